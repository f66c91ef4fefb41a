"""The response of the whole leg: the difference of its motion from the wanted motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.design.settled_pose import settled_pose
from synth.swing.chain import Chain, Conditions, compiled_chain
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, static_torque


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
