"""``synth spring``: design a torsion spring, or list the nearest ones that can be made.

With --rate and --travel it searches all stock wire; with --wire-diameter, --mean-diameter and --coils it checks
a given spring (--rate is then its measured rate). The first line is the answer, followed by a table; --json stores
the result, --out adds STEP, STL and a winding sheet. Sizes are those of the free spring unless a row states
otherwise.

  synth spring --rate "1.7 N*m/rad" --travel "40 deg" --included-angle "120 deg" --arbor "12 mm" --out spring

If no spring meets the request, the exit status is 1 and the nearest ones are listed. Wound samples calibrate mandrel
and rate:

  synth spring calibrate SAMPLES.csv --json calibration.json
  synth spring --rate ... --calibration calibration.json

A spring on a bench, from torque over angle wound up and let back:

  synth spring measure TORQUES.csv --wire-diameter "2 mm" --mean-diameter "20 mm" --coils 5.25
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from synth.commands.arguments import Quantities, one_of
from synth.commands.spring_measure import measure, measure_arguments
from synth.errors import Problem

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.files.spring_words import Hand
    from synth.parts.catalogs import Catalogue
    from synth.spring.spring_requirements import SpringRequirements
    from synth.spring.spring_task import SpringLimits

IMPOSSIBLE = 1  # exit status if no single spring meets the request, or the given one breaks a limit
GIVEN = ("--wire-diameter", "--mean-diameter", "--coils")


def _add_tables(parser: argparse.ArgumentParser) -> None:
    """Declare what reads a table of measurements."""
    parser.add_argument(
        "action",
        nargs="?",
        type=one_of(["calibrate", "measure"]),
        help="calibrate: spring-back and rate from wound samples; measure: a spring from torque over angle",
    )
    parser.add_argument(
        "samples", nargs="?", metavar="TABLE.csv", help="for calibrate: of wound coils; for measure: angle and torque"
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    from synth.files.spring_words import Hand, Objective, RateFormula, System
    from synth.parts.coil_angle import CONVENTIONS

    _add_tables(parser)

    def quantity(option: str, example: str, text: str) -> None:
        parser.add_argument(option, metavar=f'"{example}"', help=text)

    quantity("--rate", "38 N*m/rad", "spring rate")
    quantity("--travel", "45 deg", "largest angle from rest that winds the coil up")
    quantity("--opening-travel", "10 deg", "largest angle from rest the other way (default: 0)")
    quantity("--included-angle", "120 deg", "between the legs of the free spring (default: 90 deg)")
    quantity("--leg-length", "25 mm", "of each leg, to where the load acts; the leg ends beyond it (default: 25 mm)")
    quantity("--arbor", "12 mm", "shaft inside the coil, which the spring must not grip")
    quantity("--max-outer-diameter", "32 mm", "room around the coil")
    quantity("--max-body-length", "32 mm", "room along the coil, at full travel")
    quantity("--safety", "1.1", "yield over the stress at full travel (default: 1.1)")
    quantity("--cycles", "1e6", "number of full turns to last, up to 1e6 (default: 1e5 if possible)")
    quantity("--fatigue-safety", "1.2", "strength over stress at --cycles (default: 1)")
    quantity("--bend-radius", "3 mm", "inside radius where a radial or axial arm leaves (default: the wire's diameter)")
    parser.add_argument("--material", help="wire: music (default), stainless, A228 ...; see synth catalog list")
    parser.add_argument("--system", type=one_of(get_args(System)), help="stock sizes to search (default: both)")
    parser.add_argument(
        "--rate-formula",
        type=one_of(get_args(RateFormula)),
        default="64",
        help="64 (default): E d^4/(64 D N); 10.8: the handbook's rate per turn with friction between coils, 6 %% less",
    )
    parser.add_argument("--calibration", metavar="FILE", help="result of synth spring calibrate")
    parser.add_argument(
        "--objective",
        type=one_of(get_args(Objective)),
        default="mass",
        help="mass (default): small and nearly the lightest; space: smallest; life: strongest against fatigue",
    )
    parser.add_argument(
        "--legs",
        type=one_of(CONVENTIONS),
        default="tangent",
        help="how the legs leave the coil: tangent (default), radial, axial",
    )
    parser.add_argument(
        "--closes",
        type=one_of(["clockwise", "counter-clockwise"]),
        help="direction in which the load turns the far arm, seen from the near end; determines the hand",
    )
    parser.add_argument("--hand", type=one_of(get_args(Hand)), help="right (default) or left wound")
    check = parser.add_argument_group("to check a given spring")
    check.add_argument("--wire-diameter", metavar='"2 mm"')
    check.add_argument("--mean-diameter", metavar='"18 mm"')
    check.add_argument("--coils", metavar="N", help="of the body")
    measure_arguments(parser)
    parser.add_argument(
        "--catalog", metavar="FILE", action="append", default=[], help="your own wire table; repeatable"
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - prints it")
    parser.add_argument("--out", metavar="DIR", help="folder for spring.json, STEP, STL and winding sheet")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the request, design or check, write, print."""
    from synth.api.springs import given_spring, to_wind
    from synth.commands.spring_text import check_text, design_text
    from synth.files.output import output_folder
    from synth.files.shown_units import shown_for
    from synth.parts.catalogs import Catalogue
    from synth.spring.spring_files import reasons_not_drawn, write_result

    catalogue = Catalogue.load([Path(name) for name in arguments.catalog])
    if arguments.action == "measure":
        return measure(arguments, catalogue, progress)
    if arguments.action is not None:
        return _calibrate(arguments, catalogue, progress)
    wish, sizes = _read_request(arguments)
    shown = shown_for(arguments.units, texts=_quantities(arguments))
    if sizes is None:
        answer = to_wind(wish, catalogue, shown)
    else:
        angle = None if arguments.included_angle is None else wish.included_angle
        rate = None if arguments.rate is None else wish.rate
        answer = given_spring(wish, sizes, catalogue, included_angle=angle, stated_rate=rate, shown=shown)
    written = []
    if arguments.out:
        with output_folder(arguments.out) as folder, progress.stage("drawing and writing the spring"):
            answer.write(folder)
            names = sorted(path.name for path in folder.iterdir())
        written = [str(Path(arguments.out) / name) for name in names]
        if answer.best is not None:
            for reason in reasons_not_drawn(answer.best):
                progress.say(f"note: no STEP or STL, {reason}")
    status = 0 if answer.best is not None and answer.best.feasible else IMPOSSIBLE
    if arguments.json == "-":
        progress.document(json.dumps(answer.content, indent=2))
        return status
    if arguments.json:
        written.append(write_result(Path(arguments.json), answer.content))
    if answer.found is not None:
        progress.result(design_text(answer.found, shown))
    elif answer.best is not None:
        progress.result(check_text(answer.best, shown))
    if written:
        progress.say(f"written: {', '.join(written)}")
    return status


