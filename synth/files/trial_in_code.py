"""Trials made in code, checked and continued as recordings that are read: the same checks on the same columns.

A key in a message is the attribute, indexed as in numpy where a sample is at fault: ``angles[17, 0] (knee)``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from synth import units
from synth.arrays import Array
from synth.drives.servo import Servo, ServoSignals
from synth.errors import Problem
from synth.files.leg_in_code import check_leg
from synth.files.made_in_code import number_fault, with_hint
from synth.files.recording import CODE, Columns, Recorded, checked_columns
from synth.files.trial_list import (
    OWN_LEG,
    TRIAL_LIMIT,
    TipMass,
    Trial,
    TrialEntry,
    locked_faults,
    on_one_turn,
    other_leg_fault,
    trials_together,
    turned_back,
)
from synth.files.turns import far_command, widest
from synth.files.validate import check_part, gathering, raise_if_any
from synth.files.yaml_lines import Document
from synth.swing.leg_model import Leg

TIP = {"mass": "tip_mass", "inertia": "tip_inertia", "at": "tip_at"}  # key of a body in a file -> attribute
UNITS = {"tip_mass": "kg", "tip_inertia": "kg*m^2", "tip_at": "m", "tilt": "rad"}
USUAL = {item.name: item.default for item in fields(Trial) if item.name in ("held_out", *UNITS)}
SUFFIXES = {"angles": "", "velocities": " velocity", "torques": " torque"}


def checked_trials(trials: Sequence[Trial], leg: Leg, place: Document, *, own_legs: bool = False) -> tuple[Trial, ...]:
    """Trials of a checked leg as floating point arrays, their angles continued over jumps by whole turns.

    ``own_legs`` : whether a trial may have its own leg. A trial that needs no change is returned as it is.

    Raises
    ------
    UserError
        With every mistake: trial, attribute, and what is allowed.
    """
    problems: list[Problem] = []
    if len(trials) > TRIAL_LIMIT:
        problems.append(Problem(f"{len(trials)} trials are given; at most {TRIAL_LIMIT}", place.name))
    found = []
    for index, trial in enumerate(trials):
        with gathering(problems):
            found.append(_checked(trial, leg, f"trials[{index}]", own_legs=own_legs))
    raise_if_any([*problems, *_name_problems(trials)])
    # Trials that were continued when they were read are on one turn already.
    if any(any(new.jumps) and new is not old for new, old in zip(found, trials, strict=True)):
        found = on_one_turn(found, leg)
    found = turned_back(found, leg)
    raise_if_any(trials_together(found, leg, in_code=True))
    return tuple(found)


def _name_problems(trials: Sequence[Trial]) -> list[Problem]:
    """Trials of one name: results, pages and predictions find a trial by its name, and would show one for the other."""
    places: dict[str, list[str]] = {}
    for index, trial in enumerate(trials):
        if isinstance(trial.name, str):
            places.setdefault(trial.name, []).append(f"trials[{index}]")
    text = "is the name of {}; name each trial once: dataclasses.replace(trial, name=...)"
    twice = {name: ", ".join(found) for name, found in places.items() if len(found) > 1}
    return [Problem(text.format(found), name, key="name") for name, found in twice.items()]


def _checked(trial: Trial, leg: Leg, fallback: str, *, own_legs: bool) -> Trial:
    """One trial; raises its mistakes."""
    named = isinstance(trial.name, str) and bool(trial.name.strip())
    name = trial.name if named else fallback
    problems = [] if named else [Problem(f"{trial.name!r} is no name: write text", fallback, key="name")]
    problems += _condition_problems(trial, leg, name)
    arrays = _arrays(trial, leg, name, problems)
    if trial.leg is not None:
        problems += _own_leg_problems(trial.leg, leg, name, allowed=own_legs)
    raise_if_any(problems)
    own = trial.leg or leg
    raise_if_any(_signal_problems(trial.signals, own, name))
    recorded = checked_columns(_columns(trial, arrays, own, name), own)
    return _changed(trial, arrays, recorded)


def _changed(trial: Trial, arrays: Mapping[str, Array], recorded: Recorded) -> Trial:
    """The trial with what the checks changed of it."""
    made: dict[str, Any] = {key: array for key, array in arrays.items() if array is not getattr(trial, key)}
    if any(recorded.jumps):
        made["angles"] = recorded.angles
        before = trial.jumps or (0,) * len(recorded.jumps)
        made["jumps"] = tuple(old + new for old, new in zip(before, recorded.jumps, strict=True))
    if "torques" in arrays and np.isnan(arrays["torques"]).any():
        made["torques"] = recorded.torques
    if any(recorded.unusual) and not trial.sha256:  # a file states the unit of its angles
        made["unusual"] = recorded.unusual
    if not isinstance(trial.locked, tuple):
        made["locked"] = tuple(trial.locked)
    return replace(trial, **made) if made else trial


def _arrays(trial: Trial, leg: Leg, name: str, problems: list[Problem]) -> dict[str, Array]:
    """The arrays that are given, by attribute, in their shapes; mistakes go to ``problems``."""
    found: dict[str, Array] = {}
    names, wide = ", ".join(leg.joint_names), len(leg.joints)
    for key in ("time", *SUFFIXES):
        given = getattr(trial, key)
        if given is None and key not in ("time", "angles"):
            continue
        try:
            array = _numbers(given)
        except (TypeError, ValueError):
            shown = f"an array of {given.dtype}" if isinstance(given, np.ndarray) else f"{given!r:.60}"
            problems.append(Problem(f"{shown} is not allowed: an array of numbers is needed", name, key=key))
            continue
        rows = len(found["time"]) if "time" in found else array.shape[0] if array.ndim else 0
        wanted = array.shape[:1] if key == "time" else (rows, wide)
        if array.ndim != len(wanted) or array.shape != wanted or array.ndim == 0:
            text = f"has the shape {array.shape}, where "
            text += "(samples,) is needed" if key == "time" else f"{wanted} is needed: samples by joints ({names})"
            text += f"; write {key}[:, None]" if key != "time" and wide == 1 and array.shape == (rows,) else ""
            problems.append(Problem(text, name, key=key))
            continue
        if np.isinf(array).any():
            at = ", ".join(map(str, np.argwhere(np.isinf(array))[0]))
            problems.append(Problem("inf is not allowed; nan where a sample is missing", name, key=f"{key}[{at}]"))
        found[key] = array
    return found


def _numbers(given: object) -> Array:
    """An attribute as floating point numbers, nan where a masked array has its mask.

    Raises
    ------
    TypeError, ValueError
        Where these are no real numbers. numpy would take the real part of complex ones and count the ticks of a date.
    """
    rows = given if isinstance(given, (list, tuple)) else ()
    if isinstance(given, np.ma.MaskedArray) or any(isinstance(row, np.ma.MaskedArray) for row in rows):
        given = np.ma.asarray(given)
        if given.dtype.kind in "fiub":
            given = np.ma.filled(given.astype(float), np.nan)
    if np.asarray(given).dtype.kind in "cmM":
        raise TypeError
    return np.asarray(given, dtype=float)


def _columns(trial: Trial, arrays: Mapping[str, Array], leg: Leg, name: str) -> Columns:
    """The arrays as the columns of a recording."""
    values, places = {"time": arrays["time"]}, {"time": ("time", -1)}
    for key, suffix in SUFFIXES.items():
        for j, joint in enumerate(leg.joint_names if key in arrays else ()):
            column = arrays[key][:, j]
            if key == "velocities" and np.isnan(column).all():
                continue  # of a joint without such a column
            values[joint + suffix], places[joint + suffix] = column, (key, j)
    unit = {"time": "s", **dict.fromkeys(leg.joint_names, "rad")}
    if trial.signals is not None:
        unit |= {f"{joint.name} command": "rad" for joint in leg.joints if isinstance(joint.drive, Servo)}

    def problem(text: str, column: str, row: int | None) -> Problem:
        if not column:
            return Problem(text, name)
        key, j = places[column]
        sample = ":" if row is None else str(row)
        place = key if j < 0 and row is None else f"{key}[{sample}]" if j < 0 else f"{key}[{sample}, {j}]"
        return Problem(text, name, key=place if j < 0 else f"{place} ({leg.joint_names[j]})")

    return Columns(values, unit, problem, CODE)


def _condition_problems(trial: Trial, leg: Leg, name: str) -> list[Problem]:
    """Mistakes of what stands beside a recording's file in a project."""
    given = {key: getattr(trial, key) for key in UNITS if getattr(trial, key) is not USUAL[key]}
    faults = {key: number_fault(value, UNITS[key]) for key, value in given.items()}
    problems = [Problem(fault, name, key=key) for key, fault in faults.items() if fault]
    locked = trial.locked
    if not isinstance(locked, (tuple, list)) or not all(isinstance(joint, str) for joint in locked):
        return [*problems, Problem(f'{locked!r:.60} is not allowed: write a tuple, ("knee",)', name, key="locked")]
    problems += [Problem(text, name, key="locked") for text in locked_faults(set(locked), leg)]
    if problems or (not given and trial.held_out is USUAL["held_out"]):
        return problems
    written = {key: units.write(float(value), UNITS[key]) for key, value in given.items()}
    held_out = bool(trial.held_out) if isinstance(trial.held_out, np.bool_) else trial.held_out
    entry = {"file": name, "held_out": held_out, "locked": list(locked)}
    entry |= {"tilt": written["tilt"]} if "tilt" in written else {}
    body = {key: written[attribute] for key, attribute in TIP.items() if attribute in written}
    found, place = list[Problem](), Document(Path(), name, {}, {}, b"")
    check_part(TrialEntry, place, entry, (), found)
    if body:
        check_part(TipMass, place, {"mass": "0 kg", **body}, (), found)
    return [with_hint(replace(problem, key=TIP.get(problem.key or "", problem.key))) for problem in found]


