"""Effects that the leg file states, in the forms of the generator's engine."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from synth.errors import Problem, UserError
from synth.planting.model import Law
from synth.planting.torque_laws import BRISTLES, DRAG, GEAR, STICK_SLIP
from synth.swing.effects import registered
from synth.swing.effects.inlined import LEAST_PRESLIDING
from synth.swing.leg_model import Leg

GAUSSIAN = 2.0  # shape of the generator's friction that falls with exp(-(w / speed)^2)
Values = Mapping[str, float]


def stated_laws(leg: Leg) -> tuple[Law, ...]:
    """The torques that the leg file states beside springs, dampers and drives.

    Raises
    ------
    UserError : the generator's engine has no such effect.
    """
    defaults = {effect.name: effect.defaults for effect in registered()}
    found, problems = [], [Problem(_refusal(name), key="base") for name in leg.effects]
    for j, joint in enumerate(leg.joints):
        for name, given in joint.effects.items():
            law = LAWS[name](j, {**defaults[name], **given}) if name in LAWS else None
            if law is None:
                problems.append(Problem(_refusal(name), key=joint.name))
            else:
                found.append(law)
    if problems:
        raise UserError(problems)
    return tuple(found)


def _coulomb(joint: int, values: Values) -> Law | None:
    torque = values["torque"]
    return None if values["creep"] else _dry(joint, values["presliding"], (torque, torque, 1.0, 0.0))


def _stribeck(joint: int, values: Values) -> Law | None:
    torque = values["torque"]
    return _dry(joint, values["presliding"], ((1.0 - values["fall"]) * torque, torque, values["speed"], GAUSSIAN))


def _dry(joint: int, presliding: float, par: tuple[float, ...]) -> Law:
    """Rigid where the effect holds, else with the same deflection before it slides."""
    if presliding <= LEAST_PRESLIDING:
        return Law(STICK_SLIP, joint, par)
    return Law(BRISTLES, joint, (*par, presliding, 0.0))


def _gear(joint: int, values: Values) -> Law | None:
    if values["backdriven"] or values["fall"]:
        return None
    return Law(GEAR, joint, (values["share"], values["torque"]))


def _drag(joint: int, values: Values) -> Law | None:
    return Law(DRAG, joint, (values["coefficient"], 0.0)) if values["exponent"] == 2.0 else None


LAWS: Mapping[str, Callable[[int, Values], Law | None]] = {
    "coulomb_friction": _coulomb,
    "stribeck_friction": _stribeck,
    "gear_friction": _gear,
    "quadratic_damping": _drag,
}


def _refusal(name: str) -> str:
    known = f"it has {', '.join(LAWS)}"
    if name in LAWS:
        known = (
            "it has coulomb_friction without creep, gear_friction without fall and backdriven, and quadratic_damping "
            "with exponent 2"
        )
    return (
        f"the leg file gives it {name}; a rehearsal plants causes in the designed leg with a separate engine that does "
        f"not support this; {known}. Remove it for the rehearsal"
    )
