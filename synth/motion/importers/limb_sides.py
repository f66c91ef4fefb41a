"""Left and right of a limb's points or joints, decided together.

A tracker that confuses the legs exchanges a whole limb, or single points of it. Each point by itself shows most
exchanges by its jumps (``swaps``), but where the sides happen to pass each other there is none to see. Restoring what
shows, point by point, then makes a chimera of two limbs. Here the recording is divided at each suspected exchange of
any point. Between, the state of each point is constant, and two kinds of evidence tie the states together: a point's
own step (exchanged there, or surely not), and the length of the link between two neighbours, which tells whether both
are of the same limb. Only if these determine every state, without contradiction, is anything restored.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask
from synth.motion.importers.foreign_data import name_list
from synth.motion.importers.swaps import SMOOTHER, STRIDES, Steps, side_steps
from synth.noise import robust_deviation

MOST_EXCHANGED = 0.5  # share of exchanged frames: with more, the first frame may be wrong as well
MOST_NAMED = 6  # times in a note
STEADY = 1e-3  # of a link's length: none is known better in a picture
# Of the distance to a neighbour: sides of a point that stay nearer move an angle by less than 6 deg when exchanged.
# Such a point goes with its neighbours.
TOGETHER = 0.1

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class LimbExchange:
    """What is found in the tracks of a limb's points.

    ``swapped`` (n_point, n) True where a point's two tracks hold each other's values; ``doubtful`` frames at which an
    exchange may begin or end, and ``suspected`` the points that show one. If any is doubtful, nothing is swapped.
    """

    swapped: Mask
    doubtful: tuple[int, ...] = ()
    suspected: tuple[int, ...] = ()

    def notes(self, names: Sequence[str], time: Array) -> list[str]:
        """The finding in words, if there is one; ``names`` of the points, ``time`` (n,) s of the frames."""
        if self.doubtful:
            times = [f"{each:.3f}" for each in time[list(self.doubtful[:MOST_NAMED])]]
            shown = ", ".join(times) + (" and later" if len(self.doubtful) > MOST_NAMED else "")
            text = f"{name_list(names[i] for i in self.suspected)}: left and right may be exchanged from or to {shown} "
            text += (
                "s, which is not certain; the recording is left as it is: look at it there, and leave it out or cut "
            )
            return [f"{text}it with a window if they are"]
        found = []
        for name, own in zip(names, self.swapped, strict=True):
            stretches = int(np.diff(np.concatenate([[False], own]).astype(int)).clip(0).sum())
            text = f"{name}: left and right are exchanged in {int(own.sum())} frames ({stretches} stretches); restored"
            found += [text] if stretches else []
        return found


def exchanged_limb(one: Sequence[Array], other: Sequence[Array], linked: Sequence[bool] = ()) -> LimbExchange:
    """Frames in which points of a limb hold the values of the other side's.

    Parameters
    ----------
    one, other : the points' tracks (n, d), proximal to distal, of either side, nan where missing. Angles that may jump
        by a turn are points on the unit circle.
    linked : whether a point and the next are at a constant distance, the ends of one link. Empty: none are.

    Returns
    -------
    The first frame is assumed correct. Doubtful is an exchange without one back, one at which a step is not clear and
    the lengths of links do not tell, and a meeting from which both tracks turn back as if each had gone on as the
    other.
    """
    steps = [side_steps(*pair) for pair in zip(one, other, strict=True)]
    count, found = len(one[0]), [np.flatnonzero(each.turned | each.open) for each in steps]
    none, events = np.zeros((len(steps), count), dtype=bool), np.unique(np.concatenate(found))
    if not len(events):
        return LimbExchange(none)
    bounds = np.concatenate([[0], events, [count]])
    states = _States(len(steps), len(bounds) - 1)
    for i, each in enumerate(steps):
        _tie_in_time(states, i, each, events)
    for i in np.flatnonzero(linked).tolist():
        _tie_by_length(states, i, (one[i], other[i], one[i + 1], other[i + 1]), bounds)
    known = states.solved()
    if known is not None:
        _join_near_sides(known, one, other, linked, bounds)
        swapped = np.repeat(known == 1.0, np.diff(bounds), axis=1)
        clear = not np.isnan(known).any() and not known[:, -1].any()
        if clear and (swapped.mean(axis=1) <= MOST_EXCHANGED).all():
            return LimbExchange(np.asarray(swapped))
    return LimbExchange(none, tuple(events.tolist()), tuple(i for i, own in enumerate(found) if len(own)))


class _States:
    """States 0 or 1 (n_point, n_segment), known by ties: two are equal, or opposite. In the first segment all are 0."""

    def __init__(self, points: int, segments: int) -> None:
        self._shape = points, segments
        self._ties: dict[tuple[int, int], list[tuple[tuple[int, int], bool]]] = {}

    def tie(self, one: tuple[int, int], other: tuple[int, int], *, opposite: bool) -> None:
        """Two states (point, segment) are equal, or opposite."""
        self._ties.setdefault(one, []).append((other, opposite))
        self._ties.setdefault(other, []).append((one, opposite))

    def solved(self) -> Array | None:
        """(n_point, n_segment) 0, 1, or nan where no ties lead; None if ties contradict each other."""
        found = np.full(self._shape, np.nan)
        found[:, 0] = 0.0
        waiting = [(i, 0) for i in range(self._shape[0])]
        while waiting:
            here = waiting.pop()
            for there, opposite in self._ties.get(here, ()):
                state = 1.0 - found[here] if opposite else found[here]
                if np.isnan(found[there]):
                    found[there] = state
                    waiting.append(there)
                elif found[there] != state:
                    return None
        return found


def _tie_in_time(states: _States, point: int, steps: Steps, events: Indices) -> None:
    """By a point's own steps from one segment to a later one; events (m,) are the segments' first frames."""
    present = np.flatnonzero(steps.present)
    segment = np.searchsorted(events, present, side="right")
    for k in np.flatnonzero(np.diff(segment)).tolist():
        frame = present[k + 1]
        if steps.turned[frame] or steps.kept[frame]:
            pair = (point, int(segment[k])), (point, int(segment[k + 1]))
            states.tie(*pair, opposite=bool(steps.turned[frame]))


def _tie_by_length(states: _States, point: int, tracks: tuple[Array, Array, Array, Array], bounds: Indices) -> None:
    """By a link's length in each segment: of its ends, a point and the next, both are exchanged or none, or just one.

    ``tracks`` (n, d) : the point, its other side, the next point, its other side.
    """
    one, other, next_one, next_other = tracks
    same = np.stack([_distance(one, next_one), _distance(other, next_other)], axis=1)
    crossed = np.stack([_distance(one, next_other), _distance(other, next_one)], axis=1)
    if not np.isfinite(same).any(axis=0).all():
        return
    length = np.nanmedian(same, axis=0)
    off = same - length
    spread = max(*(robust_deviation(each[np.isfinite(each)]) for each in off.T), STEADY * float(length.mean()))
    errors = [_length_errors(each, length) for each in (same, crossed)]
    for segment, (first, end) in enumerate(pairwise(bounds.tolist())):
        known = np.isfinite(errors[0][first:end]) & np.isfinite(errors[1][first:end])
        if known.any():
            apart, joined = (float(each[first:end][known].mean()) for each in errors)
            right, wrong = min(apart, joined), max(apart, joined)
            if right < SMOOTHER * wrong and wrong > 2.0 * (STRIDES * spread) ** 2:  # of two links
                states.tie((point, segment), (point + 1, segment), opposite=joined < apart)


def _distance(one: Array, other: Array) -> Array:
    return np.asarray(np.linalg.norm(one - other, axis=1))


def _length_errors(found: Array, length: Array) -> Array:
    """(n,) squared errors of two links' lengths (n, 2) against those of both sides (2,), whichever way fits."""
    return np.asarray(np.minimum(((found - length) ** 2).sum(axis=1), ((found - length[::-1]) ** 2).sum(axis=1)))


def _join_near_sides(
    known: Array, one: Sequence[Array], other: Sequence[Array], linked: Sequence[bool], bounds: Indices
) -> None:
    """Set open states, in place, to those of the neighbours where the sides are never both seen, or stay near."""
    reach = np.full(len(one), np.inf)
    for i in np.flatnonzero(linked).tolist():
        reach[i : i + 2] = np.minimum(reach[i : i + 2], TOGETHER * np.nanmedian(_distance(one[i], one[i + 1])))
    waiting = np.argwhere(np.isnan(known)).tolist()
    while waiting:
        still = []
        for i, segment in waiting:
            apart = _distance(one[i], other[i])[bounds[segment] : bounds[segment + 1]]
            beside = {known[k, segment] for k in (i - 1, i + 1) if 0 <= k < len(known) and known[k, segment] >= 0.0}
            near = not np.isfinite(apart).any() or (np.isfinite(reach[i]) and np.nanmax(apart) <= reach[i])
            if near and len(beside) == 1:
                known[i, segment] = beside.pop()
            else:
                still.append([i, segment])
        if len(still) == len(waiting):
            return
        waiting = still
