"""Conversion of a foreign file to a recording of a leg: read, turn into measured angles, clean, cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from synth.arrays import Array
from synth.drives.servo import TorqueDrive
from synth.errors import Problem, UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.files.log_clock import LogClock
from synth.motion.importers.channel_clock import channel_clock
from synth.motion.importers.cleaning import SHORTEST, JointTurns, clean_angles, remarks
from synth.motion.importers.drive_inputs import DriveInput, drive_inputs, inputs_within
from synth.motion.importers.foreign_data import Channels, Markers, name_list, other_side
from synth.motion.importers.from_point_columns import points_in_columns
from synth.motion.importers.limb_sides import exchanged_limb
from synth.motion.importers.other_columns import unused_columns, velocities
from synth.motion.importers.points import TrackedAngles, track
from synth.motion.importers.quaternion_angles import with_quaternions
from synth.motion.importers.raw_counts import angle_scale, without_overflow
from synth.motion.importers.registry import ForeignFormat, formats, recognise
from synth.motion.importers.repeated_rows import without_empty_rows, without_repeated_rows
from synth.motion.importers.segment_angles import measured_angles
from synth.motion.limb_pace import pace_doubt
from synth.motion.release import Release, find_release
from synth.pace import own_paces
from synth.remarks import decisive
from synth.swing.leg_model import Joint, Leg

Cut = Literal["cut", "free", "keep"]


@dataclass(frozen=True, eq=False)
class ImportedRecording:
    """A recording of the leg.

    ``time`` (n,) s on the file's own clock, a large one (``log_clock``) counted from the first sample; ``angles`` (n,
    n_joint) rad, measured, nan if missing. ``total`` samples in the file, ``began`` s its first; ``release`` as
    detected at its start, None if not searched; ``notes`` messages on everything detected, repaired or cut.
    ``tracked``: the points of the angles, for marker files, on the same samples. ``inputs`` : of the leg's drives,
    known torques and velocities, over the same time. ``turns`` : whole turns of each joint.
    """

    format: str
    time: Array
    angles: Array
    total: int
    release: Release | None
    notes: tuple[str, ...]
    tracked: TrackedAngles | None
    began: float = 0.0
    inputs: tuple[DriveInput, ...] = ()
    turns: tuple[JointTurns, ...] = ()

    @property
    def driven(self) -> float | None:
        """Duration of the external torque after the release, s; None if none is detected."""
        found = self.release
        if found is None or found.driven_until is None or found.free_from < found.driven_until:
            return None  # if an external torque and a leg of another law look alike, it counts as free
        return found.driven_until - self.start

    @property
    def start(self) -> float:
        """The release, or the first sample of a recording that starts in motion; s on the file's own clock."""
        at = None if self.release is None else self.release.released
        return self.began if at is None else at

    def later(self, start: float, note: str) -> ImportedRecording:
        """The recording without the samples before ``start`` s, with a note."""
        kept = slice(int(np.searchsorted(self.time, start)), None)
        tracked = self.tracked
        if tracked is not None:
            clock = replace(tracked.clock, time=tracked.clock.time[kept])
            tracked = replace(tracked, clock=clock, rotation=tracked.rotation[kept], points=tracked.points[kept])
        inputs = inputs_within(self.inputs, self.time, kept.start, len(self.time))[0]
        time, angles, notes = self.time[kept], self.angles[kept], (*self.notes, note)
        return replace(self, time=time, angles=angles, notes=notes, tracked=tracked, inputs=inputs)


# Of the links' weights at their centres of mass: the RMS change of a known torque from which it drives the leg. Motors
# whose windings are open, and torque sensors, scatter by less.
DRIVING_SHARE = 0.02


