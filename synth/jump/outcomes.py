"""The outcome of a jump by any model: how it ended, and its numbers as rows of an array or by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array

# How a jump ended.
RUNNING, LANDED_AGAIN, TOO_WEAK, COLLAPSED, TOO_STIFF, CROSSED = 0, 1, 2, 3, 4, 5
OUT_OF_REACH = -1.0  # not simulated: the links do not reach the crouch

# Rows of a lane's outcome.
OUTCOMES = (
    "status", "clearance", "takeoff_time", "takeoff_speed", "takeoff_height", "apex", "peak_gear_torque",
    "peak_current", "energy", "peak_normal", "least_spread", "end_time", "start_com", "gear_torque_at_start",
)  # fmt: skip
N_OUTCOME = len(OUTCOMES)
# Their row numbers. The least spread is the least sine of the lower link's angle; below 0 the knees have crossed.
STATUS, CLEARANCE, TAKEOFF_TIME, TAKEOFF_SPEED, TAKEOFF_HEIGHT, APEX, PEAK_GEAR_TORQUE = range(7)
PEAK_CURRENT, ENERGY, PEAK_NORMAL, LEAST_SPREAD, END_TIME, START_COM, GEAR_TORQUE_AT_START = range(7, N_OUTCOME)

SETTLED = 0.05  # s, after which a leg at rest will not lift off
CREEP = 0.02  # m/s, of the centre of mass: a folding self-locking gear is this slow
LEVEL = 0.999  # sine of a lower link's angle at which it counts as level: there the leg locks
LIFTED = 1e-3  # m, the foot's height from which it counts as lifted


@dataclass(frozen=True)
class JumpOutcome:
    """The outcome of a jump.

    clearance : the foot's greatest height, m; 0 if it does not lift.
    rise : greatest rise of the centre of mass over the crouch, m (the total height), until the foot lands from its
    greatest height: a slow leg may hop by a millimetre and then stand up.
    takeoff_time, takeoff_speed : s, and of the centre of mass, m/s, when the foot leaves the ground for its greatest
    height: a slow leg may lift it, come down while it still pushes, and lift it again.
    peak_gear_torque : largest torque of one gear on its link until takeoff, N m; peak_current : of both motors, A,
    likewise.
    energy : electrical, both motors, to takeoff, J.
    limit : why there is no jump; empty if there is one. All numbers are 0 if it is too stiff, and none is ``known``.
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

    @property
    def known(self) -> bool:
        """Whether its end was reached: not if too stiff, which says nothing about the jump."""
        return self.limit != LIMITS[TOO_STIFF]


LIMITS = {
    RUNNING: "no result",
    LANDED_AGAIN: "",
    TOO_WEAK: "too weak or too slow to lift",
    COLLAPSED: "too weak to hold the crouch: folds up",
    TOO_STIFF: "too stiff for the step: contact, links or winding",
    CROSSED: "goes through its stop: the knees cross",
}


def outcome_of(column: Array) -> JumpOutcome:
    """From one column (n_outcome,) of ``jump_runs.Jumper.run``."""
    if column[STATUS] == TOO_STIFF:
        return too_stiff()
    lifts = column[STATUS] == LANDED_AGAIN
    return JumpOutcome(
        clearance=float(column[CLEARANCE]) if lifts else 0.0,
        rise=float(column[APEX]),
        takeoff_time=float(column[TAKEOFF_TIME]),
        takeoff_speed=float(column[TAKEOFF_SPEED]),
        peak_gear_torque=float(column[PEAK_GEAR_TORQUE]),
        peak_current=float(column[PEAK_CURRENT]),
        energy=float(column[ENERGY]),
        peak_normal=float(column[PEAK_NORMAL]),
        limit=LIMITS[int(column[STATUS])],
    )


def too_stiff() -> JumpOutcome:
    """The outcome of a jump that ended for the step, whatever it had reached by then."""
    return JumpOutcome(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, LIMITS[TOO_STIFF])


def rise_of_jump(rise: Array, foot: Array, touching: float) -> float:
    """m, the greatest rise until the landing after the foot's greatest height; of all times if it does not lift.

    ``rise`` of the centre of mass and height of the ``foot`` (n_time,) m; the foot lands at the height ``touching``.
    """
    top = int(np.argmax(foot))
    down = np.flatnonzero(foot[top:] <= touching)
    end = top + int(down[0]) if foot[top] > LIFTED and len(down) else len(foot)
    return float(rise[:end].max())


def heights(found: Array, row: int = CLEARANCE) -> Array:
    """(n_lane,) m, the clearance or another height of outcomes (n_outcome, n_lane); 0 without a jump."""
    return np.where(found[STATUS] == LANDED_AGAIN, found[row], 0.0)


def known_heights(found: Array, row: int = CLEARANCE) -> Array:
    """``heights``, but nan for a lane whose height is not known: too stiff, through its stop, or out of reach."""
    return np.where(_unknown(found), np.nan, heights(found, row))


def known_values(found: Array, row: int) -> Array:
    """(n_lane,) one row of outcomes (n_outcome, n_lane), whether it jumps or not; nan where it is not known."""
    return np.where(_unknown(found), np.nan, found[row])


def _unknown(found: Array) -> NDArray[np.bool_]:
    return np.isin(found[STATUS], [TOO_STIFF, CROSSED, OUT_OF_REACH])


def column_of(outcome: JumpOutcome) -> Array:
    """(n_outcome,) the inverse, for engines that give a ``JumpOutcome``; missing values are 0."""
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
