"""The sections ``measured`` and ``dampers`` of a leg design: measurements of available parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import Field

from synth.files.curve import read_curve
from synth.files.named_files import ProjectReader
from synth.files.paths import inside
from synth.files.project_options import (
    MeasuredSpring,
)
from synth.files.trial_list import Trial
from synth.files.validate import Title, gathering
from synth.files.yaml_lines import Key
from synth.swing.leg_model import DamperCurve, Leg

Entries = Annotated[list[Any], Field(min_length=1, examples=["[trials/*.csv]"])]


@dataclass(frozen=True)
class MeasuredDamper:
    """Measurements of a joint's damper: its ``curve``, or drops of ``leg`` with only that damper."""

    part: str | None
    curve: DamperCurve | None
    leg: Leg | None
    trials: tuple[Trial, ...]


@dataclass(frozen=True)
class MeasuredPartsSection:
    spring: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class DamperSection:
    part: Title | None = None
    curve: str | None = None
    leg: str | None = None
    trials: Entries | None = None
    locked: list[str] = field(default_factory=list)


def read_measured_springs(reader: ProjectReader, target: Leg | None) -> dict[str, MeasuredSpring]:
    """``measured: {spring: {JOINT: {free_angle, rate, …}}}``, of available springs."""
    section = reader.section(MeasuredPartsSection, "measured")
    if section is None or target is None:
        return {}
    place: Key = ("measured", "spring")
    reader.known_joints(section.spring, target, place)
    found = {}
    for name, item in section.spring.items():
        measured = reader.entry(MeasuredSpring, (*place, name), item)
        if measured is None or name not in target.joint_names:
            continue
        if measured.free_angle is None and measured.rate is None:
            reader.refuse('needs "free_angle", "rate" or both', (*place, name))
            continue
        stray = [key for key in ("rate_held", "rate_distance") if key in item]
        if stray and measured.rate is None:
            reader.refuse(f'"{stray[0]}" says how "rate" was measured, which is not given', (*place, name))
            continue
        if "free_angle_by" in item and measured.free_angle is None:
            reader.refuse('"free_angle_by" says how "free_angle" was found, which is not given', (*place, name))
            continue
        if measured.rate_held == "joint" and measured.rate_distance is not None:
            text = '"rate_distance" belongs to a loose spring; leave it out, or write rate_held: loose'
            reader.refuse(text, (*place, name, "rate_distance"))
            continue
        found[name] = measured
    return found


def read_measured_dampers(reader: ProjectReader, value: Any, target: Leg | None) -> dict[str, MeasuredDamper]:
    if value is None or target is None:
        return {}
    if not isinstance(value, dict):
        reader.refuse(f"{value!r} is not allowed: a mapping {{joint: {{...}}}} is needed", ("dampers",))
        return {}
    reader.known_joints(value, target, ("dampers",))
    result: dict[str, MeasuredDamper] = {}
    for name, item in value.items():
        key: Key = ("dampers", name)
        damper = reader.entry(DamperSection, key, item)
        if damper is not None and name in target.joint_names:
            measured = _measured_damper(reader, damper, name, key)
            if measured is not None:
                result[name] = measured
    return result


def _measured_damper(reader: ProjectReader, damper: DamperSection, joint: str, key: Key) -> MeasuredDamper | None:
    drops = [name for name in ("leg", "trials") if getattr(damper, name) is not None]
    if damper.curve is not None and drops:
        reader.refuse(f'"curve" and "{drops[0]}" are both given; keep the table or the drops', key)
        return None
    if damper.curve is not None:
        with gathering(reader.problems, reader.document, (*key, "curve")):
            path = inside(reader.folder, damper.curve)
            curve = read_curve(path)
            reader.note(path)
            return MeasuredDamper(damper.part, curve, None, ())
        return None
    if damper.leg is None or damper.trials is None:
        text = 'needs "curve" (a CSV of speed and torque), or "leg" and "trials" (drops with that damper alone)'
        reader.refuse(text, key)
        return None
    leg = reader.leg(damper.leg, (*key, "leg"))
    if leg is None:
        return None
    if joint not in leg.joint_names:
        reader.refuse(f'"{joint}" is no joint of {leg.name}', (*key, "leg"))
        return None
    reader.known_joints(dict.fromkeys(damper.locked), leg, (*key, "locked"))
    if joint in damper.locked:
        reader.refuse(f"{joint} is locked in its own drops, so its damper has no effect", (*key, "locked"))
        return None
    if not set(damper.locked) <= set(leg.joint_names):
        return None
    trials = reader.trials(damper.trials, leg, (*key, "trials"), damper.locked)
    return MeasuredDamper(damper.part, None, leg, trials)