def import_file(
    path: Path,
    leg: Leg,
    mapping: Mapping,
    *,
    name: str,
    form: str = "auto",
    cut: Cut = "cut",
    window: tuple[float, float] | None = None,
    turns: Sequence[int] | None = None,
) -> ImportedRecording:
    """Read one file as a recording of ``leg``.

    Parameters
    ----------
    form : the format, or ``auto``.
    cut : ``cut`` to the release, ``free`` also to the end of the driven part, ``keep`` everything.
    window : s on the file's clock, chosen manually; disables the search.
    turns : whole turns to shift each joint by, as in ``clean_angles``.

    Raises
    ------
    UserError : the file cannot be read, does not contain the columns or points of ``mapping``, or too little remains.
    """
    found_form = recognise(path, name, points=bool(mapping.points)) if form == "auto" else formats()[form]
    _check_mapping(found_form, mapping, name)
    found_form.require(name)
    source = found_form.read(path, mapping, name)
    tracked: TrackedAngles | None = None
    if isinstance(source, Markers):
        tracked = track(source, leg, mapping)
        clock, angles, notes = tracked.clock, leg.to_measured(tracked.rotation), list(tracked.notes)
    else:
        source, clock, angles, notes = _angles(source, leg, mapping)
        source = _with_other_clocks(source, clock)
    time = clock.time
    directions = [joint for joint in leg.joint_names if tracked is not None or _column_of(joint, mapping).segment]
    cleaned = clean_angles(time, angles, leg, name, arbitrary_turns=directions, turns=turns)
    notes += cleaned.notes
    moved = any(joint.drive not in (None, TorqueDrive()) for joint in leg.joints)
    _refuse_cut(cut, "the leg is driven" if moved else "", name)
    inputs: tuple[DriveInput, ...] = ()
    if isinstance(source, Channels):
        inputs = drive_inputs(source, leg, mapping, time, angles, cleaned.angles, notes)
        inputs += velocities(source, leg, mapping, time, cleaned.angles, notes)
        notes += unused_columns(source, leg, mapping, inputs, notes)
    pushed = _known_torques(inputs)
    moved = moved or _driven_by_torque(leg, inputs, notes)
    _refuse_cut(cut, f"a known torque acts ({name_list(pushed)})" if pushed else "", name)
    release = None if window is not None or moved else _release(time, cleaned.angles, leg, notes)
    if release is not None and pushed:
        notes.append(f"the release was looked for as if the known torque ({name_list(pushed)}) did not act")
    if window is None:
        first, last = _samples_kept(time, release, cut, notes)
    else:
        first, last = _within_window(clock, window, notes, name)
    inputs, known = inputs_within(inputs, time, first, last)
    if known >= last:
        raise UserError(Problem("all its commands come after its last sample", name))
    if known > first:
        notes.append(f"cut to the first command: {known - first} of {len(time)} samples left out")
        first = known
    _require_samples(time[first:last], cleaned.angles[first:last], leg, name)
    kept = slice(first, last)
    notes += remarks(time[kept], cleaned.angles[kept], leg)
    if tracked is not None:
        own = replace(clock, time=time[kept])
        tracked = replace(tracked, clock=own, rotation=tracked.rotation[kept], points=tracked.points[kept])
    notes += _pace_notes(leg, time[kept], cleaned.angles[kept])
    angles, texts, began = cleaned.angles[kept], tuple(notes), float(time[0])
    return ImportedRecording(
        found_form.name, time[kept], angles, len(time), release, texts, tracked, began, inputs, cleaned.turns
    )


def _pace_notes(leg: Leg, time: Array, angles: Array) -> list[str]:
    """The doubt whether a limb moves as fast or slowly as the times (n,) s and angles (n, n_joint) rad say."""
    own = own_paces(time, angles)
    text = pace_doubt(leg, float(np.nanmin(own))) if np.isfinite(own).any() else ""
    return [decisive(text)] if text else []


def _refuse_cut(cut: Cut, why: str, name: str) -> None:
    """Refuse to look for free motion where a torque acts all along, as ``why`` tells."""
    if why and cut == "free":
        raise UserError(Problem(f"{why}: no part of its motion is free; leave release: free out", name))


def _known_torques(inputs: Sequence[DriveInput]) -> list[str]:
    """Columns of torques that are not 0 throughout."""
    return [each.column for each in inputs if each.title.endswith(" torque [N*m]") and np.nan_to_num(each.value).any()]


def _driven_by_torque(leg: Leg, inputs: Sequence[DriveInput], notes: list[str]) -> bool:
    """Whether a known torque drives the leg; a note tells of a joint's ``drive`` without a torque.

    It is that of a joint's ``drive`` or, of a joint without one, changes by more than moves no limb: a constant one may
    be a weight, and a sensor that scatters about 0 is none.
    """
    drives = [joint.name for joint in leg.joints if joint.drive == TorqueDrive()]
    by_title = {each.title.removesuffix(" torque [N*m]"): each for each in inputs}
    for joint in drives:
        if joint not in by_title:
            text = f"no torque of the drive of {joint} in the file: taken as free there; if it acted, name the column "
            notes.append(f"{text}of its torque in a project, joints: {{{joint}: {{column: NAME, torque: NAME}}}}")
    stated = _known_torques([by_title[joint] for joint in drives if joint in by_title])
    weight = sum(joint.link.mass * leg.gravity * abs(joint.link.com) for joint in leg.joints)
    changing = [
        each.column
        for joint in leg.joints
        if joint.drive is None and (each := by_title.get(joint.name)) is not None
        if float(np.nanstd(each.value)) > DRIVING_SHARE * weight
    ]
    if changing and not stated:
        notes.append(f"kept whole: it is driven by a known torque ({name_list(changing)})")
    return bool(stated or changing)


