"""Electromagnet: from the current to the gap between nozzle and flapper."""

from __future__ import annotations

from itertools import pairwise
from math import exp, expm1, inf, log, log1p, sqrt, tanh
from types import SimpleNamespace

from valvemodel.reference.instant import first_instant
from valvemodel.reference.lags import answer_of_both

PLAYS = 8
"""Equal shares of a density of half-widths."""

CUT = 3.0
"""Where an exponential density ends, in its scales; what is beyond it of others is left out as well."""


def half_widths(evenness: float) -> list[float]:
    """Return the mean half-width of each share over that of all, by the integral of its quantiles."""

    def upto(share: float) -> float:
        left = 1.0 - share
        if evenness == 0.0:
            return share + left * log(left)
        if evenness == 1.0:
            return share
        order = evenness / (1.0 - evenness)
        return (share - (1.0 - left ** (order + 1.0)) / (order + 1.0)) / order

    ends = [upto(-number / PLAYS * expm1(-CUT)) for number in range(PLAYS + 1)]
    return [PLAYS * (end - begin) / ends[PLAYS] for begin, end in pairwise(ends)]


Core = tuple[float, float, list[float]]
"""The magnetising current [A], where in its loop the core is, and the plays [A]."""


class Electromagnet:
    """Coil, core and flapper; a current is held from one call of `hold` to the next."""

    def __init__(self, numbers: SimpleNamespace, current: float) -> None:
        self.numbers = numbers
        # Two lags in series may stand in either order.
        self.shorter, self.longer = sorted((numbers.coil_time_constant, numbers.eddy_time_constant))
        self.turn = inf
        magnetised = saturated(numbers, current)
        scale, start = numbers.hysteresis_half_width * (1.0 + numbers.hysteresis_roundness), numbers.hysteresis_start
        self.widths = [scale * half_width for half_width in half_widths(numbers.play_evenness)]
        self.core: Core = (magnetised, start, [magnetised - start * width for width in self.widths])
        # What the lags follow: the current, or what the core makes of it at once.
        self.is_behind = numbers.lag_behind_core > 0.0
        self.lagged = self.flux = self.held = self.behind_loop(*self.core) if self.is_behind else current

    def hold(self, current: float) -> None:
        """Switch to a current."""
        self.held = current
        if self.is_behind:
            self.core = self.core_at(current, self.core)
            self.held = self.behind_loop(*self.core)
        self.turn = self.turning_instant()

    def turning_instant(self) -> float:
        """Return when the flux turns while the current is held, behind the second lag; never if it need not. [s]"""
        ahead = self.lagged - self.flux
        if self.is_behind or self.shorter == 0.0 or ahead * (self.held - self.lagged) >= 0.0:
            return inf
        return first_instant(
            lambda instant: ahead * (self.lagged_after(instant) - self.flux_after(instant)) <= 0.0, 1e3
        )

    def lagged_after(self, duration: float) -> float:
        """Return the current behind the longer lag: tau di_1/dt = i - i_1. [A]"""
        if self.longer == 0.0:
            return self.held
        return self.held + (self.lagged - self.held) * exp(-duration / self.longer)

    def flux_after(self, duration: float) -> float:
        """Return the current that the flux stands for: tau_e di_e/dt = i_1 - i_e. [A]"""
        if self.longer == 0.0:
            return self.held
        began = (self.lagged - self.held) * self.longer * answer_of_both(self.longer, self.shorter, duration)
        dying = (self.flux - self.held) * exp(-duration / self.shorter) if self.shorter > 0.0 else 0.0
        return self.held + dying + began

    def core_after(self, duration: float) -> Core:
        """Return the magnetising current [A], where in its loop the core is, and the plays [A], past a turn or not."""
        core = self.core
        if self.is_behind:
            return core
        for instant in (self.turn, duration):
            if instant <= duration:
                core = self.core_at(self.flux_after(instant), core)
        return core

    def core_at(self, current: float, core: Core) -> Core:
        """Return the same after the current has gone one way to another, from where the core was. [A]"""
        before, loop, plays = core
        magnetising = saturated(self.numbers, current)
        return magnetising, self.loop_after(magnetising, before, loop), self.plays_after(magnetising, plays)

    def loop_after(self, magnetising: float, before: float, loop: float) -> float:
        """Return where in its loop the core is, -1..1, after a magnetising current before and where it was then.

        dz = (1 - |z| ((1 - gamma) sign(z di) + gamma)) di / (2 h (1 - gamma) (1 + rho)): where z and di are opposed a
        straight line in dz and z, up to z = 0; beyond it another one.
        """
        n = self.numbers
        change = magnetising - before
        if n.hysteresis_half_width == 0.0 or change == 0.0:
            return loop
        side = 1.0 if change > 0.0 else -1.0
        way = abs(change) / (2.0 * n.hysteresis_half_width * (1.0 - n.bouc_wen_gamma) * (1.0 + n.hysteresis_roundness))
        place, slope = side * loop, 1.0 - 2.0 * n.bouc_wen_gamma
        if place < 0.0:
            to_middle = -place if slope == 0.0 else log(1.0 - slope * place) / slope
            if way < to_middle:
                place = place + way if slope == 0.0 else (1.0 - (1.0 - slope * place) * exp(-slope * way)) / slope
                return side * place
            place, way = 0.0, way - to_middle
        return side * (1.0 - (1.0 - place) * exp(-way))

    def plays_after(self, magnetising: float, plays: list[float]) -> list[float]:
        """Return where plays are then: each is dragged along at its half-width from the magnetising current. [A]"""
        return [
            min(max(play, magnetising - width), magnetising + width)
            for play, width in zip(plays, self.widths, strict=True)
        ]

    def current_after(self, duration: float) -> float:
        """Return the effective current: lagged, saturated, behind the loop; or lagged behind that. [A]"""
        return self.flux_after(duration) if self.is_behind else self.behind_loop(*self.core_after(duration))

    def behind_loop(self, magnetising: float, loop: float, plays: list[float]) -> float:
        """Return the current behind Dahl's curve, or behind the mean of the plays. [A]"""
        n = self.numbers
        behind = n.hysteresis_half_width * loop
        behind_plays = magnetising - sum(plays) / PLAYS
        return magnetising - behind + n.return_point_memory * (behind - behind_plays / (1.0 + n.hysteresis_roundness))

    def advance(self, duration: float) -> None:
        """Let a duration pass."""
        self.core = self.core_after(duration)
        self.lagged, self.flux = self.lagged_after(duration), self.flux_after(duration)
        self.turn = self.turning_instant()


