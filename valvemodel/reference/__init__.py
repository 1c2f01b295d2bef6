"""The valve in plain Python: the same laws as the compiled chain, to be read and to be tested against."""

from valvemodel.reference.run import simulate_slowly

__all__ = ["simulate_slowly"]