def _require_samples(time: Array, angles: Array, leg: Leg, name: str) -> None:
    """Refuse a trial in which a joint has too few samples."""
    left = np.isfinite(angles).sum(axis=0)
    few = [joint for joint, count in zip(leg.joint_names, left, strict=True) if count < SHORTEST]
    if few:
        text = f"too few samples of {name_list(few)} remain from {time[0]:.3f} s; leave the file out"
        text += f" (in a project: exclude: [{name}])"
        raise UserError(Problem(text, name))


def _check_mapping(form: ForeignFormat, mapping: Mapping, name: str) -> None:
    """Refuse keys that a format does not use: ignoring a request would give a wrong result."""
    if form.gives == "points":
        unused = {
            "joints": bool(mapping.joints),
            "time": mapping.time is not None and "time" not in form.keys,
            "supply": mapping.supply is not None,
        }
        unused |= {"plane": not form.space and mapping.plane is not None}
    else:
        unused = {"points": bool(mapping.points), "plane": mapping.plane is not None, "mirror": mapping.mirror}
        unused |= {"roll": mapping.roll != 0.0}
    special: dict[str, object] = {
        "likelihood": mapping.likelihood,
        "individual": mapping.individual,
        "topic": mapping.topic,
    }
    special["commands"] = mapping.commands or None
    unused |= {key: value is not None for key, value in special.items() if key not in form.keys}
    if form.own_clock:
        unused |= {"time": mapping.time is not None, "frame_rate": mapping.frame_rate is not None}
    hint = {
        "points": f"; points are read from {name_list(k for k, each in formats().items() if each.gives == 'points')}"
    }
    problems = [
        Problem(f"does not apply to a file of format {form.name}; leave it out{hint.get(key, '')}", name, key=key)
        for key, given in unused.items()
        if given
    ]
    if problems:
        raise UserError(problems)


def _angles(source: Channels, leg: Leg, mapping: Mapping) -> tuple[Channels, LogClock, Array, list[str]]:
    """A file of channels without its repeated rows, its clock, and measured angles (n, n_joint) rad."""
    source, sensed = with_quaternions(source, leg, mapping)
    notes = [*source.notes, *sensed]
    problems: list[Problem] = []
    columns: list[tuple[int, float]] = []
    clock, no_clock = LogClock(np.full(len(source.values), np.nan)), []
    try:
        clock = channel_clock(source, mapping, notes)
    except UserError as error:
        no_clock = list(error.problems)
    wanted = [_column_of(joint, mapping) for joint in leg.joint_names]
    for joint, column in zip(leg.joints, wanted, strict=True):
        try:
            columns.append(_column(source, joint, column, leg, notes))
        except UserError as error:
            problems += error.problems
    if problems or no_clock:
        raise UserError([*problems, *no_clock, *_points_instead(source, leg, problems)])
    used, clock = without_repeated_rows(*without_empty_rows(source, clock, notes), notes)
    source = _continued(used, leg, wanted, [index for index, _ in columns], notes)
    angles = _of_own_side(source, leg, columns, clock.time, notes)
    return used, clock, measured_angles(leg, wanted, angles), [*clock.notes, *notes]


def _points_instead(source: Channels, leg: Leg, problems: list[Problem]) -> list[Problem]:
    """Where columns of angles are missing from a CSV of points: how to name those."""
    points = points_in_columns(source.names)
    if not problems or len(points) < len(leg.joints):
        return []
    if len(points) == len(leg.joints):
        text = (
            f"its columns hold points ({name_list(points)}): if they are of the leg, whose first joint stays where the "
        )
        return [
            Problem(f"{text}coordinates are 0, write points: [origin, {', '.join(points)}] (--points)", source.name)
        ]
    text = f"its columns hold points ({name_list(points)}): if they are of the leg, name them, proximal to distal and "
    return [Problem(f"{text}then the tip: points: [{', '.join(leg.joint_names)}, tip] (--points)", source.name)]


def _column_of(joint: str, mapping: Mapping) -> JointColumn:
    """The column that the project names for a joint, else that of its own name."""
    return mapping.joints.get(joint) or JointColumn(joint)


