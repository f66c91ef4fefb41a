"""``synth leg``: from a leg-design project to a folder with the whole design."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cad import BuiltLeg, ExportedFile
    from synth.commands.progress import Progress
    from synth.design.leg_design import LegDesign


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", help="project file, kind: leg-design")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--no-cad", action="store_true", help="leave the solids out")
    parser.add_argument("--no-pictures", action="store_true", help="leave the pictures of the solids out")
    parser.add_argument("--dry-run", action="store_true", help="read and check everything, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read, fit, choose, draw and write."""
    from synth.design.leg_design import design_leg
    from synth.design.write import write_files
    from synth.files.output import output_folder
    from synth.files.projects import read_leg_project
    from synth.parts.catalog import Catalogue
    from synth.parts.resolver import resolver

    with progress.stage("reading the project"):
        project = read_leg_project(arguments.file, open_catalogue=lambda paths: resolver(Catalogue.load(paths)))
        catalogue = Catalogue.load(project.catalogs)
    if arguments.dry_run:
        progress.say(f"{arguments.file} can be used: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    with output_folder(arguments.out) as folder:
        progress.compiling(len(project.target.joints))
        design = design_leg(project, catalogue, progress.stage)
        with progress.stage("writing the design"):
            write_files(design, folder)
        extra: dict[str, Any] = {"pictures": [], "solids": {"drawn": False, "checks": [], "notes": []}}
        if not arguments.no_cad:
            with progress.stage("drawing, checking and writing the joints"):
                extra = _solids(design, folder, pictures=not arguments.no_pictures)
        with progress.stage("writing the report"):
            _report(design, folder, extra)
    progress.say(f"design: {Path(arguments.out) / 'design.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def _solids(design: LegDesign, folder: Path, *, pictures: bool) -> dict[str, Any]:
    """Draw, gate and export the joints; what cannot be drawn is a user's mistake with the dimension named."""
    import cad
    from synth.commands.solids import dimensions_of
    from synth.errors import Problem, UserError

    file = str(design.project.path)
    try:
        solids = dimensions_of(design)
        leg = cad.build_leg(solids.dimensions)
        checks = cad.check_leg(leg)
        written = cad.export_leg(leg, folder / "parts", checks=checks, pictures=False)
        notes = list(solids.notes)
        if pictures:
            written += _pictures(leg, folder / "parts", notes)
    except cad.DimensionError as error:
        hint = "change cad: or select: in the project, or leave the solids out with --no-cad"
        raise UserError([Problem(f"{problem}; {hint}", file, key="cad") for problem in error.problems]) from None
    except cad.GateError as error:
        raise UserError(Problem(f"the joints cannot be exported: {error}", file, key="cad")) from None
    shown = [item for item in written if item.kind == "png"]
    return {
        "pictures": [{"path": f"parts/{item.path}", "caption": _caption(design, item.path)} for item in shown],
        "solids": {
            "drawn": True,
            "checks": [{"name": c.name, "part": c.part, "passed": c.passed, "text": str(c)} for c in checks],
            "notes": notes,
        },
    }


def _pictures(leg: BuiltLeg, folder: Path, notes: list[str]) -> list[ExportedFile]:
    """Pictures of the parts; a machine that cannot draw gets a design without them, and is told."""
    import cad
    from cad.export import draw_leg

    try:
        return draw_leg(leg, folder)
    except cad.PreviewError as error:
        notes.append(str(error))
        return []


def _caption(design: LegDesign, path: str) -> str:
    """What a picture shows: the leg, a joint with its arm offset, or a part of a joint."""
    from math import degrees

    stem = path.removesuffix(".png")
    for index, name in enumerate(design.built.joint_names):
        if stem == name or stem.startswith(f"{name}_"):
            part = stem.removeprefix(name).lstrip("_").replace("_", " ")
            offset = f"arm offset {degrees(design.arm_offset(index)):+.1f} deg"
            return (
                f"{name}, {part}" if part and part != "inside" else f"{name} joint{', cut open' * bool(part)}: {offset}"
            )
    return "the whole leg in its rest pose" if stem == "leg" else stem


def _report(design: LegDesign, folder: Path, extra: dict[str, Any]) -> None:
    """Write design.json, the page made from it, and list every file with its hash but design.json itself."""
    from reports import write_leg_report
    from synth.design.write import design_json
    from synth.files.output import write_json

    files = sorted(path for path in folder.rglob("*") if path.is_file())
    content = design_json(design, files, folder, extra)
    content["warnings"] += [{"joint": None, "text": note} for note in extra["solids"]["notes"]]
    write_json(folder / "design.json", content)
    write_leg_report(folder)
