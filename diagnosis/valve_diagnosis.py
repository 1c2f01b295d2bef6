"""The diagnosis of a whole valve: all that it found."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from diagnosis.base_numbers import BaseNumber
from diagnosis.judging.confusability import Confusability
from diagnosis.judging.sham import Control
from diagnosis.judging.stages import open_stages
from diagnosis.score import Errors, closed_interval, closed_share
from diagnosis.told import Told
from diagnosis.trying.candidates import Candidate
from diagnosis.whereabouts.curve import Curve
from diagnosis.whereabouts.regime_map import RegimeMap
from diagnosis.whereabouts.where import Where
from identification.experiment import Experiment
from identification.fit import Fit
from identification.holdout import Holdout
from valvemodel.effects import are_aliases
from valvemodel.model import Model
from valvemodel.stages import EFFECTS

if TYPE_CHECKING:
    from diagnosis.next_experiment import NextExperiment
    from diagnosis.report import Evidence

YARDSTICKS = {"free": "free run", "anchored": "re-anchored on the measured position every 2 s"}
"""How the gap is measured: where slips stick, a free run loses their phase even if the model is right."""


@dataclass(frozen=True, repr=False)
class Diagnosis(Told):
    """All that a diagnosis found, in SI units."""

    regime_map: RegimeMap
    stage_gaps: Where
    as_given: Errors
    sampling_error: float
    left_out: float
    yardstick: str
    holdout: Holdout
    base: Fit
    found: Fit
    base_numbers: list[BaseNumber]
    candidates: tuple[str, ...]
    tried: list[Candidate]
    confusability: Confusability
    control: Control
    ceiling: Errors
    residual_curves: list[Curve]
    next_experiment: NextExperiment | None = None

    @property
    def found_model(self) -> Model:
        """The refitted base, with the cause where one is named, as it goes for other records of the valve."""
        return self.found.model.without_starts()

    @property
    def models(self) -> dict[str, Model]:
        """The refitted base and the found model, by the names of their files."""
        return {"base.json": self.base.model, "model.json": self.found_model}

    @property
    def open_stages(self) -> list[str]:
        """Stages in which the cause may lie as far as the records tell, the most probable first."""
        causes = [self.cause.effects, *self.cause.rivals] if self.verdict == "effect" else []
        return open_stages(self.verdict, self.stage_probability, [*causes, *((key,) for key in self.untried_aliases)])

    @property
    def not_tried(self) -> list[str]:
        """Effects that were no candidates, or that nothing called for."""
        tried = {each.effects for each in self.causes}
        return [effect.key for effect in EFFECTS if (effect.key,) not in tried]

    @property
    def untried_aliases(self) -> list[str]:
        """Effects that were no candidates and are declared to look like one that is named, or like none."""
        named = {"effect": self.cause.effects, "none": ("none",), "unknown": ()}[self.verdict]
        others = [effect.key for effect in EFFECTS if effect.key not in self.candidates]
        return [key for key in others if any(are_aliases(key, each) for each in named)]

    def as_json(self) -> dict[str, Any]:
        """Return the content of diagnosis.json."""
        content = self._content()
        content["where"] |= {
            "open_stages": self.open_stages,
            "regime_map": self.regime_map.as_json(),
            **self.stage_gaps.as_json(),
        }
        return {
            **content,
            "gap": {
                "unit": "m",
                "as_given": self.as_given.rms,
                "refitted": self.refitted.rms,
                "with_cause": self.cause.errors.rms,
                "noise_floor": self.floor,
                "sampling_error": self.sampling_error,
                "left_out": self.left_out,
                "scored_on": self.holdout.scored_on,
                "yardstick": YARDSTICKS[self.yardstick],
            },
            "ceiling": {
                "gap_after": self.ceiling.rms,
                "gap_closed": closed_share(self.refitted.rms, self.ceiling.rms, self.floor),
                "gap_closed_interval": closed_interval(self.refitted, self.ceiling, self.floor),
            },
            "control": asdict(self.control),
            "confusability": self.confusability.as_json(),
            "residual_curves": [curve.as_json() for curve in self.residual_curves],
            "next_experiment": None if self.next_experiment is None else self.next_experiment.as_json(),
            "base": {
                "name": self.base.model.name,
                "file": "base.json",
                "numbers": [asdict(each) for each in self.base_numbers],
            },
            "signals": ["current", "position"] + ["pressure"] * self.base.problem.has_pressure,
            "not_tried": self.not_tried,
            "untried_aliases": self.untried_aliases,
            "records": [experiment.name for experiment in self.experiments],
            "warnings": list(self.warnings),
            "seconds": self.seconds,
        }

    @property
    def experiments(self) -> list[Experiment]:
        """All experiments, fitted and scored, each once."""
        experiments = list(self.holdout.experiments)
        return experiments + [each for each in self.holdout.scored_experiments if each not in experiments]

    def evidence(self) -> Evidence:
        """Return what the pictures show."""
        from diagnosis.valve_picture import evidence_of_valve

        return evidence_of_valve(self)
