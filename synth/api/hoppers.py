"""``synth.hopper``: gear motor, ratio and link length of a jumping leg."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.api.beside_project import require_path
from synth.api.report import Cell, Panel, Report, Stage, silent
from synth.files.hopper_project import HopperProject
from synth.files.hopper_project import read_hopper_project as _read_hopper_project
from synth.files.input_hashes import read_by
from synth.hopper.checkpoint import Checkpoint
from synth.hopper.study import Study, study, sweep_problem
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import LANDED_AGAIN
from synth.parts.catalogs import Catalogue

if TYPE_CHECKING:
    from synth.batch.cluster import Cluster

Chunks = Callable[[int, int], None]  # finished chunks, total


@dataclass(frozen=True, eq=False, repr=False)
class Hopper(Report):
    """The sweep and choice of a jumping leg; ``study`` holds everything."""

    study: Study

    @property
    def project(self) -> HopperProject:
        """The project."""
        return self.study.project

    @property
    def jumps(self) -> bool:
        """Whether any design lifts off."""
        return bool((self.study.sweep.status == LANDED_AGAIN).any())

    @property
    def chosen(self) -> bool:
        """Whether a design lifts off and, where ``gearbox`` is ``stop``, its gearbox bears the push."""
        return self.study.best is not None

    @property
    def headline(self) -> str:
        """The chosen design, or why there is none."""
        found = self.study
        if found.best is None:
            return f"{self.project.name}: {found.none_because}"
        motor, length = found.best_motor, float(found.sweep.length[found.best])
        return f"{self.project.name}: {motor.name} with an upper link of {length * 1e3:.4g} mm"

    def columns(self) -> dict[str, list[Cell]]:
        """One row per design of the Pareto front, with the chosen one marked."""
        found, rows = self.study, self.study.front
        sweep = found.sweep
        return {
            "motor": [sweep.problem.motors[int(sweep.motor[i])].name for i in rows],
            "leg length [mm]": [float(sweep.length[i]) * 1e3 for i in rows],
            "clearance [mm]": [float(sweep.values["clearance"][i]) * 1e3 for i in rows],
            "clearance low [mm]": [float(found.low[i]) * 1e3 for i in rows],
            "clearance high [mm]": [float(found.high[i]) * 1e3 for i in rows],
            "chosen": [i == found.best for i in rows],
        }

    def panels(self) -> Sequence[Panel]:
        """Clearance of every design over its length, and the Pareto front."""
        sweep, front = self.study.sweep, self.study.front
        all_of = (sweep.length * 1e3, sweep.values["clearance"] * 1e3)
        curves = {"designs": all_of, "front": (all_of[0][front], all_of[1][front])}
        labels = ("upper link [mm]", "clearance [mm]")
        return [Panel("designs", *labels, {k: (np.asarray(x), np.asarray(y)) for k, (x, y) in curves.items()},
                      frozenset(curves))]  # fmt: skip

    def inputs(self) -> tuple[list[Path], list[str]]:
        """What its project reads."""
        return read_by(self.project)

    def write(self, folder: Path) -> None:
        """``hopper.json``, ``designs.csv``, the jump, the parts and a report."""
        self.write_with(folder)

    def write_with(self, folder: Path, *, parts: bool = True, stage: Stage = silent) -> None:
        """The same with or without ``parts``."""
        from synth.files.output import write_json
        from synth.hopper.laminate_parts import draw_parts
        from synth.hopper.write_study import hopper_json, write_designs, write_jump
        from synth.reports.hopper_pages import write_hopper_report

        found = self.study
        with stage("writing the designs"):
            write_designs(found, folder / "designs.csv")
            write_jump(found, folder / "jump.csv")
        drawn: dict[str, Any] = {}
        if parts:
            with stage("drawing the chosen leg's parts"):
                drawn = draw_parts(found, folder)
        with stage("writing the report"):
            files = sorted(path for path in folder.rglob("*") if path.is_file())
            content = hopper_json(found, files, folder, drawn.get("notes", ()))
            write_json(folder / "hopper.json", content | ({"parts": drawn} if drawn else {}))
            write_hopper_report(folder)


def read_hopper(path: str | Path) -> tuple[HopperProject, Catalogue, int]:
    """Read a project of kind ``hopper-design``, its catalogue, and the number of motors in the sweep.

    Raises
    ------
    UserError
        With every mistake of the project, or if a pattern matches no motor.
    """
    project = _read_hopper_project(path)
    catalogue = Catalogue.load(project.catalogs)
    return project, catalogue, len(sweep_problem(project, catalogue)[0].motors)


def hopper(
    what: str | Path | HopperProject,
    catalogue: Catalogue | None = None,
    *,
    checkpoint: Checkpoint | None = None,
    cluster: Cluster | None = None,
    stage: Stage = silent,
    progress: Chunks | None = None,
) -> Hopper:
    """Sweep motors, ratios and lengths, and choose a design.

    Parameters
    ----------
    what
        a project file, or a project that was read.
    catalogue
        the motors to sweep; default: the built-in tables and those that the project names.
    checkpoint
        folder of finished chunks, from which an interrupted sweep goes on; None: none is kept.
    cluster
        remote workers; None: the cores of this machine.
    stage
        called with the current stage.
    progress
        called with the number of finished chunks.

    Raises
    ------
    UserError
        If the project cannot be used. A sweep without any jumping design is a valid result.
    """
    if not isinstance(what, HopperProject):
        require_path(what, 'hopper("hopper.yaml")')
    project = what if isinstance(what, HopperProject) else _read_hopper_project(what)
    with stage("loading the compiled jump (compiled once on this machine, some 15 s)"):
        compiled_jump(project.leg.bending)
    return Hopper(study(project, catalogue or Catalogue.load(project.catalogs), checkpoint, stage, progress, cluster))
