"""``synth.design``: from wanted motion to a leg of parts to buy, wind and print."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from synth.api.beside_project import require_path
from synth.api.design_input import read_design
from synth.api.report import Cell, Panel, Report, Stage, silent
from synth.design.leg_design import LegDesign, design_leg
from synth.design.solid_work import load_kernel
from synth.errors import UserError
from synth.files.input_hashes import input_hashes, read_by
from synth.files.leg_project import LegProject
from synth.files.plain_value import Remade, digest_of
from synth.files.project_options import CadOptions
from synth.files.stage_cache import StageCache, key_of
from synth.parts.catalogs import Catalogue
from synth.remarks import of_joint, remark_json
from synth.side_processes import side_processes
from synth.spring.unit_text import UnitText
from synth.swing.chain import Chain, compiled_chain
from synth.swing.leg_model import Leg


@dataclass(frozen=True, eq=False, repr=False)
class Design(Report):
    """A designed leg; ``design`` holds everything, see ``LegDesign``. ``solids`` : whether its joints are drawn."""

    design: LegDesign
    solids: bool = True

    @property
    def project(self) -> LegProject:
        """The project."""
        return self.design.project

    @property
    def leg(self) -> Leg:
        """The leg with the chosen parts."""
        return self.design.built

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings to read before ordering."""
        return tuple(of_joint(joint, text) for joint, text in self.design.warnings)

    @property
    def headline(self) -> str:
        """The RMS distance of the built leg's motion from the wanted one."""
        off = math.degrees(float(np.sqrt(np.mean(self.design.errors**2))))
        at = f", at {', '.join(self.design.another_motion)} not the animal's" if self.design.another_motion else ""
        return f"{self.project.name}: {off:.2f} deg RMS from the wanted motion{at} with nominal parts"

    def columns(self) -> dict[str, list[Cell]]:
        """One row per joint: wanted values, the chosen spring and damper, the error."""
        found = self.design
        wanted = [joint.spring for joint in found.target.leg.joints]
        return {
            "joint": list(found.built.joint_names),
            "wanted spring rate [N*m/rad]": [None if spring is None else spring.rate for spring in wanted],
            "spring": [option.label for option in found.springs.chosen],
            "spring rate [N*m/rad]": [option.rate for option in found.springs.chosen],
            "damper": [option.label for option in found.dampers.chosen],
            "arm offset [deg]": [math.degrees(found.arm_offset(j)) for j in range(len(found.built.joints))],
            "RMS [deg]": [math.degrees(float(error)) for error in found.errors],
        }

    def panels(self) -> Sequence[Panel]:
        """One panel per release: wanted and built angles."""
        found, panels = self.design, []
        for release, wanted, built in zip(
            found.wanted.releases, found.wanted.motions, found.built_motions, strict=True
        ):
            curves = {}
            for j, name in enumerate(found.built.joint_names):
                for word, motion in (("wanted", wanted), ("built", built)):
                    curves[f"{name} {word}"] = (release.time, np.degrees(found.built.to_measured(motion)[:, j]))
            panels.append(Panel("wanted and built", "time [s]", "angle [deg]", curves))
        return panels

    def inputs(self) -> tuple[list[Path], list[str]]:
        """What its project reads."""
        return read_by(self.project)

    def write(self, folder: Path) -> None:
        """All files of ``synth leg``, including the solids.

        Raises
        ------
        UserError
            If a joint cannot be drawn; ``CannotBeHad`` if one fails a check. Nothing is written then.
        """
        failure = self.write_with(folder)
        if failure is not None:
            raise failure

    def write_compared(self, folder: Path) -> tuple[str, str]:
        """Without solids and what drawing them changes, and without the report."""
        from synth.design.drawn_springs import seats_set
        from synth.design.free_angle_reach import refuse_stops
        from synth.design.write_design import design_json, write_files
        from synth.files.output import write_json

        refuse_stops(self.design)
        design, _ = seats_set(self.design)
        write_files(design, folder)
        write_json(folder / "design.json", design_json(design, [], folder, {}))
        return "design", self.project.name

    def write_with(
        self,
        folder: Path,
        *,
        pictures: bool = True,
        cache: StageCache | None = None,
        report: Path | None = None,
        stage: Stage = silent,
    ) -> UserError | None:
        """Write the files; return the error to raise at the end if the solids fail a check.

        ``report`` : the page's final path, for the message.
        """
        from synth.design.bearing_friction import bearing_friction, with_friction, with_friction_notes
        from synth.design.bom import write_bom
        from synth.design.drawn_springs import as_drawn, seats_set
        from synth.design.free_angle_reach import refuse_stops
        from synth.design.mass_loop import with_drawn_masses
        from synth.design.robot_files import write_robots
        from synth.design.solid_files import (
            NOT_DRAWN,
            DrawnSolids,
            draw_solids,
            not_weighed,
            require_drawn,
            with_settings,
        )
        from synth.design.write_design import write_files

        refuse_stops(self.design)
        design, drawn = self.design, DrawnSolids(dict(NOT_DRAWN))
        extra = drawn.extra
        if not self.solids:
            design = not_weighed(design)
        else:
            with stage("drawing, checking and writing the joints"), drawing(design.project, stage=stage):
                drawn = draw_solids(design, folder, cache or StageCache(on=False), pictures=pictures)
                design, extra = with_drawn_masses(design, drawn.masses), drawn.extra
                friction = bearing_friction(design)
                design = as_drawn(with_friction(design, friction), extra["solids"]["joints"])
                extra = with_friction_notes(extra, friction)
        design, settings = seats_set(design)
        extra = with_settings(extra, design, settings)
        with stage("writing the design"):
            write_files(design, folder)
            lost = write_robots(design, drawn.masses, folder)
        with stage("writing the report"):
            bill = write_bom(design, extra["solids"]["parts"], drawn.orders, folder / "bom.csv")
            _report(design, folder, extra, lost, bill)
        try:
            require_drawn(extra["solids"], design.project.path, report or folder / "report.html")
        except UserError as error:
            return error
        return None


