"""What of a record was not measured, or cannot be? It is left out or put right, and said."""

from identification.mending.steps import mend

__all__ = ["mend"]
