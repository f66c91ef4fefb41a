"""Releases of small legs with errors within tolerance and an effect that their design lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.swing.chain import Conditions, simulate
from synth.swing.effects import effect_named
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring
from synth.swing.tolerances import Tolerances

PLAIN = Conditions()
NOISE = np.radians(0.1)
TIME = np.arange(201) * 0.01
# rad from the free angles, hip and knee
AWAY = np.array([[0.5, 0.6], [-0.4, 0.7], [0.35, -0.6], [0.6, -0.8]])

_JOINTS = (
    Joint("hip", Link(0.25, 0.6, 0.11, 4e-3), 0.4, 1, None, Spring(6.0, 0.5), Damper(0.08)),
    Joint("knee", Link(0.22, 0.35, 0.09, 2e-3), 2.0, -1, None, Spring(1.5, 1.8), Damper(0.015)),
)
ONE, TWO = Leg("pendulum", _JOINTS[1:]), Leg("leg", _JOINTS)
HANGING = Leg("hanging", (replace(_JOINTS[1], spring=Spring(0.4, 1.8)),))  # gravity holds it as much as its spring does
Effects = Mapping[str, Mapping[str, Mapping[str, float]]]


def off(leg: Leg, seed: int, share: float = 1.0) -> Leg:
    """The leg with random errors of the usual tolerances, ``share`` of one standard deviation, none beyond two."""
    tolerances = Tolerances.of(leg, Tolerance())
    errors = np.clip(np.random.default_rng(seed).standard_normal(tolerances.size), -2.0, 2.0)
    return tolerances.leg(leg, share * errors)


def shifted(leg: Leg, joint: str, angle: float) -> Leg:
    """The leg with a free angle elsewhere."""
    (spring,) = (j.spring for j in leg.joints if j.name == joint)
    assert spring is not None
    return leg.with_joints(**{joint: {"spring": replace(spring, free_angle=spring.free_angle + angle)}})


def heavier(leg: Leg, joint: str, share: float) -> Leg:
    """The leg with a link heavier by a share, its inertia in proportion."""
    (link,) = (j.link for j in leg.joints if j.name == joint)
    more = replace(link, mass=link.mass * (1.0 + share), inertia=link.inertia * (1.0 + share))
    return leg.with_joints(**{joint: {"link": more}})


def with_effects(leg: Leg, effects: Effects) -> Leg:
    """The leg with effects by joint name, ``base`` those of the base."""
    made = leg.with_joints(**{name: {"effects": given} for name, given in effects.items() if name != "base"})
    return replace(made, effects=effects.get("base", {}))


def recorded(
    leg: Leg,
    away: Array = AWAY,
    *,
    seed: int = 0,
    noise: float = NOISE,
    time: Array = TIME,
    held_out: int = 1,
    conditions: Conditions = PLAIN,
    first: int = 0,
) -> list[Trial]:
    """Releases from rest, read with noise; the last ``held_out`` are held out.

    ``away`` (n_trial, at least n) rad from the springs' free angles. Effects on the reading act on it.
    """
    generator = np.random.default_rng(seed)
    n = len(leg.joints)
    rest = np.array([j.sign * (j.spring.free_angle - j.zero) for j in leg.joints if j.spring])
    trials = []
    for index, by in enumerate(away):
        motion = simulate(leg, rest + by[:n], np.zeros(n), time, conditions, rates=True)
        angles = leg.to_measured(read(leg, time, motion[:, :n], motion[:, n:]))
        angles = angles + noise * generator.standard_normal(angles.shape)
        for j, joint in enumerate(leg.joints):
            step = joint.effects.get("encoder_quantisation", {}).get("step")
            if step:
                angles[:, j] = step * np.round(angles[:, j] / step)
        trials.append(
            Trial(
                f"{first + index}.csv",
                time,
                angles,
                locked=tuple(leg.joint_names[j] for j in conditions.locked),
                tip_mass=conditions.tip_mass,
                tilt=conditions.tilt,
                held_out=index >= len(away) - held_out,
            )
        )
    return trials


def read(leg: Leg, time: Array, rotation: Array, rate: Array) -> Array:
    """Rotations (m, n) as the leg's encoders tell them, but for counts."""
    told = rotation.copy()
    for j, joint in enumerate(leg.joints):
        for name, given in joint.effects.items():
            effect = effect_named(name)
            assert set(given) <= {p.name for p in effect.parameters}
            if effect.way == "reading" and name != "encoder_quantisation":
                values = [np.array([given.get(p.name, effect.defaults[p.name])]) for p in effect.parameters]
                column = effect.function()(
                    time, told[:, j : j + 1], rate[:, j : j + 1], joint.sign, joint.zero, *values
                )
                told[:, j] = column[:, 0]
    return told


def causes(result: GapResult) -> list[tuple[str, str]]:
    """Effect and joint of the explanation."""
    return [(cause.effect, cause.joint) for cause in result.explanation]


def best(result: GapResult) -> tuple[str, str]:
    """Effect and joint of the most probable cause."""
    return result.ranked[0].cause.effect, result.ranked[0].cause.joint
