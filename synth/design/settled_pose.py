"""The rest pose of a leg to which its motions lead, where there are several."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Leg
from synth.swing.mechanics import rest_pose


def settled_pose(leg: Leg, motions: Sequence[Array], locked: Sequence[Sequence[int]]) -> Array:
    """(n,) rad, the stable equilibrium nearest to the ends of motions.

    A weak spring that is unloaded some turns away leaves a joint several equilibria, a turn apart or so. From the
    springs' free angles another one is found than the leg comes to rest in. The search starts at the mean of each
    joint over the second half of the motions in which it is free, of all if there is none.

    Parameters
    ----------
    motions : (m, n) rad each; one that is not finite is left out, and without any the search starts at the springs'
        free angles.
    locked : indices of the joints that are locked in each.

    Raises
    ------
    ArithmeticError : as ``rest_pose``.
    """
    ends = [(motion[len(motion) // 2 :], held) for motion, held in zip(motions, locked, strict=True)]
    ends = [(end, held) for end, held in ends if np.isfinite(end).all()]
    if not ends:
        return rest_pose(leg)
    start = np.empty(len(leg.joints))
    for j in range(len(start)):
        free = [end[:, j] for end, held in ends if j not in held] or [end[:, j] for end, _ in ends]
        start[j] = np.concatenate(free).mean()
    return rest_pose(leg, start=start)
