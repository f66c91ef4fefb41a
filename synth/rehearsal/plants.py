"""One planted case of a user's rig: a main cause of a given gap or none, small additional causes, recordings."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from synth.arrays import Array, Mask
from synth.planting.effect_makers import EFFECTS, EFFECTS_AT_BASE
from synth.planting.effect_size import PlainMotion, PlantedCause, combined
from synth.planting.forms import Form, Maker, Scale
from synth.planting.model import PlantedLeg
from synth.planting.parameter_errors import PARAMETER_ERRORS, TORQUE_ERRORS
from synth.planting.refusals import NotApplicable
from synth.planting.servo_errors import SERVO_ERRORS
from synth.planting.setup import Setup
from synth.planting.unlisted_effects import EFFECTS_ON_ALL_CHANNELS, UNLISTED_EFFECTS
from synth.rehearsal.sizes import size_of
from synth.rehearsal.users_rig import Rig

LIBRARY: dict[str, Maker] = {
    k: v for k, v in {**EFFECTS, **PARAMETER_ERRORS, **SERVO_ERRORS}.items() if k != "encoder_quantisation"
}
# Gap of a main cause relative to what is unexplained beside it (noise and the case's small causes), in steps of about
# three, the best resolution of a few draws.
RUNGS = (1.0, 3.0, 10.0, 30.0)
SMALL_CAUSES = 3  # additional causes; each has the share of the background that adds up to it in squares
POOL_SIZE = 9  # pool of additional causes from which each case draws
GAP_TOLERANCE = 0.12  # relative tolerance of a gap around its rung, well below a step
FORMS_TRIED = 10  # draws of a form that tell whether a joint can have the cause: of two forms both but once in 500
ATTEMPTS = 4  # draws of a form after which a joint counts as unable to have the cause
# Never as small causes: they change the whole motion.
NEVER_SMALL = ("joint_stop", "base_compliance", "dropped_samples")


@dataclass(frozen=True)
class PlantingTask:
    """A cause to plant: effect ("" for none), joint (-1 the base), rung of the gap; ``draw`` of the leg."""

    effect: str
    joint: int
    rung: int
    draw: int

    @property
    def name(self) -> str:
        """As a file name."""
        return f"{self.effect or 'nothing'}-{self.joint}-{self.rung}-{self.draw}"


@dataclass(frozen=True)
class Planted:
    """Readings (m, n) rad per trial, nan where missing, and the answer, hidden from the diagnosis."""

    readings: tuple[Array, ...]
    answer: Mapping[str, Any]


@dataclass
class Field:
    """The user's rig with one leg drawn within its tolerances, and its small causes, each made when first drawn.

    ``seeds`` of the leg; ``pool`` : names of small causes, of each place the first that the leg can have.
    """

    rig: Rig
    ground: PlainMotion
    seeds: tuple[int, ...]
    pool: tuple[tuple[str, ...], ...] = ()
    small: dict[int, PlantedCause | None] = field(default_factory=dict)

    @classmethod
    def of(cls, rig: Rig, seed: int, draw: int) -> Field:
        """Leg number ``draw`` of a seed, with a pool of small causes.

        Raises
        ------
        NotApplicable : the trials hardly move the leg.
        """
        seeds = (seed, draw, 0xF1E1D)
        rng = np.random.default_rng(seeds)
        ground = PlainMotion(rig.built(rng))
        if rig.background < ground.floor:  # all of them together are hidden by the noise
            return cls(rig, ground, seeds)
        names = [name for name in (*LIBRARY, *UNLISTED_EFFECTS) if name not in (*NEVER_SMALL, *TORQUE_ERRORS)]
        names = [name for name in names if rig.nominal.servos or name not in SERVO_ERRORS]
        order = rng.permutation(sorted(names)).tolist()
        return cls(rig, ground, seeds, tuple(tuple(order[k::POOL_SIZE]) for k in range(POOL_SIZE)))

    def left_by(self, beside: Sequence[PlantedCause]) -> float:
        """Rad RMS that these causes leave together, as if independent."""
        return self.ground.floor * math.hypot(*(cause.reached for cause in beside))

    def unexplained(self, beside: Sequence[PlantedCause]) -> float:
        """Rad RMS left by noise and these small causes."""
        return math.hypot(self.ground.floor, self.left_by(beside))

    def beside(self, rng: np.random.Generator, effect: str) -> list[PlantedCause]:
        """The small causes of a case, none of them the main one's ``effect``."""
        found: list[PlantedCause] = []
        for place in rng.permutation(len(self.pool)).tolist():
            cause = self._small_cause(place) if len(found) < SMALL_CAUSES else None
            if cause is not None and cause.effect != effect:
                found.append(cause)
        return found

    def _small_cause(self, place: int) -> PlantedCause | None:
        """The small cause at a place of the pool; the same whenever it is drawn."""
        if place not in self.small:
            rng = np.random.default_rng((*self.seeds, place))
            each = self.rig.background / math.sqrt(SMALL_CAUSES) / self.ground.floor
            self.small[place] = None
            for name in self.pool[place]:
                joint = int(rng.integers(0, self.rig.nominal.n))
                with contextlib.suppress(NotApplicable):
                    self.small[place] = self._cause_with_gap(rng, name, joint, each, 3.0 * GAP_TOLERANCE)
                    break
        return self.small[place]

    def _cause_with_gap(
        self, rng: np.random.Generator, effect: str, joint: int, strength: float, near: float
    ) -> PlantedCause:
        """The cause with that gap in noise floors.

        Raises
        ------
        NotApplicable : the joint cannot have it, for the reason of the last attempt.
        """
        maker = UNLISTED_EFFECTS.get(effect) or LIBRARY[effect]
        place = -1 if effect in EFFECTS_AT_BASE else -2 if effect in EFFECTS_ON_ALL_CHANNELS else joint
        reason = NotApplicable("no attempt")
        for _ in range(ATTEMPTS):
            try:
                form: Form = maker(rng, self.ground.setup, self.ground.scale, max(joint, 0))
                return self.ground.find(effect, place, form, strength, near)
            except NotApplicable as why:
                reason = why
            except (ArithmeticError, np.linalg.LinAlgError):
                reason = NotApplicable("its motion cannot be simulated")
        raise reason

    def plant(self, rng: np.random.Generator, task: PlantingTask) -> Planted:
        """The case.

        Raises
        ------
        NotApplicable : the joint cannot have such a cause, or with ``TooSmall`` none as large.
        """
        ground, main = self.ground, []
        beside = self.beside(rng, task.effect)
        if task.effect:
            strength = RUNGS[task.rung] * self.unexplained(beside) / ground.floor
            main.append(self._cause_with_gap(rng, task.effect, task.joint, strength, GAP_TOLERANCE))
        truth, sensor = combined(ground.setup, [*main, *beside])
        readings = []
        for i, (motion, trial) in enumerate(zip(ground.run(truth, sensor, every=True), self.rig.trials, strict=True)):
            assert motion is not None
            clean = sensor.read(ground.setup.true, motion, ground.times[i], trial.start, counted=False)
            missing = self._missing_samples(i)
            read = sensor.record(clean, self.rig.noise, self.rig.counts, rng, self.rig.unit_noise(rng, missing))
            readings.append(np.where(missing, np.nan, read))
        return Planted(tuple(readings), self._answer(main, beside))

    def _missing_samples(self, number: int) -> Mask:
        """(m, n) True where the user's recording has no sample; a locked joint always has one."""
        lost = self.rig.missing[number].copy()
        lost[:, list(self.rig.trials[number].locked)] = False
        return lost

    def _answer(self, main: list[PlantedCause], beside: list[PlantedCause]) -> dict[str, Any]:
        names = {-1: "base", -2: "all", **dict(enumerate(self.rig.nominal.names))}
        ground = self.ground

        def told(cause: PlantedCause) -> dict[str, Any]:
            return {
                "effect": cause.effect,
                "joint": names[cause.joint],
                "form": cause.form.name,
                "gap": cause.reached * ground.floor,
                "size": size_of(cause, ground.setup, ground.scale),
            }

        every = [told(cause) | {"numbers": _plain(cause.form.tell(cause.size))} for cause in (*main, *beside)]
        return {
            "causes": [told(cause) for cause in main],
            "small": [[cause.effect, names[cause.joint]] for cause in beside],
            "small_gap": self.left_by(beside),
            "truth": {"leg": _changes_of(self.rig.nominal, ground.setup.true), "causes": every},
        }


