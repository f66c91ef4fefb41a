"""The result of a fit, with its intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90, Estimate
from synth.fit.interval_sources import IntervalSource
from synth.fit.proposal import Proposal
from synth.fit.ridge_family import RidgeFamily
from synth.fit.static_points import JudgedPoint
from synth.motion.characteristics import Characteristics, characteristics
from synth.motion.first_state import FirstState
from synth.remarks import remarks_json
from synth.swing.chain import Conditions
from synth.swing.leg_model import Leg
from synth.units import quantity

FORMAT = "synth/fit/1"
DRIVEN = "driven: no release"


@dataclass(frozen=True)
class JointFit:
    """One joint's estimates; ``damper_rate`` is None where a torque-speed curve was given.

    ``damper`` : its law, ``linear``, ``curve`` or ``none``. ``estimated`` : False where the leg file's values are kept.
    """

    spring_rate: Estimate
    free_angle: Estimate  # measured angle
    free_angle_spread: Estimate  # standard deviation over trials
    damper_rate: Estimate | None
    damper: str = "linear"
    estimated: bool = True

    @classmethod
    def of_locked(cls) -> JointFit:
        """Where nothing is sought; what the leg file gives takes its place."""
        nothing, angle = Estimate(0.0, "N*m/rad"), Estimate(0.0, "deg")
        return cls(nothing, angle, angle, None, "none", estimated=False)

    def as_json(self) -> dict[str, Any]:
        """The joint's entry of ``fit.json``."""
        written: dict[str, Any] = {
            "spring_rate": self.spring_rate.as_json(),
            "free_angle": self.free_angle.as_json(),
            "free_angle_spread": self.free_angle_spread.as_json(),
        }
        if self.damper_rate is not None:
            written["damper_rate"] = self.damper_rate.as_json()
        else:
            written["damper"] = {"law": self.damper}
        if not self.estimated:
            written["estimated"] = False
        return written


@dataclass(frozen=True)
class StartFit:
    """A trial's initial state, in the measured angle's sense; (n,) rad and rad/s, nan for a locked joint.

    ``angle``, ``rate`` as fitted; ``recorded`` from the first samples only, with its uncertainty.
    """

    angle: Array
    rate: Array
    recorded: FirstState

    def as_json(self, joints: tuple[str, ...]) -> dict[str, Any]:
        """Fitted and recorded angle and rate by joint; the recorded ones with their 90 % intervals."""
        seen = self.recorded
        rows = (
            ("initial_angle", self.angle, None, "deg"),
            ("initial_rate", self.rate, None, "deg/s"),
            ("recorded_initial_angle", seen.angle, seen.angle_deviation, "deg"),
            ("recorded_initial_rate", seen.rate, seen.rate_deviation, "deg/s"),
        )
        written: dict[str, Any] = {}
        for key, values, deviations, unit in rows:
            written[key] = {}
            for j, name in enumerate(joints):
                if np.isfinite(values[j]):
                    half = None if deviations is None else NORMAL90 * float(deviations[j])
                    value = float(values[j])
                    interval = None if half is None else (value - half, value + half)
                    written[key][name] = quantity(value, unit, interval)
        return written

    def misfit(self) -> Array:
        """(2, n) deviation of fitted angle and rate from the recorded ones, in standard deviations of the latter."""
        seen = self.recorded
        off = [(self.angle - seen.angle) / seen.angle_deviation, (self.rate - seen.rate) / seen.rate_deviation]
        return np.abs(off)


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """The smoothed motion of a trial's free joints: ``time`` (m,) s; measured ``angle`` (m, k), ``noise`` (k,) rad.

    ``equilibrium`` (k,) rad, of the fitted leg in this trial, nan if it has none: rest of a motion that ends before.
    ``cut``: it begins after the release; ``driven``: it is no release.
    """

    joints: tuple[str, ...]
    time: Array
    angle: Array
    noise: Array
    equilibrium: Array
    cut: bool = False
    driven: bool = False

    @cached_property
    def characteristics(self) -> Mapping[str, Characteristics]:
        """Joint -> characteristics of its motion, of the recording and not of the model: they describe the data."""
        if self.driven:
            return dict.fromkeys(self.joints, Characteristics(np.nan, None, None, None, None, None, DRIVEN))
        rests = [float(rest) if np.isfinite(rest) else None for rest in self.equilibrium]
        return {
            name: characteristics(self.time, self.angle[:, k], float(self.noise[k]), equilibrium=rests[k], cut=self.cut)
            for k, name in enumerate(self.joints)
        }


