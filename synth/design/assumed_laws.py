"""Dampers whose torque-speed law is assumed, off by a factor at low speed: the response with each combination.

Below the lowest point of a measured table the law is assumed, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.design.part_lanes import column
from synth.swing.leg_model import Damper
from synth.units import quantity

FACTOR = 2.0  # to either side at low speed; see ``curve_warnings``
# Of the vendor's or a table's lowest speed, down to which the curve passes over to the whole factor: so it rises with
# speed on either side.
WHOLE_FACTOR_AT = 0.1


@dataclass(frozen=True)
class LawsOff:
    """The nominal response error (rad), smallest and largest, with the laws of ``joints`` off by ``FACTOR``."""

    joints: tuple[str, ...]
    least: float
    most: float

    def as_json(self) -> dict[str, Any]:
        """The entry ``assumed_laws`` of a forecast."""
        return {
            "joints": list(self.joints),
            "factor": quantity(FACTOR, "1"),
            "least": quantity(self.least, "deg"),
            "most": quantity(self.most, "deg"),
        }


def off_at_low_speed(damper: Damper, factor: float, known_from: float | None = None) -> Damper:
    """The damper with ``factor`` times its torque at low speed, and its torque from ``known_from`` (rad/s) upwards.

    ``known_from``: default its fastest point, the vendor's. Below, the factor's logarithm grows in proportion to that
    of the speed, over a decade.
    """
    assert damper.curve is not None
    speed, torque = np.array(damper.curve.speed), np.array(damper.curve.torque)
    known = speed[-1] if known_from is None else known_from
    share = np.clip(np.log(speed / known) / np.log(WHOLE_FACTOR_AT), 0.0, 1.0)
    return replace(damper, curve=replace(damper.curve, torque=tuple((torque * factor**share).tolist())))


def columns_off(columns: Sequence[Array], dampers: Sequence[tuple[Damper, float | None] | None]) -> list[Array]:
    """(ROWS, 2^n) by joint, of (ROWS, 1) : every combination of the ``dampers`` too weak and too strong.

    ``dampers``: by joint, those of assumed laws, each with its ``known_from``; None: the others.
    """
    assumed = [j for j, damper in enumerate(dampers) if damper is not None]
    signs = np.array(list(product((0, 1), repeat=len(assumed)))).T
    found = [np.repeat(each, signs.shape[1], axis=1) for each in columns]
    for j, sign in zip(assumed, signs, strict=True):
        assumed_one = dampers[j]
        assert assumed_one is not None
        damper, known = assumed_one
        ends = [column(1.0, 0.0, off_at_low_speed(damper, factor, known))[3:] for factor in (1.0 / FACTOR, FACTOR)]
        found[j][3:] = np.stack(ends, axis=1)[:, sign]
    return found
