"""diffrax: its Runge-Kutta step in a hand-written event loop, compiled by JAX; the stop by bisection on the step."""

from __future__ import annotations

from functools import partial

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from benchmarks.simulation.workload import PERIOD, STOP_SPEED, Stem

TITLE = "diffrax step in a JIT-compiled loop"
SETTINGS = (("Tsit5", 4), ("Dopri8", 2), ("Tsit5", 8), ("Dopri8", 4), ("Dopri8", 8))
"""Steps a period."""

HALVINGS = 48
"""Of the step in which the stem stops."""


def run(stem: Stem, pressures: np.ndarray, setting: tuple[str, int]) -> np.ndarray:
    """Return the positions just before each pressure acts. [m]"""
    jax.config.update("jax_enable_x64", True)
    return np.asarray(run_periods(stem, jnp.asarray(pressures), *setting))


prepare = run
"""Compiles, which is not timed."""


@partial(jax.jit, static_argnums=(0, 2, 3))
def run_periods(stem: Stem, pressures: jax.Array, solver_name: str, substeps: int) -> jax.Array:
    """Scan the periods."""
    solver = getattr(diffrax, solver_name)()

    def slope(_, state, force):
        return jnp.stack([state[1], (force - stem.rate * state[0] - stem.damping * state[1]) / stem.mass])

    term = diffrax.ODETerm(slope)

    def step(state, force, duration):
        return solver.step(term, 0.0, duration, state, force, (False, slope(0.0, state, force)), False)[0]

    def stop(state, force, side, duration):
        def halve(_, bracket):
            low, high = bracket
            middle = 0.5 * (low + high)
            has_stopped = side * step(state, force, middle)[1] <= 0.0
            return jnp.where(has_stopped, low, middle), jnp.where(has_stopped, middle, high)

        _, high = lax.fori_loop(0, HALVINGS, halve, (0.0 * duration, duration))
        return high, step(state, force, high).at[1].set(0.0)

    def advance(carry, pressure):
        def slips(inner):
            return inner[2] < PERIOD

        def move(inner):
            state, side, time = inner
            net = stem.area * pressure - stem.rate * state[0]
            is_stuck = (jnp.abs(state[1]) < STOP_SPEED) & (jnp.abs(net) <= stem.static)
            side = jnp.where(side == 0.0, jnp.sign(net), side)

            def rest(_):
                return state.at[1].set(0.0), 0.0, PERIOD

            def slip(_):
                force = stem.area * pressure - side * stem.coulomb
                duration = jnp.minimum(PERIOD / substeps, PERIOD - time)
                following = step(state, force, duration)
                end = jnp.where(PERIOD - time - duration < 1e-12, PERIOD, time + duration)

                def stopped(_):
                    used, at_rest = stop(state, force, side, duration)
                    return at_rest, 0.0, time + used

                return lax.cond(side * following[1] <= 0.0, stopped, lambda _: (following, side, end), None)

            return lax.cond(is_stuck, rest, slip, None)

        state, side = carry
        state_after, side_after, _ = lax.while_loop(slips, move, (state, side, 0.0))
        return (state_after, side_after), state[0]

    start = jnp.array([stem.area * pressures[0] / stem.rate, 0.0])
    return lax.scan(advance, (start, 0.0), pressures)[1]
