"""How every function of the chain is compiled: cached on disk, without Python's checks and lock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import llvmlite.binding
import numpy as np
from numba import cfunc, from_dtype, njit, types

compiled = njit(cache=True, error_model="numpy", nogil=True)

inlined = njit(cache=True, error_model="numpy", nogil=True, forceinline=True)
"""For the few short functions that every period passes."""


def apart(records: Sequence[np.dtype], numbers: int) -> Callable[[Callable[..., None]], Any]:
    """Compile a long function of records and numbers once, into code of its own that its callers link to by name.

    Other functions are compiled anew, with all that they call, in each of their callers: minutes for the whole chain.
    """
    signature = types.void(*map(from_dtype, records), *[types.float64] * numbers)

    def compile_apart(function: Callable[..., None]) -> Any:
        made = cfunc(signature, cache=True, error_model="numpy")(function)
        symbol = f"{function.__module__}.{function.__name__}"
        llvmlite.binding.add_symbol(symbol, made.address)
        return types.ExternalFunction(symbol, signature)

    return compile_apart
