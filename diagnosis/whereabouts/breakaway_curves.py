"""Breakaway curves: what it takes to set the stem going, and what that depends on where it is not one force."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from diagnosis.whereabouts.curve import AT_REST, BREAKAWAY, PLAIN, Curve
from identification.fit import Fit
from identification.stick_slip.bent_lines import straight_line
from identification.stick_slip.breakaway import Line, slopes_of

FEWEST = 8
"""Breakaways on ramps, where the force is known, of which nothing is shown if they are fewer."""

KNOWN = 1e-6
"""Part of the most that breakaways tell of the line from which they tell it."""


def curves_of_breakaways(base: Fit) -> Iterator[Curve]:
    """Yield the breakaway force beyond one that is always the same, over what it may depend on.

    The line of spring, gap and breakaway force is laid through the breakaways on ramps once more with a curve of each
    quantity in turn, over its ranks: a force that grows with the time at rest is not taken for another spring. A curve
    explains what it foretells of breakaways that it was not laid through.
    """
    line = straight_line(base)
    if line is None or line.is_explained:
        return
    breakaways, quantities = line.breakaways, quantities_of(line)
    is_known = breakaways.is_ramped(line.point) & np.isfinite(quantities[AT_REST][1])
    if is_known.sum() < FEWEST:
        return
    # What rests below its line as it leaves upwards has taken more force.
    newton = -breakaways.side * base.model.values["spring_rate"] * breakaways.spread
    off = (newton * breakaways.centred(line.point[None, :])[0])[is_known]
    bends = told_by((newton[:, None] * slopes_of(breakaways.centred, line.point, line.columns))[is_known])
    alone = foretold(bends, off)
    for name, (unit, values) in quantities.items():
        order = np.argsort(values[is_known])
        ranks = np.argsort(order) / (len(order) - 1.0)
        shape = np.stack([ranks, ranks**2], axis=1)
        columns = np.concatenate([bends, shape - shape.mean(axis=0)], axis=1)
        weights = np.linalg.lstsq(columns, off)[0]
        force = off - bends @ weights[: bends.shape[1]]
        share = max(1.0 - foretold(columns, off) / alone, 0.0)
        at, error = values[is_known][order], np.abs(newton)[is_known][order]
        yield Curve(BREAKAWAY, "N", "stem", name, unit, at, force[order], error, share, has_single=True)


def curves_of_ageing(base: Fit) -> list[Curve]:
    """Return the curves of the breakaway force if it plainly depends on the time at rest most, else none.

    A cause that makes the stem jump has one breakaway force, as all listed ones have: it may be the right one, and lack
    how the force grows while the stem rests.
    """
    curves = sorted(curves_of_breakaways(base), key=lambda curve: -curve.share)
    return curves if curves and curves[0].against == AT_REST and curves[0].share >= PLAIN else []


def quantities_of(line: Line) -> dict[str, tuple[str, np.ndarray]]:
    """Return what a breakaway may depend on, unit and values of shape (breakaways,).

    The time at rest is NaN where the record began at rest.
    """
    breakaways = line.breakaways
    pairs = zip(breakaways.problem.experiments, breakaways.rests, strict=True)
    spans = [(each, rest.first, rest.last) for each, rests in pairs for rest in rests]
    rested = [each.time[last] - each.time[first] if first > 0 else np.nan for each, first, last in spans]
    return {
        AT_REST: ("s", np.array(rested)),
        "position": ("m", breakaways.position),
        "pressure": ("Pa", breakaways.pressures(line.point[None, :])[:, 0].mean(axis=0)),
        "time": ("s", np.array([each.start + each.time[last] for each, _, last in spans])),
    }


def told_by(slopes: np.ndarray) -> np.ndarray:
    """Return what a line's own numbers can do at breakaways as orthonormal columns, from its slopes, shape (n, m)."""
    basis, sizes, _ = np.linalg.svd(slopes, full_matrices=False)
    return basis[:, sizes > KNOWN * sizes.max()]


def foretold(columns: np.ndarray, values: np.ndarray) -> float:
    """Return the sum of squares by which each value is off a least-squares fit to all others."""
    basis, _ = np.linalg.qr(columns)
    own = np.minimum(np.sum(basis**2, axis=1), 1.0 - KNOWN)
    return float(np.sum(((values - basis @ (basis.T @ values)) / (1.0 - own)) ** 2))