def saturated(n: SimpleNamespace, current: float) -> float:
    """Return the current, bent above the knee: i - (1 - r) times what is lost, but for a constant: 0 at none. [A]"""
    if n.saturation_slope == 1.0:
        return current
    return current - (1.0 - n.saturation_slope) * (lost(n, current) - lost(n, 0.0))


def lost(n: SimpleNamespace, current: float) -> float:
    """Return a^2/(a + b) or a - b tanh(a/b), of the way a above the knee: 0 below, with a rounded corner. [A]"""
    above = current - n.saturation_knee
    ramp = 0.5 * (above + sqrt(above**2 + n.saturation_rounding**2))
    if n.saturation_law > 0.0 and n.saturation_reach > 0.0:
        return ramp - n.saturation_reach * tanh(ramp / n.saturation_reach)
    return ramp**2 / (ramp + n.saturation_reach)


def crept(time: float, time_constant: float, is_logarithmic: float) -> float:
    """Return how far a creep of unit rate at the start has come: T (1 - exp(-t/T)), or T ln(1 + t/T). [s]"""
    return time_constant * (log1p(time / time_constant) if is_logarithmic else -expm1(-time / time_constant))


def gap(n: SimpleNamespace, current: float, time: float) -> float:
    """Return the gap at an effective current, eq. (31), and at a time since the start, as it drifts. [m]"""
    drift = n.gap_drift_rate * crept(time, n.gap_drift_time, n.gap_drift_creep)
    return n.gap_offset - n.gap_gain * sqrt(max(current, 0.0)) + drift
