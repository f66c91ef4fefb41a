"""Time: gaps and jitter, samples per period of the fastest swing, and implausible clocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.diagnosis.check.finding import Finding, Level
from synth.diagnosis.check.undersampling import (
    ENOUGH_SAMPLES,
    LEAST_SAMPLES,
    FrequencyDoubt,
    designed_swings,
    doubt_of_frequency,
    hanging_stiffness,
    reading_jumps,
)
from synth.fit.recordings import Recording
from synth.pace import SINUSOID_PACE
from synth.sampling import densest_clock
from synth.swing.leg_model import Leg
from synth.swing.mechanics import outboard_inertia
from synth.units import quantity

HOLE_STEPS = 4.5  # times the usual step, as in ``motion.smoothing``
MOST_JITTER = 0.2  # of the step, RMS: more jitter suggests wrong time stamps rather than samples
# A clock in ms is wrong by a thousand. Frequencies of a leg with effects lie within a few times the nominal ones.
OTHER_CLOCK_RATIO = 30.0
CLOCK_UNITS = {"ns": "nanoseconds", "us": "microseconds", "ms": "milliseconds", "s": "seconds"}  # by thousands
NEAR_POWER = 1.0  # of the logarithm: a motion up to ten times beyond the leg's own, as effects and tolerances allow


@dataclass(frozen=True)
class Sampling:
    """One recording: samples, median ``step`` s, longest ``hole`` s, ``frequency`` Hz of its fastest joint.

    ``designed`` : Hz, slowest and fastest swing of the designed leg's free joints; None if nothing swings freely.
    ``against`` : what speaks against ``frequency``, see ``undersampling.doubt_of_frequency``.
    """

    name: str
    samples: int
    step: float
    hole: float
    frequency: float
    designed: tuple[float, float] | None = None
    against: FrequencyDoubt = ""

    @property
    def a_period(self) -> float:
        """Samples per period of the fastest joint's swing, as read."""
        return 1.0 / (self.frequency * self.step)

    @property
    def resolved(self) -> bool:
        """Whether its samples show its motion, and noise apart from it."""
        return self.against not in ("slow", "jumps", "unclear")

    def as_json(self) -> dict[str, Any]:
        """The entry under ``recordings``."""
        return {
            "file": self.name,
            "samples": self.samples,
            "step": quantity(self.step, "s"),
            "longest_hole": quantity(self.hole, "s"),
            "fastest_motion": None if self.against else quantity(self.frequency, "Hz"),
            "samples_a_period": None if self.against else self.a_period,
            "designed_swing": None if self.designed is None else quantity(self.designed[1], "Hz"),
        }


def describe_sampling(leg: Leg, recording: Recording) -> Sampling:
    """Sample steps of a recording, its pace as a frequency, and what speaks against that."""
    step, hole = recording.step, float(np.diff(densest_clock(recording.time, recording.moments)).max())
    frequency = SINUSOID_PACE / recording.smoothed.pace / (2.0 * np.pi)
    designed = designed_swings(leg, recording)
    against: FrequencyDoubt = doubt_of_frequency(1.0 / step, frequency, designed, reading_jumps(recording))
    span = None if recording.driven else _natural_rates(leg)
    if span is not None and _clock_factor(frequency, span) is not None:
        against = ""  # the clock is another: nothing can be said by the designed leg's
    return Sampling(recording.name, len(recording.time), step, hole, frequency, designed, against)


def clock_findings(
    leg: Leg, recordings: Sequence[Recording], made: Sequence[Sampling], units: Mapping[str, str] | None = None
) -> list[Finding]:
    """Faults of the recordings' clocks, individually and relative to the leg.

    ``units`` : of recordings' clocks, as their files' headers have it; of others it is not known.
    """
    found = _clock_unit_findings(leg, recordings, made, units or {})
    for recording, one in zip(recordings, made, strict=True):
        found += _hole_findings(recording, one)
        found += _jitter_findings(recording, one)
    found += _sample_count_findings(made)
    return found


