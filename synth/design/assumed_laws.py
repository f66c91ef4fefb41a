"""Dampers whose torque-speed law is assumed, off by a factor at low speed: the response with each combination."""

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
# Of the vendor's speed, to which the curve passes over to the whole factor: so it rises with speed on either side.
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


def off_at_low_speed(damper: Damper, factor: float) -> Damper:
    """The damper with ``factor`` times its torque at low speed, and its torque at its fastest point, the vendor's.

    Between, the factor's logarithm falls in proportion to that of the speed, over a decade.
    """
    assert damper.curve is not None
    speed, torque = np.array(damper.curve.speed), np.array(damper.curve.torque)
    share = np.minimum(np.log(speed / speed[-1]) / np.log(WHOLE_FACTOR_AT), 1.0)
    return replace(damper, curve=replace(damper.curve, torque=tuple((torque * factor**share).tolist())))


def columns_off(columns: Sequence[Array], dampers: Sequence[Damper | None]) -> list[Array]:
    """(ROWS, 2^n) by joint, of (ROWS, 1) : every combination of the ``dampers`` too weak and too strong.

    ``dampers``: by joint, those of assumed laws; None: the others.
    """
    assumed = [j for j, damper in enumerate(dampers) if damper is not None]
    signs = np.array(list(product((0, 1), repeat=len(assumed)))).T
    found = [np.repeat(each, signs.shape[1], axis=1) for each in columns]
    for j, sign in zip(assumed, signs, strict=True):
        damper = dampers[j]
        assert damper is not None
        ends = [column(1.0, 0.0, off_at_low_speed(damper, factor))[3:] for factor in (1.0 / FACTOR, FACTOR)]
        found[j][3:] = np.stack(ends, axis=1)[:, sign]
    return found
