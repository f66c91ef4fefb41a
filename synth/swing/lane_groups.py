"""Groups of lanes that share their steps: what a start does not change, and how they enter the workspace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.swing.lane_layout import LANES, Layout

Memories = tuple[tuple[str, int], ...]  # effect and joint
Switches = NDArray[np.int64]  # (2, 2 + n_law), see ``ActiveEffects.active``


@dataclass(frozen=True)
class LaneGroups:
    """Groups of at most sixteen lanes that share their steps, and what is on in each: all that a start does not change.

    ``lanes`` : each (n_row, 16), copies of the first lane behind its own; ``widths`` : numbers of own lanes; ``bent``,
    ``memories`` : the results of ``bends`` and ``remembered``. ``state`` (2 n, n_lane) rad, rad/s of all groups in
    order: initial rotations and rates instead of those in ``lanes``.
    """

    lanes: Sequence[Array]
    widths: Sequence[int]
    switched: Sequence[Switches]
    bent: Sequence[bool]
    memories: Sequence[Memories]
    state: Array | None = None

    def starting(self, state: Array) -> LaneGroups:
        """The same legs from another initial state."""
        return replace(self, state=state)


def full_group(group: Array) -> Array:
    """(n_row, 16) a group's lanes, and copies of the first one."""
    made = np.empty((len(group), LANES))
    made[:, : group.shape[1]] = group
    made[:, group.shape[1] :] = group[:, :1]
    return made


def write_group(layout: Layout, flat: Array, group: Array, state: Array | None, factors: Array | None) -> None:
    """Write a group's lanes (n_row, 16) into a workspace (n_row * 16,).

    Parameters
    ----------
    state : (2 n, n_lane) rad, rad/s of its own lanes, instead of the rotations and rates in the group.
    factors : (n_row * 16,) that convert to another unit of time; None for the same.
    """
    if factors is None:
        flat[:] = group.reshape(-1)
    else:
        np.multiply(group.reshape(-1), factors, out=flat)
    if state is None:
        return
    workspace, width = flat.reshape(-1, LANES), state.shape[1]
    for block, rows in (("rotation", state[: layout.n]), ("rate", state[layout.n :])):
        place = layout.rows(block)
        workspace[place, :width] = rows
        workspace[place, width:] = rows[:, :1]
        if factors is not None:
            workspace[place] *= factors[place.start * LANES]
