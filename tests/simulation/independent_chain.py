"""The chain with every integrated effect, written from the equations for an adaptive integrator of high order.

Not a line of the simulator: SciPy's DOP853 at 1e-12 between events that it locates itself, kinks of the pressure
among them. State: flux current, place in the hysteresis loop, sag, chamber and filled pressure, stem position and
speed, bristle force, lagged reading, and that behind a filter; the coil's current, before the eddy currents.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FLUX, LOOP, SAG, CHAMBER, FILLED, STEM, SPEED, BRISTLE, READING, FILTERED, COIL = range(11)
STOP_SPEED = 1e-6
WITHIN = 1e-10
"""Share of the breakaway force that a creep must be inside of; the rest of its way is below 1e-11 m."""

TINY = 1e-10
"""Time after an event in which the same is not looked for. [s]"""

KINK = 1e-7
"""Below this a driving pressure difference is at rest. [Pa], [Pa/s]"""


class IndependentChain:
    """Held currents in, readings out."""

    def __init__(self, numbers: dict[str, float], *, precision: float = 1e-12) -> None:
        for name, value in numbers.items():
            setattr(self, name, value)
        self.precision = precision
        is_dead = self.stop_compliance == 0.0
        self.highest = min(self.travel_max, self.upper_stop) if is_dead else self.travel_max
        self.lowest = max(self.travel_min, self.lower_stop) if is_dead else self.travel_min
        self.ratio = max(self.static_friction_ratio, self.stribeck_ratio)

    @classmethod
    def of(cls, model):
        """The chain of a model's numbers."""
        row = model.rows()[0]
        return cls({name: float(row[name]) for name in row.dtype.names})

    # Electromagnet and nozzle, some of it for complex arguments: their imaginary part carries a derivative.

    def saturated(self, current):
        """Normal magnetisation curve."""
        if self.saturation_slope == 1.0:
            return current
        width, knee, reach = self.saturation_rounding, self.saturation_knee, self.saturation_reach

        def lost(x):
            ramp = 0.5 * (x - knee + np.sqrt((x - knee) ** 2 + width**2))
            return ramp - reach * ramp / (reach + ramp)

        return current - (1.0 - self.saturation_slope) * (lost(current) - lost(0.0))

    def loop_rate(self, loop, change):
        """dz of Bouc and Wen, of exponent 1, by a change of the saturated current."""
        if self.hysteresis_half_width == 0.0:
            return 0.0
        gamma = self.bouc_wen_gamma
        reach = 2.0 * self.hysteresis_half_width * (1.0 - gamma) * (1.0 + self.hysteresis_roundness)
        return (1.0 - abs(loop) * ((1.0 - gamma) * np.sign(loop * change) + gamma)) * change / reach

    def gap(self, flux, loop, time):
        """Eq. (31) with drift."""
        effective = self.saturated(flux) - self.hysteresis_half_width * loop
        drifted = self.gap_drift_rate * self.gap_drift_time * (1.0 - np.exp(-time / self.gap_drift_time))
        return self.gap_offset - self.gap_gain * np.sqrt(effective) + drifted

    def share(self, gap):
        """Eq. (16) over the supply, or the balance of the choking holes."""
        share = 1.0 / (1.0 + self.flow_ratio * gap**2)
        if self.compressible_share == 0.0:
            return share
        high, opening, critical = self.supply_pressure + 101325.0, math.sqrt(self.flow_ratio) * gap.real, 0.0
        critical = self.critical_pressure_ratio

        def psi(ratio):
            return 1.0 if ratio <= critical else math.sqrt(max(1.0 - ((ratio - critical) / (1.0 - critical)) ** 2, 0.0))

        def balance(x):
            return high * psi(x / high) - opening * x * psi(101325.0 / x)

        root = brentq(balance, 101325.0, high, xtol=1e-9, rtol=1e-15)
        compressible = (root - 101325.0) / self.supply_pressure
        return share + self.compressible_share * (compressible - share)

    def inflow(self, pressure, gap):
        """Eq. (15), right side."""
        part = pressure / self.supply_pressure
        turbulent = math.sqrt(max(1.0 - part, 0.0)) - gap * math.sqrt(self.flow_ratio * max(part, 0.0))
        return (1.0 - self.laminar_filling) * turbulent - self.laminar_filling * part

    def settled_sag(self, share):
        return self.droop_consumption * self.supply_pressure * np.sqrt(1.0 - share)

    def behind_leak(self, pressure):
        loss = self.leak_ratio * math.sqrt(self.supply_pressure)
        kept = 1.0 + self.turbulent_leak_ratio
        return ((-loss + math.sqrt(loss**2 + 4.0 * kept * pressure)) / (2.0 * kept)) ** 2

    def upstream(self, time, x, current):
        """Rates of all that is upstream of the stem, and the actuator pressure."""
        rates = np.zeros(11)
        has_lag = self.coil_time_constant > 0.0
        flux = x[FLUX] if has_lag else current
        if has_lag and self.eddy_time_constant > 0.0:
            rates[COIL] = (current - x[COIL]) / self.coil_time_constant
            rates[FLUX] = (x[COIL] - flux) / self.eddy_time_constant
        elif has_lag:
            rates[FLUX] = (current - flux) / self.coil_time_constant
        if has_lag:
            bent = self.saturated(flux + 1e-30j * rates[FLUX]).imag / 1e-30
            rates[LOOP] = self.loop_rate(x[LOOP], bent)
        gap = self.gap(flux, x[LOOP], time)
        share = self.share(gap)
        pressure = (self.supply_pressure - x[SAG]) * share
        if self.droop_gain > 0.0 or self.droop_consumption > 0.0:
            share_rate = 0.0
            if self.compressible_share == 0.0:
                moved = self.gap(flux + 1e-30j * rates[FLUX], x[LOOP] + 1e-30j * rates[LOOP], time + 1e-30j)
                share_rate = self.share(moved).imag / 1e-30
            recovery = (self.settled_sag(share) - x[SAG]) / self.droop_recovery_time
            tendency = (self.supply_pressure - x[SAG]) * share_rate - share * recovery
            rates[SAG] = recovery
            if tendency > 0.0:
                rates[SAG] += self.droop_gain * tendency / (1.0 + self.droop_gain * share)
            self.tendency = tendency
        if self.chamber_filling_time > 0.0:
            own = self.chamber_filling_time * (1.0 + self.filling_growth * x[CHAMBER] / self.supply_pressure)
            excess = self.inflow(x[CHAMBER], gap) - self.inflow(pressure, gap)
            own /= 1.0 + self.filling_of_gas * x[CHAMBER] / 101325.0
            rates[CHAMBER] = excess * self.supply_pressure / own
            pressure = x[CHAMBER]
        if self.fill_time > 0.0 or self.vent_time > 0.0:
            self.lead = pressure - x[FILLED]
            rates[FILLED] = self.lead / (self.fill_time if self.lead > 0.0 else self.vent_time)
            if self.filling_slowness > 0.0:
                rates[FILLED] = max(rates[FILLED], -1.0 / self.filling_slowness)
            elif self.filling_slowness < 0.0:
                rates[FILLED] = min(rates[FILLED], -1.0 / self.filling_slowness)
            pressure = x[FILLED]
        return rates, self.behind_leak(pressure)

    # Stem.

    def thrust(self, time, y, pressure):
        area = self.diaphragm_area * (1.0 + self.area_slope * y + self.area_curvature * y**2)
        spring = self.spring_rate * y * (1.0 + self.spring_progression * y + self.spring_hardening * y**2)
        angle = 2.0 * math.pi * time / self.load_period
        load = self.load_sine * math.sin(angle) + self.load_cosine * math.cos(angle)
        for n in range(2, round(self.load_waves) + 1):
            load += getattr(self, f"load_sine_{n}") * math.sin(n * angle)
            load += getattr(self, f"load_cosine_{n}") * math.cos(n * angle)
        return area * pressure - spring - self.spring_preload + load - self.contact(y)

    def contact(self, y):
        return (
            (y - min(max(y, self.lower_stop), self.upper_stop)) / self.stop_compliance if self.stop_compliance else 0.0
        )

    def coulomb(self, time, y, pressure, side):
        friction = self.coulomb_friction * (1.0 + self.friction_asymmetry * side)
        power = abs((y - self.tight_spot_position) / self.tight_spot_width) ** self.tight_spot_exponent
        left = max(1.0 - self.tight_spot_closure * power, 0.0)
        shape = left ** (1.0 / self.tight_spot_closure) if self.tight_spot_closure else math.exp(-power)
        friction *= 1.0 + self.tight_spot_excess * shape
        if self.friction_area != 0.0:
            friction += (
                self.friction_area * pressure * (pressure / self.supply_pressure) ** (self.friction_pressure_order - 1)
            )
        grown = self.friction_drift_rate * self.friction_drift_time
        return friction * (1.0 + grown * (1.0 - math.exp(-time / self.friction_drift_time)))

    def limit(self, time, y, pressure, side, speed):
        """What the bristles approach."""
        share = self.fallen(abs(speed)) if self.stribeck_ratio > 1.0 else math.exp(-abs(speed) / 1e-3)
        return self.coulomb(time, y, pressure, side) * (1.0 + (self.ratio - 1.0) * share)

    def fallen(self, speed):
        """How much of the drop from breakaway is left, by Stribeck or Hess and Soom."""
        u = abs(max(speed / self.stribeck_velocity, -0.5)) ** self.stribeck_shape
        return math.exp(-u) + self.stribeck_tail * (1.0 / (1.0 + u) - math.exp(-u))

    def rates(self, time, x, current):
        rates, pressure = self.upstream(time, x, current)
        side, y, v = self.side, x[STEM], x[SPEED]
        self.pressure = pressure
        if side != 0:
            drive = self.thrust(time, y, pressure) - self.viscous_friction * (1.0 + self.viscous_asymmetry * side) * v
            if self.presliding_compliance > 0.0:
                drive -= x[BRISTLE]
                limit = self.limit(time, y, pressure, side, v)
                rates[BRISTLE] = v / self.presliding_compliance * (1.0 - side * x[BRISTLE] / limit)
            else:
                falling = (self.stribeck_ratio - 1.0) * self.fallen(side * v)
                drive -= side * self.coulomb(time, y, pressure, side) * (1.0 + falling)
            rates[STEM], rates[SPEED] = v, drive / self.stem_mass
        if self.sensor_time_constant > 0.0:
            rates[READING] = (self.bow(self.linkage_at(y)) - x[READING]) / self.sensor_time_constant
        if self.sensor_second_time_constant > 0.0:
            arriving = x[READING] if self.sensor_time_constant > 0.0 else self.bow(self.linkage_at(y))
            rates[FILTERED] = (arriving - x[FILTERED]) / self.sensor_second_time_constant
        return rates

    # Sensor.

    def linkage_at(self, y):
        """Where its plays leave the linkage: the mean of both, each dragged by the stem or where it was."""
        return 0.5 * sum(self.part_at(number, y) for number in (0, 1))

    def part_at(self, number, y):
        if self.drag[number] == 0:
            return self.parts[number]
        return y - self.drag[number] * self.half_widths[number]

    def bow(self, z):
        share = z / self.rated_travel
        skew = math.sqrt(27.0) / 2.0 * self.linkage_skew * (1.0 - 2.0 * share)
        return z + 4.0 * share * (1.0 - share) * (self.linkage_bow + skew)

    def reading(self, x):
        if self.sensor_second_time_constant > 0.0:
            return x[FILTERED]
        return x[READING] if self.sensor_time_constant > 0.0 else self.bow(self.linkage_at(x[STEM]))

    # Events.

    def watch(self, current):
        """Events of the present mode: name, function; each ends the integration where it falls to 0."""

        def holds(time, x, side, within=WITHIN):
            _, pressure = self.upstream(time, x, current)
            net = self.thrust(time, x[STEM], pressure)
            return self.ratio * (1.0 + within) * self.coulomb(time, x[STEM], pressure, side) - side * net

        events = {}
        if self.presliding_compliance == 0.0 and self.side == 0:
            events["rise"] = lambda t, x: 1.0 if x[STEM] >= self.highest else holds(t, x, 1, 2.0 * WITHIN)
            events["fall"] = lambda t, x: 1.0 if x[STEM] <= self.lowest else holds(t, x, -1, 2.0 * WITHIN)
        elif self.side == 0 and self.pressed != 0:

            def turn(t, x):
                _, pressure = self.upstream(t, x, current)
                return self.pressed * (self.thrust(t, x[STEM], pressure) - x[BRISTLE])

            events["turn"] = turn
        elif self.side != 0:
            side = self.side
            events["stop"] = lambda t, x: side * x[SPEED]
            end = self.highest if side > 0 else self.lowest
            if math.isfinite(end):
                events["limit"] = lambda t, x: side * (end - x[STEM])
            if self.presliding_compliance == 0.0:

                def rest(t, x):
                    sides = (holds(t, x, 1), holds(t, x, -1))
                    excess = max(side * x[SPEED] / self.stick_speed - 1.0, -min(sides) / self.coulomb_friction)
                    if self.stick_speed == STOP_SPEED:
                        return excess
                    return max(excess, side * self.rates(t, x, current)[SPEED])

                events["rest"] = rest
            for number, b in enumerate(self.half_widths):
                if self.drag[number] != side:
                    events[f"contact {number}"] = lambda t, x, n=number, b=b: b - side * (x[STEM] - self.parts[n])

        def of(name):
            def function(t, x):
                self.upstream(t, x, current)
                return getattr(self, name)

            return function

        if self.droop_gain > 0.0:
            events["tendency"] = of("tendency")
        if self.fill_time > 0.0 or self.vent_time > 0.0:
            events["lead"] = of("lead")
            if self.filling_slowness != 0.0:
                wide = (self.vent_time if self.filling_slowness > 0.0 else self.fill_time) / abs(self.filling_slowness)
                way = -1.0 if self.filling_slowness > 0.0 else 1.0
                lead = of("lead")
                events["capacity"] = lambda t, x: way * lead(t, x) - wide
        return events

    def hold(self, time, x, current, duration):
        """Hold a current, from event to event."""
        self.switch(x, current)
        used, rounds = 0.0, 0
        while used < duration:
            rounds += 1
            assert rounds < 400, (time, x)
            self.choose_mode(time + used, x, current)
            events = self.watch(current)
            functions = []
            for name, function in events.items():
                functions.append(self.event_of(name, function, time + used, x))
            solution = self.integrate(time + used, time + duration, x, current, functions)
            end, x = solution.t[-1], solution.y[:, -1].copy()
            met = [name for name, found in zip(events, solution.t_events, strict=True) if len(found)]
            used = end - time
            if solution.status == 0:
                used = duration
            self.settle(x, met)
        return x

    @staticmethod
    def event_of(name, function, start, x):
        """The event of a function that falls to 0; kinks of the pressure have either sign, and none at rest."""
        begin = function(start, x)
        is_kink = name in {"tendency", "lead", "capacity"}
        side = float(np.sign(begin)) if is_kink else 1.0

        def event(t, x):
            if is_kink:
                return side * function(t, x) + KINK if abs(begin) > KINK else 1.0
            # What begins at 0 is left before it can be met again.
            return function(t, x) if t - start > TINY or begin > 0.0 else abs(function(t, x)) + 1e-9

        event.terminal, event.direction = True, -1
        return event

    def integrate(self, start, end, x, current, functions):
        return solve_ivp(
            lambda t, x: self.rates(t, x, current), (start, end), x, "DOP853",
            events=functions, rtol=self.precision, atol=self.scales(), max_step=2e-3,
        )  # fmt: skip

    def scales(self):
        share = self.precision
        return np.array([1e-2, 1.0, 3e5, 3e5, 3e5, 0.1, 0.1, 1e3, 0.1, 0.1, 1e-2]) * share

    def switch(self, x, current):
        """What a jump of the current does at once."""
        before = (self.supply_pressure - x[SAG]) * self.held_share
        if self.coil_time_constant == 0.0 and self.hysteresis_half_width > 0.0:
            change = self.saturated(current) - self.saturated(x[FLUX])
            way = solve_ivp(
                lambda _, z: [self.loop_rate(z[0], change)], (0.0, 1.0), [x[LOOP]], "DOP853",
                rtol=self.precision, atol=self.precision, max_step=0.02,
            )  # fmt: skip
            x[LOOP] = way.y[0, -1]
        if self.coil_time_constant == 0.0:
            x[FLUX] = current
            share = self.share(self.gap(current, x[LOOP], self.now))
            rise = (self.supply_pressure - x[SAG]) * share - before
            x[SAG] += self.droop_gain * max(rise, 0.0) / (1.0 + self.droop_gain * share)

    def choose_mode(self, time, x, current):
        """Decide whether a stem at rest moves, and whether the linkage is dragged."""
        _, pressure = self.upstream(time, x, current)
        if self.side == 0:
            net = self.thrust(time, x[STEM], pressure)
            if self.presliding_compliance > 0.0:
                later = self.rates_at_rest(time, x, current)
                net -= x[BRISTLE]
                side = int(np.sign(net)) if abs(net) > 1e-9 else int(np.sign(later))
                self.side = side
            else:
                side = 1 if net > 0.0 else -1
                holds = self.ratio * (1.0 + 2.0 * WITHIN) * self.coulomb(time, x[STEM], pressure, side)
                self.side = side if abs(net) > holds else 0
            blocked = (self.side > 0 and x[STEM] >= self.highest) or (self.side < 0 and x[STEM] <= self.lowest)
            self.pressed = self.side if blocked else 0
            if blocked:
                self.side = 0
            x[SPEED] = 0.0
        for number, half_width in enumerate(self.half_widths):
            if self.side != 0 and self.drag[number] != self.side:
                self.parts[number], self.drag[number] = self.part_at(number, x[STEM]), 0
                if self.side * (x[STEM] - self.parts[number]) >= half_width - 1e-13:
                    self.drag[number] = self.side

    def rates_at_rest(self, time, x, current):
        """How fast the thrust on a stem at rest changes."""
        ahead = x + 1e-6 * self.upstream(time, x, current)[0]
        _, before = self.upstream(time, x, current)
        _, after = self.upstream(time + 1e-6, ahead, current)
        return self.thrust(time + 1e-6, x[STEM], after) - self.thrust(time, x[STEM], before)

    def settle(self, x, met):
        """Take the consequences of events."""
        if "limit" in met:
            x[STEM] = self.highest if self.side > 0 else self.lowest
        if {"stop", "rest", "limit"} & set(met):
            x[SPEED], self.side = 0.0, 0
        for number in (0, 1):
            if f"contact {number}" in met:
                self.drag[number] = self.side
        if "rise" in met or "fall" in met:
            self.side = 1 if "rise" in met else -1
            x[SPEED] = 0.0

    def run(self, time, currents):
        """Readings before each period, from rest in the middle of the stuck band. [m]"""
        self.side, self.pressed, self.drag, self.now = 0, 0, [0, 0], 0.0
        self.half_widths = [self.backlash_half_width * (1.0 + way * self.backlash_wear) for way in (-1.0, 1.0)]
        x = np.zeros(11)
        x[FLUX] = x[COIL] = currents[0]
        share = self.share(self.gap(currents[0], 0.0, 0.0))
        self.held_share = share
        x[SAG] = self.settled_sag(share)
        x[CHAMBER] = x[FILLED] = (self.supply_pressure - x[SAG]) * share
        pressure = self.behind_leak(x[FILLED])
        x[STEM] = brentq(lambda y: self.thrust(0.0, y, pressure), -1.0, 2.0, xtol=1e-16, rtol=1e-15)
        if self.presliding_compliance > 0.0:
            limit = self.limit(0.0, x[STEM], pressure, 0, 0.0)
            x[BRISTLE] = min(max(self.contact(x[STEM]), -limit), limit)
        x[READING] = x[FILTERED] = self.bow(x[STEM])
        self.parts = [x[STEM] - self.backlash_start * (self.backlash_half_width - half) for half in self.half_widths]
        x[STEM] -= self.backlash_start * self.backlash_half_width
        readings = []
        for sample, current in enumerate(currents):
            readings.append(self.reading(x))
            if sample + 1 < len(currents):
                self.now = time[sample]
                x = self.hold(time[sample], x, current, time[sample + 1] - time[sample])
                self.held_share = self.share(self.gap(x[FLUX], x[LOOP], time[sample + 1]))
        return np.array(readings)
