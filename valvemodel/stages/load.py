"""Load on the stem: a Fourier series, of one wave where it is periodic and of many where it varies at will."""

from __future__ import annotations

import math

from numba import literal_unroll

from valvemodel.compiled import compiled, inlined

MOST_WAVES = 20
"""Waves that a load has at most."""

HIGHER_SINES, HIGHER_COSINES = (
    tuple(f"load_{kind}_{number}" for number in range(2, MOST_WAVES + 1)) for kind in ("sine", "cosine")
)
"""Names of the sizes of a load's waves from the second on. [N]"""


@inlined
def has_load(p):
    """Return whether a load acts."""
    return p.load_sine != 0.0 or p.load_cosine != 0.0 or p.load_waves > 1.0


@compiled
def load(p, time):
    """Return the load force at an instant. [N]"""
    angle = 2.0 * math.pi * time / p.load_period
    sine, cosine = math.sin(angle), math.cos(angle)
    force = p.load_sine * sine + p.load_cosine * cosine
    if p.load_waves > 1.0:
        force += higher_waves(p, sine, cosine)
    return force


@inlined
def load_if_any(p, time):
    """Return the load force at an instant, 0 where none acts. [N]"""
    return load(p, time) if has_load(p) else 0.0


@compiled
def higher_waves(p, sine, cosine):
    """Return the load of all waves but the first, whose sine and cosine are given. [N]"""
    force, number, wave_sine, wave_cosine = 0.0, 1.0, sine, cosine
    for name in literal_unroll(HIGHER_SINES):
        number += 1.0
        wave_sine, wave_cosine = wave_sine * cosine + wave_cosine * sine, wave_cosine * cosine - wave_sine * sine
        if number <= p.load_waves:
            force += p[name] * wave_sine
    number, wave_sine, wave_cosine = 1.0, sine, cosine
    for name in literal_unroll(HIGHER_COSINES):
        number += 1.0
        wave_sine, wave_cosine = wave_sine * cosine + wave_cosine * sine, wave_cosine * cosine - wave_sine * sine
        if number <= p.load_waves:
            force += p[name] * wave_cosine
    return force


@compiled
def steepest_slope(p):
    """Return a bound on how fast the load changes: all waves steep at once (Cauchy and Schwarz). [N/s]"""
    return math.sqrt(p.load_waves) * size_of_slopes(p)


@compiled
def usual_slope(p):
    """Return how fast the load changes but for moments: 1.4 times the root mean square of its slope. [N/s]

    Of one wave that is the bound.
    """
    return size_of_slopes(p)


@compiled
def size_of_slopes(p):
    """Return the root of the sum of the squares of the waves' steepest slopes. [N/s]"""
    square = p.load_sine * p.load_sine + p.load_cosine * p.load_cosine
    if p.load_waves > 1.0:
        number = 1.0
        for name in literal_unroll(HIGHER_SINES):
            number += 1.0
            if number <= p.load_waves:
                square += (number * p[name]) ** 2
        number = 1.0
        for name in literal_unroll(HIGHER_COSINES):
            number += 1.0
            if number <= p.load_waves:
                square += (number * p[name]) ** 2
    return 2.0 * math.pi / p.load_period * math.sqrt(square)
