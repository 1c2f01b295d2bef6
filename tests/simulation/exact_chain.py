"""The base valve in 50 digits, written from the paper's equations without a line of the simulator."""

from __future__ import annotations

import mpmath as mp

STOP_SPEED = mp.mpf("1e-6")


class ExactValve:
    """Held pressures in, positions out; slips as sums of two exponentials, complex where they ring."""

    def __init__(self, numbers: dict[str, float], ratio: float = 1.0) -> None:
        self.number = {name: mp.mpf(value) for name, value in numbers.items() if mp.isfinite(value)}
        self.breakaway = mp.mpf(ratio) * self.number["coulomb_friction"]

    def pressure(self, current: float) -> mp.mpf:
        """Eqs. (31), (16)."""
        n = self.number
        gap = n["gap_offset"] - n["gap_gain"] * mp.sqrt(mp.mpf(current))
        return n["supply_pressure"] / (1 + n["flow_ratio"] * gap**2)

    def run(self, currents: list[float], period: float) -> list[mp.mpf]:
        """Positions before each period, from rest in the middle of the stuck band."""
        n = self.number
        self.y, self.v = n["diaphragm_area"] * self.pressure(currents[0]) / n["spring_rate"], mp.mpf(0)
        self.side = 0
        self.stops = 0
        out = []
        for current in currents:
            out.append(self.y)
            left = mp.mpf(period)
            events = 0
            while left > 0:
                left -= self.event(self.pressure(current), left)
                events += 1
                assert events < 1000
        return out

    def event(self, pressure: mp.mpf, left: mp.mpf) -> mp.mpf:
        """Move to the next event; time used."""
        n = self.number
        net = n["diaphragm_area"] * pressure - n["spring_rate"] * self.y
        slow = abs(self.v) < STOP_SPEED
        if slow and abs(net) <= self.breakaway:
            self.v, self.side = mp.mpf(0), 0
            return left
        if self.side == 0:
            self.side = 1 if net > 0 else -1
        side = self.side
        m, c, k = n["stem_mass"], n["viscous_friction"], n["spring_rate"]
        # v = A exp(r t) + B exp(s t)
        root = mp.sqrt(mp.mpc((c / m) ** 2 - 4 * k / m))
        r, s = (-c / m + root) / 2, (-c / m - root) / 2
        a = (side * net - n["coulomb_friction"] - c * side * self.v) / m
        v = side * self.v
        first = (a - s * v) / (r - s)
        second = v - first

        def speed(t: mp.mpf) -> mp.mpf:
            return mp.re(first * mp.exp(r * t) + second * mp.exp(s * t))

        def way(t: mp.mpf) -> mp.mpf:
            return mp.re(first * mp.expm1(r * t) / r + second * mp.expm1(s * t) / s)

        def force(t: mp.mpf) -> mp.mpf:
            slope = mp.re(first * r * mp.exp(r * t) + second * s * mp.exp(s * t))
            return m * slope + c * speed(t) + n["coulomb_friction"] - self.breakaway

        stop = self.first_zero(first, second, r, s, v)
        ends = min(stop, left)
        if stop > left and speed(left) < STOP_SPEED and force(left) < 0:
            ends = self.rule(lambda t: max(speed(t) - STOP_SPEED, force(t)), left)
            stop = ends
        self.y += side * way(ends)
        if stop <= left:
            self.v, self.side = mp.mpf(0), 0
            self.stops += 1
        else:
            self.v = side * speed(ends)
        return ends

    @staticmethod
    def first_zero(first, second, r, s, v) -> mp.mpf:
        """First time after 0 at which the speed is 0."""
        if mp.im(r) == 0:
            if mp.re(first) == 0 or -mp.re(second / first) <= 0:
                return mp.inf
            t = mp.log(-mp.re(second / first)) / mp.re(r - s)
            return t if t > mp.mpf("1e-40") else mp.inf
        beta = mp.im(r)
        # Re(2 first exp(i beta t)) = 0
        phase = mp.arg(first)
        t = (mp.pi / 2 - phase) / beta
        while t <= mp.mpf("1e-40"):
            t += mp.pi / beta
        while t - mp.pi / beta > mp.mpf("1e-40"):
            t -= mp.pi / beta
        return t

    @staticmethod
    def rule(value, high: mp.mpf) -> mp.mpf:
        """Last time at which a value was positive, by bisection."""
        low = mp.mpf(0)
        if value(low) <= 0:
            # It rises first: begin where it is largest.
            grid = [high * i / 2000 for i in range(2000)]
            low = max((t for t in grid if value(t) > 0), default=mp.mpf(0))
        for _ in range(170):
            middle = (low + high) / 2
            low, high = (middle, high) if value(middle) > 0 else (low, middle)
        return high
