"""``synth leg``: from a leg-design project to a folder with the whole design."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.errors import UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.design.leg_design import LegDesign
    from synth.files.leg_project import LegProject
    from synth.files.stage_cache import StageCache
    from synth.parts.catalogs import Catalogue


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    from synth.commands import leg_parts

    parser.add_argument("file", help="project file, kind: leg-design")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--no-cad", action="store_true", help="leave the solids out")
    parser.add_argument("--no-pictures", action="store_true", help="leave the pictures of the solids out")
    parser.add_argument("--no-cache", action="store_true", help="do everything again, keep nothing for a later run")
    parser.add_argument("--dry-run", action="store_true", help="read and check everything, write nothing")
    leg_parts.add_arguments(parser)


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read, then either fetch an earlier run of the same input or fit, choose, draw and write."""
    from synth.commands.answers import tell
    from synth.commands.leg_parts import parts_text, require_known_joints, with_options
    from synth.files.output import output_folder
    from synth.files.projects import read_leg_project
    from synth.files.stage_cache import StageCache, key_of
    from synth.parts.catalogs import Catalogue
    from synth.parts.resolver import resolver

    with progress.stage("reading the project"):
        project = read_leg_project(arguments.file, open_catalogue=lambda paths: resolver(Catalogue.load(paths)))
        catalogue = Catalogue.load(project.catalogs)
        project = with_options(project, arguments, catalogue)
        require_known_joints(project)
    if arguments.dry_run:
        progress.say(f"{arguments.file} can be used: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    cache = StageCache(on=not arguments.no_cache)
    key = key_of("leg", arguments.file, _inputs(project), arguments.no_cad, arguments.no_pictures, repr(project.parts))
    report = Path(arguments.out) / "report.html"
    failure: UserError | None = None
    with output_folder(arguments.out) as folder:
        if cache.fetch(key, folder):
            progress.say("nothing changed since an earlier run: its result is copied (--no-cache does it again)")
        else:
            failure = _made(arguments, project, catalogue, folder, cache, progress, report)
            # A machine that could not draw may be able to later.
            whole = arguments.no_cad or arguments.no_pictures or (folder / "parts" / "leg.png").exists()
            if failure is None and whole:
                cache.keep(key, folder)
    if failure is not None:
        raise failure
    tell(progress, Path(arguments.out) / "design.json", parts_text)
    progress.say(f"design: {Path(arguments.out) / 'design.json'}")
    progress.say(f"report: {report}")
    return 0


def _inputs(project: LegProject) -> list[tuple[str, str]]:
    """Name and hash of every file that the project reads."""
    trials = [*project.trials, *(trial for damper in project.dampers.values() for trial in damper.trials)]
    files = [(item.name, item.sha256) for item in project.inputs]
    return [*files, *((trial.name, trial.sha256) for trial in trials)]


def _made(
    arguments: argparse.Namespace,
    project: LegProject,
    catalogue: Catalogue,
    folder: Path,
    cache: StageCache,
    progress: Progress,
    report: Path,
) -> UserError | None:
    """Do the whole work into ``folder``; where gates fail, the error to end with once the folder is whole."""
    from synth.commands.solid_files import NOT_DRAWN, draw_solids, drawn_up, require_drawn, with_settings
    from synth.design.bom import write_bom
    from synth.design.drawn_springs import as_drawn, seats_set
    from synth.design.leg_design import fastest_rates
    from synth.design.write_design import write_files
    from synth.files.robot_xml import write_robot_files

    design = _designed(project, catalogue, cache, progress)
    extra: dict[str, Any] = NOT_DRAWN
    if not arguments.no_cad:
        with progress.stage("drawing, checking and writing the joints"):
            design = drawn_up(design, catalogue)
            extra = draw_solids(design, folder, cache, pictures=not arguments.no_pictures)
            design = as_drawn(design, extra["solids"]["joints"])
    design, settings = seats_set(design)
    extra = with_settings(extra, design, settings)
    with progress.stage("writing the design"):
        write_files(design, folder)
        times = [release.time for release in design.wanted.releases]
        lost = write_robot_files(design.built, fastest_rates(design.built_motions, times), folder)
    with progress.stage("writing the report"):
        write_bom(design, extra["solids"]["parts"], folder / "bom.csv")
        _report(design, folder, extra, lost)
    try:
        require_drawn(extra["solids"], project.path, report)
    except UserError as error:
        return error
    return None


def _designed(project: LegProject, catalogue: Catalogue, cache: StageCache, progress: Progress) -> LegDesign:
    """The chosen design: kept from an earlier run where only what concerns drawing and printing changed."""
    from dataclasses import replace

    from synth.design.leg_design import LegDesign, design_leg
    from synth.files.plain_value import Remade, digest_of
    from synth.files.project_options import CadOptions
    from synth.files.stage_cache import key_of
    from synth.swing.chain import Chain, compiled_chain

    # The choice of springs looks at the joint's room: shaft, clearance and wall.
    room = CadOptions(project.cad.shaft_diameter, project.cad.clearance, project.cad.wall)
    rest = replace(project, cad=room, defaults=(), inputs=(), measured_springs={})
    key = key_of("design", digest_of(rest), digest_of(catalogue), _inputs(replace(project, inputs=project.inputs[1:])))
    chains = {Chain: Remade(lambda chain: chain.layout.n, compiled_chain)}  # without its machine code
    kept = cache.value(key, LegDesign, chains)
    if kept is not None:
        return replace(kept, project=project)
    progress.compiling(len(project.target.joints))
    design = design_leg(project, catalogue, progress.stage)
    cache.keep_value(key, design, chains)
    return design


def _report(design: LegDesign, folder: Path, extra: dict[str, Any], lost: list[str]) -> None:
    """Write design.json, the page made from it, and list every file with its hash but design.json itself."""
    from reports import write_leg_report
    from synth.design.page_data import page_json
    from synth.design.write_design import design_json
    from synth.files.output import write_json

    write_json(folder / "page.json", page_json(design))
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    content = design_json(design, files, folder, extra)
    content["warnings"] += [{"joint": None, "text": note} for note in (*extra["solids"]["notes"], *lost)]
    write_json(folder / "design.json", content)
    write_leg_report(folder)
