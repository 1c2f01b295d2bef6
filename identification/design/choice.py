"""The parameters that a test is to tell, by their letters or full names, and whether it can."""

from __future__ import annotations

from collections.abc import Sequence

from identification.determined.structure import own_name, product
from identification.unknowns import OF_GAP
from valvemodel.base_valve import BASE_PARAMETERS, FITTED_BASE
from valvemodel.effects import effect_of_key
from valvemodel.equations.symmetries import GROUPS
from valvemodel.errors import InputError, unknown_name
from valvemodel.model import Model

LETTERS = {
    "m": "stem_mass",
    "k": "spring_rate",
    "S_1": "diaphragm_area",
    "P_1": "supply_pressure",
    "f_v": "viscous_friction",
    "F_c": "coulomb_friction",
    "F_s": "static_friction_ratio",
    "F_0": "spring_preload",
    "K": "flow_ratio",
    "c0": "gap_offset",
    "E": "gap_gain",
}
"""The paper's letters for parameters, as an engineer writes them."""


def chosen_parameters(text: str, model: Model) -> list[str]:
    """Return the full names of parameters written as `k,F_c` or `spring_rate,coulomb_friction`.

    Raises
    ------
    InputError
        If a name is unknown, comes twice, or is one that current and position cannot tell.
    """
    fitted = [each.name for each in FITTED_BASE]
    if model.values["pressure_per_current"] > 0.0:
        fitted = [name for name in fitted if name not in OF_GAP]
    for key, values in model.effects.items():
        fitted += [each.name for each in effect_of_key(key).free_at(values)]
    names: list[str] = []
    for word in filter(None, (part.strip() for part in text.split(","))):
        name = LETTERS.get(word, word)
        if name in names:
            raise InputError("a parameter is named once", f"{word} came twice in {text!r}", "name it once")
        if name not in fitted:
            raise _refusal(word, name, fitted)
        names.append(name)
    if not names:
        raise InputError("a design is for at least one parameter", f"got {text!r}", f"name some of {', '.join(fitted)}")
    return names


def _refusal(word: str, name: str, fitted: Sequence[str]) -> InputError:
    if name == "static_friction_ratio":
        arrived = f"{word} is asked for, and the model has F_s = F_c"
        return InputError("F_s is a parameter of the effect static_friction", arrived, "fit a model with that effect")
    if name not in {each.name for each in BASE_PARAMETERS}:
        return unknown_name("a parameter of the design", word, [*LETTERS, *fitted])
    groups = [product(group) for group in GROUPS["current, position", False] if own_name(group) in fitted]
    return InputError(
        "a design is for parameters that a fit to current and position moves",
        f"{word} is held as given: current and position tell only {'; '.join(groups)}",
        f"choose among {', '.join(fitted)}",
    )
