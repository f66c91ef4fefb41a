"""Jumps by the compiled lanes: designs in, outcomes out, sixteen at a time."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from synth.hopper import generate
from synth.hopper.integrator import OUTCOMES
from synth.hopper.layout import LANES, LAYOUTS, JumpLayout
from synth.hopper.leg import Array, Contact, HopperLeg, Motor
from synth.hopper.models import Model, lane
from synth.model.generate import load

TOLERANCE = 1e-4  # clearance within 0.1 mm of a hundred times finer one, see tests/hopper
DURATION = 1.0  # s, for the push; a leg that has not lifted by then does not
FALL = 0.1  # m/s, falling that fast its highest point is past
FIRST_STEP = 1e-5  # s
MAX_STEPS = 60_000
LIFTS = 1  # status of a jump


@dataclass(frozen=True)
class Outcome:
    """What a jump came to; see ``synth.hopper.integrator`` for how it ends.

    clearance : the foot's greatest height, m; 0 where it does not lift.
    rise : greatest rise of the centre of mass over the crouch, m (the total height).
    peak_gear_torque : largest torque of one gear on its link during the push, N m; peak_current : of both motors, A.
    energy : electrical, both motors, to takeoff, J.
    limit : why there is no jump, empty where there is one.
    """

    clearance: float
    rise: float
    takeoff_time: float
    takeoff_speed: float
    peak_gear_torque: float
    peak_current: float
    energy: float
    peak_normal: float
    limit: str


LIMITS = {
    0.0: "no result",
    1.0: "",
    2.0: "too weak or too slow to lift",
    3.0: "too weak to hold the crouch: folds up",
    4.0: "too stiff for the step: contact, links or winding",
}


@dataclass(frozen=True)
class Jumper:
    """The compiled functions for one way of bending; obtain it from ``compiled_jump``."""

    layout: JumpLayout
    right_hand_side: Any
    jump: Any

    @property
    def where(self) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Rows that the integrator looks at."""
        names = ("derivative", "normal", "foot", "foot_speed", "com_speed", "com", "gear_torque", "drawn", "bend",
                 "alive", "height", "energy")  # fmt: skip
        return np.array([self.layout.n_state, *(self.layout.row(name) for name in names), 0], dtype=np.int64)

    def run(self, lanes: Array, tolerance: float = TOLERANCE, duration: float = DURATION, workers: int = 1) -> Array:
        """Outcomes (14, n_lane), rows as ``integrator.OUTCOMES``, of lanes (n_row, n_lane) from ``models.lane``."""
        groups = range(0, lanes.shape[1], LANES)
        outcome = np.empty((14, lanes.shape[1]))

        def one(first: int) -> None:
            group = lanes[:, first : first + LANES]
            workspace = np.empty((self.layout.n_row, LANES))
            workspace[:, : group.shape[1]] = group
            workspace[:, group.shape[1] :] = group[:, :1]
            found = np.empty((14, LANES))
            self.jump(self.right_hand_side, workspace, self.where, duration, tolerance, FIRST_STEP, MAX_STEPS, FALL,
                      found, np.empty((0, 1 + self.layout.n_row)))  # fmt: skip
            outcome[:, first : first + LANES] = found[:, : group.shape[1]]

        if workers > 1:
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(one, groups))
        else:
            for first in groups:
                one(first)
        return outcome

    def trace(
        self, parameters: Array, tolerance: float = TOLERANCE, duration: float = DURATION, fall: float = FALL
    ) -> Array:
        """Time and the whole workspace (n_step, 1 + n_row) of one lane at every step."""
        workspace = np.repeat(parameters[:, None], LANES, axis=1)
        found, room = np.empty((14, LANES)), np.empty((MAX_STEPS, 1 + self.layout.n_row))
        where = self.where
        self.jump(self.right_hand_side, workspace, where, duration, tolerance, FIRST_STEP, MAX_STEPS, fall, found, room)
        return room[: where[13]]


@lru_cache(maxsize=3)
def compiled_jump(bending: str) -> Jumper:
    """The compiled jump; the first call on a machine compiles for some seconds, then it is on disk."""
    layout = LAYOUTS[bending]
    made = load(f"hopper{layout.n}", generate.right_hand_side(layout), (generate.TRIGONOMETRY,))
    integrator = importlib.import_module("synth.hopper.integrator")
    return Jumper(layout, made.right_hand_side, integrator.jump)


def outcome_of(column: Array) -> Outcome:
    """One column of ``Jumper.run``."""
    lifts = column[0] == LIFTS
    return Outcome(
        clearance=float(column[1]) if lifts else 0.0,
        rise=float(column[5]),
        takeoff_time=float(column[2]),
        takeoff_speed=float(column[3]),
        peak_gear_torque=float(column[6]),
        peak_current=float(column[7]),
        energy=float(column[8]),
        peak_normal=float(column[9]),
        limit=LIMITS[float(column[0])],
    )


def column_of(outcome: Outcome) -> Array:
    """The other way round, for engines that give an ``Outcome``; what it does not hold is 0."""
    status = next(code for code, text in LIMITS.items() if text == outcome.limit)
    values = {
        "status": status,
        "clearance": outcome.clearance,
        "takeoff_time": outcome.takeoff_time,
        "takeoff_speed": outcome.takeoff_speed,
        "apex": outcome.rise,
        "peak_gear_torque": outcome.peak_gear_torque,
        "peak_current": outcome.peak_current,
        "energy": outcome.energy,
        "peak_normal": outcome.peak_normal,
    }
    return np.array([values.get(name, 0.0) for name in OUTCOMES])


def simulate(
    designs: Sequence[tuple[HopperLeg, Motor]], contact: Contact, model: Model, *, tolerance: float = TOLERANCE
) -> list[Outcome]:
    """Jumps of designs that bend alike, by a model that the lanes have."""
    jumper = compiled_jump(designs[0][0].bending)
    lanes = np.stack([lane(leg, motor, contact, model) for leg, motor in designs], axis=1)
    return [outcome_of(column) for column in jumper.run(lanes, tolerance).T]
