"""Left and right exchanged: a tracker that confuses the two legs in some frames."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array, Mask

SHORTER = 0.25  # the exchanged step against the plain one, squared distances
STRIDES = 6.0  # ordinary steps; a plain step must be larger


def exchanged(one: Array, other: Array) -> Mask:
    """Frames in which two tracks hold each other's values.

    Parameters
    ----------
    one, other : (n, d), the same point or angle of either side, nan where missing.

    Returns
    -------
    (n,) True if exchanged. An exchange shows as a step of both tracks that is long
    as recorded and short when crossed; each such step begins or ends an exchange. Tracks that merely cross
    have short steps and are left alone. The first frame is assumed correct.
    """
    known = np.isfinite(one).all(axis=1) & np.isfinite(other).all(axis=1)
    at = np.flatnonzero(known)
    swapped = np.zeros(len(one), dtype=bool)
    if len(at) < 3:
        return swapped
    a, b = one[at], other[at]
    plain = ((a[1:] - a[:-1]) ** 2 + (b[1:] - b[:-1]) ** 2).sum(axis=1)
    crossed = ((a[1:] - b[:-1]) ** 2 + (b[1:] - a[:-1]) ** 2).sum(axis=1)
    stride = float(np.median(np.minimum(plain, crossed)))
    turns = (crossed < SHORTER * plain) & (plain > STRIDES**2 * stride)
    state = np.concatenate([[False], np.cumsum(turns) % 2 == 1])
    # A frame with one side missing goes with the frame before it.
    position = np.searchsorted(at, np.arange(len(one)), side="right") - 1
    return np.asarray(state[np.maximum(position, 0)] & (position >= 0))


def restored(one: Array, swapped: Mask, other: Array) -> Array:
    """Track ``one`` with the frames held by ``other`` restored."""
    return np.where(swapped[:, None], other, one)


def swap_note(what: str, swapped: Mask) -> str:
    """The finding in words."""
    stretches = int(np.diff(np.concatenate([[False], swapped])[:].astype(int)).clip(0).sum())
    text = f"{what}: left and right are exchanged in {int(swapped.sum())} frames ({stretches} stretches); restored"
    if swapped[-1]:
        text += ". The last stretch runs to the end: check that the first frames, not the last, are correct"
    return text
