"""A curve: the mean of what is left over what it may depend on."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

BREAKAWAY = "breakaway force"
"""The signal of what it takes to set the stem going, beyond one force for all."""

AT_REST = "time at rest"
"""How long a stem had rested before it broke away."""

PLAIN = 0.5
"""Share of what is left of breakaway forces from which a curve plainly explains them."""


@dataclass(frozen=True, eq=False)
class Curve:
    """The mean of a residual over a quantity.

    Attributes
    ----------
    signal, unit : str
        `position`, `pressure`, `gap`, `force` or `friction` (the force against the motion), or `breakaway force`,
        measured less modelled.
    stage : str
        Where the residual arises: the stage, or those before the position where the pressure was not measured.
    against, against_unit : str
        The quantity.
    at, mean, error : arrays, shape (bins,)
        Middle of each bin, mean of the residual in it and its standard error; neighbouring samples that go together
        count as one. Of breakaways each is a bin of its own.
    share : float
        Part of the residual's variance that the curve explains.
    is_lead : bool
        Whether it is no residual but what the stage would have to do by its own signals.
    has_single : bool
        Whether each value is a single one that was measured, not a mean.
    """

    signal: str
    unit: str
    stage: str
    against: str
    against_unit: str
    at: np.ndarray
    mean: np.ndarray
    error: np.ndarray
    share: float
    is_lead: bool = False
    has_single: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return the curve as diagnosis.json has it."""
        return asdict(self)
