"""Which current to send next: admissible inputs, what they would tell, and the one that tells most."""

from identification.design.inputs import Limits
from identification.design.search import Design, design

__all__ = ["Design", "Limits", "design"]