def _changes_of(nominal: PlantedLeg, built: PlantedLeg) -> dict[str, dict[str, dict[str, float]]]:
    """By joint and parameter, SI: the designed value and the built one, where they differ."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for j, joint in enumerate(nominal.names):
        for row, name in enumerate(nominal.rows):
            designed, made = float(nominal.values[row, j]), float(built.values[row, j])
            if made != designed:
                found.setdefault(joint, {})[name] = {"designed": designed, "built": made}
    return found


def _plain(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """For JSON, which has no infinity."""
    told = {name: value if isinstance(value, str) else float(value) for name, value in numbers.items()}
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value for name, value in told.items()
    }


def cause_places(rig: Rig, seed: int) -> list[tuple[str, int]]:
    """Every cause of the library at every joint that is free in some scored trial and can have it, in random order."""
    free = sorted({j for t in rig.trials if not t.held_out for j in range(rig.nominal.n) if j not in t.locked})
    driven = [j for j in free if any(trial.strongest(j) > 0.0 for trial in rig.trials)]
    with_drive = [servo.joint for servo in rig.nominal.servos]
    found, setup = [], rig.built(np.random.default_rng([seed, 0x5E7]))
    for effect in LIBRARY:
        joints = [-1] if effect in EFFECTS_AT_BASE else driven if effect in TORQUE_ERRORS else free
        joints = [j for j in joints if j in with_drive] if effect in SERVO_ERRORS else joints
        if effect == "latency" and len(free) < 2:
            continue  # a delay needs a second joint to be relative to
        found += [(effect, j) for j in joints if _can_act(setup, effect, j)]
    order = np.random.default_rng([seed, 0x91A]).permutation(len(found))
    return [found[i] for i in order]


def _can_act(setup: Setup, effect: str, joint: int) -> bool:
    """Whether the leg has what the cause changes at the joint (-1 the base): a spring, a damper, a motor.

    In some form, on a motion of a radian to both sides of the springs' free angles: how far a joint moves decides how
    large a cause can be, and is told of its case.
    """
    free = setup.true.of("free_angle")
    ones = np.ones(setup.true.n)
    scale, rng = Scale(2.0 * ones, ones, free - ones, free + ones, free, 1.0), np.random.default_rng(0)
    for _ in range(FORMS_TRIED):
        with contextlib.suppress(NotApplicable, ArithmeticError):
            if LIBRARY[effect](rng, setup, scale, max(joint, 0)).largest > 0.0:
                return True
    return False


def unlisted_causes(rig: Rig, rng: np.random.Generator, count: int) -> list[tuple[str, int]]:
    """``count`` causes outside every library, each at a random joint."""
    free = sorted({j for t in rig.trials if not t.held_out for j in range(rig.nominal.n) if j not in t.locked})
    names = [name for name in UNLISTED_EFFECTS if rig.nominal.n > 1 or name not in ("cable_coupling", "cross_talk")]
    return [(str(rng.choice(names)), int(rng.choice(free))) for _ in range(count)]
