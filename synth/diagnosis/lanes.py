"""What a simulator offers to the search over hypotheses: legs that differ little, predicted together.

The adapter of a plant implements ``LanePredictor`` on its own simulator (``plants.swinging_chain.chain_predictor``);
fits, screening and search know no more of the plant than this.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.effect_shape import ShapedEffect

Hypothesis = tuple[ShapedEffect, ...]


@dataclass(frozen=True)
class Block:
    """Legs, at most as many as step together, that differ little from the first and so share its steps.

    ``unknowns`` (n_tolerance + n_effect, n_lane): whitened tolerances, then each candidate's; ``state`` (2 n + 2 m,
    n_lane): rotations and rates at the trial's start, true ones, not as read; below them, two a link that the
    candidates add, how far and how fast it is from where it would start if held, in whitened units. Links of which
    nothing is said start as if held.
    """

    hypothesis: Hypothesis
    unknowns: Array
    state: Array


class LanePredictor(Protocol):
    """Predicts readings of one leg's trials, many legs side by side."""

    @property
    def n_tolerance(self) -> int:
        """Number of tolerance unknowns."""

    @property
    def open_tolerances(self) -> Sequence[int]:
        """Those of them that are not held at their nominal value."""

    @property
    def n_lane(self) -> int:
        """How many legs step together."""

    def coarser(self, tolerance: float) -> Self:
        """The same, integrated to another relative tolerance."""

    def groups(self, hypotheses: Sequence[Hypothesis], widths: Sequence[int]) -> list[list[int]]:
        """Places of the blocks of so many legs that can step together."""

    def predict(self, trial: AngleTrial, blocks: Sequence[Block]) -> list[Array]:
        """(m, n, n_lane) rad in the sense of q for each block; nan where the motion diverged."""

    def together(self, trial: AngleTrial, blocks: Sequence[Block]) -> list[Array]:
        """As ``predict``, for one of the ``groups``."""
