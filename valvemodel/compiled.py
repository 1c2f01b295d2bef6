"""How every function of the chain is compiled: cached on disk, without Python's checks, free of the interpreter lock."""

from numba import njit

compiled = njit(cache=True, error_model="numpy", nogil=True)
