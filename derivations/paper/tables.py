"""Tables 1 and 2, and the sentences of the text that can be checked, as printed."""

from __future__ import annotations

import sympy as sp

from derivations.glossary import symbol
from derivations.paper.printed import Entry

TABLE_1 = {
    "actuator signal": (0.08e6, 0.24e6),
    "converter input": (4e-3, 20e-3),
    "converter output": (0.04e6, 0.21e6),
}
"""Ranges, in Pa and A."""

_ROWS = (
    ("m", "1.36", "kg"),
    ("k", "5.25e4", "kg/s^2"),
    ("S_1", "6.45e-2", "m^2"),
    ("P_1", "3e5", "Pa"),
    ("f_v", "1.59", "kg/s"),
    ("F_c", "1423", "N"),
    ("L_m", "0.4", "m"),
    ("delta_max", "3e-4", "m"),
    ("C_q1", "0.75", "1"),
    ("C_q2", "0.7", "1"),
    ("U", "12", "V"),
    ("D_1", "4.3e-4", "m"),
    ("D_2", "1.6e-3", "m"),
    ("N", "24000", "1"),
    ("sigma", "4.2", "1"),
    ("S", "1.995e-3", "m^2"),
)
TABLE_2 = {letter: Entry(letter, digits, unit) for letter, digits, unit in _ROWS}

_y, _v, _band = symbol("y"), symbol("v"), symbol("epsilon")
SENTENCES = {
    "sweep currents": (6e-3, 20e-3),
    "factors n": (1, 2),
    "exponent v": 2,
    "epsilon": 1e-4,
    "upper point": (20e-3, 0.263, 1),  # current, position, direction in which the stem came there
    "lower point": (7e-3, 0.2131, -1),
    "first group": ("m", "k", "S_1", "P_1", "f_v", "F_c"),  # "(m to F_c) come from reference [18]"
    # The condition on the branch of (33) that each state names, and how the stem moves in it.
    "states": {
        "state-1": (sp.GreaterThan(_y, _band), "rising"),
        "state-2": (sp.StrictLessThan(_v, _band), "stuck"),
        "state-3": (sp.LessThan(_v, -_band), "falling"),
        "state-4": (sp.LessThan(_y, -_band), "stuck"),
    },
    "captions": {
        "1": "conversion diagram in the control loop of the pneumatic control valve",
        "2": "the experimental platform of the pneumatic control valve",
    },
    "reference": ("1", "the experimental equipment"),
    "rising current": "the stem rises",
    "use of the threshold": (1, 1),  # times I_threshold, added when rising, subtracted when falling
    "controller values": (),  # no gain, set point or sample time is printed
}
