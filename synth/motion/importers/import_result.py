"""The result of ``synth import``: trials in the project's own format, and ``import.json`` on their origin."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import synth
from synth.drives.servo import TorqueDrive
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.files.import_project import ForeignFile, ImportProject
from synth.files.leg_file import write_leg
from synth.files.names import written_name
from synth.files.output import place, write_csv, write_json, write_text
from synth.files.run_manifest import sha256_file
from synth.files.validate import gathering, raise_if_any
from synth.motion.importers.cleaning import SHORTEST, common_turns
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.motion.importers.drive_inputs import merge_inputs
from synth.motion.importers.points import along_its_axis
from synth.motion.release import free_after
from synth.sampling import own_moments, usual_step
from synth.swing.leg_model import Leg
from synth.units import quantity

TRIALS = "trials"
FIT, GAP, LEG = "fit.yaml", "gap.yaml", "leg.leg.yaml"  # a project of the trials, ready to run
LIBRARIES = ("numpy", "scipy")
DRAWN = 9  # frames whose points are drawn
OBLIQUE = np.radians(45.0)  # between planes; from here the opposite side is nearly as near, at 90 deg just as near
OTHER_WAY = (
    "its plane stands {:.0f} deg from the mean plane of all files: if it was seen from the other side, import it by "
    "itself with mirror: true"
)


@dataclass(frozen=True, eq=False)
class ImportedTrial:
    """A foreign file and its recording; ``target`` is its file name in the result."""

    source: ForeignFile
    target: str
    imported: ImportedRecording


def read_files(project: ImportProject) -> list[ImportedTrial]:
    """Read every file of a project.

    Raises
    ------
    UserError
        With every mistake of all files.
    """
    problems: list[Any] = []
    trials: list[ImportedTrial] = []
    targets = _targets(project.files)
    for file, target in zip(project.files, targets, strict=True):
        with gathering(problems):
            trials.append(ImportedTrial(file, target, _import_file(project, file, None)))
    raise_if_any(problems)
    trials, mapping = _on_one_side(project, trials)
    trials = _with_oblique_planes(_on_one_turn(replace(project, mapping=mapping), trials), mapping)
    return _without_hand(trials) if project.release == "free" else trials


def _import_file(project: ImportProject, file: ForeignFile, turns: Sequence[int] | None) -> ImportedRecording:
    return import_file(
        file.path,
        project.leg,
        project.mapping,
        name=file.name,
        form=project.format,
        cut=project.release,
        window=file.window,
        turns=turns,
    )


def _on_one_side(project: ImportProject, trials: list[ImportedTrial]) -> tuple[list[ImportedTrial], Mapping]:
    """The recordings seen from one side, and the mapping that says which.

    A fitted plane alone decides on its right by the nearest axis of space, which for a walkway diagonal to the axes is
    another one in every other file. The common right is the direction that the planes of all files have in the mean.
    """
    rights = [trial.imported.tracked.right for trial in trials if trial.imported.tracked is not None]
    ways = np.array([right for right in rights if right is not None])
    if len(ways) < 2 or len(ways) < len(trials):
        return trials, project.mapping
    mean = along_its_axis(np.linalg.eigh(ways.T @ ways)[1][:, -1])
    mapping = replace(project.mapping, towards=(float(mean[0]), float(mean[1])))
    there = replace(project, mapping=mapping)
    made = [
        trial if along >= 0.0 else replace(trial, imported=_import_file(there, trial.source, None))
        for trial, along in zip(trials, ways @ mean, strict=True)
    ]
    return made, mapping


def _with_oblique_planes(trials: list[ImportedTrial], mapping: Mapping) -> list[ImportedTrial]:
    """The recordings, with a note on each whose plane stands far from the mean one of all."""
    if mapping.towards is None:
        return trials
    made = []
    for trial in trials:
        tracked, notes = trial.imported.tracked, trial.imported.notes
        assert tracked is not None
        assert tracked.right is not None
        along = float(tracked.right @ np.array(mapping.towards))
        if along < np.cos(OBLIQUE):
            notes = (*notes, OTHER_WAY.format(float(np.degrees(np.arccos(along)))))
        made.append(replace(trial, imported=replace(trial.imported, notes=notes)))
    return made


def _on_one_turn(project: ImportProject, trials: list[ImportedTrial]) -> list[ImportedTrial]:
    """The recordings on whole turns that they have in common; one that alone had others is read again with these."""
    columns = [
        common_turns(joint, [trial.imported.turns[j] for trial in trials]) for j, joint in enumerate(project.leg.joints)
    ]
    made = []
    for trial, turns in zip(trials, zip(*columns, strict=True), strict=True):
        alone = tuple(each.shift for each in trial.imported.turns)
        again = trial if alone == turns else replace(trial, imported=_import_file(project, trial.source, turns))
        made.append(again)
    return made


def _without_hand(trials: list[ImportedTrial]) -> list[ImportedTrial]:
    """Cut all at the end of the longest external torque detected; see ``release.free_after``."""
    driven = {trial.source.name: trial.imported.driven for trial in trials if trial.source.window is None}
    seen = [length for length in driven.values() if length is not None]
    if not seen:
        return trials
    after = free_after(seen)
    made = []
    for trial in trials:
        own, name = trial.imported, trial.source.name
        start = own.start + after
        left = int((own.time >= start).sum())
        if name not in driven or start <= own.time[0] or left < SHORTEST:
            made.append(trial)
            continue
        shown = f"detected in {len(seen)} of {len(driven)} recordings, plus its decay"
        text = f"cut to {start:.3f} s, {after * 1e3:.0f} ms after its start: while an external torque acts ({shown})"
        made.append(replace(trial, imported=own.later(start, text)))
    return made


def project_file(leg: Leg) -> str:
    """The project that is written: a fit, or for a leg with motors or servos a gap, which needs no springs."""
    return GAP if any(joint.drive not in (None, TorqueDrive()) for joint in leg.joints) else FIT


def write_import(project: ImportProject, trials: list[ImportedTrial], folder: Path) -> None:
    """Write the trials, each validated by the fit's reader, a project of them that runs, and ``import.json``."""
    from synth.files.recording import read_recording

    (folder / TRIALS).mkdir()
    problems: list[Any] = []
    for trial in trials:
        clock, rows, inputs = merge_inputs(trial.imported.time, trial.imported.inputs)
        columns = {"time [s]": clock}
        for index, joint in enumerate(project.leg.joint_names):
            columns[f"{joint} [deg]"] = angle = np.full(len(clock), np.nan)
            angle[rows] = np.degrees(trial.imported.angles[:, index])
        columns |= inputs
        path = place(folder, trial.target)
        write_csv(path, columns)
        with gathering(problems):
            read_recording(path, project.leg, name=f"{trial.source.name} (as {trial.target})")
    if problems:
        raise UserError(problems)
    write_leg(project.leg, folder / LEG)
    name = project_file(project.leg)
    more = "free_angle: auto\n" if name == FIT else ""
    write_text(folder / name, f"kind: {Path(name).stem}\nleg: {LEG}\ntrials:\n  - {TRIALS}/*.csv\n{more}")
    content = {
        "format": "synth/import/1",
        "name": project.name,
        "leg": _leg(project.leg),
        "trials": [_trial(trial, folder, project.leg.joint_names) for trial in trials],
        "inputs": {item.name: item.sha256 for item in project.inputs},
        "versions": {"synth": synth.__version__, **{n: importlib.metadata.version(n) for n in LIBRARIES}},
    }
    write_json(folder / "import.json", content)


