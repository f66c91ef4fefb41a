"""Jumps by the compiled lanes: from designs to outcomes, sixteen at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.compiling.code_cache import load
from synth.compiling.numba_internals import as_argument, entry_point
from synth.jump import jump_integrator, jump_source
from synth.jump.hopper_leg import Contact, HopperLeg, Motor
from synth.jump.jump_layout import LANES, LAYOUTS, JumpLayout
from synth.jump.jump_models import Model, lane
from synth.jump.outcomes import N_OUTCOME, STATUS, TOO_STIFF, JumpOutcome, outcome_of

TOLERANCE = 1e-4  # clearance within 0.1 mm of a hundred times finer one, see tests/hopper
DURATION = 1.0  # s, for the push; a leg still on the ground by then does not lift off. A flight may take longer
NO_END = 1e9  # s; later than any flight ends
FALL = 0.1  # m/s; falling that fast its highest point has passed
FIRST_STEP = 1e-5  # s: far below the contact's and the winding's time constants
MAX_STEPS = 60_000  # a jump takes hundreds to thousands; a stiffer one is reported as too stiff


@dataclass(frozen=True)
class Jumper:
    """The compiled functions for one bending model, from ``compiled_jump``."""

    layout: JumpLayout
    right_hand_side: Any
    jump: Any

    @property
    def where(self) -> np.ndarray[Any, np.dtype[np.int64]]:
        """Rows that the integrator looks at."""
        names = ("derivative", "normal", "foot", "foot_speed", "com_speed", "com", "gear_torque", "drawn", "bend",
                 "alive", "height", "energy")  # fmt: skip
        return np.array([self.layout.n_state, *(self.layout.row(name) for name in names), 0], dtype=np.int64)

    def run(self, lanes: Array, tolerance: float = TOLERANCE, duration: float = DURATION) -> Array:
        """Outcomes (n_outcome, n_lane), rows as ``outcomes.OUTCOMES``, of ``jump_models`` lanes (n_row, n_lane).

        Lanes of a group share their steps, and one stiff lane ends all: those that are too stiff together run alone.
        """
        count = lanes.shape[1]
        outcome = np.empty((N_OUTCOME, count))
        for first in range(0, count, LANES):
            outcome[:, first : first + LANES] = self._together(lanes[:, first : first + LANES], tolerance, duration)
        if count > 1:
            for k in np.flatnonzero(outcome[STATUS] == TOO_STIFF):
                outcome[:, k : k + 1] = self._together(lanes[:, k : k + 1], tolerance, duration)
        return outcome

    def _together(self, group: Array, tolerance: float, duration: float) -> Array:
        """Outcomes (n_outcome, m) of at most sixteen lanes (n_row, m) with common steps."""
        jump, right_hand_side = self._compiled
        workspace, found = np.empty((self.layout.n_row, LANES)), np.empty((N_OUTCOME, LANES))
        workspace[:, : group.shape[1]] = group
        workspace[:, group.shape[1] :] = group[:, :1]
        untraced = np.empty((0, 1 + self.layout.n_row))
        jump(right_hand_side, workspace, self.where, duration, NO_END, tolerance, FIRST_STEP, MAX_STEPS, FALL, found,
             untraced)  # fmt: skip
        return found[:, : group.shape[1]]

    @cached_property
    def _compiled(self) -> tuple[Any, Any]:
        """Both functions, whose lookup through numba costs as much as twenty steps at each call."""
        return entry_point(self.jump), as_argument(self.right_hand_side)

    def trace(
        self, parameters: Array, tolerance: float = TOLERANCE, duration: float | None = None, fall: float = FALL
    ) -> Array:
        """Time and the whole workspace (n_step, 1 + n_row) of one lane at every step.

        ``duration`` s: the end whatever the leg does by then; None: as a run ends, also in a long flight.
        """
        workspace = np.repeat(parameters[:, None], LANES, axis=1)
        found, room = np.empty((N_OUTCOME, LANES)), np.empty((MAX_STEPS, 1 + self.layout.n_row))
        where = self.where
        push, longest = (DURATION, NO_END) if duration is None else (duration, duration)
        self.jump(self.right_hand_side, workspace, where, push, longest, tolerance, FIRST_STEP, MAX_STEPS, fall, found,
                  room)  # fmt: skip
        return room[: where[13]]


@lru_cache(maxsize=3)
def compiled_jump(bending: str) -> Jumper:
    """The compiled jump; the first call on a machine compiles for some seconds, later ones load it from disk."""
    layout = LAYOUTS[bending]
    made = load(f"hopper{layout.n}", jump_source.right_hand_side(layout), jump_source.INLINED)
    return Jumper(layout, made.right_hand_side, jump_integrator.jump)


def simulate(
    designs: Sequence[tuple[HopperLeg, Motor]], contact: Contact, model: Model, *, tolerance: float = TOLERANCE
) -> list[JumpOutcome]:
    """Jumps of designs with one bending model, by a model that the lanes implement."""
    jumper = compiled_jump(designs[0][0].bending)
    lanes = np.stack([lane(leg, motor, contact, model) for leg, motor in designs], axis=1)
    return [outcome_of(column) for column in jumper.run(lanes, tolerance).T]
