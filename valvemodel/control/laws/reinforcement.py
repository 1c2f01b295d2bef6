"""Constant reinforcement of a PID's output."""

from __future__ import annotations

import math

from valvemodel.compiled import compiled


@compiled
def reinforce(s, m, output, error):
    """Return what is added in the direction in which the output changes, and nothing inside the dead band. [A]

    References
    ----------
    Ivan and Lakshminarayanan, A new unified approach to valve stiction quantification and compensation, Ind. Eng.
    Chem. Res. 48 (2009) 3474-3483.
    """
    change = output - m.last_output
    m.last_output = output
    if m.is_started == 0.0 or change == 0.0 or abs(error) <= s.dead_band:
        return 0.0
    return math.copysign(s.reinforcement, change)
