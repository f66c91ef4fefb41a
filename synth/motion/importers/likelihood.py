"""Points that a tracker itself thinks unlikely: missing below a stated likelihood, else told."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError

SCORES = ("likelihood", "score", "confidence", "visibility")  # what trackers' tables call it
USUAL = 0.6  # DeepLabCut's own `pcutoff`; its default there. Of other trackers only the number of lower ones is told


def without_unlikely(
    positions: Array, scores: Array | None, least: float | None, word: str, name: str
) -> tuple[str, ...]:
    """Set unlikely points to nan, in place; returns the notes.

    Parameters
    ----------
    positions : (n, n_point, d), nan where missing.
    scores : (n, n_point), None if the file has none; one that is nan is below every bound.
    least : the bound; None: all points stay.
    word : what the file calls its scores; ``name`` : the file, in messages.

    Raises
    ------
    UserError : a bound, and no scores.
    """
    if scores is None:
        if least is not None:
            raise UserError(Problem(f"has no {word} of all its points; leave it out", name, key="likelihood"))
        return ()
    seen = np.isfinite(positions).all(axis=2)
    unlikely = ~(scores >= (USUAL if least is None else least)) & seen
    if not unlikely.any():
        return ()
    count = f"the {word} of {int(unlikely.sum())} points (all body parts) is below "
    if least is None:
        return (f"{count}{USUAL:g}: all are kept; with likelihood: {USUAL:g} they are taken as missing",)
    positions[unlikely] = np.nan
    return (f"{count}{least:g}: taken as missing",)
