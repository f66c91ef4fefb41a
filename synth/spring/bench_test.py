"""The table of a bench test of a torsion spring, and the drawing that its result is compared with.

``TORQUES.csv``: ``angle [deg],torque [N*m]`` in the order of reading, wound up and let back, once or several times;
``time [s]`` may stand beside them. Any units of these.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.csv_table import in_si, read_table
from synth.parts.coil_rate import RATE_FORMULA, RateForm, active_coils, rate
from synth.parts.rows import TorsionSpringRow
from synth.parts.wire import WireMaterial
from synth.spring.torque_angle import MeasuredCycles, measured_cycles
from synth.units import quantity

FORMAT = "synth/spring/measured/1"
UNITS = {"angle": "rad", "torque": "N*m", "time": "s"}
HOW = (
    "a bench test has angle [deg] and torque [N*m]; multiply a force by the length of its lever, and take a lever's "
    "own weight off"
)
# Ratio of two units of a rate, and what was taken for what.
UNIT_SLIPS = {math.degrees(1.0): "per degree and per radian", 2.0 * math.pi: "per turn and per radian"}
NEAR_SLIP = 0.25  # share by which a ratio may be off a slip of units: springs scatter by a tenth


@dataclass(frozen=True)
class Drawing:
    """What a drawing or a catalogue states: rate (N m/rad) of the test, its source in words, free angle (rad)."""

    rate: float
    words: str
    free_angle: float = 0.0
    wire_diameter: float | None = None

    def wire_for(self, measured: float) -> float | None:
        """The wire's diameter (m) that would explain a measured rate (N m/rad): k ~ d^4; None: it is not known."""
        return None if self.wire_diameter is None else self.wire_diameter * (measured / self.rate) ** 0.25

    def slip(self, measured: float) -> str | None:
        """The two units that were mistaken for each other, if a measured rate (N m/rad) looks like it."""
        for ratio, words in UNIT_SLIPS.items():
            if any(abs(measured / self.rate / each - 1.0) < NEAR_SLIP for each in (ratio, 1.0 / ratio)):
                return words
        return None


def drawing_of_coil(
    sizes: tuple[float, float, float], leg: float, material: WireMaterial, form: RateForm, free_angle: float
) -> Drawing:
    """By ``k = E d^4 / (64 D N)`` of wire and mean diameter (m) and coils, pins ``leg`` m from the coil."""
    wire, mean, coils = sizes
    modulus = material.elastic_modulus(wire)
    if modulus is None:
        raise UserError(Problem(f"no elastic modulus of {material.name} wire is known", key="--material"))
    count = active_coils(coils, mean, (leg, leg))
    text = (
        f"E d^4/({RATE_FORMULA[form]} D N{' per turn' if form == 'friction' else ''}) with E {modulus * 1e-9:.4g} GPa "
        f"({material.name}), d {wire * 1e3:.4g} mm, D {mean * 1e3:.4g} mm, N {count:.4g}"
    )
    return Drawing(rate(modulus, wire, mean, count, form), text, free_angle, wire)


def drawing_of_row(row: TorsionSpringRow, leg: float, free_angle: float) -> Drawing:
    """By a catalogue's rate, which is that of the body; pins ``leg`` m from the coil make it softer."""
    if row.rate is None:
        raise UserError(Problem(f"{row.part} ({row.place}) has no rate", key="--part"))
    stated, text = row.rate, f"{row.part} of {row.vendor}"
    if leg > 0.0 and row.body_coils is not None and row.mean_diameter is not None:
        stated *= row.body_coils / active_coils(row.body_coils, row.mean_diameter, (leg, leg))
        text += f", with pins {leg * 1e3:.4g} mm from the coil"
    return Drawing(stated, text, free_angle, row.wire_diameter)


def read_bench_test(path: Path) -> MeasuredCycles:
    """Read the table and find the spring in it.

    Raises
    ------
    UserError : a column is missing or unknown, a cell is empty, or no spring is in it; with file and line.
    """
    table = read_table(path)
    found, problems = in_si(table, UNITS, f"is not read: {HOW}")
    problems += [
        Problem(f'column "{name} [{unit}]" is missing: {HOW}', table.name, 1)
        for name, unit in (("angle", "deg"), ("torque", "N*m"))
        if not any(column.name == name for column in table.columns)
    ]
    if problems:
        raise UserError(problems)
    angle, torque = found["angle"], found["torque"]
    empty = np.flatnonzero(np.isnan(angle) | np.isnan(torque))
    if len(empty):
        text = "has an empty cell; every sample needs its angle and torque"
        raise UserError(Problem(text, table.name, table.line(int(empty[0]))))
    try:
        return measured_cycles(angle, torque)
    except UserError as error:
        raise UserError([Problem(each.text, table.name) for each in error.problems]) from None


def bench_json(found: MeasuredCycles, drawing: Drawing | None, source: str) -> dict[str, Any]:
    """The content of the result's file; ``source`` : the table."""
    content: dict[str, Any] = {"format": FORMAT, "source": source, **found.as_json(), "drawing": None}
    if drawing is not None:
        wire = drawing.wire_for(found.rate.value)
        content["drawing"] = {
            "rate": quantity(drawing.rate, "N*m/rad"),
            "by": drawing.words,
            "measured_over_drawing": quantity(found.rate.value / drawing.rate, "1"),
            "free_angle": quantity(drawing.free_angle, "deg"),
            "preload": quantity(found.preload(drawing.free_angle), "N*m"),
            "wire_diameter": None if wire is None else quantity(wire, "mm"),
        }
    return content
