"""Location of the gap: shares of the squared residuals above the samples' uncertainty, and the missing torque."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import PHASES, THIRDS, Where, shares
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, CURRENT, FORCE, Jump
from synth.diagnosis.plants.jumping_leg.jump_score import ScoredJump

PLACES = {ANGLE: "hip", CURRENT: "hip", "supply": "hip"}  # the other channels are measured at the ground: base
PHASES_OF_JUMP = PHASES[:2]  # the phases that a jump or a pull-up has; the file holds the others as 0
RATE_HALF_WIDTH = 0.004  # s, half the time range over which a rate is computed


@dataclass(frozen=True, eq=False)
class MissingHipTorque:
    """One trial: ``torque`` (m,) N m missing at each hip, nan without a plate; ``speed`` rad/s, ``phase``."""

    torque: Array
    speed: Array
    deflection: Array
    phase: NDArray[np.int64]


def missing_hip_torque(trial: Jump, before: ScoredJump) -> MissingHipTorque:
    """By virtual work: the missing ground force times the hips' motion per radian of the upper links, half per hip.

    The leg's own inertia is neglected: it is a hundredth of the body's.
    """
    angle = trial.measured[ANGLE]
    speed = _smoothed_rate(trial.time, angle)
    torque = np.full(len(angle), np.nan)
    if FORCE in trial.measured and not trial.leaning:
        share = (0.5 * trial.leg.hip_spacing + trial.leg.length * np.sin(angle)) / trial.leg.lower_length
        slope = np.tan(np.arcsin(np.clip(share, -0.99, 0.99)))  # the lower link nearly level
        leverage = trial.leg.length * (np.sin(angle) + np.cos(angle) * slope)
        torque = 0.5 * leverage * (trial.measured[FORCE] - before.channels[FORCE])
    return MissingHipTorque(torque, speed, angle - angle[0], _push_and_flight(speed))


def _smoothed_rate(time: Array, angle: Array) -> Array:
    width = max(1, round(RATE_HALF_WIDTH / float(np.median(np.diff(time)))))
    low = np.clip(np.arange(len(time)) - width, 0, None)
    high = np.clip(np.arange(len(time)) + width, None, len(time) - 1)
    return np.asarray((angle[high] - angle[low]) / (time[high] - time[low]))


def _push_and_flight(speed: Array) -> NDArray[np.int64]:
    """Release until the highest speed, about at takeoff, then swing; a jump is cut before it could settle or rest."""
    found = np.ones(len(speed), dtype=np.int64)
    found[: int(np.argmax(np.abs(speed))) + 1] = 0
    return found


def locate_gap(trials: Sequence[Jump], before: Sequence[ScoredJump], lacks: Sequence[MissingHipTorque]) -> Where:
    """Shares over all scored trials; equal if nothing is above the noise."""
    places = {"hip": 0.0, "base": 0.0}
    bins: dict[str, dict[str, float]] = {name: dict.fromkeys(THIRDS, 0.0) for name in
                                         ("speed", "position", "load", "time")}  # fmt: skip
    phases = dict.fromkeys(PHASES_OF_JUMP, 0.0)
    for trial, told, lack in zip(trials, before, lacks, strict=True):
        energy = np.zeros(len(trial.time))
        for name, measured in trial.measured.items():
            miss = np.nan_to_num(told.channels[name] - measured) / trial.sigma[name]
            above = miss**2 - 1.0
            places[PLACES.get(name, "base")] += trial.weight * max(float(above.sum()), 0.0)
            energy += trial.weight * above
        for index, phase in enumerate(PHASES_OF_JUMP):
            phases[phase] += float(energy[lack.phase == index].sum())
        load = trial.measured.get(FORCE, np.zeros(len(energy)))
        for key, along in (("speed", np.abs(lack.speed)), ("position", np.abs(lack.deflection)),
                           ("load", np.abs(load)), ("time", trial.time - trial.time[0])):  # fmt: skip
            third = np.minimum((3.0 * along / max(float(along.max()), 1e-12)).astype(int), 2)
            for index, name in enumerate(THIRDS):
                bins[key][name] += float(energy[third == index].sum())
    keys = ("speed", "position", "load", "time")
    at, by_phase, *rest = (
        shares([*found], np.array([*found.values()])) for found in (places, phases, *(bins[k] for k in keys))
    )
    return Where(at, dict.fromkeys(PHASES, 0.0) | by_phase, *rest)
