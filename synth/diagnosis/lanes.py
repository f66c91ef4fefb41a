"""The simulator interface of the search: similar legs predicted together.

The adapter of a plant implements ``LanePredictor`` on its own simulator (``plants.swinging_chain.chain_predictor``);
fits, screening and search use nothing else of the plant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.effect_shape import ShapedEffect

Hypothesis = tuple[ShapedEffect, ...]
PredictorCache = dict[Any, Any]  # of a predictor's own kind


@dataclass(frozen=True)
class Block:
    """Legs that differ little from the first and share its integration steps, at most as many as the lanes.

    ``unknowns`` (n_tolerance + n_effect, n_lane): whitened tolerances, then the candidates' unknowns; ``state``
    (n_trial, 2 n + k + 2 m, n_lane): true (not measured) rotations and rates at each trial's start; below them one per
    controller with a memory, then two per link that the designed leg's structures add, then two per link that the
    candidates add, its deflection and rate: all relative to the state when held, whitened. What has no entry starts as
    if held. One column if all lanes start alike.
    """

    hypothesis: Hypothesis
    unknowns: Array
    state: Array


class LanePredictor(Protocol):
    """Predicts readings of one leg's trials, many legs in parallel."""

    @property
    def n_tolerance(self) -> int:
        """Number of tolerance unknowns."""

    @property
    def open_tolerances(self) -> Sequence[int]:
        """Indices of the tolerance unknowns that are not fixed."""

    @property
    def n_lane(self) -> int:
        """Number of legs that step together."""

    @property
    def stated_links(self) -> int:
        """Number of links of the designed leg's structures, which have initial states of their own in each trial."""

    @property
    def stated_memories(self) -> int:
        """Number of the designed leg's controllers with a memory, an initial state of its own in each trial."""

    def coarser(self, tolerance: float) -> Self:
        """The same, integrated to another relative tolerance."""

    def groups(self, hypotheses: Sequence[Hypothesis], widths: Sequence[int]) -> list[list[int]]:
        """Indices of blocks with so many legs that can step together."""

    def runs(self, hypotheses: Sequence[Hypothesis], groups: Sequence[Sequence[int]], least: int) -> list[list[int]]:
        """Indices of groups that one call of ``together`` predicts, in at least ``least`` calls if possible."""

    def predict(
        self, trials: Sequence[AngleTrial], blocks: Sequence[Block], kept: PredictorCache | None = None
    ) -> list[Array]:
        """(m, n, n_lane) rad in the sense of q for each block; nan if the motion diverged.

        ``trials`` : one, or pieces of one recording, in order; m is the number of samples of all.
        ``kept`` : as in ``together``, one for all calls with blocks that differ in their states only.
        """

    def together(
        self, trials: Sequence[AngleTrial], groups: Sequence[Sequence[Block]], kept: PredictorCache | None = None
    ) -> Array:
        """(m, n, n_lane) like ``predict``, of all blocks in order, for the groups of one of the ``runs``.

        ``kept`` : what does not depend on the trial or on the states; one for all trials of these groups.
        """


def state_size(predictor: LanePredictor, n_joint: int, hypothesis: Hypothesis) -> int:
    """Number of a trial's initial states: two for each joint and link of a structure, stated or candidate, one for each
    controller's memory.
    """
    links = predictor.stated_links + sum(candidate.links for candidate in hypothesis)
    return predictor.stated_memories + 2 * (n_joint + links)
