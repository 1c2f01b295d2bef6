"""The four stages of the chain, each a room with its physics and its effects; the one list of all effects."""

from valvemodel.declarations import Effect
from valvemodel.stages import electromagnet, nozzle, sensor, stem

EFFECTS: tuple[Effect, ...] = electromagnet.EFFECTS + nozzle.EFFECTS + stem.EFFECTS + sensor.EFFECTS
