"""Axes of a panel: round ticks, a frame, and data to drawing coordinates."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

from synth.reports.figures.palette import GREY, RULE
from synth.reports.figures.svg import Point, Svg

TICK = f'font-size="10" fill="{GREY}"'


@dataclass(frozen=True)
class AxisScale:
    """Data from ``low`` to ``high`` on drawing coordinates from ``start`` to ``end``."""

    low: float
    high: float
    start: float
    end: float
    logarithmic: bool = False

    def __call__(self, value: float) -> float:
        """The drawing coordinate; nan stays nan."""
        if self.logarithmic:
            value, low, high = (math.log(x) if x > 0 else math.nan for x in (value, self.low, self.high))
        else:
            low, high = self.low, self.high
        return self.start + (value - low) / (high - low) * (self.end - self.start)

    def ticks(self, most: int) -> list[float]:
        """Round values within the scale."""
        return log_ticks(self.low, self.high, most) if self.logarithmic else ticks(self.low, self.high, most)


@dataclass(frozen=True)
class Axes:
    """A panel: its frame and scales."""

    x: AxisScale
    y: AxisScale

    def points(self, data: Iterable[Point]) -> list[Point]:
        """Data points in drawing coordinates."""
        return [(self.x(x), self.y(y)) for x, y in data]

    def frame(self, svg: Svg, x_ticks: int = 5, y_ticks: int = 4) -> None:
        """Grid, tick labels and the two axis lines."""
        for tick in (at := self.y.ticks(y_ticks)):
            height = self.y(tick)
            svg.line((self.x.start, height), (self.x.end, height), f'stroke="{RULE}" stroke-width="0.7"')
            svg.text((self.x.start - 4, height + 3.5), tick_text(tick, at), f'text-anchor="end" {TICK}')
        with svg.group("x-ticks"):
            for tick in (at := self.x.ticks(x_ticks)):
                place = self.x(tick)
                svg.line((place, self.y.start), (place, self.y.start + 3), f'stroke="{GREY}" stroke-width="0.8"')
                svg.text((place, self.y.start + 13.5), tick_text(tick, at), f'text-anchor="middle" {TICK}')
        line = f'stroke="{GREY}" stroke-width="0.9"'
        svg.line((self.x.start, self.y.start), (self.x.end, self.y.start), line)
        svg.line((self.x.start, self.y.start), (self.x.start, self.y.end), line)


def ticks(low: float, high: float, most: int) -> list[float]:
    """Multiples of 1, 2 or 5 times a power of ten in [low, high], at most so many; of 4 where 5 gives only one."""
    if not high > low:
        return [low]
    exponent = math.floor(math.log10((high - low) / max(1, most)))
    for m, e in ((m, e) for e in (exponent, exponent + 1, exponent + 2) for m in (1, 2, 5)):
        step = m * 10.0**e
        found = _multiples(step, low, high)
        if len(found) <= most:
            between = _multiples(0.8 * step, low, high)
            return between if m == 5 and len(found) < 2 <= len(between) <= most else found
    return [low]


def _multiples(step: float, low: float, high: float) -> list[float]:
    """All within [low, high]."""
    return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def log_ticks(low: float, high: float, most: int) -> list[float]:
    """Powers of ten in [low, high], with 2 and 5 or finer where few fit."""
    for steps in ((1.0, 1.5, 2.0, 3.0, 5.0, 7.0), (1.0, 2.0, 5.0), (1.0, 3.0), (1.0,)):
        powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        found = [m * 10.0**e for e in powers for m in steps]
        found = [value for value in found if low * (1 - 1e-9) <= value <= high * (1 + 1e-9)]
        if len(found) <= most:
            break
    if len(found) > most:
        found = found[:: math.ceil(len(found) / most)]
    return found if len(found) > 1 else ticks(low, high, most)


def tick_text(tick: float, at: list[float]) -> str:
    """A tick's label with the decimals that its neighbours need."""
    if not tick:
        return "0"
    steps = [abs(b - a) for a, b in itertools.pairwise(at) if b != a]
    step = min(steps) if steps else abs(tick)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    if abs(tick) >= 1e6 or decimals > 6:
        return f"{tick:.2g}".replace("-", "−")
    shown = f"{tick:.{decimals}f}"
    if len(steps) > 1 and max(steps) > 1.5 * step and "." in shown:  # logarithmic: 0.1, 1, 10
        shown = shown.rstrip("0").rstrip(".")
    return shown.replace("-", "−")


def with_margin(values: Iterable[float], share: float = 0.06, least: float = 0.0) -> tuple[float, float]:
    """Least and greatest finite value with a margin; at least ``least`` apart."""
    finite = [value for value in values if math.isfinite(value)]
    low, high = (min(finite), max(finite)) if finite else (0.0, 1.0)
    if high - low < least or high == low:
        # A span of 5 % to either side for a constant curve.
        middle, half = (low + high) / 2, max(least / 2, abs(low) * 0.05, 1e-9)
        low, high = middle - half, middle + half
    margin = share * (high - low)
    return low - margin, high + margin