def design(
    what: str | Path | LegProject,
    catalogue: Catalogue | None = None,
    *,
    solids: bool = True,
    cache: StageCache | None = None,
    stage: Stage = silent,
    compiling: Callable[[int], object] | None = None,
) -> Design:
    """Fit, scale and choose: design a leg of parts that moves as wanted.

    Parameters
    ----------
    what
        a project file, or a project that was read.
    catalogue
        the parts to choose from; default: the built-in tables and those that the project names.
    solids
        draw the joints and use the masses of their parts; False leaves them out.
    cache
        folder of an earlier design of the same input; options of the printer's bed and measured springs may differ.
        None: nothing is stored.
    stage
        called with the current stage.
    compiling
        called with the number of links before their equations are needed.

    Raises
    ------
    UserError
        If trials cannot be used, or no joint can be drawn from the dimensions; ``CannotBeHad`` if no part
        meets the constraints.
    """
    from synth.design.solid_files import on_bed

    if not isinstance(what, LegProject):
        require_path(what, 'design("leg-design.yaml")')
    project = what if isinstance(what, LegProject) else read_design(what)[0]
    catalogue = catalogue or Catalogue.load(project.catalogs)
    cache = cache or StageCache(on=False)
    bed, anywhere = project.cad.bed, CadOptions().bed
    stated = tuple(default for default in project.defaults if default.key != "cad.bed")
    rest = replace(project, cad=replace(project.cad, bed=anywhere), defaults=stated, inputs=(), measured_springs={})
    read = input_hashes(replace(project, inputs=project.inputs[1:]))
    key = key_of("design", digest_of(rest), digest_of(catalogue), read, solids)
    remade = {
        Chain: Remade(lambda chain: chain.layout.n, compiled_chain),  # without its machine code
        UnitText: Remade(UnitText.as_data, UnitText.from_data),
    }
    kept = cache.value(key, LegDesign, remade)
    if kept is not None:
        return Design(on_bed(replace(kept, project=project), bed), solids)
    with drawing(project, solids=solids, stage=stage):  # their start overlaps the fits
        if compiling is not None:
            compiling(len(project.target.joints))
        made = _make_design(project, catalogue, solids=solids, stage=stage)
    cache.keep_value(key, made, remade)
    return Design(made, solids)


def drawing(project: LegProject, *, solids: bool = True, stage: Stage = silent) -> AbstractContextManager[None]:
    """The processes that draw the project's joints, open within the block; with one thread, or no solids, none."""
    return side_processes(len(project.target.joints), load_kernel, stage) if solids else nullcontext()


def _make_design(project: LegProject, catalogue: Catalogue, *, solids: bool, stage: Stage) -> LegDesign:
    from synth import cad
    from synth.design.drawable_dampers import refuse_short_links
    from synth.design.drawing_refusals import not_drawable
    from synth.design.held_to_ranges import held_to_ranges
    from synth.design.mass_loop import design_with_masses

    if solids:
        refuse_short_links(project)
    try:
        return held_to_ranges((design_with_masses if solids else design_leg)(project, catalogue, stage))
    except cad.DimensionError as error:
        raise not_drawable(error, project) from None


def _report(design: LegDesign, folder: Path, extra: dict[str, Any], lost: list[str], bill: Mapping[str, str]) -> None:
    """Write design.json and its page, and list every other file with its hash; ``bill``: as ``page_json``."""
    from synth.design.page_data import page_json
    from synth.design.write_design import design_json
    from synth.files.kept_templates import kept_templates
    from synth.files.output import write_json
    from synth.reports import write_leg_report

    write_json(folder / "page.json", page_json(design, bill))
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    content = design_json(design, files, folder, extra)
    messages = {str(note): note for note in design.drawn.notes} if design.drawn is not None else {}
    notes = [messages.get(note, note) for note in extra["solids"]["notes"]]  # stored solids hold texts without severity
    content["warnings"] = _with_told(content["warnings"], [*notes, *lost])
    write_json(folder / "design.json", content)
    write_leg_report(folder, kept_templates())


def _with_told(warnings: Sequence[dict[str, Any]], told: Sequence[str]) -> list[dict[str, Any]]:
    """The design's warnings with what drawing told: a part that does not work comes before numbers in doubt."""
    items = [{"joint": None, **remark_json(text)} for text in told]
    stops = [item for item in items if item["severity"] == "decide"]
    return [*stops, *warnings, *(item for item in items if item not in stops)]
