"""A motion from wanted characteristics: the springs and dampers with which the whole leg's release shows them.

Every joint alone is first assumed to be a damped oscillator of the wanted frequency and damping ratio (Inman,
*Engineering
Vibration*, 4th ed., section 1.3). Springs and dampers of the coupled leg are then moved until the release of the whole
leg shows the wanted characteristics, evaluated as for a recording.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import CannotBeHad, Problem
from synth.files.projects import FitProject, LegProject
from synth.files.trial_list import Trial
from synth.files.wanted_section import WantedCharacteristics
from synth.motion.characteristics import characteristics
from synth.motion.rest import last_tenth
from synth.swing.chain import Chain, compiled_chain
from synth.swing.leg_model import Damper, Leg, Spring
from synth.swing.mechanics import coefficients, mass_matrix, static_torque
from synth.units import quantity

KEYS = {"damping_ratio": "1", "damped_frequency": "rad/s", "rise_time": "s"}
ENVELOPE_DECAY = 9.0  # of the slowest joint's envelope, exp(-9) or a ten-thousandth remains at the end of the motion
SAMPLES_A_SWING = 100  # samples per period of the fastest joint
MOST_SAMPLES = 4000  # of the motion, if one joint is far slower than another
FINE_TOLERANCE = 1e-8  # the integrator's tolerance, far below the steps of the simplex
# weight of a logarithm's change that no characteristic determines (overdamped: one for two unknowns)
CHANGE_WEIGHT = 0.003
UNREPORTED_MISS = 0.02  # relative deviation of a characteristic that is not reported
REFUSED_MISS = 0.25  # relative deviation above which the request is refused
LEAST_SWING = 0.05  # of the amplitude: smaller swings are coupled from other joints
ABSENT_LOGARITHM = 2.0  # logarithm for a characteristic that the motion does not show: a factor of e^2
SIZES = (0.2, -0.3, 0.4, -0.15, 0.6)  # of the first simplex in logarithms; restarted until the request is met
EVALUATIONS = 150  # simulations per unknown of one simplex, a choice: ``LARGEST_MISS`` ends it earlier
LARGEST_MISS = 0.01  # largest relative deviation of a characteristic for the search to end


@dataclass(frozen=True)
class WantedMotion:
    """The leg with the characteristics, its release as a trial, and its actual characteristics, joint by joint."""

    leg: Leg
    trial: Trial
    asked: Mapping[str, WantedCharacteristics]
    shown: Mapping[str, Mapping[str, float]]

    @property
    def messages(self) -> tuple[str, ...]:
        """A sentence on each characteristic that differs from the request."""
        found = []
        for name, key, asked, shown in _pairs(self.asked, self.shown):
            if abs(shown / asked - 1.0) > UNREPORTED_MISS:
                words = key.replace("_", " ")
                text = f"wanted: {name}: a {words} of {_text(asked, key)} is wanted, {_text(shown, key)} results; "
                found.append(f"{text}the links are coupled")
        return tuple(found)

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
                "shown": {key: quantity(value, KEYS[key]) for key, value in shown.items()},
                "rest": quantity(asked.rest, "deg"),
                "amplitude": quantity(asked.amplitude, "deg"),
                "spring_rate": quantity(joint.spring.rate, "N*m/rad"),
                "damper_rate": quantity(joint.damper.rate, "N*m*s/rad"),
            }
        return found


def _pairs(
    asked: Mapping[str, WantedCharacteristics], shown: Mapping[str, Mapping[str, float]]
) -> list[tuple[str, str, float, float]]:
    """Joint, characteristic, wanted and actual value, if both are numbers."""
    return [
        (name, key, value, shown[name][key])
        for name, joint in asked.items()
        for key in KEYS
        if (value := getattr(joint, key)) is not None and key in shown[name]
    ]


def _text(value: float, key: str) -> str:
    unit = KEYS[key]
    return f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"


def rise_of(ratio: float) -> float:
    """10-90 % rise time of an oscillator released at rest, times its natural frequency."""
    # Before the first half period ends: later the motion returns through the level.
    last = min(10.0, np.pi / np.sqrt(1 - ratio**2)) if ratio < 1 else 10.0 * (1 + ratio)
    from scipy.optimize import brentq  # imported here: it takes 0.1 s, and few fits state a wanted motion

    ends = [brentq(lambda t, level=level: _fall(ratio, t) - level, 0.0, last) for level in (0.9, 0.1)]
    return float(ends[1] - ends[0])


def _fall(ratio: float, time: float | Array) -> Any:
    """From 1 at rest to 0, of an oscillator of natural frequency 1."""
    if abs(ratio - 1.0) < 1e-6:  # critical damping: the general formula divides by zero
        return (1.0 + time) * np.exp(-time)
    root = np.sqrt(complex(ratio**2 - 1.0))
    slow, fast = -ratio + root, -ratio - root
    return ((slow * np.exp(fast * time) - fast * np.exp(slow * time)) / (slow - fast)).real


def natural_frequency(joint: WantedCharacteristics) -> float:
    """Of the oscillator with the wanted characteristics, rad/s; a given damped frequency takes precedence."""
    if joint.damped_frequency is not None:
        return joint.damped_frequency / float(np.sqrt(1.0 - joint.damping_ratio**2))
    assert joint.rise_time is not None
    return rise_of(joint.damping_ratio) / joint.rise_time


def wanted_motion(leg: Leg, asked: Mapping[str, WantedCharacteristics]) -> WantedMotion:
    """The springs and dampers with which a release of ``leg`` has the wanted characteristics, and that release.

    Raises
    ------
    CannotBeHad : the nearest motion of this leg differs by more than a quarter in a characteristic.
    """
    from scipy.optimize import minimize  # imported here, like ``brentq``

    task = _Task.of(leg, asked)
    # Characteristics jump when one more swing is counted, so the derivative-free Nelder-Mead simplex is used.
    found = np.zeros(task.n)
    for size in SIZES:
        simplex = found + np.vstack([np.zeros(task.n), size * np.eye(task.n)])
        options = {"initial_simplex": simplex, "maxfev": EVALUATIONS * task.n, "xatol": 1e-5, "fatol": 1e-9}
        found = np.asarray(minimize(task.misfit, found, method="Nelder-Mead", options=options).x)  # type: ignore[call-overload]
        if task.worst(found) < LARGEST_MISS:
            break
    shown = task.shown(found)
    result = WantedMotion(task.leg_of(found), task.trial(found), asked, shown)
    _refuse_far(result, task)
    return result


def _refuse_far(found: WantedMotion, task: _Task) -> None:
    """Raise if the nearest motion differs too much from the request."""
    problems = []
    for name, joint in found.asked.items():
        shown = found.shown[name]
        missed = [
            key for key in KEYS if getattr(joint, key) is not None and key not in shown and joint.damping_ratio < 1
        ]
        far = [
            f"a {key.replace('_', ' ')} of {_text(asked, key)} (nearest {_text(value, key)})"
            for where, key, asked, value in _pairs(found.asked, found.shown)
            if where == name and abs(value / asked - 1.0) > REFUSED_MISS
        ]
        far += [f"a {key.replace('_', ' ')} (the nearest motion shows none)" for key in missed]
        if far:
            text = f"{name}: this leg cannot move with {', '.join(far)}{task.why(name)}"
            problems.append(Problem(text, key=f"wanted.{name}"))
    if problems:
        raise CannotBeHad(problems)


@dataclass(frozen=True)
class _Task:
    """Unknowns (2 n,): logarithms of spring and damper rates over ``spring`` and ``damper`` (n,), the start."""

    leg: Leg
    asked: Mapping[str, WantedCharacteristics]
    chain: Chain
    time: Array
    spring: Array
    damper: Array
    gravity: Array  # (n,) N m/rad, gravity's stiffness at rest

    @property
    def n(self) -> int:
        """Unknowns."""
        return 2 * len(self.spring)

    @classmethod
    def of(cls, leg: Leg, asked: Mapping[str, WantedCharacteristics]) -> _Task:
        joints = [asked[name] for name in leg.joint_names]
        natural = np.array([natural_frequency(joint) for joint in joints])
        ratio = np.array([joint.damping_ratio for joint in joints])
        slowest = np.where(ratio < 1, ratio, ratio - np.sqrt(np.maximum(ratio**2 - 1, 0.0))) * natural
        step = 2 * np.pi / (natural.max() * SAMPLES_A_SWING)
        count = int(min(MOST_SAMPLES, np.ceil(ENVELOPE_DECAY / (slowest.min() * step)))) + 1
        time = np.linspace(0.0, ENVELOPE_DECAY / slowest.min(), count)
        pose = leg.to_rotation(np.array([joint.rest for joint in joints]))
        coefficient = coefficients(leg)
        inertia = np.diag(mass_matrix(coefficient, pose, leg.tilt))
        weight = coefficient.gravity * np.cos(leg.tilt + np.cumsum(pose))
        gravity = np.cumsum(weight[::-1])[::-1]
        whole = inertia * natural**2
        # A fiftieth: a start needs a positive rate where gravity alone is stiffer than wanted.
        spring = np.maximum(whole - gravity, 0.02 * whole)
        return cls(leg, asked, compiled_chain(len(joints)), time, spring, 2 * ratio * natural * inertia, gravity)

    def leg_of(self, x: Array) -> Leg:
        """The leg with these rates, with the wanted rest pose."""
        n = len(self.spring)
        k, b = self.spring * np.exp(x[:n]), self.damper * np.exp(x[n:])
        rest = np.array([self.asked[name].rest for name in self.leg.joint_names])
        pose = self.leg.to_rotation(rest)
        free = self.leg.to_measured(pose + static_torque(coefficients(self.leg), pose, self.leg.tilt) / k)
        changes = {
            joint.name: {"spring": Spring(float(k[j]), float(free[j])), "damper": Damper(float(b[j]))}
            for j, joint in enumerate(self.leg.joints)
        }
        return self.leg.with_joints(**changes)

    def motion(self, x: Array) -> Array:
        """(m, n) rad, measured, of the release; nan if the simulation fails."""
        leg, layout = self.leg_of(x), self.chain.layout
        lanes = self.chain.parameters(leg)[:, None]
        lanes[layout.rows("rotation")] = leg.to_rotation(
            np.array([each.rest + each.amplitude for each in self.asked.values()])
        )[:, None]
        return np.asarray(leg.to_measured(self.chain.run(lanes, self.time, FINE_TOLERANCE)[:, :, 0]))

    def shown(self, x: Array) -> dict[str, dict[str, float]]:
        """The characteristics of the release, evaluated as for a recording."""
        motion, found = self.motion(x), {}
        if not np.isfinite(motion).all():
            return {name: {} for name in self.leg.joint_names}
        for j, name in enumerate(self.leg.joint_names):
            least = LEAST_SWING * abs(self.asked[name].amplitude) / 3.0  # peaks count from three times this
            seen = characteristics(self.time, motion[:, j], least, rest=last_tenth(motion[:, j]))
            found[name] = {key: value for key in KEYS if (value := getattr(seen, key)) is not None}
        return found

    def misfit(self, x: Array) -> float:
        """Squared logarithms of actual over wanted, plus a weak penalty on the distance from the start."""
        off = self._logarithms(x)
        return float(off @ off + CHANGE_WEIGHT**2 * (x @ x))

    def worst(self, x: Array) -> float:
        """Largest logarithm of actual over wanted."""
        return float(np.abs(self._logarithms(x)).max())

    def _logarithms(self, x: Array) -> Array:
        shown, found = self.shown(x), []
        for name, joint in self.asked.items():
            for key in KEYS:
                asked = getattr(joint, key)
                if asked is None or (key == "damping_ratio" and asked >= 1):
                    continue  # an overdamped joint shows no decrement
                value = shown[name].get(key)
                found.append(ABSENT_LOGARITHM if value is None else np.log(value / asked))
        return np.array(found)

    def trial(self, x: Array) -> Trial:
        """The release as a recording without noise."""
        angles = self.motion(x)
        digest = sha256(np.round(np.column_stack([self.time, angles]), 9).tobytes()).hexdigest()
        return Trial("wanted characteristics", self.time, angles, sha256=digest)

    def why(self, name: str) -> str:
        """The reason, if gravity prevents it."""
        joint, j = self.asked[name], self.leg.joint_names.index(name)
        inertia = np.diag(
            mass_matrix(
                coefficients(self.leg),
                self.leg.to_rotation(np.array([each.rest for each in self.asked.values()])),
                self.leg.tilt,
            )
        )[j]
        if self.gravity[j] <= inertia * natural_frequency(joint) ** 2:
            return ""
        alone = float(np.sqrt(self.gravity[j] / inertia)) / (2 * np.pi)
        return f". Gravity alone swings it at {alone:.2g} Hz, and no spring makes that slower"


def with_wanted_fit(project: FitProject) -> tuple[FitProject, WantedMotion | None]:
    """The project with the wanted motion as its trial, if it states one."""
    if not project.wanted:
        return project, None
    found = wanted_motion(project.leg, project.wanted)
    return replace(project, trials=(found.trial,), release="recorded"), found


def with_wanted_leg(project: LegProject) -> LegProject:
    """The same for a leg-design; the characteristics belong to its source."""
    if not project.wanted:
        return project
    found = wanted_motion(project.source, project.wanted)
    return replace(
        project,
        trials=(found.trial,),
        release="recorded",
        wanted_shown=found.as_json(),
        messages=found.messages,
        wanted={},
    )
