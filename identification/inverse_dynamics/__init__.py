"""Which numbers of the stem follow from its measured force and position alone, without a simulation?"""

from identification.inverse_dynamics.diagnose import (
    Gap,
    ScoredCause,
    StemDiagnosis,
    diagnose_stem,
)
from identification.inverse_dynamics.fit import StemFit, fit_stem
from identification.inverse_dynamics.regressors import Estimate, stem_candidates
from identification.inverse_dynamics.signals import Preprocessing, StemSignals, prepare_signals

__all__ = [
    "Estimate",
    "Gap",
    "Preprocessing",
    "ScoredCause",
    "StemDiagnosis",
    "StemFit",
    "StemSignals",
    "diagnose_stem",
    "fit_stem",
    "prepare_signals",
    "stem_candidates",
]
