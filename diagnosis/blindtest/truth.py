"""What is really in a plant: one effect, its formulation and its numbers."""

from dataclasses import dataclass, replace
from typing import Self


@dataclass(frozen=True)
class Truth:
    """One effect of a plant as it was built in.

    Attributes
    ----------
    effect : str
        Key of the effect, as in every file of the project.
    stage : str
        `electromagnet`, `nozzle`, `stem` or `sensor`.
    formulation : str
        The physical law chosen for it.
    parameters : dict
        The law's own numbers, SI units.
    visibility : float
        Root-mean-square change of the reading that it causes, over the noise's. [1]
    unabsorbed : float
        The part of it that a small change of the base parameters cannot imitate, over the noise. [1]
    nuisance : bool
        Whether it was put in below notice; such an effect is no part of the answer.
    """

    effect: str
    stage: str
    formulation: str
    parameters: dict[str, float]
    visibility: float = float("nan")
    unabsorbed: float = float("nan")
    nuisance: bool = False

    def scaled(self, name: str, value: float) -> Self:
        """The same effect with one of its numbers replaced."""
        return replace(self, parameters={**self.parameters, name: value})


def by_effect(truths: tuple[Truth, ...], stage: str) -> dict[str, Truth]:
    """The truths of one stage by effect; an effect may occur once."""
    chosen = [truth for truth in truths if truth.stage == stage]
    named = {truth.effect: truth for truth in chosen}
    if len(named) < len(chosen):
        raise ValueError(f"an effect occurs twice in {[truth.effect for truth in chosen]}; keep one of each")
    return named
