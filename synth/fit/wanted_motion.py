"""A motion from wanted characteristics: the springs and dampers with which the whole leg's release shows them.

Of the legs that show them the likeliest is given (``wanted_release``), with the others (``wanted_search``), which are
the uncertainty of the answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import CannotBeHad, Problem
from synth.estimation.intervals import Estimate
from synth.files.projects import FitProject, LegProject
from synth.files.trial_list import Trial
from synth.files.wanted_section import WantedCharacteristics
from synth.fit.drives_off import drives_off_sentence
from synth.fit.fit_result import FitResult, JointFit
from synth.fit.wanted_release import (
    CHARACTERISTIC_ERROR,
    KEYS,
    LARGEST_EXCURSION,
    LEAST_SWING,
    SHAPE_ERROR,
    UNITS,
    AskedJoint,
    CharacteristicRelease,
    natural_frequency,
    swing_of,
)
from synth.fit.wanted_search import WantedSearch
from synth.remarks import decisive
from synth.swing.leg_model import Leg
from synth.units import quantity

UNREPORTED_MISS = 0.02  # relative deviation of a characteristic that is not reported
REFUSED_MISS = 0.25  # relative deviation above which the request is refused
WORTH_NAMING = 1.5  # ratio of a spring rate's ends from which other legs are named: makers' steps are finer


@dataclass(frozen=True)
class WantedMotion:
    """The leg with the characteristics, its release as a trial, and its actual characteristics, joint by joint.

    ``off`` : of each joint, its deviation from the wanted oscillation, RMS over that of the oscillation, and its
    largest way from rest in amplitudes.
    ``legs`` : with the characteristics, the first is ``leg``. The ends of each rate's 90 % interval are among them.
    """

    legs: tuple[Leg, ...]
    trial: Trial
    asked: Mapping[str, WantedCharacteristics]
    shown: Mapping[str, Mapping[str, float]]
    off: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def leg(self) -> Leg:
        """The likeliest."""
        return self.legs[0]

    @property
    def messages(self) -> tuple[str, ...]:
        """A sentence on other legs that show the same, and one on each characteristic that differs from the request."""
        found = self._contradictions()
        found += [] if (off := drives_off_sentence(self.leg)) is None else [off]
        found += [] if (others := other_legs_sentence(self.legs, self.asked)) is None else [others]
        for name, key, asked, shown in _pairs(self.asked, self.shown):
            if abs(shown / asked - 1.0) > UNREPORTED_MISS:
                words = f"{_article(key)} {key.replace('_', ' ')}"
                text = f"wanted: {name}: {words} of {_text(asked, key)} is wanted, {_text(shown, key)} results; "
                found.append(f"{text}the links are coupled")
        for name, joint in self.asked.items():
            past, ratio = self.shown[name].get("overshoot", 0.0), joint.damping_ratio
            if not AskedJoint(joint).swings and past > swing_of(ratio, 1) + LEAST_SWING:
                alone = f"wanted: {name}: with a damping ratio of {ratio:.3g} the joint alone hardly passes its rest"
                found.append(f"{alone}; moved by the others it does once, by {past:.0%} of its amplitude")
        return tuple(found)

    def _contradictions(self) -> list[str]:
        """A sentence where a joint shows its figures, but does not move as they describe."""
        texts = []
        for name, (shape, way) in self.off.items():
            if AskedJoint(self.asked[name]).swings and shape > SHAPE_ERROR:
                texts.append(f"the {name}'s motion is {shape:.0%} (RMS) off the oscillation that is asked")
            if way > LARGEST_EXCURSION:
                texts.append(f"the {name} swings to {way:.2g} amplitudes from its rest")
        if not texts:
            return []
        text = f"wanted: the leg shows the figures, but does not move as they describe: {'; '.join(texts)}"
        remedy = "Look at the responses; ask for other frequencies or dampings, or state the motion as a recording."
        return [decisive(text, remedy)]

    def as_json(self) -> dict[str, Any]:
        """The wanted and the actual characteristics, with the springs and dampers."""
        found: dict[str, Any] = {}
        for joint in self.leg.joints:
            assert joint.spring is not None
            assert joint.damper is not None
            assert joint.damper.rate is not None
            asked, shown = self.asked[joint.name], self.shown[joint.name]
            found[joint.name] = {
                "asked": {
                    key: quantity(v, unit) for key, unit in KEYS.items() if (v := getattr(asked, key)) is not None
                },
                "shown": {key: quantity(value, UNITS[key]) for key, value in shown.items()},
                "rest": quantity(asked.rest, "deg"),
                "amplitude": quantity(asked.amplitude, "deg"),
                "spring_rate": quantity(joint.spring.rate, "N*m/rad"),
                "damper_rate": quantity(joint.damper.rate, "N*m*s/rad"),
            }
        return found


def _pairs(
    asked: Mapping[str, WantedCharacteristics], shown: Mapping[str, Mapping[str, float]]
) -> list[tuple[str, str, float, float]]:
    """Joint, measure, wanted and actual value, if the motion shows it."""
    return [
        (name, key, value, shown[name][key])
        for name, joint in asked.items()
        for key, value in AskedJoint(joint).measures.items()
        if key in shown[name]
    ]


def _text(value: float, key: str) -> str:
    unit = UNITS[key]
    if unit == "rad/s":  # written in Hz, as people do
        value, unit = value / (2.0 * np.pi), "Hz"
    return f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"


def wanted_motion(leg: Leg, asked: Mapping[str, WantedCharacteristics], seed: int = 0) -> WantedMotion:
    """The springs and dampers with which a release of ``leg`` has the wanted characteristics, and that release.

    Raises
    ------
    CannotBeHad : the nearest motion of this leg differs by more than a quarter in a characteristic.
    """
    release = CharacteristicRelease.of(leg, asked)
    found = WantedSearch(release).legs(seed)
    motion = release.motions(found[0].x[None])[0]
    _refuse_far(release, motion)
    legs = tuple(release.leg_of(each.x) for each in found)
    off = np.stack(release.off_oscillators(motion), axis=1).tolist()
    ways = {name: (shape, way) for name, (shape, way) in zip(leg.joint_names, off, strict=True)}
    return WantedMotion(legs, _trial(release.time, motion), asked, release.shown(motion), ways)


def _trial(time: Array, angles: Array) -> Trial:
    """The release (m, n) rad as a recording without noise."""
    digest = sha256(np.round(np.column_stack([time, angles]), 9).tobytes()).hexdigest()
    return Trial("wanted characteristics", time, angles, sha256=digest)


def _refuse_far(release: CharacteristicRelease, motion: Array) -> None:
    """Raise if the nearest motion (m, n) rad differs too much from the request, in what was sought."""
    problems = []
    shown = release.shown(motion)
    for j, (name, joint) in enumerate(zip(release.leg.joint_names, release.joints, strict=True)):
        measures, found = joint.measures, shown[name]
        far = [
            f"{_article(key)} {key.replace('_', ' ')} of {_text(asked, key)} "
            + (f"(nearest {_text(found[key], key)})" if key in found else "(the nearest motion shows none)")
            for key, asked in measures.items()
            if key not in found or abs(found[key] / asked - 1.0) > REFUSED_MISS
        ]
        if not joint.swings and "damping_ratio" in found:
            wanted, least = joint.asked.damping_ratio, found["damping_ratio"]
            far.append(f"a damping ratio of {wanted:.3g} (the nearest motion swings, with one of {least:.3g})")
        if far:
            text = f"this leg cannot move with {', '.join(far)}{_why(release, j)}"
            problems.append(Problem(text, key=f"wanted.{name}"))
    if problems:
        raise CannotBeHad(problems)


def _article(key: str) -> str:
    return "an" if key == "overshoot" else "a"


def _why(release: CharacteristicRelease, j: int) -> str:
    """The reason, if gravity prevents it."""
    gravity, inertia = release.gravity[j], release.inertia[j]
    if gravity <= inertia * natural_frequency(release.joints[j].asked) ** 2:
        return ""
    alone = float(np.sqrt(gravity / inertia)) / (2 * np.pi)
    return f". Gravity alone swings it at {alone:.2g} Hz, and no spring makes that slower"


def other_legs_sentence(legs: Sequence[Leg], asked: Mapping[str, WantedCharacteristics]) -> str | None:
    """How far apart the spring rates of legs are that all show the ``asked`` figures; None if they hardly are."""
    rates = np.array([leg.spring_rate for leg in legs])
    low, high = rates.min(axis=0), rates.max(axis=0)
    if np.all(high <= WORTH_NAMING * low):
        return None
    ends = [
        f"{name} {at:.3g} (from {least:.2g} to {most:.2g})"
        for name, at, least, most in zip(legs[0].joint_names, rates[0], low, high, strict=True)
    ]
    return decisive(
        f"wanted: {_why_many(asked)}, so many legs show these characteristics, each with its own dampers. The "
        f"one given is the likeliest; its spring rates in N*m/rad, and those of the others: {', '.join(ends)}",
        remedy="A recording of the motion instead of its characteristics tells which of these legs it is",
    )


def _why_many(asked: Mapping[str, WantedCharacteristics]) -> str:
    """The reason why many legs show the figures that are asked."""
    if len(asked) > 1:
        return "the links move each other"
    if any(len(AskedJoint(joint).measures) == 1 for joint in asked.values()):
        return "a rise time fixes the damper for each spring, not both"
    share = f"{CHARACTERISTIC_ERROR:.0%} of a figure are much of the spring"
    return f"gravity holds the link more than its spring does: {share}"


def with_other_legs(result: FitResult, legs: Sequence[Leg]) -> FitResult:
    """The fit to the motion of the first leg, with all ``legs`` in its intervals and as its drawn legs.

    The motion itself has no noise: by it alone every estimate would be exact.
    """
    if not legs:
        return result
    joints = {name: _widened(joint, legs, j) for j, (name, joint) in enumerate(result.joints.items())}
    return replace(result, joints=joints, drawn=tuple(legs), intervals={"by": "wanted characteristics"}, sources=())


def _widened(joint: JointFit, legs: Sequence[Leg], j: int) -> JointFit:
    """The estimates with intervals from the least to the greatest of all legs."""
    springs = [leg.joints[j].spring for leg in legs]
    dampers = [leg.joints[j].damper for leg in legs]
    rate = _spanning(joint.spring_rate, [spring.rate for spring in springs if spring is not None])
    free = _spanning(joint.free_angle, [spring.free_angle for spring in springs if spring is not None])
    damper = joint.damper_rate
    if damper is not None:
        damper = _spanning(damper, [each.rate for each in dampers if each is not None and each.rate is not None])
    return replace(joint, spring_rate=rate, free_angle=free, damper_rate=damper)


def _spanning(estimate: Estimate, values: Sequence[float]) -> Estimate:
    ends = [end for end in (estimate.low, estimate.high) if end is not None]
    return replace(estimate, low=min(*ends, *values), high=max(*ends, *values))


def with_wanted_fit(project: FitProject) -> tuple[FitProject, WantedMotion | None]:
    """The project with the wanted motion as its trial, if it states one."""
    if not project.wanted:
        return project, None
    found = wanted_motion(project.leg, project.wanted, project.fit.seed)
    return replace(project, trials=(found.trial,), release="recorded"), found


def with_wanted_leg(project: LegProject) -> LegProject:
    """The same for a leg-design; the characteristics belong to its source."""
    if not project.wanted:
        return project
    found = wanted_motion(project.source, project.wanted, project.fit.seed)
    return replace(
        project,
        trials=(found.trial,),
        release="recorded",
        wanted_shown=found.as_json(),
        wanted_legs=found.legs,
        messages=found.messages,
        wanted={},
    )
