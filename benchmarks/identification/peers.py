"""What a user would write instead: SciPy on a smoothed model, lmfit and pyPESTO on the exact simulator; same data."""

from __future__ import annotations

import importlib.util
import inspect
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from benchmarks.identification.plants import CASES, NOISE, SEARCHED, make, missed

if TYPE_CHECKING:
    from valvemodel.model import Model

Values = dict[str, float]
Array = npt.NDArray[np.float64]

SMOOTHING_SPEED = 1e-3
"""Width of the smoothed friction that keeps one simulation of 100 s below some seconds. [m/s]"""

STARTS = 20
"""Of the multi-start."""


def toolkit(time: Array, current: Array, position: Array, start: Model) -> Values:
    """valvemodel, exact route."""
    from identification.fitting import fit_records
    from valvemodel.records import Record

    record = Record.from_arrays(time=time, current=current, position=position)
    outcome = fit_records([record], start)
    return {each.name: each.value for each in outcome.parameters}


def smoothed_scipy(time: Array, current: Array, position: Array, start: Model) -> Values:
    """SciPy least_squares, smoothed friction, LSODA."""
    from scipy.integrate import odeint
    from scipy.optimize import least_squares

    held = dict(start.values)
    names = list(SEARCHED)
    period = time[1] - time[0]

    def simulated(x):
        p = held | dict(zip(names, np.exp(x), strict=True))
        gap = p["gap_offset"] - p["gap_gain"] * np.sqrt(current)
        force = p["diaphragm_area"] * p["supply_pressure"] / (1.0 + p["flow_ratio"] * gap**2)

        def derivative(state, t):
            y, v = state
            push = force[min(int(t / period), len(force) - 1)] - p["spring_rate"] * y
            friction = p["coulomb_friction"] * np.tanh(v / SMOOTHING_SPEED) + p["viscous_friction"] * v
            return v, (push - friction) / p["stem_mass"]

        return odeint(derivative, [position[:5].mean(), 0.0], time, hmax=period, mxstep=100_000)[:, 0]

    def residuals(x):
        return (simulated(x) - position) / NOISE

    found = least_squares(residuals, np.log([held[name] for name in names]), diff_step=1e-3, x_scale="jac", max_nfev=15)
    return dict(zip(names, np.exp(found.x), strict=True))


def lmfit_descent(time: Array, current: Array, position: Array, start: Model) -> Values:
    """lmfit, leastsq, exact simulator."""
    return _lmfit(time, current, position, start, "leastsq")


def lmfit_evolution(time: Array, current: Array, position: Array, start: Model) -> Values:
    """lmfit, differential_evolution, exact simulator."""
    return _lmfit(time, current, position, start, "differential_evolution")


def _lmfit(time: Array, current: Array, position: Array, start: Model, method: str) -> Values:
    import lmfit

    from valvemodel.simulation import simulate

    first = float(np.median(position[:5]))
    parameters = lmfit.Parameters()
    for name in SEARCHED:
        value = np.log(start.values[name])
        parameters.add(name, value=value, min=value - 1.2, max=value + 1.2)
    parameters.add("start", value=first, min=first - 1e-3, max=first + 1e-3)

    def residuals(given):
        values = given.valuesdict()
        model = start.with_values(**{name: np.exp(values[name]) for name in SEARCHED})
        run = simulate(model, time=time, current=current, start_position=values["start"])
        return (run.position - position) / NOISE

    found = lmfit.minimize(residuals, parameters, method=method, nan_policy="omit")
    return {name: float(np.exp(found.params[name].value)) for name in SEARCHED}


def pypesto_multistart(time: Array, current: Array, position: Array, start: Model) -> Values:
    """pyPESTO, 20 starts of L-BFGS-B, exact simulator."""
    import pypesto
    import pypesto.optimize

    from valvemodel.simulation import simulate

    first = float(np.median(position[:5]))
    centre = np.append(np.log([start.values[name] for name in SEARCHED]), first)
    reach = np.append(np.full(len(SEARCHED), 1.2), 1e-3)

    def misfit(x):
        model = start.with_values(**dict(zip(SEARCHED, np.exp(x[:-1]), strict=True)))
        run = simulate(model, time=time, current=current, start_position=x[-1])
        return 0.5 * float(np.sum(((run.position - position) / NOISE) ** 2))

    problem = pypesto.Problem(
        objective=pypesto.Objective(fun=misfit), lb=centre - reach, ub=centre + reach, x_guesses=[centre]
    )
    found = pypesto.optimize.minimize(
        problem,
        optimizer=pypesto.optimize.ScipyOptimizer("L-BFGS-B"),
        n_starts=STARTS,
        progress_bar=False,
        engine=pypesto.engine.SingleCoreEngine(),
    )
    return dict(zip(SEARCHED, np.exp(found.optimize_result[0].x[:-1]), strict=True))


@dataclass(frozen=True)
class Peer:
    """A way to fit, the package that it takes, the functions that a user would have to write, most repetitions."""

    fit: Callable[[Array, Array, Array, Model], Values]
    package: str
    written: tuple[Callable[..., Any], ...]
    most: int = 1000

    @property
    def lines(self) -> int:
        """Lines of user code, without blank ones, comments and docstrings."""
        return sum(_lines_of(each) for each in self.written)

    @property
    def is_there(self) -> bool:
        """Whether its package is installed."""
        return importlib.util.find_spec(self.package) is not None


def _lines_of(function: Callable[..., Any]) -> int:
    lines = [line.strip() for line in inspect.getsource(function).splitlines()]
    return sum(bool(line) and not line.startswith(("#", '"""')) for line in lines)


PEERS = {
    "valvemodel, exact route": Peer(toolkit, "valvemodel", (toolkit,)),
    "SciPy least_squares, smoothed friction": Peer(smoothed_scipy, "scipy", (smoothed_scipy,), most=2),
    "lmfit leastsq, our simulator": Peer(lmfit_descent, "lmfit", (_lmfit,)),
    "lmfit differential_evolution, our simulator": Peer(lmfit_evolution, "lmfit", (_lmfit,)),
    "pyPESTO multi-start, our simulator": Peer(pypesto_multistart, "pypesto", (pypesto_multistart,)),
}


def score_peer(peer: Peer, repetitions: int, tick: Callable[[], None]) -> dict[str, Any]:
    """Return successes (all parameters within 2 %), median seconds and lines of user code on the base case."""
    import logging

    logging.getLogger("pypesto").setLevel(logging.ERROR)
    hits, seconds = 0, []
    with threadpool_limits(1), np.errstate(all="ignore"):
        for seed in range(min(repetitions, peer.most)):
            made = make(CASES["base"], seed)
            began = clock.perf_counter()
            values = peer.fit(made.time, made.current, made.position, made.start)
            seconds.append(clock.perf_counter() - began)
            hits += not missed(made.truth, values)
            tick()
    return {
        "successes": hits,
        "repetitions": len(seconds),
        "seconds": float(np.median(seconds)),
        "lines of user code": peer.lines,
    }
