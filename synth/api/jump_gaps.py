"""``synth.jump_gap``: why the built leg jumps differently from the designed one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.api.beside_project import require_path
from synth.api.diagnosed import Diagnosed
from synth.api.report import Panel, Stage, silent, stage_by_stage
from synth.diagnosis.diagnosis_result import Diagnosis
from synth.diagnosis.plants.jumping_leg.jump_data import prepare_jumps
from synth.diagnosis.plants.jumping_leg.jump_result import JumpGapResult
from synth.errors import UserError
from synth.files.gap_kind import kind_of_leg
from synth.files.hopper_gap_project import HopperGapProject, read_hopper_gap_project
from synth.files.input_hashes import read_by
from synth.parts.catalogs import Catalogue


@dataclass(frozen=True, eq=False, repr=False)
class JumpGap(Diagnosed):
    """Why a jumping leg jumps differently."""

    project: HopperGapProject
    result: JumpGapResult

    @property
    def diagnosis(self) -> Diagnosis:
        """The diagnosis."""
        return self.result

    def panels(self) -> Sequence[Panel]:
        """Rise of each scored trial, measured and predicted."""
        rises = self.result.gaps.rises
        number = np.arange(1.0, len(rises) + 1.0)
        curves = {}
        for name in ("measured", "as_designed", "before", "after"):
            values = [getattr(rise, name) for rise in rises]
            if any(value is not None for value in values):
                heights = np.array([np.nan if value is None else 1e3 * value for value in values])
                curves[name.replace("_", " ")] = (number, heights)
        return [Panel("rise of the centre of mass", "trial", "rise [mm]", curves, frozenset(curves))] if curves else []

    def inputs(self) -> tuple[list[Path], list[str]]:
        """What its project reads."""
        return read_by(self.project)

    def write(self, folder: Path) -> None:
        """``gap.json``, predictions and a report."""
        from synth.diagnosis.plants.jumping_leg.jump_write import write_gap
        from synth.reports.hopper_pages import write_jump_gap_report

        write_gap(self.result, self.project, folder)
        write_jump_gap_report(folder)


def read_jump_gap(path: str | Path) -> tuple[HopperGapProject, Catalogue, tuple[str, ...]]:
    """Read a project of kind ``gap`` for a jumping leg, its catalogue, and warnings about its recordings."""
    project = read_hopper_gap_project(path)
    catalogue = Catalogue.load(project.design.catalogs)
    return project, catalogue, tuple(prepare_jumps(project, catalogue)[1])


def jump_gap(
    what: str | Path | HopperGapProject, catalogue: Catalogue | None = None, *, stage: Stage = silent
) -> JumpGap:
    """Find why a built leg jumps differently from its design, from a project file or a read project.

    Raises
    ------
    UserError
        With every mistake of the project, or if its leg swings.
    """
    if not isinstance(what, HopperGapProject):
        require_path(what, 'jump_gap("gap.yaml")')
        if kind_of_leg(what) == "leg":
            raise UserError(f"{what} describes a swinging leg: read it with synth.gap")
    project = what if isinstance(what, HopperGapProject) else read_hopper_gap_project(what)
    with stage("loading the compiled jump (compiled once on this machine, some 15 s)"):
        from synth.diagnosis.plants.jumping_leg.jump_diagnosis import diagnose as diagnose_jumps
        from synth.jump.jump_runs import compiled_jump

        compiled_jump(project.design.leg.bending)
    with stage("diagnosing"), stage_by_stage(stage) as say:
        return JumpGap(project, diagnose_jumps(project, catalogue or Catalogue.load(project.design.catalogs), say))
