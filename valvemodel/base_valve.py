"""The parameters of the base valve, the paper's eqs. (16), (31), (33), each declared once."""

from __future__ import annotations

import math

from valvemodel.declarations import Parameter

BASE_PARAMETERS = (
    Parameter("stem_mass", "kg", "mass of stem and plug", 0.01, 200.0, 1.36, scale="log", prior_spread=0.3),
    Parameter("spring_rate", "N/m", "spring rate", 0.0, 1e7, 52500.0),
    Parameter("diaphragm_area", "m^2", "effective diaphragm area", 1e-4, 1.0, 0.0645, scale="log", is_fitted=False),
    Parameter(
        "supply_pressure", "Pa", "gauge supply pressure", 1e4, 2e6, 3e5, scale="log", is_fitted=False, prior_spread=0.2
    ),
    # The mean of two that may differ by a factor of sixty.
    Parameter("viscous_friction", "N*s/m", "viscous friction", 0.0, 1e6, 612.9, reach=3.5),
    Parameter("coulomb_friction", "N", "Coulomb friction", 0.0, 1e5, 1423.0),
    Parameter("spring_preload", "N", "spring force at position 0", -1e5, 1e5, 0.0, is_fitted=False),
    Parameter(
        "flow_ratio",
        "1/m^2",
        "K = 16 Cq2^2 D2^2 / (Cq1^2 D1^4)",
        1e3,
        1e15,
        1.0437e9,
        scale="log",
        is_fitted=False,
    ),
    Parameter("gap_offset", "m", "c0, the gap of the flapper at no current", 1e-6, 1e-2, 126.30e-6, scale="log"),
    Parameter(
        "gap_gain",
        "m/A^0.5",
        "E, closing of the flapper's gap with the root of the current",
        1e-7,
        1.0,
        750.1e-6,
        scale="log",
    ),
    Parameter("travel_min", "m", "lower travel stop", -10.0, 10.0, -math.inf, is_fitted=False),
    Parameter("travel_max", "m", "upper travel stop", -10.0, 10.0, math.inf, is_fitted=False),
    Parameter(
        "restitution",
        "1",
        "speed after hitting an end of the travel over speed before",
        0.0,
        0.95,
        0.0,
        is_fitted=False,
    ),
    Parameter("rated_travel", "m", "travel from 0 to 100 %", 1e-4, 10.0, 0.25, is_fitted=False),
    Parameter(
        "pressure_at_zero_current",
        "Pa",
        "affine map of current to pressure: offset",
        -1e7,
        1e7,
        0.0,
        is_fitted=False,
    ),
    Parameter(
        "pressure_per_current",
        "Pa/A",
        "affine map of current to pressure: slope; 0 selects eqs. (16), (31)",
        0.0,
        1e10,
        0.0,
        is_fitted=False,
    ),
)
"""In the order in which they are shown. Stem, nozzle and electromagnet share them."""

ON_PRESSURE = (
    "supply_pressure",
    "flow_ratio",
    "gap_offset",
    "gap_gain",
    "pressure_at_zero_current",
    "pressure_per_current",
)
"""Those that act on the pressure; all others act behind it."""

BY_PRESSURE = ("supply_pressure",)
"""Those that only a measured pressure tells, and that are fitted where there is one."""

FITTED_BASE = tuple(parameter for parameter in BASE_PARAMETERS if parameter.is_fitted)
