"""Statistics of the records: success, bias, spread, and coverage of the intervals, over all legs and by kind."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Record = Mapping[str, Any]
QUANTITIES = {"spring_rate": "spring rate", "damper_rate": "damper rate", "free_angle": "free angle"}
NEAR = (
    0.3  # log RMS over the true leg's, up to which the fit is in the right minimum: links off by their tolerance cost
)
# up to 0.22 (50 legs, seeds 5000 on), another minimum several times as much
NORMAL90 = 1.6448536269514722
TIGHT = 0.10  # of a log rate: an interval of that half-width counts as determining it


@dataclass(frozen=True)
class Line:
    """A group of legs. ``held`` is the share of 90 % intervals with the truth in them, ``error`` its standard error.

    ``success`` : the fit ended, and leaves no more than the true leg does. ``bias`` mean error over standard deviation,
    ``rate`` median absolute error of rates that the interval claims to know, share; ``width`` median half-width.
    """

    name: str
    legs: int
    intervals: int
    success: float
    held: float
    error: float
    bias: float
    rate: float
    width: float

    @property
    def within(self) -> bool:
        """Whether the coverage is 88 to 92 %, within two standard errors."""
        return self.held - 2 * self.error <= 0.92 and self.held + 2 * self.error >= 0.88


def headline(record: Record) -> Record:
    """The headline fit."""
    found: Record = record["fits"][record["headline"]]
    return found


def succeeded(fit: Record) -> bool:
    """The fit ended, and in the right minimum."""
    return bool(fit["done"]) and fit["over"] < NEAR


def estimates(fit: Record, quantities: Sequence[str] = tuple(QUANTITIES)) -> Iterator[tuple[str, float, float, float]]:
    """Quantity, error, low and high end, all minus the truth."""
    if fit["done"]:
        for joint in fit["joints"]:
            for name in quantities:
                error, low, high = joint[name]
                yield name, error, low, high


def line(name: str, fits: Sequence[Record], quantities: Sequence[str] = tuple(QUANTITIES)) -> Line:
    """Numbers of a group; legs, not intervals, are taken to be independent (cluster-robust standard error)."""
    inside, scores, rates, widths, by_leg = [], [], [], [], []
    for fit in fits:
        mine = [low <= 0.0 <= high for _, _, low, high in estimates(fit, quantities)]
        inside += mine
        by_leg.append((sum(mine), len(mine)))
        for quantity, error, low, high in estimates(fit, quantities):
            half = (high - low) / 2
            scores.append(error / half * NORMAL90 if half > 0 else math.nan)
            if quantity != "free_angle":
                widths.append(half)
                if half < TIGHT:
                    rates.append(abs(error))
    count = len(inside)
    held = sum(inside) / count if count else math.nan
    spread = math.sqrt(sum((hit - held * size) ** 2 for hit, size in by_leg)) / count if count else math.nan
    return Line(
        name, len(fits), count,
        sum(map(succeeded, fits)) / len(fits) if fits else math.nan,
        held, spread,
        float(np.median(scores)) if scores else math.nan,
        float(np.median(rates)) if rates else math.nan,
        float(np.median(widths)) if widths else math.nan,
    )  # fmt: skip


def groups(records: Sequence[Record]) -> list[tuple[str, list[Line]]]:
    """Tables by drawn property, each a list of lines."""
    tables = [("Estimate", [line(words, [headline(r) for r in records], [q]) for q, words in QUANTITIES.items()])]
    splits: list[tuple[str, Callable[[Record], str]]] = [
        ("Noise", lambda r: _band(r["noise"], (0.1, 0.2, 0.35), "deg")),
        ("Noise over one count", lambda r: _band(r["noise"] * r["counts"] / 360, (0.25, 0.6, 2.0), "counts")),
        ("Counts a turn", lambda r: f"{r['counts']:5d}"),
        ("Sampling", lambda r: _band(r["rate"], (200, 400, 700), "Hz")),
        ("Trials", lambda r: _band(r["trials"], (2, 5, 12), "trials")),
        ("Links", lambda r: str(len(r["joints"]))),
        ("Damping", _damping),
        ("Clock", lambda r: "even" if not r["uneven"] else _band(r["uneven"], (0.1,), "of a step, RMS")),
        ("Lost samples", lambda r: "5 % lost" if r["lost"] else "none lost"),
        ("Hand", lambda r: "drives the first 0.15 s" if r["driven"] else "none"),
    ]
    for title, key in splits:
        names = sorted({key(record) for record in records})
        tables.append((title, [line(n.strip(), [headline(r) for r in records if key(r) == n]) for n in names]))
    return tables


def exact_lines(records: Sequence[Record]) -> list[Line]:
    """The same trials with the true links and no tolerance: uncertainty due to the samples alone."""
    exact = [r["fits"]["exact"] for r in records]
    return [line("all", exact), *(line(words, exact, [q]) for q, words in QUANTITIES.items())]


def hand_lines(records: Sequence[Record]) -> list[Line]:
    """Treatments of an external torque at the start, side by side, on the legs with both."""
    driven = [r for r in records if r["driven"]]
    free = [r for r in records if not r["driven"]]
    unseen = [r for r in driven if "free" not in r["fits"]]
    made = [
        line("driven, cut at the known end of the torque", [r["fits"]["known"] for r in driven]),
        line("driven, cut by detection", [r["fits"]["free"] for r in driven if "free" in r["fits"]]),
        line("driven, as synth fit does", [headline(r) for r in driven]),
        line("driven, no torque detected in any trial: as synth fit does", [headline(r) for r in unseen]),
        line("driven, no torque detected in any trial: as recorded", [r["fits"]["recorded"] for r in unseen]),
        line(
            "driven, fitted as recorded (few trials)",
            [r["fits"]["recorded"] for r in driven if "recorded" in r["fits"] and "free" in r["fits"]],
        ),
        line("free, no torque detected: as synth fit does", [headline(r) for r in free if "free" not in r["fits"]]),
        line("free, a torque detected: as synth fit does", [headline(r) for r in free if "free" in r["fits"]]),
        line("free, a torque detected: cut all the same", [r["fits"]["free"] for r in free if "free" in r["fits"]]),
    ]
    return [item for item in made if item.legs]


def hands(records: Sequence[Record]) -> dict[str, tuple[int, int]]:
    """Share of trials in which an external torque is detected, of driven and of free legs."""
    found = {}
    for name, driven in (("driven", True), ("free", False)):
        seen = [until for r in records if bool(r["driven"]) is driven for until in r["hands"]]
        found[name] = sum(until is not None for until in seen), len(seen)
    return found


def _band(value: float, edges: Sequence[float], unit: str) -> str:
    """The band of a value, sorted as text by the blanks before it."""
    for index, edge in enumerate(edges):
        if value < edge:
            low = f"{edges[index - 1]:g} to " if index else "under "
            return " " * (len(edges) - index) + f"{low}{edge:g} {unit}"
    return f"{edges[-1]:g} {unit} and more"


def _damping(record: Record) -> str:
    over = [ratio > 1 for ratio in record["damping_ratio"]]
    return "   all joints swing" if not any(over) else "  some overdamped" if not all(over) else " all overdamped"
