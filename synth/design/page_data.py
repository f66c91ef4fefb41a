"""Data for the leg's page, with which it simulates the leg and exchanges parts: ``page.json``.

The page has its own integrator. It takes the chain's inertia and gravity coefficients (defined in
``synth.swing.mechanics``), the releases, and the parts for each joint; all in SI units, rotations in rad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

import synth
from synth.arrays import Array
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.leg_design import LegDesign
from synth.design.pasted_lines import damper_value, spring_value, why_unnamed
from synth.design.response import WantedRelease, WantedResponse
from synth.files.output import stems
from synth.parts.rows import DamperRow, TorsionSpringRow
from synth.spring.stress import bending_stress
from synth.swing.damper_curves import clamps, thin
from synth.swing.effects import effect_named
from synth.swing.leg_model import Damper, Leg
from synth.swing.mechanics import coefficients, static_torque

FORMAT = "synth/page/1"
MOST_RELEASES = 12  # in the page: each one adds to its size
MOST_SAMPLES = 250  # of a release's wanted motion
MOST_CHOICES = 8  # of a joint's springs, and of its dampers
# Effects that reports/static/integrator.js supports, with its name for their law.
LAWS = {
    "coulomb_friction": "friction",
    "stribeck_friction": "friction",
    "quadratic_damping": "drag",
    "hardening_spring": "hardening",
}
OFFERED = 4.0  # ratio to the wanted rate, above or below, beyond which a spring is not offered: it makes another leg


def page_json(design: LegDesign, bill: Mapping[str, str] | None = None) -> dict[str, Any]:
    """The content of ``page.json``; ``bill``: each drawn part's line of the bill of materials, in words, by name."""
    leg = design.built
    fitted = [trial for trial in design.target.trials if not trial.held_out]
    pose = design.wanted.rest_pose
    torque = static_torque(coefficients(leg), pose, leg.tilt)
    return {
        "format": FORMAT,
        "versions": {"synth": synth.__version__},
        "leg": leg_json(leg, design.rest_pose),
        "replay": replay_json(leg, design.wanted, stems([trial.name for trial in fitted])),
        "joints": {
            joint.name: {
                "holding": {"rotation": _number(pose[j]), "torque": _number(torque[j])},
                "springs": _springs(design, j),
                "dampers": _dampers(design, j),
            }
            for j, joint in enumerate(leg.joints)
        },
        "bill": dict(bill or {}),
    }


def leg_json(leg: Leg, pose: Array) -> dict[str, Any]:
    """The leg's geometry and the elements at its joints; angles in degrees as measured. ``pose`` (n,) rad, at rest."""
    rest = np.degrees(leg.to_measured(pose))
    joints = []
    for j, (joint, angle) in enumerate(zip(leg.joints, rest, strict=True)):
        assert joint.spring is not None
        joints.append(
            {
                "name": joint.name,
                "zero": _number(math.degrees(joint.zero)),
                "sign": joint.sign,
                "length": _number(joint.link.length),
                "rest": _number(angle),
                "range": None if joint.range is None else [_number(math.degrees(end)) for end in joint.range],
                "rate": _number(joint.spring.rate),
                "rotation": _number(joint.rest),
                "damper": damper_json(joint.damper),
                "effects": effects_json(leg, j),
            }
        )
    return {"tilt": _number(math.degrees(leg.tilt)), "joints": joints}


def replay_json(leg: Leg, wanted: WantedResponse, names: Sequence[str]) -> dict[str, Any]:
    """The releases of the wanted motion: mass coefficients of the leg, initial state, wanted motion.

    ``unsupported`` names the effects of this leg that the page's integrator does not support; the page then does not
    simulate.
    """
    every = max(1, math.ceil(len(wanted.releases) / MOST_RELEASES))
    found = [
        _release(leg, release, motion, name)
        for release, motion, name in list(zip(wanted.releases, wanted.motions, names, strict=True))[::every]
    ]
    unknown = [f"{name} of the {joint.name}" for joint in leg.joints for name in joint.effects if name not in LAWS]
    unknown += [f"drive of the {joint.name}" for joint in leg.joints if joint.drive is not None]
    return {"unsupported": [*unknown, *leg.effects], "releases": found, "of": len(wanted.releases)}