def _clock_unit_findings(
    leg: Leg, recordings: Sequence[Recording], made: Sequence[Sampling], units: Mapping[str, str]
) -> list[Finding]:
    """Motion far slower or faster than springs, gravity and dampers of the designed leg allow."""
    free = [(r, one) for r, one in zip(recordings, made, strict=True) if not r.driven]
    span = _natural_rates(leg)
    if not free or span is None:
        return []
    slowest, fastest = span
    groups: dict[tuple[str, str], list[Sampling]] = {}
    for _, one in free:
        off = _clock_factor(one.frequency, span)
        if off is not None:
            groups.setdefault(_clock_words(off, units.get(one.name, "")), []).append(one)
    found = []
    for (looks, remedy), group in groups.items():
        usual = float(np.median([one.frequency for one in group]))
        text = f"the fastest joint moves at about {usual:.2g} Hz; the designed leg moves at {slowest:.2g} to "
        text += f"{fastest:.2g} Hz. {looks}"
        more = f" and {len(group) - 1} more" if len(group) > 1 else ""
        found.append(Finding("fault", text, remedy, group[0].name + more))
    return found


def _clock_factor(frequency: float, span: tuple[float, float]) -> float | None:
    """How many times too fast for another clock than the leg's ``span`` (Hz), below 1 too slow; None: possible."""
    off = frequency / span[0] if frequency < span[0] else frequency / span[1]
    return None if 1.0 / OTHER_CLOCK_RATIO < off < OTHER_CLOCK_RATIO else off


def _clock_words(off: float, written: str) -> tuple[str, str]:
    """What the time looks like of a motion ``off`` times as fast as expected, and what to do.

    ``written`` : its unit in the file's header, empty if there is none. A unit is named only if a clock has it, and its
    numbers are off by about the power of a thousand that lies between it and the written one.
    """
    power = round(float(np.log10(off)) / 3.0)
    if power == 0 or abs(float(np.log10(off)) - 3.0 * power) > NEAR_POWER:
        where = f"; its header has [{written}]" if written else ""
        return "The time looks wrong", f"find out in which unit the time was recorded{where}"
    if written in CLOCK_UNITS:
        place = list(CLOCK_UNITS).index(written) + power
        if 0 <= place < len(CLOCK_UNITS):
            unit = list(CLOCK_UNITS)[place]
            looks = f"The time looks like {CLOCK_UNITS[unit]} labelled {written}"
            return looks, f"correct the unit in the column's header: time [{unit}]"
    times = f"{10.0 ** abs(3 * power):,.0f}".replace(",", " ")
    looks = f"The times look {times} times too {'small' if power > 0 else 'large'}"
    told = f"; no other unit in the header than [{written}] does that" if written else ""
    return looks, f"{'multiply' if power > 0 else 'divide'} them by {times}{told}"


def _natural_rates(leg: Leg) -> tuple[float, float] | None:
    """Lowest and highest rate (Hz) of any joint alone with spring, gravity and damper; None without stiffness."""
    inertia, stiffness = outboard_inertia(leg), hanging_stiffness(leg)
    swing = np.sqrt(stiffness / inertia) / (2.0 * np.pi)
    if not np.any(swing > 0.0):
        return None
    creep = []
    for j, joint in enumerate(leg.joints):
        rate = joint.damper.rate if joint.damper is not None and joint.damper.rate else 0.0
        if rate**2 > 4.0 * stiffness[j] * inertia[j] > 0.0:
            creep.append(float(stiffness[j] / rate) / (2.0 * np.pi))
    return min([*swing[swing > 0.0].tolist(), *creep]), float(swing.max())


def _hole_findings(recording: Recording, one: Sampling) -> list[Finding]:
    clock = densest_clock(recording.time, recording.moments)
    long = np.flatnonzero(np.diff(clock) > HOLE_STEPS * one.step)
    lost = recording.moments & ~recording.counts
    share = lost[:, recording.free].sum() / recording.moments[:, recording.free].sum() if recording.free else 0.0
    found = []
    if len(long):
        at = float(clock[long[0]])
        text = f"{len(long)} gap{'s' if len(long) > 1 else ''} in its samples, the longest {one.hole:.3g} s, the first "
        text += f"at {at:.3g} s"
        serious = one.hole * one.frequency > 0.25  # a quarter of a period hides a turn
        remedy = "gaps are not interpolated; find out why the recorder lost samples, since its time may be wrong too"
        found.append(Finding("doubt" if serious else "note", text, remedy, one.name))
    if share > 0.1:  # more than cables and marks usually lose
        text = f"{share:.0%} of its readings are missing or are isolated outliers"
        found.append(Finding("doubt", text, "check the cable and how lost readings are marked", one.name))
    return found