def _quantities(arguments: argparse.Namespace) -> list[str]:
    """The text of all options with units, from which inch or metric units are chosen."""
    words = ("rate", "arbor", "leg_length", "max_outer_diameter", "max_body_length", "bend_radius")
    given = [getattr(arguments, name) for name in (*words, "wire_diameter", "mean_diameter")]
    return [text for text in given if text is not None]


def _calibrate(arguments: argparse.Namespace, catalogue: Catalogue, progress: Progress) -> int:
    """Calibration from wound samples, printed and written."""
    from synth.commands.spring_text import calibration_text
    from synth.errors import UserError
    from synth.parts.coil_rate import RATE_FORMS
    from synth.spring.spring_files import write_result
    from synth.spring.wound_samples import calibration_json, calibration_of, read_samples

    if arguments.samples is None:
        raise UserError(Problem("the table of wound samples is missing: synth spring calibrate SAMPLES.csv"))
    material = catalogue.find_material(arguments.material or "music wire")
    samples = read_samples(Path(arguments.samples))
    found = calibration_of(samples, material, RATE_FORMS[arguments.rate_formula], arguments.samples)
    content = calibration_json(found, arguments.samples)
    if arguments.json == "-":
        progress.document(json.dumps(content, indent=2))
        return 0
    progress.result(calibration_text(found))
    if arguments.json:
        progress.say(f"written: {write_result(Path(arguments.json), content)}")
    return 0


