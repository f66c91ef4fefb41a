"""Dry friction that a leg has by design beside that of a cause: a joint sticks by one law, which carries both."""

from __future__ import annotations

from synth.planting.model import Law, PlantedLeg
from synth.planting.refusals import NotApplicable
from synth.planting.torque_laws import BEARING, GEAR, STICK_SLIP, STUCK_LAWS


def all_laws(leg: PlantedLeg, causes: tuple[Law, ...]) -> tuple[Law, ...]:
    """The laws of a leg and of causes; where the leg sticks, a cause that does too changes the leg's law.

    Raises
    ------
    NotApplicable : a joint has two whose sum is none of them.
    """
    own, more = list(leg.laws), []
    for law in causes:
        same = [k for k, stated in enumerate(own) if _stick_together(stated, law)]
        if same:
            own[same[0]] = _sum_of(own[same[0]], law)
        else:
            more.append(law)
    return (*own, *more)


def _stick_together(one: Law, other: Law) -> bool:
    """Whether both hold the same joint as a rigid constraint."""
    both = one.law in STUCK_LAWS and other.law in STUCK_LAWS
    return both and one.joint == other.joint and not (one.base or other.base)


def _sum_of(one: Law, other: Law) -> Law:
    for law, constant in ((one, other), (other, one)):
        torque = _constant_torque(constant)
        if torque is not None:
            if law.law == STICK_SLIP:
                return law._replace(par=(law.par[0] + torque, law.par[1] + torque, *law.par[2:]))
            return law._replace(par=(law.par[0], law.par[1] + torque))
    if one.law == other.law and one.law in (GEAR, BEARING):
        return one._replace(par=(one.par[0] + other.par[0], one.par[1] + other.par[1]))
    raise NotApplicable("the leg file states another dry friction of this joint")


def _constant_torque(law: Law) -> float | None:
    """N m, of a friction that depends on neither speed nor load; None if it does."""
    return law.par[0] if law.law == STICK_SLIP and law.par[0] == law.par[1] else None