@dataclass(frozen=True)
class TrialFit:
    """One trial and its fit, measured angles in rad.

    ``time`` (m,) s; ``measured`` (m, n) with nan where no sample counted; ``fitted`` (m, n); ``rms`` (n,) rad, nan for
    a locked joint; ``free_angle`` (n,) rad in this trial; ``rotation`` and ``rate`` (n,), initial state in q;
    ``start`` : fitted and recorded initial state in the measured angle's sense.
    """

    name: str
    time: Array
    measured: Array
    fitted: Array
    rms: Array
    free_angle: Array
    rotation: Array
    rate: Array
    start: StartFit
    motion: RecordedMotion
    held_out: bool = False
    conditions: Conditions = field(default_factory=Conditions)
    driven_by: tuple[str, ...] = ()  # "a known torque", "a servo"

    @property
    def characteristics(self) -> Mapping[str, Characteristics]:
        """Joint -> characteristics of its recorded motion."""
        return self.motion.characteristics

    def begun_late(self) -> TrialFit:
        """The same trial, known to begin after its release."""
        return self if self.motion.cut else replace(self, motion=replace(self.motion, cut=True))

    def as_json(self, joints: tuple[str, ...]) -> dict[str, Any]:
        """The trial's entry of ``fit.json``."""

        def by_joint(values: Array, unit: str) -> dict[str, Any]:
            return {name: quantity(float(v), unit) for name, v in zip(joints, values, strict=True) if v == v}

        written: dict[str, Any] = {"file": self.name, "held_out": self.held_out, "rms": by_joint(self.rms, "deg")}
        written["free_angle"] = by_joint(self.free_angle, "deg")
        written |= self.conditions.as_json(joints)
        written |= {"driven_by": list(self.driven_by)} if self.driven_by else {}
        written |= {"start_cut": True} if self.motion.cut else {}
        written |= self.start.as_json(joints)
        for key, unit in (
            ("rise_time", "s"),
            ("damping_ratio", "1"),
            ("damped_frequency", "rad/s"),
            ("overshoot", "1"),
            ("settling_time", "s"),
        ):
            found = {name: getattr(c, key) for name, c in self.characteristics.items()}
            written[key] = {name: quantity(value, unit) for name, value in found.items() if value is not None}
        written["damping_ratio_validity"] = {name: c.validity for name, c in self.characteristics.items()}
        return written


@dataclass(frozen=True)
class Variant:
    """Estimates under one treatment of the free angle, for comparison."""

    free_angle: str
    spring_rate: Mapping[str, Estimate]
    damper_rate: Mapping[str, Estimate]
    rms: Mapping[str, float]
    spread: Mapping[str, float]

    def as_json(self) -> dict[str, Any]:
        """Rates, RMS and spread by joint."""
        return {
            "free_angle": self.free_angle,
            "spring_rate": {name: estimate.as_json() for name, estimate in self.spring_rate.items()},
            "damper_rate": {name: estimate.as_json() for name, estimate in self.damper_rate.items()},
            "rms": {name: quantity(value, "deg") for name, value in self.rms.items()},
            "free_angle_spread": {name: quantity(value, "deg") for name, value in self.spread.items()},
        }


