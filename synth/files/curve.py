"""A damper's torque-speed table: ``speed [rpm],torque [N*m]``, any units of these."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.csv_table import in_si, read_table
from synth.files.output import write_text
from synth.swing.leg_model import DamperCurve

UNITS = {"speed": "rad/s", "torque": "N*m"}
POINT_LIMIT = 10_000  # of a torque-speed table; more is probably a recording


def read_curve(path: Path) -> DamperCurve:
    """Read a torque-speed curve.

    Raises
    ------
    UserError
        If a column is missing or unknown, a cell is empty, speeds do not increase, or a torque is negative. A first
        point at standstill must have zero torque: the curve is odd, so a torque there would be dry friction.
    """
    table = read_table(path)
    scaled, problems = in_si(table, UNITS, "is not read")
    problems += [
        Problem(f'column "{name} [{unit}]" is missing', table.name, 1)
        for name, unit in UNITS.items()
        if name not in [column.name for column in table.columns]
    ]
    if problems:
        raise UserError(problems)

    def problem(text: str, row: int | None) -> Problem:
        return Problem(text, table.name, None if row is None else table.line(row))

    return checked_curve(scaled["speed"], scaled["torque"], problem)


def checked_curve(speed: Array, torque: Array, problem: Callable[[str, int | None], Problem]) -> DamperCurve:
    """The curve through points (n,) rad/s and N m; ``problem`` makes the mistake of a row, None: of the whole.

    Raises
    ------
    UserError
        As ``read_curve``.
    """

    def refuse(bad: NDArray[np.bool_], text: str) -> None:
        if bad.any():
            raise UserError(problem(text, int(bad.argmax())))

    refuse(np.isnan(speed) | np.isnan(torque), "has an empty cell; every point needs its speed and torque")
    refuse(np.diff(speed, prepend=-np.inf) <= 0, "speeds must increase from point to point")
    refuse(speed < 0, "speeds must not be negative: the curve is assumed equal in both directions")
    refuse(torque < 0, "torques must not be negative: they are the size of the resistance")
    refuse((speed == 0) & (torque != 0), "a torque at standstill is friction: leave this point out, give the joint "
           "effects: [coulomb_friction: {torque: ...}]")  # fmt: skip
    moving = speed > 0
    if not moving.any():
        raise UserError(problem("has no point with a speed above zero", None))
    if len(speed) > POINT_LIMIT:
        raise UserError(problem(f"has {len(speed)} points; at most {POINT_LIMIT}", None))
    return DamperCurve(tuple(map(float, speed[moving])), tuple(map(float, torque[moving])))


def write_curve(curve: DamperCurve, path: Path) -> None:
    """Write the curve in SI at full precision; ``read_curve`` restores the same numbers."""
    rows = [f"{speed!r},{torque!r}\n" for speed, torque in zip(curve.speed, curve.torque, strict=True)]
    write_text(path, "speed [rad/s],torque [N*m]\n" + "".join(rows))
