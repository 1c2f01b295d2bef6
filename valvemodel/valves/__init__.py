"""Valve sets: the numbers of a valve with unit and source, and whether they can be true."""

from valvemodel.valves.figures import Figures, figures
from valvemodel.valves.plausibility import Doubt, plausibility
from valvemodel.valves.reading import read_valve, valve_names, valve_text
from valvemodel.valves.valve import Entry, Valve

__all__ = ["Doubt", "Entry", "Figures", "Valve", "figures", "plausibility", "read_valve", "valve_names", "valve_text"]
