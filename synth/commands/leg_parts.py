"""Part options of ``synth leg``; the chosen parts and their substitutes as text."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

from synth.commands.answers import is_near_enough
from synth.commands.arguments import near_miss, one_of
from synth.commands.table_text import table_text
from synth.errors import Problem, UserError
from synth.files.shown_units import METRIC, ShownUnits

if TYPE_CHECKING:
    from synth.files.leg_project import LegProject
    from synth.parts.catalogs import Catalogue

SUBSTITUTES_SHOWN = 2  # substitutes of each part on the screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare options that restrict the parts, in addition to the project's."""
    from synth.files.spring_words import System

    group = parser.add_argument_group("available parts", "in addition to select: in the project")
    group.add_argument(
        "--vendor", action="append", default=[], metavar="NAME", help="springs and dampers of this vendor; repeatable"
    )
    group.add_argument("--without", action="append", default=[], metavar="PART", help="exclude this part; repeatable")
    group.add_argument("--system", type=one_of(get_args(System)), help="springs of inch or of metric wire only")


def with_options(project: LegProject, arguments: argparse.Namespace, catalogue: Catalogue) -> LegProject:
    """The project with the command line's options; refuses those that no catalogue row has.

    Raises
    ------
    UserError
        With every unknown vendor and part, and similar names.
    """
    from synth.parts.part_names import NameList, unknown_names

    lists: dict[str, NameList] = {"vendor": "vendors", "without": "without"}
    given = project.parts
    parts = replace(
        given,
        vendors=tuple(arguments.vendor) or given.vendors,
        without=(*given.without, *arguments.without),
        system=arguments.system or given.system,
    )
    file = str(project.path)
    problems = [
        Problem(text, key=f"--{option}")
        for option, key in lists.items()
        for _, text in unknown_names(getattr(arguments, option), key, catalogue)
    ]
    refused = {name.casefold() for name in parts.without}
    for joint, choice in project.joints.items():
        for kind, part in (("spring", choice.spring.part), ("damper", choice.damper.part)):
            if part is not None and part.casefold() in refused:
                text = f"{part} is requested here and excluded by 'without'"
                problems.append(Problem(text, file, key=f"select.joints.{joint}.{kind}.part"))
    if problems:
        raise UserError(problems)
    return replace(project, parts=parts)


def require_known_joints(project: LegProject) -> None:
    """Raise UserError where ``cad.damper_shafts`` names an unknown joint."""
    names = project.target.joint_names
    problems = [
        Problem(
            f'"{name}" is not a joint of the target{near_miss(name, names)}; its joints are {", ".join(names)}',
            str(project.path),
            key="cad.damper_shafts",
        )
        for name in project.cad.damper_shafts
        if name not in names
    ]
    if problems:
        raise UserError(problems)


def parts_text(design: Mapping[str, Any], shown: ShownUnits = METRIC) -> str:
    """Chosen parts, the forecast response with their tolerances, and substitutes with their cost."""
    response, joints = design["response"], design["joints"]
    forecast, measured = response["forecast"], response["forecast_free_angles_measured"]
    rows = [["joint", "", "part", "vendor", "nominal", "expected", "cost"]]
    for name, joint in joints.items():
        spring, damper = joint["spring"], joint["damper"]
        rows.append([name, "spring", _spring_words(spring, shown), spring.get("vendor") or "to wind", "", "", ""])
        wanted = spring["wanted_rate"]["value"]
        rows += _substitute_lines([item for item in joint["spring_alternatives"] if is_near_enough(item, wanted)])
        rows.append(["", "damper", damper["arrangement"], damper["vendor"] or "", "", "", ""])
        rows += _substitute_lines(joint["damper_alternatives"])
    low, high = forecast["expected"]["interval90"]
    known = response["free_angles_measured"]
    tolerances = f"as measured ({', '.join(known)}), and with part tolerances" if known else "with part tolerances"
    lines = [
        table_text(rows),
        f"Response: {response['wanted_to_built']['rms']['value']:.2f} deg RMS from the wanted with nominal parts;",
        f"{tolerances} {forecast['expected']['value']:.2f} deg (90 %: {low:.2f} to {high:.2f}), chance "
        f"{forecast['chance']['value']:.0%} of staying within {forecast['within']['value']:.3g} deg"
        f"{'.' if len(known) == len(joints) else ';'}",
    ]
    if len(known) < len(joints):
        lines.append(
            f"with measured free angles of {'the springs' if not known else 'all springs'} "
            f"{measured['expected']['value']:.2f} deg, chance {measured['chance']['value']:.0%}."
        )
    lines += _another_motion(response)
    laws = forecast.get("assumed_laws")
    if laws:
        lines.append(
            f"This holds if the dampers of {', '.join(laws['joints'])} follow their assumed laws; off by a factor of "
            f"{laws['factor']['value']:g} at low speed, nominal parts give {laws['least']['value']:.2f} to "
            f"{laws['most']['value']:.2f} deg."
        )
    return "\n".join(lines)


def _another_motion(response: Mapping[str, Any]) -> list[str]:
    """Where the motion that is wanted of the robot is not the animal's."""
    found = response["animal_to_wanted"]
    off = [f"{found['joints'][name]['value']:.3g} deg RMS at {name}" for name in found["another_motion"]]
    if not off:
        return []
    return [f"The wanted motion is not the animal's, which the robot's links do not make: {', '.join(off)}."]


def _spring_words(spring: Mapping[str, Any], shown: ShownUnits) -> str:
    made = spring.get("make")
    if made:
        number = f"{made['count']} x " if made["count"] > 1 else ""
        diameter = shown.of(made["wire_diameter"], "m")
        wire = f"{diameter['value']:.4g} {diameter['unit']} {made['material']}"
        return f"{number}{wire}, {made['body_coils']['value']:.4g} coils"
    number = f"{spring['count']} x " if spring.get("count", 1) > 1 else ""
    return f"{number}{spring['part']}"


def _substitute_lines(alternatives: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """The substitutes with the least expected error of the whole leg, one per line, the least first."""
    return [
        [
            "",
            "or",
            item["part"],
            item["vendor"] or "to wind",
            f"{item['response_error']['value']:.2f} deg",
            f"{item['expected_error']['value']:.2f} deg",
            f"{round(item['cost']['value'], 2) + 0.0:+.2f} deg",
        ]
        for item in sorted(alternatives, key=lambda item: float(item["cost"]["value"]))[:SUBSTITUTES_SHOWN]
    ]