def _targets(files: tuple[ForeignFile, ...]) -> list[str]:
    """A name in the result for each file: its stem if unique, else with folders, else with extension."""
    paths = [Path(file.name) for file in files]
    levels = [
        [written_name(path.stem) for path in paths],
        [written_name("_".join([*path.parts[:-1], path.stem])) for path in paths],
        [written_name("_".join([*path.parts[:-1], path.stem, path.suffix[1:]])) for path in paths],
    ]
    names: list[str] = []
    for choices in zip(*levels, strict=True):
        name = next((each for each, level in zip(choices, levels, strict=True) if level.count(each) == 1), choices[-1])
        while f"{TRIALS}/{name}.csv" in names:
            name += "_"
        names.append(f"{TRIALS}/{name}.csv")
    return names


def _leg(leg: Leg) -> dict[str, Any]:
    """The data for a drawing of the leg."""
    joints = []
    for joint in leg.joints:
        item: dict[str, Any] = {"name": joint.name, "zero": quantity(joint.zero, "deg"), "sign": joint.sign}
        item["length"] = quantity(joint.link.length, "mm")
        if joint.range is not None:
            item["range"] = [quantity(end, "deg") for end in joint.range]
        joints.append(item)
    return {"name": leg.name, "tilt": quantity(leg.tilt, "deg"), "joints": joints}


def _missing(made: ImportedRecording, joints: Sequence[str]) -> dict[str, int]:
    """Joint -> its missing readings in the trial, where there are any."""
    known = np.isfinite(made.angles)
    counts = (own_moments(made.time, known) & ~known).sum(axis=0)
    return {name: int(count) for name, count in zip(joints, counts, strict=True) if count}


def _trial(trial: ImportedTrial, folder: Path, joints: Sequence[str]) -> dict[str, Any]:
    made = trial.imported
    item: dict[str, Any] = {
        "file": trial.target,
        "sha256": sha256_file(folder / trial.target),
        "source": trial.source.name,
        "source_sha256": sha256_file(trial.source.path),
        "source_format": made.format,
        "samples": len(made.time),
        "samples_in_source": made.total,
        "missing": _missing(made, joints),
        "rate": quantity(1.0 / usual_step(made.time, np.isfinite(made.angles)), "Hz"),
        "notes": list(made.notes),
    }
    if made.release is not None:
        found = made.release
        item["release"] = {
            "released": None if found.released is None else quantity(found.released, "s"),
            "driven_until": None if found.driven_until is None else quantity(found.driven_until, "s"),
            **({} if found.not_before is None else {"not_before": quantity(found.not_before, "s")}),
        }
    if made.tracked is not None:
        seen = np.flatnonzero(np.isfinite(made.tracked.points).all(axis=(1, 2)))
        if len(seen):
            picked = seen[np.unique(np.linspace(0, len(seen) - 1, DRAWN).round().astype(int))]
            points = (made.tracked.points[picked] - made.tracked.points[picked][:, :1]) * made.tracked.scale
            item["points"] = [
                {"time": quantity(float(made.time[k]), "s"), "unit": "m", "places": frame}
                for k, frame in zip(picked, points, strict=True)
            ]
    return item
