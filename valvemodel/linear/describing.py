"""Describing function of stiction with a slip jump, for python-control's harmonic balance."""

from __future__ import annotations

import math

import control as ct


class stiction_nonlinearity(ct.DescribingFunctionNonlinearity):  # noqa: N801 (named like python-control's own)
    """A stem without mass between a spring and friction: it sticks, jumps and slides.

    The output stays until the input is `static` away from it, then jumps to within `kinetic` and follows at that
    distance until the input turns. In the words of valve diagnosis: dead band plus stick band S = static + kinetic,
    slip jump J = static - kinetic. Without a jump it is python-control's `friction_backlash_nonlinearity(2 * static)`.

    Parameters
    ----------
    static : float
        Breakaway force over spring rate. [m]
    kinetic : float
        Coulomb friction over spring rate, at most `static`. [m]

    References
    ----------
    Choudhury, Thornhill and Shah, Control Engineering Practice 13 (2005) 641-658, eqs. of the two-parameter model;
    derived anew here: the output is constant from the peak to the breakaway, then input plus `kinetic`.
    """

    def __init__(self, static: float, kinetic: float) -> None:
        super().__init__()
        if not 0.0 <= kinetic <= static:
            raise ValueError(f"static {static} must not be below kinetic {kinetic}, nor kinetic negative")
        self.static, self.kinetic = static, kinetic
        self._output, self._side = 0.0, 0.0

    def __call__(self, x: float) -> float:
        """Return the output after the input has moved on to a value."""
        away = x - self._output
        slides_on = self._side * away > self.kinetic
        if slides_on or abs(away) > self.static:
            self._side = math.copysign(1.0, away)
            self._output = x - self._side * self.kinetic
        elif self._side * away < self.kinetic:
            self._side = 0.0
        return self._output

    def describing_function(self, A: float) -> complex:
        """Return first harmonic of the output over that of the input, 0 where the input is too small to move it."""
        if A < 0.0:
            raise ValueError("cannot evaluate describing function for A < 0")
        band = self.static + self.kinetic
        if A <= 0.0 or 0.5 * band > A:
            return 0.0
        held = A - self.kinetic
        sine = (A - band) / A
        breakaway = math.pi - math.asin(max(-1.0, sine))
        cosine = math.cos(breakaway)
        in_phase = (
            (self.kinetic - held) * cosine + 0.5 * A * (1.5 * math.pi - breakaway) + 0.25 * A * math.sin(2 * breakaway)
        )
        quadrature = held * (sine - 1.0) + 0.5 * A * cosine * cosine - self.kinetic * (1.0 + sine)
        return complex(in_phase, quadrature) * 2.0 / (math.pi * A)