def _column(source: Channels, joint: Joint, column: JointColumn, leg: Leg, notes: list[str]) -> tuple[int, float]:
    """The index of one joint's angle and its scale, rad; raises UserError where the file says it is another's."""
    index = source.find(column.column, joint.name)
    own = source.called.get(column.column, joint.name)
    if own != joint.name and own in leg.joint_names:
        text = (
            f'{joint.name}: the file says that "{column.column}" is the angle of {own}; write {{column: {joint.name}}}'
        )
        raise UserError(Problem(text, source.name))
    if "/" in source.names[index] and source.names[index] != column.column:
        notes.append(f"{joint.name}: from {source.names[index]}")
    return index, angle_scale(source, index, column, joint.name)


def _continued(source: Channels, leg: Leg, wanted: list[JointColumn], columns: list[int], notes: list[str]) -> Channels:
    """The file with the joints' counters continued where they ran over their ends."""
    values = source.values.copy()
    for joint, column, k in zip(leg.joint_names, wanted, columns, strict=True):
        values[:, k] = without_overflow(values[:, k], column, joint, notes)
    return replace(source, values=values)


def _of_own_side(source: Channels, leg: Leg, columns: list[tuple[int, float]], time: Array, notes: list[str]) -> Array:
    """The columns (n, n_joint) rad of each joint's index and scale, with exchanges between the sides reversed.

    ``time`` (n,) s is for the notes.
    """
    angles = np.column_stack([source.values[:, index] * scale for index, scale in columns])
    others = [other_side(source.names[index], source.names) for index, _ in columns]
    both = [j for j, other in enumerate(others) if other is not None]
    if both:
        there = [source.values[:, k] * columns[j][1] for j, k in enumerate(others) if k is not None]
        # On the circle a column that wraps does not jump: two that pass half a turn at once are no exchange.
        found = exchanged_limb([_on_circle(angles[:, j]) for j in both], [_on_circle(each) for each in there])
        notes += found.notes([f"{leg.joint_names[j]} ({source.names[columns[j][0]]})" for j in both], time)
        for j, swapped, other_angle in zip(both, found.swapped, there, strict=True):
            angles[:, j] = np.where(swapped, other_angle, angles[:, j])
    return angles


def _on_circle(angle: Array) -> Array:
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _release(time: Array, angles: Array, leg: Leg, notes: list[str]) -> Release | None:
    try:
        found = find_release(time, angles, leg)
    except ValueError as error:
        notes.append(f"no release was looked for: {error}")
        return None
    notes.append(found.sentence)
    return found


def _with_other_clocks(source: Channels, clock: LogClock) -> Channels:
    """The file with its channels of other clocks on the same zero."""
    later = clock.begins - source.begins  # s, by which the reader's zero was moved
    inputs = (replace(each, time=None if each.time is None else each.time - later) for each in source.inputs)
    return replace(source, inputs=tuple(inputs))


def _within_window(clock: LogClock, window: tuple[float, float], notes: list[str], name: str) -> tuple[int, int]:
    """Indices of the first sample in the window, s on the file's own clock, and of the one after the last."""
    time, begins = clock.time, clock.begins
    rounding = 1e-9 + 2.0 * np.spacing(abs(begins))  # s, of a window's ends beside the samples' times
    low, high = window[0] - begins - rounding, window[1] - begins + rounding
    first, last = (int(k) for k in np.searchsorted(time, [low, high]))
    if last - first < SHORTEST:
        asked, there = (f"{a:.14g} to {b:.14g} s" for a, b in (window, begins + time[[0, -1]]))
        text = f"the window {asked} holds {last - first} samples of the file's {there}; at least {SHORTEST} are needed"
        raise UserError(Problem(text, name))
    notes.append(f"cut to the window given: {len(time) - last + first} of {len(time)} samples left out")
    return first, last


def _samples_kept(
    time: Array,
    release: Release | None,
    cut: Cut,
    notes: list[str],
) -> tuple[int, int]:
    """Indices of the first sample kept and of the one after the last; a note states the cut."""
    if release is None or cut == "keep":
        if release is not None and release.free_from > time[0]:
            notes.append("nothing was cut, as wished; a trial must start at or after the release")
        return 0, len(time)
    start = release.free_from if cut == "free" else release.released_by
    if start is None or start <= time[0]:
        return 0, len(time)
    first = int(np.searchsorted(time, start))
    if len(time) - first < SHORTEST:
        notes.append(f"not cut at {start:.3f} s: only {len(time) - first} samples would remain")
        return 0, len(time)
    what = "the release" if start == release.released_by else "the end of the external torque"
    notes.append(f"cut at {what}: {first} of {len(time)} samples, up to {time[first - 1]:.3f} s, left out")
    return first, len(time)
