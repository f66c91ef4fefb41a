"""Left and right exchanged: what the steps of one point's two tracks tell, when a tracker confuses the legs.

An exchange is a jump of both tracks at once into each other's place, and back. Two tracks that cross also come close
to each other's place from one frame to the next, but each goes on as it moved before; a prediction at constant velocity
from either side tells the two apart. Only what is beyond doubt is restored: a wrong repair destroys a good recording.
``limb_sides`` decides it, for all points of a limb together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask

# Limits tuned with tests/motion/importers/test_swaps.py: crossings of 5 to 100 samples a period and 0 to 3 % noise.
SHORTER = 0.25  # the exchanged step against the plain one, squared distances
STRIDES = 6.0  # ordinary steps nearby; a jump is longer
NEARBY = 7  # steps before, and after
SMOOTHER = 0.1  # error of the prediction with an exchange against that without, squared: below, there is no doubt


@dataclass(frozen=True, eq=False)
class Steps:
    """Of two tracks of n frames, for each frame (n,) what happened on the way there from the last one with both sides.

    ``present`` both sides are there; ``turned`` they were exchanged, or back; ``kept`` they surely were not; ``open``
    they may have been, and a jump or a corner says so. None of these: the sides are too close together to tell.
    """

    present: Mask
    turned: Mask
    kept: Mask
    open: Mask


def side_steps(one: Array, other: Array) -> Steps:
    """The steps of two tracks.

    Parameters
    ----------
    one, other : (n, d), the same point or angle of either side, nan where missing. Angles that may jump by a turn are
        points on the unit circle.

    Returns
    -------
    An exchange begins and ends with a jump of both tracks that is much longer than their steps nearby, short when
    crossed, and after which each track goes on from the other's place with the other's velocity. A jump at which the
    prediction is not clear is open, and so is a meeting from which both tracks turn back as if each had gone on as the
    other.
    """
    present = np.asarray(np.isfinite(one).all(axis=1) & np.isfinite(other).all(axis=1))
    at = _changing_frames(one, other)
    turned, kept, unclear = np.zeros(len(one), dtype=bool), present.copy(), np.zeros(len(one), dtype=bool)
    kept[at] = False  # of values that are held, the others are not exchanged
    if len(at) >= 4:
        jump, corner, clear, same = _turns(one[at], other[at], np.diff(at).astype(float))
        turned[at[1:]], kept[at[1:]], unclear[at[1:]] = jump & clear, same, (jump & ~clear) | corner
    return Steps(present, turned, kept, unclear)


def _changing_frames(one: Array, other: Array) -> NDArray[np.intp]:
    """Frames with both tracks that differ from the frame before: held values have no velocity."""
    at = np.flatnonzero(np.isfinite(one).all(axis=1) & np.isfinite(other).all(axis=1))
    both = np.concatenate([one[at], other[at]], axis=1)
    return np.asarray(at[np.concatenate([[True], (np.diff(both, axis=0) != 0).any(axis=1)])[: len(at)]])


def _turns(a: Array, b: Array, gap: Array) -> tuple[Mask, Mask, Mask, Mask]:
    """Steps (m - 1,) with a jump that is smoother crossed; such without a jump; those beyond doubt; those surely not.

    Parameters
    ----------
    a, b : (m, d) tracks without missing frames.
    gap : (m - 1,) frames from each to the next.
    """
    plain = ((a[1:] - a[:-1]) ** 2 + (b[1:] - b[:-1]) ** 2).sum(axis=1)
    crossed = ((a[1:] - b[:-1]) ** 2 + (b[1:] - a[:-1]) ** 2).sum(axis=1)
    step = np.sqrt(np.minimum(plain, crossed)) / gap
    stride = gap * _ordinary(step)
    jump = (crossed < SHORTER * plain) & (plain > (STRIDES * stride) ** 2)
    kept, turned = _errors(a, b, gap, jump)
    # Errors of prediction nearby, as recorded: a corner of two tracks that meet is larger.
    usual = _ordinary(np.sqrt(np.minimum(kept, turned)))
    corner = ~jump & (turned < SMOOTHER * kept) & (kept > (STRIDES * usual) ** 2)
    surely = (kept < SMOOTHER * turned) & (turned > (STRIDES * usual) ** 2)
    return jump & (turned < kept), corner, turned < SMOOTHER * kept, surely


def _errors(a: Array, b: Array, gap: Array, jump: Mask) -> tuple[Array, Array]:
    """Squared errors (m - 1,) of predictions at constant velocity over each step: as recorded, and exchanged there.

    From the two frames before to the one after, and from the two after to the one before. A neighbouring step that
    jumps may be an exchange too (of a single frame), whichever fits better.
    """
    mean, apart = (a + b) / 2.0, (a - b) / 2.0  # an exchange leaves the one and reverses the other
    kept, turned = np.zeros(len(gap)), np.zeros(len(gap))
    for before, after, between, reach, beside in (
        (slice(0, -2), slice(2, None), slice(1, None), gap[1:] / gap[:-1], jump[:-1]),
        (slice(2, None), slice(0, -2), slice(0, -1), gap[:-1] / gap[1:], jump[1:]),
    ):
        # Predicted from `before` and the middle one to `after`, over the steps `between`.
        far = reach[:, None]
        common = ((mean[after] - mean[1:-1] - far * (mean[1:-1] - mean[before])) ** 2).sum(axis=1)
        for total, sign in ((kept, 1.0), (turned, -1.0)):
            same = ((sign * apart[after] - apart[1:-1] - far * (apart[1:-1] - apart[before])) ** 2).sum(axis=1)
            also = ((sign * apart[after] - apart[1:-1] - far * (apart[1:-1] + apart[before])) ** 2).sum(axis=1)
            total[between] += common + np.where(beside, np.minimum(same, also), same)
    return kept, turned


def _ordinary(size: Array) -> Array:
    """The median nearby (m,) of the sizes (m,), before or after each, whichever is larger; at least the mean of all."""
    padded = np.concatenate([np.full(NEARBY, np.nan), size, np.full(NEARBY, np.nan)])
    window = np.lib.stride_tricks.sliding_window_view(padded, NEARBY)
    before, after = window[: len(size)], window[NEARBY + 1 :]
    found = np.full(len(size), float(size.mean()))
    for side in (before, after):
        some = np.isfinite(side).any(axis=1)
        found[some] = np.maximum(found[some], np.nanmedian(side[some], axis=1))
    return found
