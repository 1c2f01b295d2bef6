"""The findings as plain tables."""

from __future__ import annotations

from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from benchmarks.simulation.contest import ENOUGH


def print_tables(found: dict[str, Any], console: Console) -> None:
    """Print all of them."""
    console.print(contest_table(found))
    if found["left_out"]:
        console.print(f"not installed, left out: {', '.join(found['left_out'])} (optional dependency group `peers`)\n")
    console.print(effects_table(found["effects"]))
    for title in ("chain", "fleet", "closed_loop", "processes"):
        console.print(pairs_table(title.replace("_", " "), found[title]))


def contest_table(found: dict[str, Any]) -> Table:
    """A row a peer, two lines a workload: time and ratio, digits."""
    rows = found["contest"]
    names = list(dict.fromkeys((row["stem"], row["workload"]) for row in rows))
    title = "Stem problem, pressure held over 10 ms: us a period, times slower than valvemodel, (digits)"
    table = Table(title=title, box=box.SIMPLE, title_justify="left")
    table.add_column("")
    table.add_column("lines", justify="right")
    for stem, workload in names:
        table.add_column(f"{stem} {workload}", justify="right")
    for peer in dict.fromkeys(row["peer"] for row in rows):
        cells = [contest_cell(row) for row in rows if row["peer"] == peer]
        first = next(row for row in rows if row["peer"] == peer)
        table.add_row(first["title"], str(first["lines"]), *cells)
    return table


def contest_cell(row: dict[str, Any]) -> str:
    """Time, ratio and digits of a peer on a workload."""
    mark = " loses events" if row["loses_events"] else "" if row["digits"] >= ENOUGH else " below 6"
    ratio = f" {row['ratio']:,.0f}x" if row["ratio"] != 1.0 else ""
    return f"{row['us_per_period']:.3g}{ratio} ({row['digits']:.1f}){mark}"


def effects_table(rows: list[dict[str, Any]]) -> Table:
    """A row a combination of effects."""
    title = "Whole chain with effects, 10 ms; the distance is from a much finer setting of its own (self-convergence)"
    table = Table(title=title, box=box.SIMPLE, title_justify="left")
    for heading in ("effects", "ns a period", "distance [m]", "in a search: ns", "distance [m]"):
        table.add_column(heading, justify="left" if heading == "effects" else "right")
    for row in rows:
        table.add_row(
            row["title"],
            f"{row['ns_per_period']:.0f}",
            f"{row['m_from_finer']:.0e}",
            f"{row['ns_per_period_in_a_search']:.0f}",
            f"{row['m_from_finer_in_a_search']:.0e}",
        )
    return table


def pairs_table(title: str, values: dict[str, Any]) -> Table:
    """A row a figure."""
    table = Table(title=title, box=box.SIMPLE, title_justify="left", show_header=False)
    for name, value in values.items():
        table.add_row(name.replace("_", " "), f"{value:.4g}" if isinstance(value, float) else str(value))
    return table
