"""Recordings as sides, from trials or from the result folder of a fit or a gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import radians
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.comparison.side import ComparedMotion, FollowedMotion
from synth.errors import Problem, UserError
from synth.files.csv_table import CsvTable, read_table
from synth.files.output import stems
from synth.files.trial_list import Trial
from synth.fit.recordings import Recording, recordings
from synth.swing.chain import Conditions
from synth.swing.leg_model import Leg
from synth.units import factor

FIRST = 5  # samples of a computed, noise-free curve to which a cubic is fitted for the initial rate


def from_trials(leg: Leg, trials: Sequence[Trial]) -> tuple[ComparedMotion, ...]:
    """Trials of a leg; the first samples give each start (see ``motion.first_state``).

    Raises
    ------
    UserError : a recording cannot be used.
    """
    return tuple(_from_recording(recording) for recording in recordings(leg, trials, ()))


def _from_recording(recording: Recording) -> ComparedMotion:
    locked = list(recording.conditions.locked)
    rotation = np.where(recording.counts, recording.rotation, np.nan)
    rotation[:, locked] = recording.rotation[:, locked]
    found = recording.first_samples
    start, rate = found.angle.copy(), found.rate.copy()
    start[locked], rate[locked] = recording.rotation[0, locked], 0.0
    return ComparedMotion(
        recording.name, recording.time, rotation, start, rate, recording.conditions,
        recording.known_torque, recording.signals, deviation=np.stack([found.angle_deviation, found.rate_deviation]),
    )  # fmt: skip


def from_fit(folder: Path, leg: Leg, fit: Mapping[str, Any], responses: str, column: str) -> tuple[ComparedMotion, ...]:
    """The recordings of a fit, from ``responses/*.csv``, with the fitted initial states.

    ``column``: ``measured`` for a fit; ``animal`` for a design, with each trial's own shift of the free angle
    subtracted.
    """
    trials = [trial for trial in fit["trials"] if column != "animal" or not trial.get("held_out")]
    found = []
    for trial, stem in zip(trials, stems([str(trial["file"]) for trial in trials]), strict=True):
        file = folder / responses / f"{stem}.csv"
        if not file.is_file():
            raise UserError(Problem(f"is missing; run the command that wrote {folder} again", str(file)))
        table = read_table(file)
        conditions = conditions_of(trial, leg)
        seen = column_of(table, leg, column)
        other = column_of(table, leg, "fitted" if column == "measured" else "wanted")
        rotation = leg.to_rotation(np.where(np.isfinite(seen), seen, np.nan))
        held = leg.to_rotation(other[0])
        start, rate = held.copy(), np.zeros(len(held))
        for j, name in enumerate(leg.joint_names):
            if j in conditions.locked:
                rotation[:, j] = held[j]
                continue
            turning = trial["initial_rate"].get(name)
            if turning is not None:
                rate[j] = leg.sign[j] * turning["value"] * factor(turning["unit"], "rad/s")
        why = _not_in_the_folder(trial)
        found.append(
            ComparedMotion(
                str(trial["file"]),
                times_of(table),
                rotation,
                start,
                rate,
                conditions,
                not_driven=why,
                cut=bool(trial.get("start_cut")),
            )
        )
    return tuple(found)


def followed_by_fit(
    folder: Path, leg: Leg, fit: Mapping[str, Any], motions: Sequence[ComparedMotion]
) -> tuple[FollowedMotion, ...]:
    """The leg's own motions of a fit whose trials have their own free angles; of a common one none are needed."""
    if fit["free_angle"]["mode"] != "per_trial":
        return ()
    found = []
    for stem, motion in zip(stems([str(trial["file"]) for trial in fit["trials"]]), motions, strict=True):
        table = read_table(folder / "responses/source" / f"{stem}.csv")
        found.append(FollowedMotion(motion, leg.to_rotation(column_of(table, leg, "fitted"))))
    return tuple(found)


def from_gap(folder: Path, leg: Leg, gap: Mapping[str, Any]) -> tuple[ComparedMotion, ...]:
    """The scored recordings of a gap, with the estimated initial states of the explained leg."""
    found = []
    for trial in gap["trials"]:
        if not trial.get("predicted"):
            continue
        table = read_table(folder / trial["predicted"])
        conditions = conditions_of(trial, leg)
        time, after = times_of(table), leg.to_rotation(column_of(table, leg, "after"))
        rotation = leg.to_rotation(column_of(table, leg, "measured"))
        rotation[:, list(conditions.locked)] = after[0, list(conditions.locked)]
        rate = _first_rate(time, after)
        rate[list(conditions.locked)] = 0.0
        why = _not_in_the_folder(trial)
        found.append(ComparedMotion(str(trial["file"]), time, rotation, after[0], rate, conditions, not_driven=why))
    return tuple(found)


def _not_in_the_folder(trial: Mapping[str, Any]) -> str:
    """Why a leg cannot be driven as in a result's trial, whose folder has no torques and commands; empty if none."""
    by = " and ".join(trial.get("driven_by", ()))
    return f"{by} drives this recording and is not in the result's folder: compare its project" if by else ""


def conditions_of(trial: Mapping[str, Any], leg: Leg) -> Conditions:
    """The conditions of a trial as stated by a result."""
    locked = tuple(leg.joint_names.index(name) for name in trial.get("locked", ()))
    tip = trial.get("tip_mass", {})

    def number(item: Mapping[str, Any] | None, unit: str) -> float:
        return 0.0 if item is None else float(item["value"]) * factor(item["unit"], unit)

    at = tip.get("at")
    return Conditions(
        locked,
        number(tip.get("mass"), "kg"),
        number(trial.get("tilt"), "rad"),
        number(tip.get("inertia"), "kg*m^2"),
        None if at is None else number(at, "m"),
    )


def times_of(table: CsvTable) -> Array:
    """(m,) s from 0."""
    time = table.values[:, _index(table, "time")]
    return np.asarray(time - time[0])


def column_of(table: CsvTable, leg: Leg, kind: str) -> Array:
    """(m, n) rad, the columns ``JOINT kind`` of a response table; nan for a missing column."""
    known = {column.name: column for column in table.columns}
    out = np.full((len(table.values), len(leg.joints)), np.nan)
    for j, name in enumerate(leg.joint_names):
        column = known.get(f"{name} {kind}")
        if column is not None:
            out[:, j] = table.values[:, _index(table, column.name)] * factor(column.unit, "rad")
    return out


def _index(table: CsvTable, name: str) -> int:
    found = [index for index, column in enumerate(table.columns) if column.name == name]
    if not found:
        raise UserError(Problem(f'has no column "{name}"; it is not a response table of this program', table.name, 1))
    return found[0]


def _first_rate(time: Array, rotation: Array) -> Array:
    """(n,) rad/s at the first sample, from a cubic through the first samples."""
    count = min(FIRST, len(time))
    scale = float(time[count - 1])
    powers = np.vander(time[:count] / scale, min(4, count), increasing=True)
    solved, *_ = np.linalg.lstsq(powers, np.nan_to_num(rotation[:count]), rcond=None)
    return np.asarray(solved[1] / scale)


def standard_release(leg: Leg, pose: Array, duration: float) -> ComparedMotion:
    """A start for legs without recordings: every joint at 20 deg from the first leg's equilibrium, at rest."""
    away = np.full(len(leg.joints), radians(STANDARD))
    for j, joint in enumerate(leg.joints):
        if joint.ends is not None and pose[j] + away[j] > joint.ends[1]:
            away[j] = -away[j]
    time = np.linspace(0.0, duration, 401)
    empty = np.full((len(time), len(leg.joints)), np.nan)
    return ComparedMotion("standard release", time, empty, pose + away, np.zeros(len(away)))


STANDARD = 20.0  # deg; a common amplitude of a leg's joints, within most joints' travel
