"""Groups of lanes that share their steps: what a start does not change, and how they enter the workspace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.swing.lane_layout import INTEGRAL, LANES, Layout

Memories = tuple[tuple[str, int], ...]  # effect and joint
Switches = NDArray[np.int64]  # (2, 2 + n_law), see ``ActiveEffects.active``


@dataclass(frozen=True)
class LaneGroups:
    """Groups of at most sixteen lanes that share their steps, and what is on in each: all that a start does not change.

    ``lanes`` : each (n_row, 16), copies of the first lane behind its own; of groups in which nothing is on, only the
    first ``Layout.n_plain`` rows; ``widths`` : numbers of own lanes; ``bent``, ``memories`` : the results of ``bends``
    and ``remembered``. ``state`` (n_motion, 2 n or 3 n, n_lane) rad, rad/s of all groups in order: initial rotations
    and rates of each motion instead of those in ``lanes``, and what its servos' integrals begin with beside that
    which holds them, duty; ``begins`` : the index of its first sample.
    """

    lanes: Sequence[Array]
    widths: Sequence[int]
    switched: Sequence[Switches]
    bent: Sequence[bool]
    memories: Sequence[Memories]
    state: Array | None = None
    begins: Sequence[int] = (0,)

    def starting(self, state: Array, begins: Sequence[int] = (0,)) -> LaneGroups:
        """The same legs from other initial states, see ``LaneGroups``, in motions that begin at these samples."""
        return replace(self, state=state, begins=begins)

    def write(self, index: int, flat: Array, factors: Array | None) -> None:
        """Write a group's lanes into the first rows of a workspace (n_row * 16,).

        ``factors`` : (n_row * 16,) that convert to another unit of time; None for the same.
        """
        group = self.lanes[index].reshape(-1)
        if factors is None:
            flat[: len(group)] = group
        else:
            np.multiply(group, factors[: len(group)], out=flat[: len(group)])

    def start(self, index: int, own: slice, motion: int, layout: Layout, flat: Array, factors: Array | None) -> None:
        """Write the initial state of a group, which has its ``own`` lanes among all, at a motion into the workspace."""
        if self.state is None:
            return
        workspace, width = flat.reshape(-1, LANES), self.widths[index]
        state = self.state[motion]
        blocks = ("rotation", "rate", f"{INTEGRAL} memory")[: len(state) // layout.n]
        for number, block in enumerate(blocks):
            place, first = layout.rows(block), number * layout.n
            rows = workspace[place]
            rows[:, :width] = state[first : first + layout.n, own]
            rows[:, width:] = rows[:, :1]
            if factors is not None:
                rows *= factors[place.start * LANES]


def full_group(group: Array) -> Array:
    """(n_row, 16) a group's lanes, then copies of the first one; a full group without gaps is returned itself."""
    if group.shape[1] == LANES and group.flags.c_contiguous:
        return group
    made = np.empty((len(group), LANES))
    made[:, : group.shape[1]] = group
    made[:, group.shape[1] :] = group[:, :1]
    return made
