"""Intervals from tolerances: a design and fourteen copies of it, each with one quantity at its 90 % end.

The interval is the nominal clearance minus and plus the root of the sum of squared changes, with each quantity's worse
(better) end below (above): first order, but with the curvature that makes the two sides differ. A maker's
"plus or minus 20 %" is taken as uniform, whose 90 % ends are at 0.9 of it, see ``half_width``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.hopper.motors import with_loss, with_speed, with_torque
from synth.jump.hopper_leg import Contact, HopperLeg, HopperTolerances, Motor, in_reach
from synth.jump.jump_layout import LANES
from synth.jump.jump_models import Model, lanes
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import LEVEL, OUT_OF_REACH, PEAK_GEAR_TORQUE, STATUS, known_values

UNIFORM = 0.9  # the 90 % end of a uniform distribution over [-1, 1]
QUANTITIES = (
    "no-load speed",
    "stall torque",
    "no-load current",
    "rotor inertia",
    "body mass",
    "joint damping",
    "crouch",
)


def half_width(limit: float) -> float:
    """90 % half width of a quantity whose maker promises it within plus or minus ``limit``, in the same unit."""
    return UNIFORM * limit


def copies(leg: HopperLeg, motor: Motor, tolerances: HopperTolerances) -> list[tuple[HopperLeg, Motor]]:
    """The design and its fourteen copies, lower end before upper, in the order of ``QUANTITIES``."""
    t = tolerances
    found = [(leg, motor)]
    for sign in (-1.0, 1.0):
        flexures = replace(leg.flexures, damping=leg.flexures.damping * (1.0 + sign * t.joint_damping))
        lower = None if leg.crouch_lower is None else leg.crouch_lower + sign * t.crouch
        mass = leg.structure_mass + sign * t.mass * (leg.structure_mass + 2 * motor.mass)
        found += [
            (leg, with_speed(motor, 1.0 + sign * t.speed)),
            (leg, with_torque(motor, 1.0 + sign * t.torque)),
            (leg, with_loss(motor, 1.0 + sign * t.current)),
            (leg, replace(motor, rotor_inertia=motor.rotor_inertia * (1.0 + t.rotor_inertia) ** sign)),
            (replace(leg, structure_mass=mass), motor),
            (replace(leg, flexures=flexures), motor),
            (replace(leg, crouch=leg.crouch + sign * t.crouch, crouch_lower=lower), motor),
        ]
    return found


def groups(
    leg: HopperLeg, motor: Motor, contact: Contact, model: Model, tolerances: HopperTolerances, length: Array
) -> Array:
    """(n_design, n_row, 16) lanes of ``copies`` for each length (n_design,) m; the last lane repeats the nominal one.

    A crouch from which a copy cannot start, see ``startable``, is left unchanged: such a copy's outcome means nothing.
    """
    made = copies(leg, motor, tolerances)
    nominal = lanes(leg, motor, contact, model, length)
    columns = [nominal]
    for (bent, other), starts in zip(made[1:], startable(leg, motor, tolerances, length).T[1:], strict=False):
        column = nominal.copy()
        column[:, starts] = lanes(bent, other, contact, model, length[starts])
        columns.append(column)
    columns += [nominal] * (LANES - len(columns))
    return np.stack(columns).transpose(2, 1, 0)


def startable(leg: HopperLeg, motor: Motor, tolerances: HopperTolerances, length: Array) -> NDArray[np.bool_]:
    """(n_design, 16) whether each lane of ``groups`` can start: not with level lower links, nor beyond its stop.

    A design is not swept whose lower links stand within 10 deg of level (``LOCKED``); as built it may well do so.
    """
    level = float(np.arcsin(LEVEL))
    found = [in_reach(bent, length, level) for bent, _ in copies(leg, motor, tolerances)]
    return np.stack([*found, *[found[0]] * (LANES - len(found))], axis=1)


def outcomes_of_copies(
    leg: HopperLeg, motor: Motor, contact: Contact, model: Model, tolerances: HopperTolerances, length: Array
) -> Iterator[Array]:
    """Outcomes (n_outcome, 16) of ``groups``, one design after the other; copies that cannot start are out of reach."""
    jumper = compiled_jump(leg.bending)
    starts = startable(leg, motor, tolerances, length)
    for lanes_of_one, mask in zip(groups(leg, motor, contact, model, tolerances, length), starts, strict=True):
        found = jumper.run(lanes_of_one)
        found[STATUS, ~mask] = OUT_OF_REACH
        yield found


def intervals(clearance: Array) -> tuple[Array, Array, Array]:
    """Nominal, low and high (n,) of clearances (n, 16) in the order of ``groups``; never below 0.

    Both ends are nan where a copy's clearance is, as ``outcomes.known_heights`` gives it.
    """
    count = len(QUANTITIES)
    nominal = clearance[:, 0]
    change = np.stack([clearance[:, 1 : 1 + count], clearance[:, 1 + count : 1 + 2 * count]]) - nominal[:, None]
    down = np.sqrt((np.minimum(change, 0.0).min(axis=0) ** 2).sum(axis=1))
    up = np.sqrt((np.maximum(change, 0.0).max(axis=0) ** 2).sum(axis=1))
    return nominal, np.maximum(0.0, nominal - down), nominal + up


def torque_interval(found: Array) -> tuple[float, float]:
    """Low and high, N m, of one design's peak gear torque from outcomes (n_outcome, 16); nan if a copy's is unknown."""
    _, low, high = intervals(known_values(found, PEAK_GEAR_TORQUE)[None, :])
    return float(low[0]), float(high[0])


def contributions(clearance: Array) -> dict[str, tuple[float, float]]:
    """Change of one design's clearance (16,) at each quantity's lower and upper end, m; known ones only."""
    count = len(QUANTITIES)
    ends = (clearance[1 : 1 + count] - clearance[0], clearance[1 + count : 1 + 2 * count] - clearance[0])
    changes = zip(QUANTITIES, *(end.tolist() for end in ends), strict=True)
    return {name: (low, high) for name, low, high in changes if np.isfinite(low) and np.isfinite(high)}
