"""Blocks: small linear systems with named signals, joined where an output bears the name of an input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import control as ct
import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Treatment:
    """How an effect enters a linearisation; `is_linear` is false where it has none."""

    is_linear: bool
    how: str


def gain(name: str, value: float, source: str, target: str) -> ct.StateSpace:
    """Return a block without a state."""
    return ct.ss([], [], [], [[value]], name=name, inputs=[source], outputs=[target])


def lag(name: str, time_constant: float, state: str, source: str, target: str) -> ct.StateSpace:
    """Return a first-order lag; the identity without a time constant. [s]"""
    if time_constant == 0.0:
        return gain(name, 1.0, source, target)
    rate = 1.0 / time_constant
    return block(name, [[-rate]], [[rate]], [[1.0]], [[0.0]], [state], source, target)


def block(
    name: str, a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike, states: list[str], source: str, target: str
) -> ct.StateSpace:
    """Return a block with states."""
    return ct.ss(a, b, c, d, name=name, states=states, inputs=[source], outputs=[target])


def joined(name: str, blocks: Sequence[ct.StateSpace], source: str, targets: list[str]) -> ct.StateSpace:
    """Join blocks by the names of their signals into one system from a source to some of the signals."""
    whole = ct.interconnect(list(blocks), inputs=[source], outputs=targets, name=name, check_unused=False)
    return ct.ss(
        whole.A, whole.B, whole.C, whole.D, name=name, inputs=[source], outputs=targets,
        states=whole.state_labels, remove_useless_states=False,
    )  # fmt: skip


def static_gain(system: ct.StateSpace) -> np.ndarray:
    """Return the gains at rest, shape (outputs, inputs); infinite where the system integrates."""
    return np.atleast_2d(system.dcgain()).real
