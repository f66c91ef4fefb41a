"""The effects that act in given lanes, and the memories, events and tolerances that the integrator needs for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.swing.effects import Effect, effect_named
from synth.swing.integral_starts import started_integrals
from synth.swing.known_torque import Linear
from synth.swing.lane_groups import LaneGroups, Memories, Switches, full_group
from synth.swing.lane_layout import (
    CURVE_POINTS,
    FIRST_LAW,
    HOLDING,
    INTEGRAL,
    MOST_LINKS,
    MOST_MEMORIES,
    SERVOS,
    SHARING,
    Layout,
)

BEND_TOLERANCE = 1e3  # factor on the tolerance for a bristle's bend, which is 1 at most, against that of an angle

# Slope of a damper curve at rest over that at high speed, above which the implicit step is used: 1.5 is a power law of
# exponent 0.93 over a ratio of 500 in speed. Below, the explicit step is as fast and more accurate.
BENT = 1.5
LEAST_UNBOUNDED = 1e6  # rad/s; the last segment of a curve ends at ``damper_curves.UNBOUNDED``, in any unit of time


@dataclass(frozen=True)
class ActiveEffects:
    """The torque effects of a chain, in the order of ``layout.laws``."""

    layout: Layout
    effects: tuple[Effect, ...]

    @cached_property
    def _needs_load(self) -> dict[int, np.ndarray[Any, Any]]:
        """Index of each effect that uses the bearing force -> rows; it uses it only if one of these is not zero."""
        layout, found = self.layout, {}
        for index, effect in enumerate(self.effects):
            if effect.uses_load:
                names = effect.by_load or effect.strengths
                blocks = [layout.parameter_rows(effect.name, effect.index(name)) for name in names]
                found[index] = np.concatenate([np.arange(layout.n_row)[block] for block in blocks])
        return found

    @cached_property
    def _switches(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Rows that switch a torque on if not zero (curves, servos, each effect), and the first index of each group."""
        layout = self.layout
        groups = [list(range(layout.n_row)[layout.rows(block)]) for block in ("curve_slope", "servo_strength")]
        for effect in self.effects:
            blocks = [layout.parameter_rows(effect.name, effect.index(name)) for name in effect.strengths]
            groups.append([row for block in blocks for row in range(layout.n_row)[block]])
        starts = np.cumsum([0, *[len(group) for group in groups[:-1]]])
        return np.array([row for group in groups for row in group]), starts

    def groups(self, lanes: Array, between: Sequence[int] | NDArray[np.intp]) -> LaneGroups:
        """Groups of the columns of ``lanes`` (n_row, n_lane), split before these indices; each has its own effects."""
        split = np.split(lanes, between, axis=1)
        return self.together(split, [self.active(group) for group in split])

    def together(self, groups: Sequence[Array], switched: Sequence[Switches]) -> LaneGroups:
        """These groups, each (n_row, n_lane), with the effects that are switched on in each."""
        widths = [group.shape[1] for group in groups]
        each = list(zip(switched, groups, strict=True))
        bent = [self.bends(active, group) for active, group in each]
        memories = [self.remembered(active, group) for active, group in each]
        used = [group if active.any() else group[: self.layout.n_plain] for active, group in each]
        return LaneGroups([full_group(group) for group in used], widths, switched, bent, memories)

    def active(self, lanes: Array) -> Switches:
        """(2, 2 + n_law) extra torques that any column of ``lanes`` (n_row, n_lane) switches on; see ``integrate``."""
        rows, starts = self._switches
        switches = np.logical_or.reduceat(np.any(lanes[rows] != 0.0, axis=1), starts)
        both = np.array([switches, switches], dtype=np.int64)
        if switches[SERVOS] and np.any(lanes[self.layout.rows("servo_period")]):
            both[:, SERVOS] = HOLDING
        if switches[SERVOS] and np.any(lanes[self.layout.row("source")]):
            both[:, SERVOS] += SHARING
        for index, rows in self._needs_load.items():
            if both[1, FIRST_LAW + index] and np.any(lanes[rows]):
                both[0, FIRST_LAW + index] = 0
        return both

    def bends(self, active: Switches, lanes: Array) -> bool:
        """Whether the implicit step is used: bent damper curves, and no effect, servo or known torque beside them."""
        if not active[0, 0] or active[:, 1:].any():
            return False
        blocks = (lanes[self.layout.rows(block)] for block in ("curve_speed", "curve_slope"))
        speed, slope = (block.reshape(self.layout.n, CURVE_POINTS, -1) for block in blocks)
        at_rest, at_speed = slope.sum(axis=1), np.where(speed >= LEAST_UNBOUNDED, slope, 0.0).sum(axis=1)
        return bool(np.any(at_rest > BENT * at_speed))

    @cached_property
    def _bristles_and_plays(self) -> tuple[list[int], list[int]]:
        """Indices of the effects with a bristle, and of those with backlash, among the switches."""
        each = list(enumerate(self.effects, start=FIRST_LAW))
        return [i for i, effect in each if effect.bristle], [i for i, effect in each if effect.play]

    def rubs(self, active: Switches) -> bool:
        """Whether ``friction_integrator`` is used: a bristle, and neither a servo nor backlash beside it."""
        on, (bristles, plays) = active[1].tolist(), self._bristles_and_plays
        return not on[SERVOS] and any(on[i] for i in bristles) and not any(on[i] for i in plays)

    @staticmethod
    def needs_whole(active: Switches) -> bool:
        """Whether a servo acts, or an effect that uses the bearing force: only the whole integrator has these."""
        return bool(active[1, SERVOS]) or bool(np.any(active[0] != active[1]))

    @cached_property
    def _memory_rows(self) -> list[tuple[int, Effect, slice, list[slice], NDArray[np.intp]]]:
        """Of each effect with a memory: its switch, itself, rows of the memory, of parameters, of strengths (s, n)."""
        layout, found = self.layout, []
        for index, effect in enumerate(self.effects, start=FIRST_LAW):
            if effect.memory:
                rows = [layout.parameter_rows(effect.name, p) for p in range(len(effect.parameters))]
                strengths = [np.arange(layout.n_row)[rows[effect.index(name)]] for name in effect.strengths]
                memory = layout.rows(f"{effect.name} memory")
                found.append((index, effect, memory, rows, np.array(strengths)))
        return found

    def remembered(self, active: Switches, lanes: Array) -> Memories:
        """The memories that are states of these lanes.

        A memory is a state only at joints at which its effect is on in some lane, because even a bristle without
        friction would cost steps.
        """
        on: list[tuple[str, int]] = []
        if active[1, SERVOS]:
            gain, period = (lanes[self.layout.rows(block)] for block in ("servo_integral_gain", "servo_period"))
            on += [(INTEGRAL, j) for j in np.flatnonzero(np.any((gain != 0.0) & (period == 0.0), axis=1)).tolist()]
        for index, effect, _, _, strengths in self._memory_rows:
            if active[1, index]:
                joints = np.flatnonzero(np.any(lanes[strengths] != 0.0, axis=(0, 2)))
                on += [(effect.name, j) for j in joints.tolist()]
        return tuple(on)

    def states(self, active: Switches, workspace: Array, on: Memories, known: Linear, start: float) -> tuple[Any, ...]:
        """Rows of memories and their derivatives, tolerance factors and events; memories are set to their start values.

        ``on`` : the result of ``remembered``; ``known`` : what acts, as the integrator takes it, from ``start`` s on.
        """
        signals = known[1].shape[1] > self.layout.n
        if signals and active[1, SERVOS] and np.any(workspace[self.layout.rows("servo_integral_gain")]):
            started_integrals(self.layout, workspace, known, start)
        for index, effect, memory, rows, _ in self._memory_rows:
            if active[1, index]:
                deflection = workspace[self.layout.rows("rotation")] - workspace[self.layout.rows("rest")]
                workspace[memory] = effect.function("start")(deflection, *(workspace[each] for each in rows))
        return self._rows(on)

    @cached_property
    def _made(self) -> dict[Memories, tuple[Any, ...]]:
        """Cache of ``_rows``: the same few sets of memories recur."""
        return {}

    def _rows(self, on: Memories) -> tuple[Any, ...]:
        """The result of ``states`` for these memories."""
        if on not in self._made:
            self._made[on] = self._newly(on)
        return self._made[on]

    def _newly(self, on: Memories) -> tuple[Any, ...]:
        layout = self.layout
        if len(on) > MOST_MEMORIES:
            raise ValueError(f"{len(on)} memories of effects at once; the integrator can hold {MOST_MEMORIES}")
        state, derivative = layout.memories(on)
        laws = [None if name == INTEGRAL else effect_named(name) for name, _ in on]
        factors = np.array([BEND_TOLERANCE if law is not None and law.bristle else 1.0 for law in laws])
        bends, plays = (np.full((len(on), width), -1, dtype=np.int64) for width in (2, 3))
        for index, (effect, (name, joint)) in enumerate(zip(laws, on, strict=True)):
            if effect is None:
                continue
            if effect.bristle:
                give = layout.parameter_rows(name, effect.index(effect.bristle)).start
                bends[index] = MOST_LINKS + joint, give + joint
            elif effect.play:
                gap = layout.parameter_rows(name, effect.index(effect.play)).start
                plays[index] = joint, gap + joint, layout.row("rest", joint)
        rows = np.array(state, dtype=np.uint64), np.array(derivative, dtype=np.uint64)
        return *rows, factors, bends, plays
