"""How every function of the chain is compiled: cached on disk, without Python's checks and lock."""

from numba import njit

compiled = njit(cache=True, error_model="numpy", nogil=True)

inlined = njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
"""For the few short functions that every period passes."""
