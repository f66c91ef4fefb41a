"""Recordings that begin while the leg is still held: it stands still where the nominal leg must accelerate.

A diagnosis takes a recording as free motion from its first sample. A hold before the release is then a motion that no
torque of the leg makes, and whatever delays a start (a base that moves, a hardening spring) is found as its cause.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.fit.recordings import Recording
from synth.fit.sensor_noise import AngleSensor
from synth.pace import SINUSOID_PACE
from synth.remarks import Remark, kind_of
from synth.swing.chain import simulate
from synth.swing.effects.latency import LATEST
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, mass_matrix, static_torque
from synth.swing.tolerances import Tolerances

HELD_START = "held start"  # kind of the remark
REMEDY = "remove the rows before that time, by hand or by `synth import`, which finds the release"
MOST_LISTED = 9  # recordings that are named beside the first
# Samples: fewer are the sampling of a start that nothing holds, or the delay of a sensor.
LEAST_STILL = 4
# Times the noise that readings of a joint at rest cover: the range of 1 000 normal values is 6.5 deviations on average
# (Tippett, Biometrika 17 (1925) 364), and of fewer is less.
STILL_RANGE = 7.0
# Times that range by which the nominal leg would have moved. A released leg leaves the range when it has moved by it;
# one whose inertia is three times the stated one, when the nominal leg has moved by three times as much. No cause slows
# a start by ten: a filter of 20 ms on readings of 0.05 deg noise does by five (t^3 / 6 for t^2 / 2 of the way).
LEAST_MISSED = 5.0
# rad; of less, a filter of 20 ms on quiet readings hides as much, by the same formula at 0.001 deg noise.
LEAST_WAY = np.radians(0.5)
# Samples by which the ends of equal delays differ: each is seen within the time in which its motion leaves the noise.
SAMPLES_APART = 2.5
TOLERANCES_OFF = 3.0  # standard deviations by which the acceleration may be smaller than the nominal leg's
# Probability that a cause is wrong which is found on such recordings, as of one that held-out trials surely contradict:
# a choice. The verdict is then ``unknown``.
DOUBT = 0.9
SIMULATED = 9  # moments of the nominal leg's motion, of which the farthest counts


@dataclass(frozen=True)
class HeldStart:
    """A recording that stands still ``until`` s of its own time; ``missed`` (n,) rad, the nominal leg's way by then.

    ``joints`` : those that would have moved visibly. ``may_be_late`` : whether a latency that ``synth gap`` looks for
    may do the same. ``step`` s between samples.
    """

    name: str
    joints: tuple[str, ...]
    until: float
    missed: tuple[float, ...]
    may_be_late: bool
    step: float


def held_starts(
    leg: Leg, recordings: Sequence[Recording], sensor: AngleSensor, tolerances: Tolerances
) -> list[HeldStart]:
    """Free recordings whose joints all stand still at first, although the nominal leg must move.

    Dry friction is no explanation: where all joints stand still nothing changes, and what friction held once it would
    hold for ever. A driven recording may be held by its drive.
    """
    found = []
    for recording in recordings:
        if recording.driven or not recording.free:
            continue
        still = STILL_RANGE * sensor.noise + sensor.step
        until, samples = _still_until(recording, still)
        if samples < LEAST_STILL:
            continue
        missed = _nominal_way(recording.leg or leg, recording, until, tolerances)
        least = np.maximum(LEAST_MISSED * still, LEAST_WAY)
        joints = [j for j in recording.free if missed[j] >= least[j]]
        if joints:
            ways = tuple(float(missed[j]) for j in joints)
            names = tuple(leg.joint_names[j] for j in joints)
            late = len(leg.joints) == 1 and until <= LATEST * recording.smoothed.pace / SINUSOID_PACE
            found.append(HeldStart(recording.name, names, until, ways, late, recording.step))
    return found


def held_start_remarks(found: Sequence[HeldStart]) -> list[str]:
    """One sentence that begins with the first recording, of all; none without any.

    Of a single joint a late channel is a cause in the library, and does the same by the same time in each recording:
    that is only a doubt. Of several joints, all late by as much, no cause is right.
    """
    if not found:
        return []
    first, others = found[0], found[1:]
    listed = [f"{one.name} until {one.until:.3g} s" for one in others[:MOST_LISTED]]
    listed += [f"{len(others) - MOST_LISTED} more"] if len(others) > MOST_LISTED else []
    apart = np.ptp([one.until for one in found])
    late = all(one.may_be_late for one in found) and apart <= SAMPLES_APART * first.step
    means = "which would be found as latency" if late else "so that a cause found on it is probably wrong"
    ways = [f"{name} by {np.degrees(way):.2g} deg" for name, way in zip(first.joints, first.missed, strict=True)]
    text = (
        f"{first.name}: stands still until {first.until:.3g} s, still held (or all read so late), {means}: it counts "
    )
    text += f"as free motion from its first sample, and the nominal leg moves {' and '.join(ways)} in that time"
    text += f"; likewise {', '.join(listed)}" if listed else ""
    return [Remark(text, "decide", REMEDY, "" if late else HELD_START)]


def doubt_of_held_starts(remarks: Sequence[str]) -> float:
    """Probability that a cause is wrong because of held starts that are among the remarks; 0 without any."""
    return DOUBT if any(kind_of(remark) == HELD_START for remark in remarks) else 0.0


def _still_until(recording: Recording, still: Array) -> tuple[float, int]:
    """Last moment (s) until which every free joint's readings stay in a range of ``still`` (n,) rad, and their number.

    0 samples if a joint moves at once, or none ever does.
    """
    until, samples, moves = np.inf, 0, False
    for j in recording.free:
        time, rotation, counts = recording.channel(j)
        time, rotation = time[counts], rotation[counts]
        covered = np.maximum.accumulate(rotation) - np.minimum.accumulate(rotation)
        beyond = int(np.searchsorted(covered, still[j], side="right"))  # first reading that is outside
        moves = moves or beyond < len(time)
        if beyond and time[beyond - 1] < until:
            until, samples = float(time[beyond - 1]), beyond
    return (until, samples) if moves and samples else (0.0, 0)


def _nominal_way(leg: Leg, recording: Recording, until: float, tolerances: Tolerances) -> Array:
    """(n,) rad that the nominal leg moves until then, released where the recording stands; less what tolerances take.

    Zero where the motion cannot be simulated.
    """
    first = (recording.time <= until)[:, None] & recording.counts
    held = recording.rotation[0].copy()
    for j in recording.free:
        held[j] = float(np.median(recording.rotation[first[:, j], j]))
    times = np.linspace(0.0, until, SIMULATED)
    try:
        motion = simulate(leg, held, np.zeros_like(held), times, recording.conditions)
    except ArithmeticError:
        return np.zeros_like(held)
    way = np.asarray(np.abs(motion - held).max(axis=0))
    return way * _share_beyond_tolerances(leg, recording, held, tolerances)


def _share_beyond_tolerances(leg: Leg, recording: Recording, held: Array, tolerances: Tolerances) -> Array:
    """(n,) share of the nominal acceleration from rest that remains where the tolerances diminish it; 0 to 1."""
    nominal = _acceleration(leg, recording, held)
    units = np.eye(tolerances.size)[tolerances.width.ravel() > 0.0]
    moved = [_acceleration(tolerances.leg(leg, unit), recording, held) - nominal for unit in units]
    spread = TOLERANCES_OFF * np.sqrt(np.sum(np.square(moved), axis=0)) if moved else np.zeros_like(nominal)
    size = np.abs(nominal)
    return np.asarray(np.where(size > spread, 1.0 - spread / np.maximum(size, 1e-12), 0.0))


def _acceleration(leg: Leg, recording: Recording, held: Array) -> Array:
    """(n,) rad/s^2 from rest by springs and gravity; 0 at locked joints."""
    conditions = recording.conditions
    made, tilt = coefficients(leg, conditions.tip), leg.tilt + conditions.tilt
    torque = -leg.spring_rate * (held - leg.rest) - static_torque(made, held, tilt)
    free = recording.free
    found = np.zeros_like(held)
    inertia = mass_matrix(made, held, tilt)
    found[free] = np.linalg.solve(inertia[np.ix_(free, free)], torque[free])
    return found
