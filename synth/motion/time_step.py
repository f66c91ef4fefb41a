"""The unit of time of constants that were measured on limbs, for motions of any speed.

Windows, starts, priors and the durations of a hand's torque are seconds of a limb that swings at some hertz. A motion a
hundred times as fast has them a hundred times as short. The unit changes in steps, so that all recordings of limbs
share the very constants that were measured: paces of single recordings, also of one leg, differ by a factor of four.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# s, middle of the paces (``synth.pace``) of rats' (0.006 to 0.025 s), robot legs' (0.018 to 0.043 s) and slower limbs.
USUAL = 0.022
STEP = 20.0  # ratio of one unit to the next: limbs from 0.8 to 16 Hz have the unit 1 s


def stepped_unit(paces: Sequence[float]) -> float:
    """The unit, s, of recordings of these paces, s: a power of ``STEP``, 1 for limbs."""
    known = [pace for pace in paces if pace > 0.0]
    if not known:
        return 1.0
    return float(STEP ** round(np.log(float(np.median(known)) / USUAL) / np.log(STEP)))