def _release(leg: Leg, release: WantedRelease, motion: Array, name: str) -> dict[str, Any]:
    coefficient = coefficients(leg, release.conditions.tip_mass)
    every = max(1, math.ceil(len(release.time) / MOST_SAMPLES))
    measured = np.degrees(leg.to_measured(motion))[::every]
    return {
        "name": name,
        "time": [_number(time) for time in release.time[::every]],
        "rotation": [_number(value, 12) for value in release.rotation],
        "rate": [_number(value, 12) for value in release.rate],
        "locked": list(release.conditions.locked),
        "tilt": _number(leg.tilt + release.conditions.tilt, 12),
        "inertia": [[_number(value, 12) for value in row] for row in coefficient.inertia],
        "inertia_across": [[_number(value, 12) for value in row] for row in coefficient.inertia_across],
        "gravity": [_number(value, 12) for value in coefficient.gravity],
        "gravity_across": [_number(value, 12) for value in coefficient.gravity_across],
        "wanted": [[round(float(value), 4) for value in column] for column in measured.T],
    }


def damper_json(damper: Damper | None) -> dict[str, Any]:
    """A linear rate, or clamp speeds and slopes that represent the curve as a sum of clamped lines."""
    if damper is None:
        return {"rate": 0.0}
    if damper.curve is None:
        return {"rate": _number(damper.rate or 0.0)}
    speed, slope = clamps(thin(damper.curve))
    return {"speed": [_number(value) for value in speed], "slope": [_number(value) for value in slope]}


def effects_json(leg: Leg, j: int) -> dict[str, Any]:
    """The joint's armature and effects that the page's integrator supports, SI."""
    found: dict[str, Any] = {"armature": _number(leg.armature[j]), **{kind: [] for kind in set(LAWS.values())}}
    for name, given in leg.joints[j].effects.items():
        if name in LAWS:
            numbers = {**effect_named(name).defaults, **given}
            found[LAWS[name]].append({key: _number(value) for key, value in numbers.items()})
    return {key: found[key] for key in sorted(found)}


def _springs(design: LegDesign, j: int) -> list[dict[str, Any]]:
    """The chosen spring, then its substitutes, best first."""
    chosen = design.springs.chosen[j]
    aim = chosen.asked
    near = [option for option in design.springs.ranked[j] if aim / OFFERED <= option.rate <= aim * OFFERED]
    others = [option for option in near if option is not chosen]
    return [_spring(option) for option in (chosen, *others[:MOST_CHOICES])]


def _spring(option: SpringOption) -> dict[str, Any]:
    row, made = option.row, option.design
    if row is not None:
        wire, mean, outer = row.wire_diameter, row.mean_diameter, row.outer_diameter
    else:
        assert made is not None
        wire, mean, outer = made.wire_diameter, made.mean_diameter, made.widest_outer_diameter
    per_torque = None
    if wire is not None and mean is not None and mean > wire:
        checked = option.check if made is None else made
        peak = 1.0 if checked is None else checked.peak_moment / checked.largest_moment
        per_torque = _number(bending_stress(peak / option.number, wire, mean) * 1e-6)
    return {
        "part": option.label,
        "vendor": row.vendor if row is not None else "to wind",
        "rate": _number(option.rate),
        "error": _number(math.degrees(option.error)),
        "within_tolerance": not option.outside,
        "outer_mm": None if outer is None else _number(outer * 1e3),
        "stress_per_torque": per_torque,  # MPa per N m, inner fibre, at full travel
        "allowed_mpa": None if made is None else _number(made.allowed_stress * 1e-6),
        "choice": spring_value(option),
        **_price(row),
    }


def _dampers(design: LegDesign, j: int) -> list[dict[str, Any]]:
    """The chosen damper, then its substitutes; ``spring_rate``: of the spring with which ``error`` was found, if it is
    not the chosen one.
    """
    chosen = design.dampers.chosen[j]
    others = [option for option in design.dampers.ranked[j] if option is not chosen]
    return [_damper(option) for option in (chosen, *others[:MOST_CHOICES])]


def _damper(option: DamperOption) -> dict[str, Any]:
    row, rate = option.row, option.partner_rate
    return {
        "part": option.label,
        "vendor": row.vendor if row is not None else "",
        "law": option.law,
        "error": _number(math.degrees(option.error)),
        "spring_rate": None if rate is None else _number(rate),
        "outer_mm": None if row is None or row.outer_diameter is None else _number(row.outer_diameter * 1e3),
        "choice": damper_value(option) or "",
        "unnamed": why_unnamed(option),
        **_price(row),
        **damper_json(option.damper),
    }


def _price(row: TorsionSpringRow | DamperRow | None) -> dict[str, str]:
    """Price per piece, if the user's table states it."""
    return {"price": row.price} if row is not None and row.price else {}


def _number(value: float, digits: int = 8) -> float:
    """Rounded to significant digits: the same bytes on any machine, and a small page."""
    return float(f"{float(value):.{digits}g}")
