"""``synth spring measure``: rate, free angle, hysteresis and preload of a spring on a bench, beside its drawing."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import Quantities
from synth.errors import Problem, UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.parts.catalogs import Catalogue
    from synth.spring.bench_test import Drawing
    from synth.spring.torque_angle import BenchValue, MeasuredCycles

SIZES = ("--wire-diameter", "--mean-diameter", "--coils")
NOT_HERE = ("--travel", "--out", "--calibration", "--arbor")


def measure_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what ``measure`` alone takes."""
    measure = parser.add_argument_group("to measure a spring")
    measure.add_argument("--part", metavar="NUMBER", help="of a catalogue, to compare with")
    measure.add_argument("--free-angle", metavar='"0 deg"', help="of the drawing, as the table counts (default: 0 deg)")


def measure(arguments: argparse.Namespace, catalogue: Catalogue, progress: Progress) -> int:
    """The measured spring, printed and written."""
    from synth.spring.bench_test import bench_json, read_bench_test
    from synth.spring.spring_files import write_result

    if arguments.samples is None:
        text = "the table is missing: synth spring measure TORQUES.csv, with angle [deg] and torque [N*m]"
        raise UserError(Problem(text))
    drawing, leg = _drawing(arguments, catalogue)
    found = read_bench_test(Path(arguments.samples))
    content = bench_json(found, drawing, arguments.samples)
    if arguments.json == "-":
        progress.document(json.dumps(content, indent=2))
        return 0
    progress.result(measured_text(found, drawing, leg))
    if arguments.json:
        progress.say(f"written: {write_result(Path(arguments.json), content)}")
    return 0


def _drawing(arguments: argparse.Namespace, catalogue: Catalogue) -> tuple[Drawing | None, float | None]:
    """The drawing of --part, of the coil's sizes, or of --rate; None without any. The pins' distance, m, if stated."""
    from synth.parts.coil_rate import RATE_FORMS
    from synth.spring.bench_test import Drawing, drawing_of_coil, drawing_of_row

    read = Quantities(arguments)
    sizes = [read.read(SIZES[0], "m"), read.read(SIZES[1], "m"), read.number(SIZES[2], "5.25")]
    free, stated = read.read("--free-angle", "rad", positive=False), read.read("--rate", "N*m/rad")
    leg = read.read("--leg-length", "m", positive=False)
    given = [option for option in SIZES if read.given(option)]
    read.problems += [
        Problem("is not used by measure; leave it out", key=option) for option in NOT_HERE if read.given(option)
    ]
    if given and len(given) < len(SIZES):
        missing = " and ".join(option for option in SIZES if option not in given)
        read.problems.append(Problem(f"a drawing's rate needs {missing} as well", key=given[0]))
    both = [option for option, there in (("--part", arguments.part), ("--rate", stated), (SIZES[0], given)) if there]
    if len(both) > 1:
        read.problems.append(Problem(f"states another drawing than {both[0]}; keep one of them", key=both[1]))
    if leg is not None and leg < 0.0:
        read.problems.append(Problem(f'"{arguments.leg_length}" must be 0 or more', key="--leg-length"))
    read.require()
    pins, free = leg or 0.0, free or 0.0
    if arguments.part:
        return drawing_of_row(catalogue.find_spring(arguments.part), pins, free), leg
    if given:
        material = catalogue.find_material(arguments.material or "music wire")
        coil = (sizes[0] or 0.0, sizes[1] or 0.0, sizes[2] or 0.0)
        return drawing_of_coil(coil, pins, material, RATE_FORMS[arguments.rate_formula], free), leg
    return (None if stated is None else Drawing(stated, "--rate", free)), leg


def measured_text(found: MeasuredCycles, drawing: Drawing | None, leg: float | None) -> str:
    """The answer in words; ``leg`` m: where the pins press on the arms, from the coil; None: not stated."""
    number = "1 cycle" if found.cycles == 1 else f"{found.cycles} cycles"
    kept = f"{found.used} of {found.samples} samples, {number}"
    lines = [
        f"rate        {_text(found.rate, 'N*m/rad')}, from {kept}",
        f"free angle  {_text(found.free_angle, 'deg', math.degrees(1.0))}",
    ]
    if found.friction is not None and found.winding is not None and found.unwinding is not None:
        slip = "" if found.slip is None else f"; half of it turns within {math.degrees(found.slip):.3g} deg"
        lines += [
            f"hysteresis  {_text(found.friction, 'N*m')} either way in the middle, {found.loss or 0.0:.1%} of the work"
            f"{slip}",
            f"            {found.winding:.4g} N*m/rad winding, {found.unwinding:.4g} unwinding",
        ]
    if drawing is not None:
        share = found.rate.value / drawing.rate - 1.0
        lines += [
            f"drawing     {drawing.rate:.4g} N*m/rad by {drawing.words}: measured is {share:+.1%}",
            f"preload     {found.preload(drawing.free_angle):.3g} N*m at the drawing's free angle of "
            f"{math.degrees(drawing.free_angle):.4g} deg",
        ]
    return "\n".join([*lines, *_notes(found, drawing), *_use(found, leg)])


def _text(found: BenchValue, unit: str, scale: float = 1.0) -> str:
    low, high = (scale * (found.value + way * found.within) for way in (-1.0, 1.0))
    return f"{scale * found.value:.4g} {unit} (90 %: {low:.4g} to {high:.4g})"


def _notes(found: MeasuredCycles, drawing: Drawing | None) -> list[str]:
    from synth.parts.row_check import DISAGREEMENT

    notes = []
    if found.friction is None:
        notes.append("note: it was only wound up, so its hysteresis is unknown, and half of it is in the rate's line")
    if found.reversed_branches:
        notes.append("note: it takes less torque to wind it than it gives back, which no spring does: the torque lags")
        notes[-1] += " behind the angle; turn it more slowly, or read it at rest"
    if found.bend is not None:
        notes.append(
            f"note: its rate changes by {found.bend:+.0%} from the least to the greatest angle; a line is a mean"
        )
    if not found.repeated:
        notes.append("note: the intervals are of the scatter about the line; three cycles or more show what repeats")
    if drawing is not None and abs(found.rate.value / drawing.rate - 1.0) > DISAGREEMENT:
        slip, wire = drawing.slip(found.rate.value), drawing.wire_for(found.rate.value)
        if slip is not None:
            notes.append(f"note: the rates differ as {slip} do: check the columns' units")
        elif wire is not None:
            notes.append(
                f"note: the rate is far from the drawing's; a wire of {wire * 1e3:.3g} mm would explain it: measure "
                "the wire, and count the coils"
            )
        else:
            notes.append("note: the rate is far from the drawing's: measure the wire, and count the coils")
    return notes


def _use(found: MeasuredCycles, leg: float | None) -> list[str]:
    rate, free = f"{found.rate.value:.5g} N*m/rad", f"{math.degrees(found.free_angle.value):.5g} deg"
    distance = "" if leg is None else f", rate_distance: {leg * 1e3:g} mm"
    lines = [
        f"In a design:   measured: {{spring: {{JOINT: {{rate: {rate}{distance}}}}}}}",
        f"In a leg file: spring: {{rate: {rate}, free_angle: {free}}}, if it was held as in its joint and the angle is "
        "the joint's",
    ]
    if found.slip is not None and found.friction is not None and found.friction.value > 0.0:
        stiff = found.friction.value / found.slip
        slip = f"{math.degrees(found.slip):.3g} deg"
        lines.append(f"               effects: [spring_hysteresis: {{stiffness: {stiff:.4g} N*m/rad, slip: {slip}}}]")
    return lines