def _read_request(arguments: argparse.Namespace) -> tuple[SpringRequirements, tuple[float, float, float] | None]:
    """The request, and wire diameter m, mean diameter m and coils of a spring to check. Raises all mistakes at once."""
    from dataclasses import replace

    from synth.errors import UserError
    from synth.parts.coil_rate import RATE_FORMS
    from synth.spring.calibration import UNCALIBRATED
    from synth.spring.spring_requirements import SpringRequirements
    from synth.spring.wound_samples import read_calibration

    read = _SpringQuantities(arguments)
    rate, travel = read.within("--rate", "N*m/rad"), read.within("--travel", "rad")
    opening, angle = read.within("--opening-travel", "rad"), read.within("--included-angle", "rad")
    leg = read.within("--leg-length", "m", "leg_lengths")
    limits = _limits(read)
    sizes = [read.read(GIVEN[0], "m"), read.read(GIVEN[1], "m"), read.number(GIVEN[2], "5.25")]
    checking = any(read.given(option) for option in GIVEN)
    needed = ["--travel", *(GIVEN if checking else ["--rate"])]
    for option in needed:
        if not read.given(option):
            why = "checking needs wire diameter, mean diameter and coils" if option in GIVEN else "is required"
            read.problems.append(Problem(f"{why}; see synth spring --help", key=option))
    hand = _hand(arguments, read)
    calibration = UNCALIBRATED
    if arguments.calibration:
        try:
            calibration = read_calibration(Path(arguments.calibration))
        except UserError as error:
            read.problems.extend(error.problems)
    read.require()
    wish = SpringRequirements(
        rate=rate if rate is not None else 0.0,
        travel=travel or 0.0,
        opening_travel=opening or 0.0,
        convention=arguments.legs,
        material=arguments.material or "music wire",
        system=arguments.system,
        objective=arguments.objective,
        limits=limits,
        hand=hand,
        rate_form=RATE_FORMS[arguments.rate_formula],
        calibration=calibration,
    )
    if angle is not None:
        wish = replace(wish, included_angle=angle)
    if leg is not None:
        wish = replace(wish, leg_lengths=(leg, leg))
    return wish, (sizes[0] or 0.0, sizes[1] or 0.0, sizes[2] or 0.0) if checking else None


def _hand(arguments: argparse.Namespace, read: Quantities) -> Hand:
    """The hand as given, or as required by the load's direction."""
    from synth.spring.winding import hand_for

    given: Hand | None = arguments.hand
    if arguments.closes is None:
        return given or "right"
    needed = hand_for(closes_clockwise=arguments.closes == "clockwise")
    if given not in (None, needed):
        text = (
            f"work that turns the far arm {arguments.closes} closes a {needed}-hand coil and opens a {given}-hand one"
        )
        read.problems.append(Problem(f"{text}; leave --hand out", key="--hand"))
    return needed


PLAIN_EXAMPLES = {"--cycles": "1e6"}  # of plain numbers that are no factors


class _SpringQuantities(Quantities):
    """Quantities in the ranges of a spring's requirements, which the library has too."""

    def within(self, option: str, unit: str, name: str = "") -> float | None:
        """The value in ``unit``, ``1`` for a plain number; ``name`` : of the requirement, if not that of the option."""
        from synth.spring.requirement_ranges import RANGES

        name = name or option[2:].replace("-", "_")
        value = (
            self.number(option, PLAIN_EXAMPLES.get(option, "1.2"))
            if unit == "1"
            else self.read(option, unit, positive=False)
        )
        if value is None or RANGES[name].has(value):
            return value
        text = getattr(self._arguments, option[2:].replace("-", "_"))
        self.problems.append(Problem(f'"{text}" {RANGES[name].words}', key=option))
        return None


def _limits(read: _SpringQuantities) -> SpringLimits:
    from dataclasses import replace

    from synth.spring.spring_task import SpringLimits

    limits = SpringLimits(
        arbor_diameter=read.within("--arbor", "m", "arbor_diameter"),
        max_outer_diameter=read.within("--max-outer-diameter", "m"),
        max_body_length=read.within("--max-body-length", "m"),
        bend_radius=read.within("--bend-radius", "m"),
    )
    safety, cycles = read.within("--safety", "1"), read.within("--cycles", "1")
    fatigue = read.within("--fatigue-safety", "1")
    if fatigue is not None and not read.given("--cycles"):
        read.problems.append(Problem("needs --cycles as well", key="--fatigue-safety"))
    return replace(
        limits,
        safety=limits.safety if safety is None else safety,
        cycles=cycles,
        fatigue_safety=1.0 if fatigue is None else fatigue,
    )
