"""The files that a project was read from, with their hashes: what its results depend on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject
    from synth.files.hopper_gap_project import HopperGapProject
    from synth.files.hopper_project import HopperProject
    from synth.files.leg_project import LegProject
    from synth.files.projects import FitProject

    Project: TypeAlias = FitProject | GapProject | LegProject | HopperProject | HopperGapProject


def input_hashes(project: Project) -> dict[str, str]:
    """SHA-256 by name of every file read: the project, all files named in it or in those, then the recordings."""
    trials = [*getattr(project, "trials", ())]
    trials += [trial for damper in getattr(project, "dampers", {}).values() for trial in damper.trials]
    return {item.name: item.sha256 for item in project.inputs} | {trial.name: trial.sha256 for trial in trials}


def input_files(project: Project) -> list[Path]:
    """The files themselves, which a result must not replace."""
    return [project.path, *(project.path.parent / name for name in input_hashes(project))]


def read_by(project: Project) -> tuple[list[Path], list[str]]:
    """``input_files``, those of legs that code read too, and the SHA-256 of each recording: its place is not known."""
    trials = getattr(project, "trials", ())
    legs = [getattr(project, "leg", None), *(trial.leg for trial in trials)]
    files = [Path(file) for leg in legs for file in getattr(leg, "read_from", ())]
    return input_files(project) + files, [trial.sha256 for trial in trials if trial.sha256]
