"""The one error that a user's mistake raises: the rule, what arrived, what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """Raised where an input makes the answer meaningless; the command line ends with status 2.

    Parameters
    ----------
    rule : str
        What must hold, as a sentence without a full stop.
    arrived : str
        What was found instead, with row, column, value and unit where there are any.
    remedy : str
        What the user can do about it.
    """

    def __init__(self, rule: str, arrived: str, remedy: str) -> None:
        super().__init__(f"{rule}; {arrived}; {remedy}")
        self.rule, self.arrived, self.remedy = rule, arrived, remedy

    def __reduce__(self) -> tuple[type[InputError], tuple[str, str, str]]:
        # an error of a worker process comes back with its three parts
        return InputError, (self.rule, self.arrived, self.remedy)


def unknown_name(kind: str, name: str, known: Iterable[str]) -> InputError:
    """Make the error for a name that is not in a list, with the nearest names."""
    known = sorted(known)
    nearest = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    remedy = f"did you mean {' or '.join(nearest)}?" if nearest else f"known: {', '.join(known)}"
    return InputError(f"{kind} must be one of the known ones", f"got {name!r}", remedy)
