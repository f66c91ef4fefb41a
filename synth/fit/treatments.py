"""Treatments of the free angle, common to all trials or with a spread over them, and their fits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.fit.least_squares import Solution, Stage
from synth.fit.model_error import ModelError
from synth.fit.point_check import LeftOutPoint
from synth.fit.recordings import Recording
from synth.fit.stated_knowledge import StatedKnowledge
from synth.fit.unknowns import SpringsAndDampers
from synth.remarks import Remark, at_joint


@dataclass(frozen=True)
class Treatment:
    """One treatment of the free angle: its stage, and the spread (n,) rad over trials that it allows.

    ``ends`` (2, n) rad of the spread's 90 % interval, nan where there is none; None for none at all.
    ``of_mean`` (n,) rad^2, see ``free_angle.Heterogeneity.excess``; None for none.
    """

    stage: Stage
    spread: Array
    ends: Array | None = None
    of_mean: Array | None = None

    def excess(self, unknowns: SpringsAndDampers, covariance: Array) -> Array:
        """(p, p) to add to the unknowns' ``covariance`` (p, p), because the spread of their free angles is estimated.

        It is of the trials' mean free angle. Static points hold the estimates against it, and a rate that they
        determine by it follows: with their information B and the covariance C, the estimates move by I - C B.
        """
        added = np.zeros(len(unknowns.names))
        if self.of_mean is not None:
            for j in unknowns.rests:
                added[unknowns.rest_at(j)] = self.of_mean[j]
        beside = unknowns.measured(self.stage.solution.values, self.stage.weights.points)
        if beside is None:
            return np.diag(added)
        moved = np.eye(len(added)) - covariance @ beside[2]
        return np.asarray(moved @ np.diag(added) @ moved.T)


@dataclass(frozen=True)
class FittedTreatments:
    """Treatments of the free angle by name, the chosen one, and the reason.

    ``softened`` : messages if the chosen stage was moved along a ridge, and ``least`` the least-residual solution
    there: the intervals then span both, because the trials do not distinguish them.
    ``searched`` : the stage does not minimise its residuals, so a large residual does not contradict the
    model.
    ``error`` : of the model, which the chosen treatment's intervals include.
    ``left_out`` : static points that contradict the recordings. ``stated`` : of the chosen treatment.
    """

    treatments: Mapping[str, Treatment]
    mode: str
    why: str
    softened: Sequence[str] = ()
    searched: bool = False
    least: Solution | None = None
    error: ModelError | None = None
    left_out: Sequence[LeftOutPoint] = ()
    stated: StatedKnowledge | None = None

    @property
    def stage(self) -> Stage:
        """Stage of the chosen treatment."""
        return self.treatments[self.mode].stage

    def seen_once(self, joints: Sequence[str], recordings: Sequence[Recording]) -> list[Remark]:
        """Sentences on joints that one trial alone moves, where the free angles of others shift over the trials."""
        if not np.any(self.treatments[self.mode].spread > 0.0):
            return []
        free = [[each.name for each in recordings if j in each.free] for j in range(len(joints))]
        return [
            at_joint(
                joints[j],
                f"it is free in {names[0]} only, so its free angle and interval are those of this trial: how much it "
                "shifts from trial to trial, as other joints' do, is not known",
            )
            for j, names in enumerate(free)
            if len(names) == 1 < len(recordings)
        ]
