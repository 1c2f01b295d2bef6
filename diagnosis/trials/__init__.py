"""How often is the diagnosis right? Blind plants are sealed, diagnosed, opened and scored."""

from diagnosis.trials.blindtest import BlindTest, run_blindtest
from diagnosis.trials.plan import Settings

__all__ = ["BlindTest", "Settings", "run_blindtest"]