def _jitter_findings(recording: Recording, one: Sampling) -> list[Finding]:
    steps = np.diff(densest_clock(recording.time, recording.moments))
    usual = steps[steps < HOLE_STEPS * one.step]
    scatter = float(np.std(usual)) / one.step
    if scatter < MOST_JITTER:
        return []
    # 98 %: not a single outlier.
    moves = scatter * one.step * float(np.percentile(np.abs(recording.smoothed.rate), 98))
    text = (
        f"its time steps scatter by {scatter:.0%}; if only the stamps do, readings are {np.degrees(moves):.2g} deg off "
    )
    text += "where the leg is fastest"
    remedy = "use the clock that triggers the readings for the time stamps"
    # About the noise of a good encoder.
    return [Finding("doubt" if moves > np.radians(0.05) else "note", text, remedy, one.name)]


def _sample_count_findings(made: Sequence[Sampling]) -> list[Finding]:
    """One finding a kind, of the worst recording; its own frequency only where nothing speaks against that."""
    kinds: tuple[FrequencyDoubt, ...] = ("slow", "jumps", "unclear", "doubtful")
    found = [
        _finding_by_design(kind, group) for kind in kinds if (group := [one for one in made if one.against == kind])
    ]
    few = [one for one in made if not one.against and one.a_period < ENOUGH_SAMPLES]
    if few:
        worst = min(few, key=lambda one: one.a_period)
        text = f"{worst.a_period:.1f} samples per period of its fastest motion ({worst.frequency:.3g} Hz, sampled at "
        text += f"{1.0 / worst.step:.4g} Hz)"
        level: Level = "fault" if worst.a_period < LEAST_SAMPLES else "doubt"
        found.append(Finding(level, text, _rate_text(worst.frequency), _name_and_count(worst, few)))
    return found


def _finding_by_design(kind: FrequencyDoubt, group: Sequence[Sampling]) -> Finding:
    """Too few samples, by the designed leg and by how readings jump."""
    worst = max(group, key=lambda one: one.step * (one.designed or (0.0, 1.0))[1])
    rate, place = 1.0 / worst.step, _name_and_count(worst, group)
    if worst.designed is None:
        text = "its readings jump from one to the next as those of a motion do that is sampled fewer than "
        text += f"{LEAST_SAMPLES:g} times per period (sampled at {rate:.4g} Hz); noise would be a quarter of the motion"
        return Finding("doubt", text, "sample faster; if the readings still jump, a quieter sensor", place)
    slowest, fastest = worst.designed
    span = " to ".join(dict.fromkeys([f"{slowest:.3g}", f"{fastest:.3g}"])) + " Hz"
    text = (
        f"sampled at {rate:.4g} Hz, while the designed leg swings at {span}: {rate / fastest:.1f} samples per period "
    )
    text += "of its fastest swing"
    if kind == "doubtful":
        return Finding("doubt", text, _rate_text(fastest), place)
    if kind == "jumps":
        text += f", and its readings jump as those of a motion do that has fewer than {LEAST_SAMPLES:g}"
    text += "; how fast it moves, and how large the noise is, cannot be read from it"
    return Finding("fault", text, _rate_text(max(fastest, rate / LEAST_SAMPLES)), place)


def _name_and_count(worst: Sampling, group: Sequence[Sampling]) -> str:
    return worst.name + (f" and {len(group) - 1} more" if len(group) > 1 else "")


def _rate_text(frequency: float) -> str:
    """The rate to record a motion of that frequency (Hz) at, to two digits."""
    return f"sample at {float(f'{2.0 * ENOUGH_SAMPLES * frequency:.2g}'):g} Hz or faster"