@dataclass(frozen=True)
class FitResult:
    """A fitted leg; ``leg`` has the estimated springs and dampers.

    By joint, over all counted samples of the fitted trials: ``rms`` rad, the plain root mean square; ``clipped_rms``
    rad, with residuals truncated at six robust standard deviations, from which the fit estimates its noise. Of thinned
    recordings ``rms`` and ``noise`` are of the samples as recorded, ``clipped_rms`` of their means, which were fitted.
    """

    leg: Leg
    joints: Mapping[str, JointFit]
    rms: Mapping[str, float]
    clipped_rms: Mapping[str, float]
    trials: tuple[TrialFit, ...] = field(repr=False)
    free_angle: str  # common or per_trial
    free_angle_why: str
    variants: tuple[Variant, ...]
    noise: Mapping[str, float]
    not_separable: tuple[str, ...]
    warnings: tuple[str, ...]
    method: str
    iterations: int
    reason: str
    lost_samples: int
    inputs: Mapping[str, str] = field(default_factory=dict)
    cost: str = "trajectory"
    static: tuple[JudgedPoint, ...] = ()  # the static points and their fit
    proposals: tuple[Proposal, ...] = ()  # measurements that would determine what is open
    families: tuple[RidgeFamily, ...] = ()  # of joints whose spring and damper rate are not separable
    drawn: Sequence[Leg] = field(default=(), repr=False)  # consistent with the trials, for choices that depend on them
    intervals: Mapping[str, Any] = field(default_factory=lambda: {"by": "sensitivities"})
    sources: tuple[IntervalSource, ...] = ()  # contributions to each interval
    tolerance: Mapping[str, Any] = field(default_factory=dict)  # of the links, from the project and its defaults
    cut: float = 0.0  # s after each recording's first sample, start of the fit
    defaults: tuple[Mapping[str, str], ...] = ()  # values that the project omits
    wanted: Mapping[str, Any] = field(default_factory=dict)  # characteristics given instead of recordings
    law: Mapping[str, Any] = field(default_factory=dict)  # of the leg, beside springs and linear dampers
    at_bound: tuple[str, ...] = ()  # estimates at a bound of the search or near it, such as "spring_rate hip"

    def __post_init__(self) -> None:
        """Where the fit begins after the release, the trials know it: what needs the start is not measured."""
        if self.cut:
            object.__setattr__(self, "trials", tuple(trial.begun_late() for trial in self.trials))

    @property
    def averaged_rms(self) -> Mapping[str, float]:
        """As ``rms`` of the angles that were fitted, the means of samples of thinned recordings; nan without any."""
        off = np.concatenate([trial.measured - trial.fitted for trial in self.trials if not trial.held_out])
        known = np.isfinite(off)
        square = np.where(known, off, 0.0) ** 2
        rms = np.sqrt(np.where(known.any(axis=0), square.sum(axis=0), np.nan) / np.maximum(known.sum(axis=0), 1))
        return dict(zip(self.leg.joint_names, rms.tolist(), strict=True))

    def as_json(self) -> dict[str, Any]:
        """The content of ``fit.json``."""
        names = self.leg.joint_names
        static = [
            {
                "point": item.balance.name,
                "joint": names[item.balance.joint],
                "spring_torque": {
                    "measured": quantity(item.balance.torque, "N*m"),
                    "fitted": quantity(item.fitted, "N*m"),
                },
                "deviations": item.deviations,
                **({"left_out": True} if item.left_out else {}),
            }
            for item in self.static
        ]
        return {
            "format": FORMAT,
            "joints": {name: joint.as_json() for name, joint in self.joints.items()},
            "rms": {name: quantity(value, "deg") for name, value in self.rms.items()},
            "clipped_rms": {name: quantity(value, "deg") for name, value in self.clipped_rms.items()},
            "free_angle": {
                "mode": self.free_angle,
                "why": self.free_angle_why,
                "variants": [variant.as_json() for variant in self.variants],
            },
            "noise": {name: quantity(value, "deg") for name, value in self.noise.items()},
            "not_separable": list(self.not_separable),
            "families": [family.as_json() for family in self.families],
            "proposals": [proposal.as_json() for proposal in self.proposals],
            "static": static,
            "intervals": dict(self.intervals),
            "interval_sources": [source.as_json() for source in self.sources],
            "tolerance": dict(self.tolerance),
            "fitted_from": quantity(self.cut, "s"),
            "defaults": [dict(default) for default in self.defaults],
            **remarks_json(self.warnings),
            "method": self.method,
            "cost": self.cost,
            "iterations": self.iterations,
            "reason": self.reason,
            "lost_samples": self.lost_samples,
            **({"wanted": dict(self.wanted)} if self.wanted else {}),
            **({"law": dict(self.law)} if self.law else {}),
            "trials": [trial.as_json(names) for trial in self.trials],
            "inputs": dict(self.inputs),
        }
