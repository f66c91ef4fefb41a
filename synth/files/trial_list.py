"""Trials: the recordings of a project, and their conditions."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import degrees, radians
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, field_validator

from synth.arrays import Array
from synth.drives.servo import ServoSignals
from synth.errors import Problem, UserError
from synth.files.paths import matching
from synth.files.recording import Recorded, read_recording
from synth.files.recordings_together import check_together
from synth.files.sample_sizes import sizes_of
from synth.files.turns import TURN, turns_back, turns_together, usual_angle
from synth.files.validate import FileModel, Quantity, check_part, gathering, near, raise_if_any, refusal
from synth.files.yaml_lines import Document, Key
from synth.swing.leg_model import Leg

OWN_LEG = "a trial with its own leg is supported by synth gap only"
TRIAL_LIMIT = 5_000  # of a project: five times the largest of ``make scale``


@dataclass(frozen=True, eq=False, repr=False)
class Trial:
    """One recording of the leg in motion, in SI and measured angles.

    Parameters
    ----------
    name
        the file relative to the folder of the project that lists it.
    time
        (n,) s, strictly increasing.
    angles
        (n, n_joint) rad, nan where a sample is missing.
    velocities
        (n, n_joint) rad/s as recorded, nan where missing; None where no joint has such a column.
    torques
        (n, n_joint) N m, known, in the measured angles' sense, 0 for joints without a column; None if none has one.
    locked
        joints held at their recorded angle.
    tip_mass
        kg, a mass added at the last link's end, or at ``tip_at`` m from the last joint along it, of ``tip_inertia``
        kg m^2 about its own centre.
    tilt
        rad, of the base in this trial, added to the leg's own.
    held_out
        never used to fit or to choose, only to score.
    leg, leg_file
        another leg with the same joints, used in this trial, and its file as the project names it; None: the project's.
    signals
        inputs of the joints' servos, commands in measured angles; None if no joint has a servo.
    sha256
        of the file.
    jumps
        by whole turns that were removed from each joint's angles; empty: not looked for.
    unusual
        rad that each joint's angles cover where they were given in radians and it is known to do less, else 0: they may
        be degrees. Empty: not looked for.
    by_current
        joints whose torque is a recorded current times their motor's constant.
    turned
        whole turns that were added to each joint's angles, which lay on another turn than those of the other trials;
        empty: none.
    drive_off
        joints whose drive is stated to be off, its winding open.
    time_unit
        of the file's clock in its header, empty in code; ``time`` is in s.
    """

    name: str
    time: Array
    angles: Array
    velocities: Array | None = None
    torques: Array | None = None
    locked: tuple[str, ...] = ()
    tip_mass: float = 0.0
    tilt: float = 0.0
    held_out: bool = False
    sha256: str = ""
    tip_inertia: float = 0.0
    tip_at: float | None = None
    leg: Leg | None = None
    signals: ServoSignals | None = None
    jumps: tuple[int, ...] = ()
    unusual: tuple[float, ...] = ()
    by_current: tuple[str, ...] = ()
    turned: tuple[int, ...] = ()
    drive_off: tuple[str, ...] = ()
    leg_file: str = ""
    time_unit: str = ""

    def __repr__(self) -> str:
        """Name, size and conditions; the samples are in ``time`` and ``angles``."""
        return f"Trial({', '.join([repr(self.name), *sizes_of(self.time, self.angles), *self._conditions()])})"

    def _conditions(self) -> list[str]:
        """What differs from a free swing of the project's leg, in words."""
        said = [name for name in ("velocities", "torques", "signals") if getattr(self, name) is not None]
        said += [f"{' and '.join(self.locked)} locked"] if self.locked else []
        said += [f"tip mass {self.tip_mass:g} kg"] if self.tip_mass else []
        said += [f"tilt {degrees(self.tilt):.4g} deg"] if self.tilt else []
        return said + ["held out"] * self.held_out + ["its own leg"] * (self.leg is not None)


class TipMass(FileModel):
    """A body on the last link: mass, inertia about its own centre, and position along the link."""

    mass: Annotated[float, Quantity("kg", least=0)]
    inertia: Annotated[float, Quantity("kg*m^2", least=0)] = 0.0
    at: Annotated[float, Quantity("m")] | None = None


class TrialEntry(FileModel):
    """One item under ``trials:``; ``file`` may be a glob, whose files share the item's keys."""

    file: Annotated[str, Field(min_length=1, examples=["trials/*.csv"])]
    locked: list[str] = Field(default_factory=list)
    tip_mass: Annotated[float | TipMass, Quantity("kg", least=0)] = 0.0
    tilt: Annotated[float, Quantity("rad", least=-radians(360), most=radians(360))] = 0.0
    held_out: bool = False
    leg: Annotated[str, Field(examples=["long_arm.leg.yaml"])] | None = None
    drive_off: list[str] = Field(default_factory=list)

    @field_validator("locked", "drive_off")
    @classmethod
    def _once(cls, names: list[str]) -> list[str]:
        if len(set(names)) < len(names):
            raise refusal("a joint is named twice; name it once")
        return names


