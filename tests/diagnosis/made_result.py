"""A diagnosis made up for the tests of its files and pages: a robot leg whose knee has dry friction, simulated.

The motions are real (simulated with the friction and without), the verdict and its probabilities are written down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fit.simulated_legs import FREE_ANGLE, RELEASES, SPRING, robot
from synth.diagnosis.diagnosis_result import Cause, Experiment, RankedCause, Where
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult, TrialGap
from synth.diagnosis.remainder import Remainder
from synth.estimation.intervals import Estimate
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg
from synth.units import quantity

FRICTION = 0.05  # N m, at the knee
NOISE = np.radians(0.1)


def with_friction(leg: Leg, torque: float) -> Leg:
    """The leg with dry friction at its second joint."""
    name = leg.joint_names[1]
    return leg.with_joints(**{name: {"effects": {"coulomb_friction": {"torque": torque}}}})


def made_trial(
    name: str, nominal: Leg, away: Sequence[float], held_out: bool, generator: np.random.Generator
) -> TrialGap:
    """One release: measured with the friction, beside the nominal leg and the leg with nearly that friction."""
    time = np.arange(121) * 0.01
    pose = nominal.to_rotation(np.radians(FREE_ANGLE + np.array(away)))
    still = np.zeros(3)
    true = simulate(with_friction(nominal, FRICTION), pose, still, time, rates=True)
    read = nominal.to_measured(true[:, :3]) + generator.normal(0.0, NOISE, (len(time), 3))
    before = nominal.to_measured(simulate(nominal, pose, still, time))
    after = nominal.to_measured(simulate(with_friction(nominal, 0.96 * FRICTION), pose, still, time))
    missing = generator.normal(0.0, 0.004, (len(time), 3)) * SPRING
    missing[:, 1] -= FRICTION * np.tanh(true[:, 4] / 0.05)
    speed = nominal.sign * true[:, 3:]
    deflection = read - np.radians(FREE_ANGLE)
    phase = np.digitize(time, [0.08, 0.5, 0.9]).astype(float)
    designed = before + np.radians([0.3, -0.4, 0.2])
    return TrialGap(
        name, time, read, designed, before, after, missing, speed, deflection, phase, held_out, scored=held_out
    )


def thirds(low: float, middle: float) -> dict[str, float]:
    """Shares of three bins."""
    return {"low": low, "middle": middle, "high": 1.0 - low - middle}


def cause(effect: str, joint: str, **values: tuple[float, str, float]) -> Cause:
    """A cause with its parameters as (value, unit, half width of the interval), SI."""
    parameters = {name: Estimate(v, unit, v - half, v + half) for name, (v, unit, half) in values.items()}
    return Cause(effect, joint, parameters)


def share(value: float, half: float) -> Estimate:
    """A shrink."""
    return Estimate(value, "1", value - half, value + half)


def angle(degrees: float, half: float) -> Estimate:
    """An angle with its interval, from degrees."""
    return Estimate(np.radians(degrees), "deg", np.radians(degrees - half), np.radians(degrees + half))


def error(trials: Sequence[TrialGap], stage: str) -> float:
    """RMS angle error of a stage over the scored trials, deg."""
    values = [getattr(trial, stage) - trial.measured for trial in trials if trial.scored]
    return float(np.degrees(np.sqrt(np.mean(np.concatenate(values) ** 2))))


def made_result(verdict: Any = "effect", names: tuple[str, ...] | None = None) -> GapResult:
    """The whole diagnosis; ``names`` of the three joints."""
    nominal = robot()
    if names is not None:
        joints = tuple(replace(joint, name=name) for joint, name in zip(nominal.joints, names, strict=True))
        nominal = replace(nominal, joints=joints)
    hip, knee, ankle = nominal.joint_names
    generator = np.random.default_rng(4)
    trials = tuple(
        made_trial(f"trials/{'check' if k > 4 else 'free'}_{k + 1}.csv", nominal, away, k > 4, generator)
        for k, away in enumerate(RELEASES)
    )
    friction = cause("coulomb_friction", knee, torque=(0.048, "N*m", 0.004))
    stribeck = cause("stribeck_friction", knee, torque=(0.05, "N*m", 0.01), extra=(0.01, "N*m", 0.02))
    ranked = (
        RankedCause(friction, 0.86, share(0.93, 0.04)),
        RankedCause(stribeck, 0.07, share(0.92, 0.05)),
        RankedCause(cause("backlash", knee, width=(np.radians(0.8), "deg", np.radians(0.5))), 0.02, share(0.41, 0.2)),
        RankedCause(cause("load_friction", ankle, ratio=(0.01, "1", 0.02)), 0.01, share(0.05, 0.1)),
    )
    return GapResult(
        leg=nominal,
        verdict=verdict,
        sentence=f"The {knee} has dry friction of 0.048 N·m, 86 %; with it the error on unseen releases falls from "
        f"{error(trials, 'before'):.1f}° to {error(trials, 'after'):.2f}°, noise 0.10°.",
        explanation=() if verdict == "none" else (friction,),
        ranked=ranked,
        probability_none=0.01,
        probability_unknown=0.03,
        scored_by="held_out",
        within_accuracy=False,
        where=Where(
            joint={hip: 0.03, knee: 0.89, ankle: 0.08},
            phase={"release": 0.07, "swing": 0.28, "settle": 0.5, "rest": 0.15},
            speed=thirds(0.61, 0.24),
            position=thirds(0.4, 0.35),
            load=thirds(0.33, 0.34),
            time=thirds(0.12, 0.4),
        ),
        remainder=Remainder(
            angle(0.31, 0.05),
            0.13,
            0.2 if verdict == "none" else 3.1,
            {hip: 0.1, knee: 0.7, ankle: 0.2},
            {"release": 0.6, "swing": 0.2, "settle": 0.1, "rest": 0.1},
        ),
        as_designed=angle(error(trials, "as_designed"), 0.15),
        before=angle(error(trials, "before"), 0.12),
        after=angle(error(trials, "after"), 0.01),
        noise_floor=angle(0.1, 0.003),
        shrink=share(0.93, 0.04),
        best_possible=angle(error(trials, "after") * 0.99, 0.01),
        noise=dict.fromkeys(nominal.joint_names, NOISE),
        scored_on=tuple(trial.name for trial in trials if trial.scored),
        trials=trials,
        next_experiment=Experiment(
            f"a slow ramp of the {knee} separates dry friction that is constant from one that falls with speed",
            {"locked": [hip], "tip_mass": "50 g"},
            {hip: np.radians(105.0), knee: np.radians(150.0), ankle: np.radians(139.0)},
            0.61,
            (("a larger release", 0.32), (f"the {hip} locked", 0.48), ("the base tilted by 20 deg", 0.11)),
        ),
        diagnosed=with_friction(nominal, 0.048) if verdict == "effect" else nominal,
        warnings=("trials/free_2.csv is a copy of trials/free_1.csv; it counts once",),
        tied=((friction,), (stribeck,)) if verdict == "tie" else (),
    )


def in_degrees(value: float) -> dict[str, Any]:
    """An angle as result files hold it."""
    return quantity(value, "deg")