def _own_leg_problems(own: object, leg: Leg, name: str, *, allowed: bool) -> list[Problem]:
    """Mistakes of a trial's own leg."""
    if not allowed:
        return [Problem(OWN_LEG, name, key="leg")]
    problems: list[Problem] = []
    with gathering(problems):
        check_leg(own, Document(Path(), name, {}, {}, b""))
    if isinstance(own, Leg) and not problems:
        fault = other_leg_fault(own, leg)
        problems += [Problem(fault, name)] if fault else []
    return [replace(problem, key=f"leg.{problem.key}" if problem.key else "leg") for problem in problems]


def _signal_problems(signals: object, leg: Leg, name: str) -> list[Problem]:
    """Missing or misshapen inputs of the leg's servos."""
    servos = [joint.name for joint in leg.joints if isinstance(joint.drive, Servo)]
    if signals is None:
        text = f"is missing: the servo of {', '.join(servos)} needs its inputs (ServoSignals)"
        return [Problem(text, name, key="signals")] if servos else []
    if not isinstance(signals, ServoSignals) or not servos:
        why = "no joint has a servo; leave it out" if not servos else "ServoSignals are needed"
        return [Problem(f"{signals!r:.60} is not allowed: {why}", name, key="signals")]
    rows, problems = np.shape(signals.time)[:1], []
    for key, wanted in (
        ("time", rows),
        *dict.fromkeys(("command", "supply", "enabled"), (*rows, len(leg.joints))).items(),
    ):
        array = np.asarray(getattr(signals, key))
        if array.shape != wanted or not rows:
            problems.append(
                Problem(f"has the shape {array.shape}, where {wanted} is needed", name, key=f"signals.{key}")
            )
        elif array.dtype.kind not in "fiub" or not np.isfinite(array).all() or np.ma.is_masked(getattr(signals, key)):
            problems.append(Problem("holds something that is no finite number", name, key=f"signals.{key}"))
    if not problems and (np.diff(signals.time) <= 0.0).any():
        problems.append(Problem("time must increase from sample to sample", name, key="signals.time"))
    return problems or _far_commands(signals, leg, name)


def _far_commands(signals: ServoSignals, leg: Leg, name: str) -> list[Problem]:
    """Commands beyond what the joints' recordings may hold."""
    problems = []
    for j, joint in enumerate(leg.joints):
        row = far_command(joint, signals.command[:, j])
        if row is not None:
            text = (
                f"{signals.command[row, j]:g} rad is beyond the joint's travel, {widest(joint):.3g} rad; if these are "
            )
            text += "degrees, write numpy.radians(...); if the joint does turn so far, give it a range in the leg"
            problems.append(Problem(text, name, key=f"signals.command[{row}, {j}] ({joint.name})"))
    return problems
