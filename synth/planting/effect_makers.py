"""The generator's form of each library effect, by the effect's name in the files."""

from __future__ import annotations

from synth.planting import joint_effects, other_effects
from synth.planting.forms import Maker

EFFECTS: dict[str, Maker] = {
    "coulomb_friction": joint_effects.coulomb,
    "stribeck_friction": joint_effects.stribeck,
    "load_friction": joint_effects.load_friction,
    "shear_thinning_damping": joint_effects.thinning,
    "quadratic_damping": joint_effects.drag,
    "hardening_spring": joint_effects.hardening,
    "one_sided_spring": joint_effects.one_sided,
    "spring_hysteresis": joint_effects.hysteresis,
    "backlash": joint_effects.backlash,
    "spring_preload": other_effects.preload,
    "link_mass": other_effects.link_mass,
    "link_inertia": other_effects.link_inertia,
    "encoder_offset": other_effects.encoder_offset,
    "encoder_scale": other_effects.encoder_scale,
    "encoder_quantisation": other_effects.quantisation,
    "latency": other_effects.latency,
    "joint_stop": other_effects.joint_stop,
    "base_compliance": other_effects.base_compliance,
    "base_tilt": other_effects.base_tilt,
    "link_flexibility": other_effects.link_flexibility,
}
EFFECTS_AT_BASE = ("base_compliance", "base_tilt")
