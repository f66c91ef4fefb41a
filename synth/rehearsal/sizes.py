"""The size of a planted cause in its usual unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from synth.planting import torque_laws
from synth.planting.effect_size import PlantedCause
from synth.planting.forms import Scale
from synth.planting.setup import Setup

Numbers = Mapping[str, Any]
SIZE_MEANINGS = {
    "coulomb_friction": ("friction torque", "N*m"),
    "stribeck_friction": ("break-away torque", "N*m"),
    "load_friction": ("friction torque at its load", "N*m"),
    "shear_thinning_damping": ("loss of the damper's torque at top speed", "%"),
    "quadratic_damping": ("drag torque at top speed", "N*m"),
    "hardening_spring": ("change of the spring's torque at full deflection", "%"),
    "one_sided_spring": ("difference of rate on one side", "%"),
    "spring_hysteresis": ("stiffness of the loop relative to the spring's rate", "%"),
    "backlash": ("whole play", "deg"),
    "spring_preload": ("shift of the free angle", "deg"),
    "link_mass": ("change of mass", "%"),
    "link_inertia": ("change of centre of mass or inertia, the larger", "%"),
    "encoder_offset": ("shift of the reading", "deg"),
    "encoder_scale": ("scale error", "%"),
    "latency": ("delay or lag", "ms"),
    "joint_stop": ("overlap with the motion", "deg"),
    "base_compliance": ("natural frequency of the mount", "Hz"),
    "base_tilt": ("tilt", "deg"),
    "link_flexibility": ("stiffness of the softest bend", "N*m/rad"),
    "spring_rate": ("change of rate", "%"),
    "viscous_damping": ("change of rate", "N*m*s/rad"),
    "armature": ("inertia", "kg*m^2"),
    "torque_offset": ("change of torque", "N*m"),
    "torque_gain": ("change of torque", "%"),
    "torque_delay": ("delay", "ms"),
    "command_delay": ("delay", "ms"),
    "command_rate_limit": ("largest rate of the command", "deg/s"),
    "servo_gain": ("change of gain", "%"),
    "dead_band": ("dead band to either side", "deg"),
    "torque_constant": ("change of the constant", "%"),
    "winding_resistance": ("change of resistance", "%"),
    "current_limit": ("largest torque", "N*m"),
    "voltage_sag": ("source resistance over the winding's", "%"),
    "gear_friction": ("friction over the drive's torque", "%"),
    "winding_heating": ("growth of resistance in the end under the torque that holds the leg level", "%"),
}


def size_of(cause: PlantedCause, setup: Setup, scale: Scale) -> float | None:
    """SI value of the quantity in ``SIZE_MEANINGS``; None if the cause has none."""
    numbers = cause.form.tell(cause.size)
    known = _SIZE_BY_EFFECT.get(cause.effect)
    return None if known is None else abs(float(known(numbers, cause, setup, scale)))


def _named_number(name: str) -> Callable[..., float]:
    return lambda numbers, cause, setup, scale: numbers[name]


def _largest_relative_change(*names: str) -> Callable[..., float]:
    """The largest relative change among those given."""
    return lambda numbers, cause, setup, scale: max(abs(float(numbers[n]) - 1.0) for n in names if n in numbers)


def _moved_mass(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    """The largest change of a link's centre of mass, along it or beside it, over its distance, or of its inertia."""
    along, about = (abs(float(numbers[name]) - 1.0) for name in ("com_ratio", "inertia_ratio"))
    return max(along, about, abs(float(numbers["across_over_com"])))


def _friction_at_load(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    j = cause.joint
    if cause.form.build(cause.size)[0].laws[0].law == torque_laws.BEARING:
        return cause.size * setup.true.gravity * float(setup.true.of("mass")[j:].sum())
    return cause.size * float(setup.true.of("spring")[j] * scale.travel[j])


def _law_torque(cause: PlantedCause, q: float, w: float) -> float:
    """N m of a planted memoryless law at a rotation and rate."""
    law = cause.form.build(cause.size)[0].laws[0]
    par = np.array([*law.par, *(8 - len(law.par)) * [0.0]])
    return float(torque_laws.torque(law.law, par, np.zeros((1, 2)), 0.0, q, w, q, 0.0, 0.0)[0])


def _torque_lost_by_thinning(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    top = float(scale.speed[cause.joint])
    return _law_torque(cause, 0.0, top) / (float(setup.true.of("damper")[cause.joint]) * top)


def _drag_torque(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    return _law_torque(cause, 0.0, float(scale.speed[cause.joint]))


def _hardening_share(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    j = cause.joint
    k, free = float(setup.true.of("spring")[j]), float(setup.true.of("free_angle")[j])
    end = max((float(scale.low[j]), float(scale.high[j])), key=lambda q: abs(q - free))
    return _law_torque(cause, end, 0.0) / (k * (end - free))


def _over_spring_rate(name: str) -> Callable[..., float]:
    return lambda numbers, cause, setup, scale: float(numbers[name]) / float(setup.true.of("spring")[cause.joint])


def _damping_change(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    return float(numbers["rate"]) - float(setup.true.of("damper")[cause.joint])


def _delay_or_lag(numbers: Numbers, cause: PlantedCause, setup: Setup, scale: Scale) -> float:
    return float(numbers.get("delay_s", numbers.get("lag_s", math.nan)))


def _number_in_radians(name: str) -> Callable[..., float]:
    return lambda numbers, cause, setup, scale: math.radians(float(numbers[name]))


_SIZE_BY_EFFECT: dict[str, Callable[[Numbers, PlantedCause, Setup, Scale], float]] = {
    "coulomb_friction": _named_number("p0"),
    "stribeck_friction": _named_number("p1"),
    "load_friction": _friction_at_load,
    "shear_thinning_damping": _torque_lost_by_thinning,
    "quadratic_damping": _drag_torque,
    "hardening_spring": _hardening_share,
    "one_sided_spring": _over_spring_rate("rate_change"),
    "spring_hysteresis": _over_spring_rate("p0"),
    "backlash": lambda numbers, cause, setup, scale: 2.0 * math.radians(float(numbers["half_gap_deg"])),
    "spring_preload": _number_in_radians("shift_deg"),
    "link_mass": _largest_relative_change("ratio"),
    "link_inertia": _moved_mass,
    "encoder_offset": _named_number("offset_rad"),
    "encoder_scale": _named_number("scale_error"),
    "latency": _delay_or_lag,
    "joint_stop": lambda numbers, cause, setup, scale: cause.size,
    "base_compliance": _named_number("natural_hz"),
    "base_tilt": _number_in_radians("tilt_deg"),
    "link_flexibility": _named_number("rate"),
    "spring_rate": _largest_relative_change("ratio"),
    "viscous_damping": _damping_change,
    "armature": _named_number("inertia"),
    "torque_offset": _named_number("offset"),
    "torque_gain": _named_number("share"),
    "torque_delay": _delay_or_lag,
    "command_delay": _named_number("value"),
    "command_rate_limit": _named_number("value"),
    "servo_gain": _largest_relative_change("value"),
    "dead_band": _named_number("value"),
    "torque_constant": _largest_relative_change("value"),
    "winding_resistance": _largest_relative_change("value"),
    "current_limit": _named_number("value"),
    "voltage_sag": _named_number("value"),
    "gear_friction": _named_number("p0"),
    "winding_heating": _named_number("value"),
}
