"""``synth init``: create a project from an example or from a robot's leg.

With --from the leg is taken from a robot's MJCF or URDF: the joints of --chain, proximal to distal, turn in one
plane; all others are locked, and the bodies on them are lumped. Features that a leg file lacks are listed.

  synth init gap go1 --from go1.xml --chain FR_thigh_joint,FR_calf_joint --plane xz
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import one_of
from synth.errors import Problem, UserError
from synth.files.leftovers import put_back
from synth.files.signals import signals_held_back, terminated_as_exception

if TYPE_CHECKING:
    from synth.commands.progress import Progress

SCHEMAS = "schemas"  # folder of a project for its editor
EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
PROJECTS = {
    "leg": "leg-design.yaml",
    "fit": "fit.yaml",
    "hopper": "hopper.yaml",
    "gap": "gap.yaml",
    "import": "import.yaml",
}  # example -> its project file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    kinds = "|".join(PROJECTS)
    parser.add_argument("kind", type=one_of(PROJECTS), metavar=kinds, help="the command it is for")
    parser.add_argument("folder", metavar="DIR", help="folder to write; must be absent or empty")
    parser.add_argument("--from", dest="robot", metavar="ROBOT", help="MJCF or URDF that contains the leg")
    parser.add_argument("--chain", metavar="A,B,...", help="the robot's moving joints, proximal to distal")
    parser.add_argument("--plane", metavar="XZ", help="world axes to the right and up (default: from the joint axes)")
    parser.add_argument("--tip", metavar='"220 mm"', help="length of the last link (default: up to its farthest shape)")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Copy the example and print the next command."""
    target = Path(arguments.folder)
    if arguments.robot is not None:
        return _from_robot(arguments, target, progress)
    alone = [option for option in ("--chain", "--plane", "--tip") if getattr(arguments, option[2:]) is not None]
    if alone:
        raise UserError([Problem("selects parts of a robot: name its file with --from", key=key) for key in alone])
    copy_example(EXAMPLES / arguments.kind, target, prepare=with_schemas)
    project = target / PROJECTS[arguments.kind]
    progress.say(f"{target} holds the example; {target / 'README.md'} describes it. Next:")
    _tell(progress, target, project, arguments.kind)
    return 0


def _tell(progress: Progress, target: Path, project: Path, kind: str, notes: Sequence[str] = ()) -> None:
    """Print the next command; with ``--json`` also all paths."""
    from synth.commands.answers import tell_document

    words = ["synth", kind, str(project), "--out", str(target / "result")]
    progress.say(f"  {shlex.join(words)}")
    content = {"format": "synth/init/1", "folder": str(target), "project": str(project), "command": words}
    tell_document(progress, {**content, "notes": list(notes)}, "")


def _from_robot(arguments: argparse.Namespace, target: Path, progress: Progress) -> int:
    """Write the project of a robot's leg; print what is missing and what was left out."""
    from tempfile import TemporaryDirectory

    from synth.commands.arguments import Quantities
    from synth.files.robots.robot_project import PROJECT_NAMES, robot_leg, write_robot_project
    from synth.fit.leg_plausibility import leg_doubts

    quantities = Quantities(arguments)
    tip = quantities.read("--tip", "m")
    names = [name.strip() for name in (arguments.chain or "").split(",") if name.strip()]
    if arguments.kind not in PROJECT_NAMES:
        text = f"--from works with {', '.join(PROJECT_NAMES)}, not with {arguments.kind}"
        quantities.problems.append(Problem(text, key="--from"))
    if not names:
        text = "name the moving joints, proximal to distal: --chain FL_thigh_joint,FL_calf_joint"
        quantities.problems.append(Problem(text, key="--chain"))
    quantities.require()
    picked = robot_leg(arguments.robot, names, arguments.plane, tip)
    doubts = leg_doubts(picked.leg)
    with TemporaryDirectory(prefix="synth-init-") as made:
        write_robot_project(arguments.kind, picked, Path(arguments.robot).name, Path(made), doubts)
        copy_example(Path(made), target, prepare=with_schemas)
    notes = [*picked.messages, *doubts]
    for text in notes:
        progress.say(f"note: {text}")
    progress.say(f"{target} holds the leg; {target / 'README.md'} describes the recordings to add. Then:")
    project = target / f"{PROJECT_NAMES[arguments.kind]}.yaml"
    _tell(progress, target, project, arguments.kind, notes)
    return 0


def with_schemas(folder: Path) -> None:
    """Copy the files' schemas into a project, and name them in the first lines for editors."""
    import json

    from synth.files.gap_kind import is_hopper_gap
    from synth.files.reference.json_schema import json_schema
    from synth.files.reference.sections import KINDS
    from synth.files.yaml_lines import load

    for path in sorted(folder.rglob("*.yaml")):
        kind = str(load(path).value.get("kind"))
        kind = "gap-of-jumps" if kind == "gap" and is_hopper_gap(path) else kind
        if kind in KINDS:
            schema = folder / SCHEMAS / f"{kind}.schema.json"
            schema.parent.mkdir(exist_ok=True)
            schema.write_text(json.dumps(json_schema(kind), indent=1) + "\n", encoding="utf-8")
            place = os.path.relpath(schema, path.parent)
            text = path.read_text(encoding="utf-8")
            path.write_text(f"# yaml-language-server: $schema={Path(place).as_posix()}\n{text}", encoding="utf-8")


def copy_example(source: Path, target: Path, prepare: Callable[[Path], None] | None = None) -> None:
    """Copy a folder, complete or not at all; ``prepare`` changes the copy before it is moved into place.

    Raises
    ------
    UserError
        If the target is a file, is not empty, is being written by another run, or cannot be written.
    """
    from synth.files.output import own_place, umask

    name = str(target)
    try:
        whole = Path(os.path.realpath(target))
        put_back(whole)
        if whole.is_dir() and any(whole.iterdir()):
            raise UserError(Problem("is not empty; name a new folder", name))
        if whole.exists() and not whole.is_dir():
            raise UserError(Problem("is a file; name a new folder", name))
        above = next(parent for parent in whole.parents if parent.exists())
        if not above.is_dir():
            raise UserError(Problem(f"cannot be written: {above} is a file", name))
        whole.parent.mkdir(parents=True, exist_ok=True)
        temporary, lock = own_place(whole, name)
        try:
            with terminated_as_exception():
                made = temporary / "project"
                # Contents only: an installed package may be read-only and a temporary folder is its maker's alone, but
                # a project is as other folders of the user.
                ignore = shutil.ignore_patterns("__pycache__", ".*")
                shutil.copytree(source, made, ignore=ignore, copy_function=shutil.copyfile)
                for folder in (made, *(path for path in made.rglob("*") if path.is_dir())):
                    folder.chmod(0o777 & ~umask())
                if prepare is not None:
                    prepare(made)
                _bring(made, whole)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
            if lock is not None:
                os.close(lock)
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(Problem(f"cannot be written: {reason}", name)) from None


def _bring(made: Path, whole: Path) -> None:
    """Move the finished folder into place; an empty folder there, perhaps the current one, stays and is filled."""
    if not whole.exists():
        made.rename(whole)
        return
    moved: list[Path] = []
    with signals_held_back():
        try:
            for entry in sorted(made.iterdir()):
                moved.append(entry.rename(whole / entry.name))
        except BaseException:
            for entry in moved:
                entry.rename(made / entry.name)
            raise
