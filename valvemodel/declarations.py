"""What a parameter and an effect are: declared once, as data that checks itself when built."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from valvemodel.errors import unknown_name

HINTS = frozenset(
    {"highest_reading", "lowest_reading", "reading_step", "reading_phase", "travel_place", "residual_period"}
)  # fmt: skip
"""What a search may read off a record to begin with; the search says how."""

FRONT, BACK = ("electromagnet", "nozzle"), ("stem", "sensor")
"""The stages before and behind the pressure: the chain runs forward only."""

STAGES = FRONT + BACK

Form = tuple[tuple[str, float], ...]
"""What tells one form of an effect from another: the parameters that no fit moves, and their values."""


@dataclass(frozen=True)
class Parameter:
    """One physical number of the valve or of an effect.

    `low` and `high` bound the values that are physically sensible. `neutral` is the value at which an effect vanishes
    exactly (for a parameter of the base valve, its usual value). `starts` are where searches begin: numbers, or the
    name of a hint that is read off the record (`HINTS`). `typical` is the value without one named, by default the
    first start. `is_fitted` is false for a number that a record cannot tell and that keeps its start. `scale` says
    how a search should move it: "linear" or "log". `prior_spread` is the standard deviation of the weak prior that a
    fit puts on the scaled number: 1 is a factor of e either way; within `reach` of these factors a base parameter is
    looked for. `is_higher` marks a further one of a series of like numbers: a fit moves it only where it begins off
    neutral, and no table shows it. `is_later` marks one that came later than its effect: a file that does not name it
    means its typical value. `acts_in_time` marks one that a fit to settled loops keeps neutral, as their closed form is
    without it. `is_lag` marks a time by which what passes is delayed: a base valve without it has so much more viscous
    friction. `is_start` marks where something stands as a record begins: a number of the record, by which no effect
    stands in for another.
    """

    name: str
    unit: str
    meaning: str
    low: float
    high: float
    neutral: float
    starts: tuple[float | str, ...] = ()
    scale: str = "linear"
    is_fitted: bool = True
    typical: float | None = None
    prior_spread: float = 1.0
    reach: float = 2.5
    is_higher: bool = False
    is_later: bool = False
    acts_in_time: bool = False
    is_lag: bool = False
    is_start: bool = False

    def __post_init__(self) -> None:
        assert self.name.isidentifier(), self.name
        assert self.name == self.name.lower(), self.name
        assert self.low < self.high, f"{self.name}: bounds {self.low}..{self.high}"
        assert self.scale in ("linear", "log"), self.name
        assert self.scale == "linear" or self.low > 0, f"{self.name}: a log scale needs positive bounds"
        for start in self.starts:
            is_sound = start in HINTS if isinstance(start, str) else self.low <= start <= self.high
            assert is_sound or start == self.neutral, f"{self.name}: start {start}"
        if self.typical is None and self.starts:
            object.__setattr__(self, "typical", float(self.starts[0]))

    def within_bounds(self, value: float) -> float:
        """Return a value, set to a bound where it lies beyond; the neutral one may lie anywhere."""
        return value if value == self.neutral else min(max(value, self.low), self.high)

    @property
    def is_own(self) -> bool:
        """Whether it is a number of the valve by itself: no further one of a series, nor where a record began."""
        return not (self.is_higher or self.is_start)

    @property
    def is_size(self) -> bool:
        """Whether an effect grows with it: a fit moves it, and where the effect vanishes it is 0, or a ratio of 1."""
        return self.is_fitted and self.scale == "linear" and self.neutral in (0.0, 1.0)


def choice_of_law(name: str, meaning: str, *, first: float = 0.0, second: float = 1.0) -> Parameter:
    """Return a number that came later than its effect and chooses between two laws of it; no fit moves it."""
    return Parameter(name, "1", meaning, first, second, first, (first, second), is_fitted=False, is_later=True)


@dataclass(frozen=True)
class Effect:
    """A physical effect that the base model lacks, complete: nothing else holds a list of its names.

    The effect is absent, to the last bit, while all its parameters are at their neutral values. `is_jagged` says that
    the error of a fit has many minima, so that a search must be global; `is_chaotic` that a free run soon loses the
    phase of its slips, so that a fit must be re-anchored on the measured position; `takes_long` that a run beside
    another effect may take ten times as long as others. `is_one_of` says that of the parameters that are neutral at
    infinity one at a time acts; `acts_in_time` that a settled loop cannot show it; `stops_again` that it can show as a
    stem (for the sensor, a reading) that rests again and again on its way; `breakaway` names the parameter, if any,
    that is the breakaway force over Coulomb friction. `laws` are the values that go together in a search, all
    combinations of the choices of law where none is named; a fit moves none of those in force. `frees` are the base
    parameters that the records tell once it acts, as it breaks the symmetry behind which they hide: a fit moves them
    too. `differing` are parameters whose difference is the effect: alike, with its others neutral, they are those of
    another. `aliases` are the effects (or `none`) whose trace comes close in current and position; `told_apart_by`, one
    phrase, is what would tell them apart.
    """

    key: str
    stage: str
    title: str
    meaning: str
    equation: str
    source: str
    parameters: tuple[Parameter, ...]
    is_jagged: bool = False
    is_chaotic: bool = False
    takes_long: bool = False
    is_one_of: bool = False
    acts_in_time: bool = False
    stops_again: bool = False
    breakaway: str = ""
    laws: tuple[Mapping[str, float], ...] = field(default=(), hash=False)
    frees: tuple[str, ...] = ()
    differing: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    told_apart_by: str = ""

    def __post_init__(self) -> None:
        assert self.stage in STAGES, f"{self.key}: stage {self.stage}"
        assert all((self.source, self.meaning, self.equation)), f"{self.key}: meaning, equation and source"
        assert self.parameters, f"{self.key}: at least one parameter"
        assert all(parameter.starts for parameter in self.parameters), f"{self.key}: starts"

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of that name.

        Raises
        ------
        InputError
            If the effect has none of that name; names the nearest.
        """
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise unknown_name(f"a parameter of {self.key}", name, [each.name for each in self.parameters])

    @property
    def acts_on_pressure(self) -> bool:
        """Whether the pressure depends on the effect."""
        return self.stage in FRONT

    @property
    def fitted(self) -> tuple[Parameter, ...]:
        """The parameters that a fit moves."""
        return tuple(parameter for parameter in self.parameters if parameter.is_fitted)

    def held_at(self, values: Mapping[str, float]) -> frozenset[str]:
        """Return the parameters that no fit moves at some values: those never fitted, and those of the law in force."""
        law = next((each for each in self.laws if each.items() <= values.items()), {})
        return frozenset({each.name for each in self.parameters if not each.is_fitted} | law.keys())

    def free_at(self, values: Mapping[str, float]) -> tuple[Parameter, ...]:
        """Return the parameters that a fit moves at some values."""
        held = self.held_at(values)
        return tuple(parameter for parameter in self.parameters if parameter.name not in held)

    def form_at(self, values: Mapping[str, float]) -> Form:
        """Return the form of the effect at some values."""
        held = self.held_at(values)
        return tuple((each.name, values[each.name]) for each in self.parameters if each.name in held)

    def within_bounds(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return values of its parameters, set to a bound where they lie beyond."""
        return {name: self.parameter(name).within_bounds(value) for name, value in values.items()}

    def without_difference(self, values: Mapping[str, float]) -> dict[str, float] | None:
        """Return values at which those that differ are alike and what else is fitted is neutral, None if none do."""
        if not self.differing:
            return None
        alike = sum(values[name] for name in self.differing) / len(self.differing)
        neutral = {each.name: each.neutral for each in self.fitted}
        return {**values, **neutral, **dict.fromkeys(self.differing, alike)}

    @property
    def has_one_form(self) -> bool:
        """Whether a fit moves all its numbers, together: nothing is to be chosen."""
        return not self.is_one_of and not self.laws and all(each.is_fitted for each in self.parameters)

    @property
    def is_read_off(self) -> bool:
        """Whether all numbers are read off the record, as the grid of coarse readings is: a fit moves none."""
        return not self.fitted

    @property
    def hides_in_base(self) -> bool:
        """Whether it comes close to none, at any strength: the base valve's numbers make up for it by its first law."""
        is_free = all(each.is_fitted or each.neutral in each.starts for each in self.parameters)
        return "none" in self.aliases and is_free

    @property
    def shown(self) -> tuple[Parameter, ...]:
        """The parameters that a table shows: of a series of like numbers the first."""
        return tuple(parameter for parameter in self.parameters if not parameter.is_higher)

    @property
    def typical(self) -> dict[str, float]:
        """The value of each parameter where the effect is switched on without naming one."""
        return {parameter.name: float(parameter.typical or 0.0) for parameter in self.parameters}
