"""The paper's claims on its three controllers, tested on a grid; in words, and as claims.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from valvemodel.control.grid import HOLD, KEYS, NOMINAL, Grid
from valvemodel.control.kinds import kind_of

SCHEMA = "valvemodel.claims/1"

MENDS = ("sc_pid_dead_band", "dead_band", "inverse", "landing")
"""What may mend SC-PID: a dead band, giving up the feedforward, the model's branches, landing on them."""


def claims_of(grid: Grid) -> dict[str, tuple[str, np.ndarray]]:
    """Return each claim's wording as tested, and where it holds."""
    pid, sc, sc_pid = (grid.measured[key] for key in ("pid", "sc", "sc_pid_mean"))
    band = f"{1e3 * grid.band:g} mm"
    # a set point that was not settled counts as held to its end
    times = [
        np.where(each["settled_share"] > 0.0, each["settling_time"], 0.0) * each["settled_share"]
        + HOLD * (1.0 - each["settled_share"])
        for each in (pid, sc_pid)
    ]
    return {
        "pid_oscillates": (
            f"PID oscillates: a limit cycle of up to {0.25 * HOLD:g} s lasts",
            pid["limit_cycle_amplitude"] > 0.0,
        ),
        "sc_deviates": (
            f"SC leaves a fixed deviation: steady error beyond {band}, no cycle",
            (sc["steady_error"] > grid.band) & (sc["limit_cycle_amplitude"] == 0.0),
        ),
        "sc_pid_is_faster": ("SC-PID is faster than PID", times[1] < times[0]),
        "sc_pid_oscillates_little": (
            f"SC-PID oscillates little: no cycle beyond {band}",
            sc_pid["limit_cycle_amplitude"] <= grid.band,
        ),
        "sc_pid_overshoots_less": ("SC-PID overshoots less than PID", sc_pid["overshoot"] < pid["overshoot"]),
    }


def findings_of(grid: Grid) -> list[str]:
    """Say in words, from the grid alone, where each claim holds, where SC-PID fails and what mends it."""
    texts = [_where(grid, text, holds) for text, holds in claims_of(grid).values()]
    fails = ~grid.is_well("sc_pid_mean")
    texts.append(_where(grid, "SC-PID fails (a set point not settled, or a cycle beyond the band)", fails))
    texts.append(_slips(grid))
    misread = ~grid.is_well("sc_pid_misread")
    texts.append(
        f"Read as the full width each way from the mean line, it fails in {_percent(misread)} instead of "
        f"{_percent(fails)} of the cases."
    )
    if not fails.any():
        return texts
    for key in sorted(MENDS, key=lambda key: -grid.is_well(key)[fails].mean()):
        well = grid.is_well(key)
        calm = grid.measured[key]["limit_cycle_amplitude"] == 0.0
        texts.append(
            f"{kind_of(key).title} mends {_percent(well[fails])} of these failures, leaves no cycle at all in "
            f"{_percent(calm[fails])} of them, and fails in {_percent(~well)} of all cases."
        )
    return texts


def _slips(grid: Grid) -> str:
    """Say at which friction a stem that is crept upon must miss the band."""
    slips = ", ".join(f"{1e3 * jump:.1f} mm at {ratio:g}" for ratio, jump in grid.slip_jumps.items())
    over = [ratio for ratio, jump in grid.slip_jumps.items() if jump > 2.0 * grid.band]
    said = f"The shortest slip from rest, by friction ratio: {slips}"
    if not over:
        return f"{said}; it fits into the band of +-{1e3 * grid.band:g} mm."
    return (
        f"{said}. From {min(over):g} on it is longer than the whole band of +-{1e3 * grid.band:g} mm: a controller "
        "that raises the current until the stem lets go cannot stop in the band but by luck."
    )


def _where(grid: Grid, text: str, holds: np.ndarray) -> str:
    """Say in how many cases something holds, and along which factor that changes most."""
    shares = {name: shares_along(grid, holds, axis) for axis, name in enumerate(grid.factors)}
    name = max(shares, key=lambda each: np.ptp(shares[each]))
    along = ", ".join(
        f"{_percent(share)} at {level:g}" for level, share in zip(grid.factors[name], shares[name], strict=True)
    )
    said = f"{text}: {_percent(holds)} of {holds.size} cases"
    return f"{said}." if np.ptp(shares[name]) == 0.0 else f"{said}; most by {name.replace('_', ' ')}: {along}."


def shares_along(grid: Grid, holds: np.ndarray, *axes: int) -> np.ndarray:
    """Return the share of cases in which something holds, for each level of one or two factors."""
    others = tuple(axis for axis in range(len(grid.factors)) if axis not in axes)
    return holds.mean(axis=others)


def _percent(holds: np.ndarray | float) -> str:
    return f"{100.0 * float(np.mean(holds)):.0f} %"


def as_json(grid: Grid) -> dict[str, Any]:
    """Return the content of claims.json."""
    return {
        "schema": SCHEMA,
        "model": grid.model.as_json(),
        "period": {"value": grid.period, "unit": "s"},
        "noise": {"value": grid.noise, "unit": "m"},
        "band": {"value": grid.band, "unit": "m"},
        "hold": {"value": HOLD, "unit": "s"},
        "factors": {name: list(levels) for name, levels in grid.factors.items()},
        "nominal": NOMINAL,
        "slip_jumps": {"value": {f"{ratio:g}": jump for ratio, jump in grid.slip_jumps.items()}, "unit": "m"},
        "tuned": {key: dict(values) for key, values in grid.tuned.items()},
        "claims": {
            key: {
                "as_tested": text,
                "share": float(holds.mean()),
                "share_by": {name: shares_along(grid, holds, axis) for axis, name in enumerate(grid.factors)},
            }
            for key, (text, holds) in claims_of(grid).items()
        },
        "fails": {
            key: {
                "share": float((~grid.is_well(key)).mean()),
                "share_by": {
                    name: shares_along(grid, ~grid.is_well(key), axis) for axis, name in enumerate(grid.factors)
                },
            }
            for key in KEYS
        },
        "findings": findings_of(grid),
        "measured": {key: dict(measures) for key, measures in grid.measured.items()},
    }