@dataclass(frozen=True)
class _Source:
    """The document of the entries, for messages; a bare list has none."""

    document: Document | None = None
    key: Key = ()

    def problem(self, text: str, index: int, *rest: str) -> Problem:
        if self.document is None:
            return Problem(text, key=".".join([f"trials[{index + 1}]", *rest]))
        return self.document.problem(text, (*self.key, index, *rest))


@dataclass(frozen=True)
class _Listed:
    """A file to read and the entry that named it."""

    path: Path
    name: str
    entry: TrialEntry
    index: int


@dataclass
class _Listing:
    files: list[_Listed] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)


def read_trials(
    entries: Sequence[str | Mapping[str, Any] | TrialEntry],
    base_folder: str | Path,
    leg: Leg,
    *,
    document: Document | None = None,
    key: Key = ("trials",),
    locked: Sequence[str] = (),
    other_leg: Callable[[str, Key], Leg | None] | None = None,
) -> list[Trial]:
    """Read the recordings that a project lists.

    Parameters
    ----------
    entries
        a file, a glob, or a mapping as in the file format; in the order given, a glob's files by name.
    base_folder
        the project's folder; files are relative to it and must lie inside its tree.
    leg
        whose joints the columns belong to.
    document, key
        the project and the key of the entries, for line numbers in messages.
    locked
        joints locked in all of them, in addition to an entry's own.
    other_leg
        reads the leg file that an entry names; None: no entry may name one.

    Raises
    ------
    UserError
        With every mistake of the list and of all files.
    """
    source = _Source(document, key)
    listing = _listing(entries, Path(base_folder), leg, source, frozenset(locked))
    problems = list(listing.problems)
    others = _other_legs(listing, leg, source, other_leg, problems)
    trials: list[Trial] = []
    for listed in listing.files:
        with gathering(problems):
            other, off = others.get(listed.index), listed.entry.drive_off
            recorded = read_recording(listed.path, other or leg, name=listed.name, off=off)
            trials.append(_trial(recorded, listed, leg, other))
    if not problems:
        trials = turned_back(on_one_turn(trials, leg), leg)
        problems += trials_together(trials, leg)
    raise_if_any(problems)
    return trials


def trials_together(trials: Sequence[Trial], leg: Leg, *, in_code: bool = False) -> list[Problem]:
    """Trials that do not match the others; ``in_code`` : made in code, for the messages."""
    given = [trial.name for trial in trials]
    times, angles = [trial.time for trial in trials], [trial.angles for trial in trials]
    alike = [_rests_as(trial) for trial in trials]
    return check_together(given, times, angles, leg.joint_names, alike, in_code=in_code)


def on_one_turn(trials: list[Trial], leg: Leg) -> list[Trial]:
    """The trials with the angles of joints that were unwrapped in any of them on the same turn in all."""
    if not any(any(trial.jumps) for trial in trials):
        return trials
    moved = np.zeros((len(trials), len(leg.joints)))
    for j, joint in enumerate(leg.joints):
        middles = [float(np.nanmedian(trial.angles[:, j])) for trial in trials]
        jumped = [bool(trial.jumps) and trial.jumps[j] > 0 for trial in trials]
        moved[:, j] = turns_together(middles, jumped, usual_angle(joint))
    made = [replace(trial, angles=trial.angles + by) for trial, by in zip(trials, moved, strict=True)]
    for trial in made:
        trial.angles.flags.writeable = False
    return made


def turned_back(trials: list[Trial], leg: Leg) -> list[Trial]:
    """The trials, those with a joint displaced by whole turns from all others turned back; others as they are.

    A joint that a servo or a known torque turns may be on another turn, and is left.
    """
    moved = np.zeros((len(trials), len(leg.joints)), dtype=int)
    for j, joint in enumerate(leg.joints):
        free = [t for t, trial in enumerate(trials) if not _driven(trial, j)]
        if len(free) > 1:
            spans = [np.nanquantile(trials[t].angles[:, j], [0.05, 0.5, 0.95]) for t in free]
            moved[free, j] = turns_back([(float(a), float(b), float(c)) for a, b, c in spans], joint)
    made = list(trials)
    for t in np.flatnonzero(moved.any(axis=1)):
        angles = trials[t].angles + moved[t] * TURN
        angles.flags.writeable = False
        made[t] = replace(trials[t], angles=angles, turned=tuple(moved[t].tolist()))
    return made


def _driven(trial: Trial, j: int) -> bool:
    """Whether a servo or a known torque may turn joint ``j``."""
    return trial.signals is not None or (trial.torques is not None and bool(np.nan_to_num(trial.torques[:, j]).any()))


def _rests_as(trial: Trial) -> Hashable:
    """Equal for trials whose angles may be compared; a driven one compares with none."""
    if trial.torques is not None or trial.signals is not None:
        return trial.name
    return trial.locked, trial.tip_mass, trial.tip_at, trial.tilt, id(trial.leg) if trial.leg else None


