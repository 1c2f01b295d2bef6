"""The diagnosis of a whole valve: all that it found, and how it is written down."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from diagnosis.base_numbers import BaseNumber
from diagnosis.causes import Cause, content_of
from diagnosis.confusability import Confusability
from diagnosis.curve import Curve
from diagnosis.display import Told
from diagnosis.regime_map import RegimeMap
from diagnosis.regimes import Regime
from diagnosis.score import Errors, closed_interval, closed_share
from diagnosis.sham import Control
from diagnosis.stages import open_stages
from diagnosis.trying import Candidate
from diagnosis.where import Where
from identification.experiment import Experiment
from identification.fit import Fit
from identification.holdout import Holdout
from valvemodel.effects import are_aliases
from valvemodel.files import make_folder, write_json
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

    verdict: str
    stage: str | None
    stage_probability: dict[str, float]
    regimes: list[Regime]
    regime_map: RegimeMap
    stage_gaps: Where
    causes: list[Cause]
    unknown_probability: float
    as_given: Errors
    refitted: Errors
    floor: float
    sampling_error: float
    left_out: float
    yardstick: str
    holdout: Holdout
    given: Model
    base: Fit
    found: Fit
    base_numbers: list[BaseNumber]
    candidates: tuple[str, ...]
    tried: list[Candidate]
    confusability: Confusability
    control: Control
    ceiling: Errors
    residual_curves: list[Curve]
    steps: list[tuple[str, float]]
    warnings: tuple[str, ...]
    seconds: float
    next_experiment: NextExperiment | None = None

    @property
    def cause(self) -> Cause:
        """The cause that is shown: the most probable one, of which the verdict speaks unless it is unknown.

        Where it is, causes that are a series of waves come last.
        """
        return self.causes[0]

    @property
    def found_model(self) -> Model:
        """The refitted base, with the cause where one is named, as it goes for other records of the valve."""
        return self.found.model.without_starts()

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
        content = content_of(self)
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
        from diagnosis.picture import evidence_of

        return evidence_of(self)

    def write(self, folder: Path, *, jobs: int | None = 1) -> dict[str, Path]:
        """Write diagnosis.json, base.json, model.json and report.html, and return their places.

        So many processes draw at the same time; None is one a core.
        """
        from diagnosis.report import write_page

        folder = make_folder(folder)
        places = {name: folder / name for name in ("diagnosis.json", "base.json", "model.json", "report.html")}
        content = self.as_json()
        write_json(places["diagnosis.json"], content)
        self.base.model.write(places["base.json"])
        self.found_model.write(places["model.json"])
        write_page(places["report.html"], content, self.evidence(), jobs=jobs)
        return places
