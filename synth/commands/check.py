"""``synth check``: compare a leg's model with closed forms, statics, energy and another engine.

FILE is a leg (*.leg.yaml), a project of kind hopper-design, or a folder that synth leg wrote. Each check prints the
expected value, the model's value and the allowed difference. For a swinging leg: each joint as a pendulum and as an
oscillator with the others locked, the equilibrium pose, energy, and the same release in MuJoCo if installed. For a
jumping leg: free fall, the pogo stick, statics in the crouch, energy of a drop, the planar form, and MuJoCo's drop and
jump. For a designed leg: every predicted release, simulated in MuJoCo with the exported model, which includes the
parts' drawn inertias, dry friction and stops; the largest allowed difference is 0.3 deg at any instant. The model of an
impossible leg holds too: notes name masses, lengths and inertias of links that no limb has.

Exit status 1 if a check fails.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.model_checks.checked import ModelChecks


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", metavar="FILE", help="a leg, a hopper's project, or the folder of a designed leg")
    parser.add_argument("--out", metavar="DIR", help="folder for check.json and the page, whole or not at all")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read, check, print; write files if requested."""
    from synth.files.output import output_folder, write_json
    from synth.files.text_forms import json_text, plain

    with ExitStack() as stack:
        folder = None if arguments.out is None else stack.enter_context(output_folder(arguments.out))
        found = _check_file(arguments.file, progress)
        document = found.as_json()
        if folder is not None:
            from synth.reports.model_checks import write_checks_report

            write_json(folder / "check.json", document)
            write_checks_report(folder)
    if progress.as_json:
        progress.document(json_text(plain(document, ""), 0) + "\n")
    else:
        progress.result(check_text(document))
    for sentence in found.left_out:
        progress.say(f"not checked: {sentence}")
    for sentence in found.doubts:
        progress.say(f"note: {sentence}")
    if arguments.out is not None:
        progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 1 if found.failed else 0


def check_text(document: Mapping[str, Any]) -> str:
    """One row per check, then the number of checks that hold."""
    from synth.commands.table_text import table_text

    rows = [["check", "of", "expected", "found", "allowed difference", ""]]
    for check in document["checks"]:
        numbers = [_quantity_text(check.get(key)) for key in ("expected", "found", "limit")]
        rows.append([check["name"], check["where"], *numbers, "holds" if check["passed"] else "FAILS"])
    failed = sum(not check["passed"] for check in document["checks"])
    count = len(document["checks"])
    return f"{table_text(rows)}\n{f'{failed} of {count} checks fail' if failed else f'all {count} checks hold'}"


def _quantity_text(item: Mapping[str, Any] | None) -> str:
    if item is None:
        return "not found"
    unit = "" if item["unit"] == "1" else f" {item['unit']}"
    return f"{item['value']:.7g}{unit}"


def _check_file(file: str, progress: Progress) -> ModelChecks:
    from synth.errors import UserError
    from synth.files.validate import COMMANDS, may_be_of
    from synth.files.yaml_lines import load

    if Path(file).is_dir():
        from synth.model_checks.designed_leg import designed_leg_checks

        with progress.stage("the predicted responses by another engine"):
            return designed_leg_checks(Path(file))
    document = load(file)
    if may_be_of(document, "hopper-design"):
        return _hopper(file, progress)
    kind = document.value.get("kind")
    command = COMMANDS.get(kind) if isinstance(kind, str) else None
    if command is not None:
        text = f'a file of kind {kind} is read by {command}; "synth check" reads "kind: leg", "kind: hopper-design"'
        raise UserError(document.problem(f"{text} and the folder of a designed leg", ("kind",)))
    return _leg(file, progress)


def _leg(file: str, progress: Progress) -> ModelChecks:
    from synth.files.leg_file import read_leg
    from synth.files.paths import name_from
    from synth.files.run_manifest import sha256_file
    from synth.fit.leg_plausibility import leg_doubts
    from synth.model_checks.checked import ModelChecks
    from synth.model_checks.other_engine import same_release
    from synth.model_checks.swinging import swinging_checks
    from synth.parts.resolver import resolver
    from synth.swing.foreign_effects import own_hashes

    named = [Path(file)]
    leg = read_leg(file, resolve_part=resolver(), opened=named.append)
    curves = any(joint.damper and joint.damper.curve for joint in leg.joints)
    progress.compiling(len(leg.joints), effects=curves)
    with progress.stage("pendulums, oscillators, equilibrium, energy"):
        checks, left_out = swinging_checks(leg)
    with progress.stage("the same release by another engine"):
        more, missing = same_release(leg)
    inputs = tuple((name_from(Path(file).parent, each), sha256_file(each)) for each in named)
    inputs += tuple(own_hashes(leg).items())
    return ModelChecks(leg.name, "leg", (*checks, *more), (*left_out, *missing), inputs, leg_doubts(leg))


def _hopper(file: str, progress: Progress) -> ModelChecks:
    from synth.files.hopper_project import read_hopper_project
    from synth.hopper.study import sweep_problem
    from synth.jump.jump_runs import compiled_jump
    from synth.model_checks.checked import ModelChecks
    from synth.model_checks.jumping import jumping_checks, length_checked
    from synth.parts.catalogs import Catalogue

    project = read_hopper_project(file)
    problem, _ = sweep_problem(project, Catalogue.load(project.catalogs))
    leg = length_checked(project.leg, project.lengths)
    with progress.stage("loading the compiled jump (compiled once on this machine, some 15 s)"):
        compiled_jump(leg.bending)
    with progress.stage(f"drops and jumps of the leg with upper links of {1e3 * leg.length:g} mm"):
        checks, left_out = jumping_checks(leg, list(problem.motors), project.contact)
    inputs = tuple((item.name, item.sha256) for item in project.inputs)
    return ModelChecks(project.name, "hopper", tuple(checks), tuple(left_out), inputs)
