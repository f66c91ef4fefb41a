"""The response of the whole leg: the difference of its motion from the wanted motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.design.settled_pose import settled_pose
from synth.fit.recordings import Recording
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.unknowns import SpringsAndDampers
from synth.swing.chain import Chain, Conditions, compiled_chain
from synth.swing.leg_model import Leg, Spring
from synth.swing.mechanics import coefficients, static_torque

TUNING_STEPS = 8  # Gauss-Newton steps at most; a gain below ``TUNED`` ends them earlier
TUNED_RELEASES = 7  # approximate number of releases that suffice to tune a spring; errors are computed over all
TUNED = 0.02  # relative reduction of the squared error below which the steps end


@dataclass(frozen=True)
class WantedRelease:
    """One release: times (m,) s, initial rotation (n,) rad and rate (n,) rad/s, and the state of the trial's leg."""

    name: str
    time: Array
    rotation: Array
    rate: Array
    conditions: Conditions


@dataclass(frozen=True)
class WantedResponse:
    """The wanted leg's motion (m, n) rad from each release; errors count free joints only."""

    leg: Leg
    releases: tuple[WantedRelease, ...]
    motions: tuple[Array, ...]
    chain: Chain

    @classmethod
    def of(cls, leg: Leg, releases: Sequence[WantedRelease]) -> WantedResponse:
        """Simulate the wanted leg from each release."""
        chain = compiled_chain(len(leg.joints))
        made = cls(leg, tuple(releases), (), chain)
        return replace(made, motions=tuple(motion[:, :, 0] for motion in made.simulate([leg])))

    @cached_property
    def rest_pose(self) -> Array:
        """(n,) rad, in which the wanted leg comes to rest."""
        return self.settled(self.leg, self.motions)

    def settled(self, leg: Leg, motions: Sequence[Array]) -> Array:
        """(n,) rad, in which a leg comes to rest that moves so from each release; see ``settled_pose``."""
        return settled_pose(leg, motions, [release.conditions.locked for release in self.releases])

    def simulate(self, legs: Sequence[Leg]) -> list[Array]:
        """(m, n, n_leg) rad for each release; nan where the simulation of a leg fails."""
        layout = self.chain.layout
        out = []
        for release in self.releases:
            lanes = np.stack([self.chain.parameters(leg, release.conditions) for leg in legs], axis=1)
            lanes[layout.rows("rotation")] = release.rotation[:, None]
            lanes[layout.rows("rate")] = release.rate[:, None]
            out.append(self.chain.run(lanes, release.time, 1e-6))
        return out

    def errors(self, legs: Sequence[Leg]) -> Array:
        """(n_leg, n) rad, RMS difference of each joint from the wanted motion over all releases in which it is free."""
        square, count = np.zeros((len(legs), len(self.leg.joints))), np.zeros(len(self.leg.joints))
        for release, motion, wanted in zip(self.releases, self.simulate(legs), self.motions, strict=True):
            free = [j for j in range(len(self.leg.joints)) if j not in release.conditions.locked]
            square[:, free] += np.sum((motion[:, free] - wanted[:, free, None]) ** 2, axis=0).T
            count[free] += len(wanted)
        error = np.sqrt(square / np.maximum(count, 1))
        return np.where(np.isfinite(error), error, np.pi)

    def overall(self, legs: Sequence[Leg]) -> Array:
        """(n_leg,) rad, RMS over joints of ``errors``."""
        return np.asarray(np.sqrt(np.mean(self.errors(legs) ** 2, axis=1)))

    def at_rest_like_wanted(self, leg: Leg) -> Leg:
        """The leg with free angles changed so that its rest pose is the wanted leg's, for its own spring rates."""
        pose = self.rest_pose
        torque = static_torque(coefficients(leg), pose, leg.tilt)
        joints = []
        for joint, angle, needed in zip(leg.joints, pose, torque, strict=True):
            assert joint.spring is not None
            rest = float(angle + needed / joint.spring.rate)
            joints.append(replace(joint, spring=replace(joint.spring, free_angle=joint.zero + joint.sign * rest)))
        return replace(leg, joints=tuple(joints))

    def tuned(self, leg: Leg, joints: Sequence[int]) -> Leg:
        """The leg with the spring rates and free angles of ``joints`` tuned to the wanted motion.

        Gauss-Newton with step halving on the simulated motions. Used to rank dampers, each with the spring tuned to it.
        """
        unknowns = SpringsAndDampers(self.chain, leg, tuple(joints), tuple(joints), ())
        model = TrajectoryModel(self.chain, leg, unknowns)
        values = unknowns.pack(leg.spring_rate, leg.rest, np.zeros(len(leg.joints)))
        residual, jacobian = self._linearised(model, values)
        for _ in range(TUNING_STEPS):
            step = _step(jacobian, residual)
            if step is None:
                break  # the leg is unchanged: its motion does not determine a step
            for halving in range(3):
                moved = np.clip(values + step * 0.5**halving, unknowns.lower, unknowns.upper)
                new_residual, new_jacobian = self._linearised(model, moved)
                if new_residual @ new_residual < residual @ residual:
                    break
            else:
                break
            gain = 1 - (new_residual @ new_residual) / (residual @ residual)
            values, residual, jacobian = moved, new_residual, new_jacobian
            if gain < TUNED:
                break
        natural = unknowns.natural(values)
        changed = list(leg.joints)
        for place, j in enumerate(joints):
            rest = float(natural[len(joints) + place])
            joint = leg.joints[j]
            changed[j] = replace(joint, spring=Spring(float(natural[place]), joint.zero + joint.sign * rest))
        return replace(leg, joints=tuple(changed))

    def _linearised(self, model: TrajectoryModel, values: Array) -> tuple[Array, Array]:
        """Residuals from the wanted motion and their Jacobian, over at most about ``TUNED_RELEASES`` releases."""
        every = max(1, len(self.releases) // TUNED_RELEASES)
        releases, motions = self.releases[::every], self.motions[::every]
        residuals, jacobians = [], []
        locals_ = [Local(r.rotation, r.rate, np.zeros_like(r.rate)) for r in releases]
        found = model.evaluate_all([_as_recording(r) for r in releases], values, locals_)
        for evaluation, wanted in zip(found, motions, strict=True):
            assert evaluation.common is not None
            difference = np.nan_to_num(evaluation.prediction - wanted, nan=np.pi)
            residuals.append(difference.ravel())
            jacobians.append(np.nan_to_num(evaluation.common).reshape(-1, len(values)))
        return np.concatenate(residuals), np.concatenate(jacobians)


def _step(jacobian: Array, residual: Array) -> Array | None:
    """Damped Gauss-Newton step (n_unknown,); None if the motion does not determine one.

    The derivatives of a diverging motion are so large that their squares overflow.
    """
    with np.errstate(all="ignore"):
        normal, side = jacobian.T @ jacobian, jacobian.T @ residual
    if not (np.all(np.isfinite(normal)) and np.all(np.isfinite(side))):
        return None
    damped = normal + np.diag(1e-4 * np.diag(normal) + 1e-12)
    try:
        # A logarithm of at most 0.7, a factor of two: beyond it the linearisation is invalid.
        return np.asarray(np.clip(-np.linalg.solve(damped, side), -0.7, 0.7))
    except np.linalg.LinAlgError:
        return None


def _as_recording(release: WantedRelease) -> Recording:
    """A release in the form that the trajectory model takes; its samples are not used."""
    from synth.motion.smoothing import Smoothed

    empty = np.zeros((len(release.time), len(release.rotation)))
    smoothed = Smoothed(release.time, empty, empty, empty[0], np.zeros(len(release.time), dtype=bool))
    return Recording(release.name, release.time, empty, empty > 0, release.conditions, smoothed)
