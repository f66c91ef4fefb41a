"""What drives the lanes of one run: a known torque, late or scaled in some lanes, and the signals of servos."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.drives.servo import ServoSignals
from synth.swing.known_torque import HeldCommands, KnownTorque, Linear, delay_torques, for_integrator
from synth.swing.lane_groups import LaneGroups
from synth.swing.lane_layout import DRIVE, LANES, Layout


def driven_by(known: KnownTorque | None, signals: ServoSignals | None) -> tuple[str, ...]:
    """What drives a trial, in words for its result; empty for a free motion."""
    given = (("a known torque", known), ("a servo", signals))
    return tuple(what for what, inputs in given if inputs is not None)


def is_driven(known: KnownTorque | None, signals: ServoSignals | None) -> bool:
    """Whether something acts on the joints: with its servos off and no torque a leg moves as after a release."""
    return (known is not None and bool(np.any(known[1]))) or (signals is not None and bool(signals.enabled.any()))


@dataclass(frozen=True)
class DrivingInputs:
    """``known`` and ``signals`` as in ``Chain.run``, in the integrator's unit of time.

    ``held`` : joints whose servo holds its command for a period in some lane; ``steps`` : more steps that a motion may
    need, because some end at knots, and at the control steps of servos; ``given`` : what acts on lanes without errors
    of their known torque, as the integrator takes it.
    """

    layout: Layout
    known: KnownTorque | None
    signals: ServoSignals | None
    held: tuple[int, ...]
    steps: int
    given: tuple[Linear, HeldCommands]

    @classmethod
    def of(
        cls, layout: Layout, groups: LaneGroups, known: KnownTorque | None, signals: ServoSignals | None, length: float
    ) -> DrivingInputs:
        """``length`` : of the motion, in the unit of the lanes in ``groups``."""
        held: tuple[int, ...] = ()
        if signals is not None:
            periods = np.max([group[layout.rows("servo_period")].max(axis=1) for group in groups.lanes], axis=0)
            held = tuple(np.flatnonzero(periods).tolist())
        given = for_integrator(known, layout.n, signals, held)
        steps = len(given[0][0])
        if signals is not None:
            late = max(_delays(group[layout.rows("servo_delay")][list(signals.held)]) for group in groups.lanes)
            steps += ceil(sum(length / periods[j] for j in held)) + len(given[1][0]) * late
        return cls(layout, known, signals, held, 2 * steps, given)

    def on(self, workspace: Array) -> tuple[Linear, HeldCommands]:
        """What acts on a group of lanes (n_row, 16), as the integrator takes it.

        Their delays become differences from the first lane's, with which the torque is given.
        """
        if self.known is None or not np.any(workspace[self._error_rows]):
            return self.given
        offset, delay = (workspace[self.layout.rows(block)] for block in DRIVE[1:])
        offset[self._idle] = 0.0  # in place: these are rows of the workspace
        first = delay[:, 0].copy()
        delay -= first[:, None]
        if not np.any(first):
            return self.given
        return for_integrator(delay_torques(self.known, first), self.layout.n, self.signals, self.held)

    @cached_property
    def _error_rows(self) -> list[int]:
        """Rows of a known torque's errors: gain, offset, delay."""
        rows = range(self.layout.n_row)
        return [row for block in DRIVE for row in rows[self.layout.rows(block)]]

    @cached_property
    def _idle(self) -> NDArray[np.bool_]:
        """(n,) joints without torque, which are not driven."""
        assert self.known is not None
        return np.asarray(np.all(self.known[1] == 0.0, axis=0))


def _delays(late: Array) -> int:
    """Number of different delays (n_held, n_lane) of the held commands in a group of lanes."""
    return int(sum(min(len(np.unique(row)), LANES) for row in late))
