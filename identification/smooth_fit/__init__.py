"""The fit on smooth functions with exact derivatives, held against the exact simulator; its public door."""

from __future__ import annotations

from identification.smooth_fit.fit import SmoothFit, fit_smooth
from identification.smooth_fit.smoothing import Smoothing

__all__ = ["SmoothFit", "Smoothing", "fit_smooth"]
