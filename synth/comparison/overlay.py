"""Every side's motion from the same starts, and the differences between the motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.comparison.read_motion import moved_motion
from synth.comparison.recorded_sides import standard_release
from synth.comparison.side import MODEL, ComparedMotion, Side, not_driven_alike
from synth.comparison.starts_alike import Away, RecordedStart, nearest, recorded_starts
from synth.errors import UserError
from synth.swing.mechanics import rest_pose

MOST_STARTS = 12  # more starts add pages without new information
STANDARD_TIME = 2.0  # s, time in which a limb of this size comes to rest


@dataclass(frozen=True)
class OverlaidMotion:
    """One side's motion from a start.

    ``rotation`` (m, n) rad at the start's times, of a side with a pace at its own times over that; nan where undefined;
    ``measured`` and ``away``: the recording used and how far its start is from this one; None and 0 for a simulated
    leg.
    """

    rotation: Array
    measured: ComparedMotion | None = None
    away: Away | None = None

    @property
    def recording(self) -> str:
        """The recording's name; empty for a simulated leg."""
        return "" if self.measured is None else self.measured.name


@dataclass(frozen=True)
class Overlay:
    """All sides from one start; ``motions`` in the sides' order, None where a side has none, with ``why``."""

    start: ComparedMotion
    motions: tuple[OverlaidMotion | None, ...]
    why: tuple[str, ...]


def chosen_starts(sides: Sequence[Side], given: Sequence[ComparedMotion] = ()) -> tuple[str, list[ComparedMotion]]:
    """The source of the starts, and the starts: given ones, else the first recorded side's, else a standard release."""
    if given:
        return "given", list(given)
    for side in sides:
        if side.motions:
            motions = list(side.slowed)
            every = -(-len(motions) // MOST_STARTS)
            return side.name, motions[::every]
    leg = sides[0].leg
    try:
        pose = rest_pose(leg)
    except ArithmeticError as error:
        text = f"{sides[0].name}: {error}; state the start: --start 'hip=60 deg, knee=100 deg'"
        raise UserError(text) from None
    return "standard", [standard_release(leg, pose, STANDARD_TIME)]


def overlaid(sides: Sequence[Side], starts: Sequence[ComparedMotion]) -> tuple[Overlay, ...]:
    """Each side from each start: legs are simulated, recordings are matched to the nearest start."""
    found = []
    known = [[] if side.kind == MODEL else recorded_starts(side) for side in sides]
    for start in starts:
        like = RecordedStart.of(start)
        pairs = [
            _moved(side, start, read=is_read(side, sides)) if side.kind == MODEL else _recorded(side, start, own, like)
            for side, own in zip(sides, known, strict=True)
        ]
        found.append(Overlay(start, tuple(motion for motion, _ in pairs), tuple(why for _, why in pairs)))
    return tuple(found)


def is_read(side: Side, sides: Sequence[Side]) -> bool:
    """Whether a leg's motion is compared as its encoders read it: beside recordings, which are readings too."""
    return side.reads and any(other.kind != MODEL for other in sides)


def _moved(side: Side, start: ComparedMotion, *, read: bool) -> tuple[OverlaidMotion | None, str]:
    """The leg simulated from the start under the recording's conditions, driven as it was; or as fitted to it.

    ``read`` : as its encoders read it, see ``moved_motion``.
    """
    why = not_driven_alike(side, start)
    if why:
        return None, why
    followed = side.as_fitted_to(start)
    if followed is not None:
        return OverlaidMotion(followed), ""
    slower = side.pace / side.stretch
    try:
        rotation = moved_motion(side.leg, start, slower, read=read)
    except ArithmeticError as error:
        return None, str(error)
    return OverlaidMotion(rotation), ""


def _recorded(
    side: Side, start: ComparedMotion, known: Sequence[RecordedStart], like: RecordedStart
) -> tuple[OverlaidMotion | None, str]:
    """The recording that begins nearest to the start, at the start's times."""
    found = nearest(known, like, side.leg)
    if found is None:
        return (
            None,
            start.not_driven
            or "no recording with the same joints locked, tip mass, tilt and known torques or commands",
        )
    motion, away = found[0].motion, found[1]
    if away.distance > found[0].near(like):
        return None, _far(motion.name, side.leg.joint_names, away)
    if motion is start or (away.distance == 0.0 and np.array_equal(motion.time, start.time)):
        return OverlaidMotion(motion.rotation, motion), ""
    out = np.full((len(start.time), motion.rotation.shape[1]), np.nan)
    for j in range(out.shape[1]):
        good = np.isfinite(motion.rotation[:, j])
        if good.sum() > 1:
            seen = np.interp(start.time, motion.time[good], motion.rotation[good, j])
            out[:, j] = np.where(start.time <= motion.time[good][-1], seen, np.nan)
    return OverlaidMotion(out, motion, away), ""


def _far(recording: str, joints: Sequence[str], away: Away) -> str:
    """Why a side has no recording from a start: the nearest one, and whether angle or rate is what differs."""
    angle, rate, swing = (float(np.degrees(each[away.joint])) for each in (away.angle, away.rate, away.swing))
    joint = joints[away.joint]
    text = f"the nearest recording, {recording}, starts"
    if swing <= angle:
        return f"{text} {angle:.0f} deg away at the {joint}"
    return (
        f"{text} at another speed: {rate:.0f} deg/s and {angle:.0f} deg away at the {joint}, {swing:.0f} deg of swing"
    )


@dataclass(frozen=True)
class Difference:
    """Difference of side ``b`` from side ``a``: ``rms`` (n,) rad, nan if undefined, over ``starts`` starts.

    ``basis``: ``measured`` if both are recordings, ``predicted`` if one is simulated.
    """

    a: int
    b: int
    rms: Array
    overall: float
    starts: int
    basis: str


def differences(sides: Sequence[Side], overlays: Sequence[Overlay]) -> tuple[Difference, ...]:
    """Between all pairs of sides, over the starts that both have."""
    found = []
    for a in range(len(sides)):
        for b in range(a + 1, len(sides)):
            off, count = [], 0
            for overlay in overlays:
                one, other = overlay.motions[a], overlay.motions[b]
                if one is None or other is None:
                    continue
                count += 1
                difference = other.rotation - one.rotation
                difference[:, list(overlay.start.conditions.locked)] = np.nan
                off.append(difference)
            basis = "predicted" if MODEL in (sides[a].kind, sides[b].kind) else "measured"
            rms, overall = _rms(np.concatenate(off)) if off else (np.full(len(sides[a].leg.joints), np.nan), np.nan)
            found.append(Difference(a, b, rms, overall, count, basis))
    return tuple(found)


def _rms(off: Array) -> tuple[Array, float]:
    """(n,) rad by joint, and over all joints together."""
    known = np.isfinite(off)
    count = known.sum(axis=0)
    square = np.where(known, off, 0.0) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(square.sum(axis=0) / count)
    seen = rms[np.isfinite(rms)]
    return rms, float(np.sqrt(np.mean(seen**2))) if len(seen) else float("nan")