def _other_legs(
    listing: _Listing,
    leg: Leg,
    source: _Source,
    other_leg: Callable[[str, Key], Leg | None] | None,
    problems: list[Problem],
) -> dict[int, Leg]:
    """Index of each entry with its own leg -> that leg, which must have the same joints."""
    found: dict[int, Leg] = {}
    for entry, index in {listed.index: (listed.entry, listed.index) for listed in listing.files}.values():
        if entry.leg is None:
            continue
        if other_leg is None:
            problems.append(source.problem(OWN_LEG, index, "leg"))
            continue
        other = other_leg(entry.leg, (*source.key, index, "leg"))
        if other is None:
            continue
        fault = other_leg_fault(other, leg)
        if fault:
            problems.append(source.problem(fault, index, "leg"))
        else:
            found[index] = other
    return found


def other_leg_fault(other: Leg, leg: Leg) -> str:
    """Why ``other`` cannot be a trial's own leg beside ``leg``; empty if it can."""
    if other.joint_names != leg.joint_names:
        text = f"{other.name} has other joints ({', '.join(other.joint_names)}) than {leg.name} "
        return text + f"({', '.join(leg.joint_names)}); a trial's leg needs the same, in the same order"
    if not (np.allclose(other.zero, leg.zero) and np.array_equal(other.sign, leg.sign)):
        return f"{other.name} and {leg.name} differ in a joint's zero or sign; angles must mean the same on both"
    return ""


def _trial(recorded: Recorded, listed: _Listed, leg: Leg, other: Leg | None) -> Trial:
    entry = listed.entry
    tip = entry.tip_mass if isinstance(entry.tip_mass, TipMass) else TipMass.model_construct(mass=entry.tip_mass)
    locked = tuple(name for name in leg.joint_names if name in entry.locked)
    return Trial(
        listed.name,
        recorded.time,
        recorded.angles,
        recorded.velocities,
        recorded.torques,
        locked,
        tip.mass,
        entry.tilt,
        entry.held_out,
        recorded.sha256,
        tip.inertia,
        tip.at,
        other,
        recorded.signals,
        recorded.jumps,
        recorded.unusual,
        recorded.by_current,
        drive_off=tuple(name for name in leg.joint_names if name in entry.drive_off),
        leg_file=entry.leg or "",
        time_unit=recorded.time_unit,
    )


def _listing(
    entries: Sequence[str | Mapping[str, Any] | TrialEntry],
    folder: Path,
    leg: Leg,
    source: _Source,
    locked: frozenset[str],
) -> _Listing:
    """All files of the entries; a file listed twice is a mistake."""
    listing = _Listing()
    first: dict[Path, int] = {}
    for index, raw in enumerate(entries):
        entry = _entry(raw, source, index, listing.problems)
        held = raw.get("locked") if isinstance(raw, Mapping) else getattr(raw, "locked", None)
        names = {name for name in held or () if isinstance(name, str)} if isinstance(held, list) else set()
        names |= locked
        listing.problems += _locked_problems(names, leg, source, index)
        if entry is None:
            continue
        unknown = sorted(set(entry.drive_off) - set(leg.joint_names))
        texts = [f'"{name}" is no joint of the leg{near(name, leg.joint_names)}' for name in unknown]
        listing.problems += [source.problem(text, index, "drive_off") for text in texts]
        entry = entry.model_copy(update={"locked": sorted(names)})
        try:
            paths = matching(folder, entry.file)
        except UserError as error:
            listing.problems += [source.problem(problem.text, index) for problem in error.problems]
            continue
        for path in paths:
            name = path.relative_to(folder).as_posix()
            real = Path(os.path.realpath(path))
            if real in first:
                text = f'"{name}" is listed twice (item {first[real] + 1} names it too); name it once'
                listing.problems.append(source.problem(text, index))
                continue
            first[real] = index
            listing.files.append(_Listed(path, name, entry, index))
        if len(listing.files) > TRIAL_LIMIT:
            raise UserError(source.problem(f"more than {TRIAL_LIMIT} trials are listed; narrow the glob", index))
    return listing


def _entry(raw: object, source: _Source, index: int, problems: list[Problem]) -> TrialEntry | None:
    if isinstance(raw, TrialEntry):
        return raw
    value = {"file": raw} if isinstance(raw, str) else raw
    if not isinstance(value, Mapping):
        problems.append(source.problem(f"{raw!r} is not a trial; write a file, a glob or {{file: ...}}", index))
        return None
    if source.document is not None:
        return check_part(TrialEntry, source.document, dict(value), (*source.key, index), problems)
    found: list[Problem] = []
    entry = check_part(TrialEntry, Document(Path(), "", {}, {}, b""), dict(value), ("trials", index), found)
    problems += [Problem(problem.text, key=problem.key) for problem in found]
    return entry


def _locked_problems(locked: set[str], leg: Leg, source: _Source, index: int) -> list[Problem]:
    return [source.problem(text, index, "locked") for text in locked_faults(locked, leg)]


def locked_faults(locked: set[str], leg: Leg) -> list[str]:
    """What is wrong with the names of a trial's locked joints."""
    names = leg.joint_names
    faults = [f'"{name}" is no joint of the leg{near(name, names)}' for name in sorted(locked - set(names))]
    return [*faults, "every joint is locked: nothing moves in this trial"] if set(names) <= locked else faults
