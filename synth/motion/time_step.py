"""The unit of time of constants that were measured on limbs, for motions of any speed.

Windows, starts, priors and the durations of a hand's torque are seconds of a limb that swings at some hertz. A motion a
hundred times as fast has them a hundred times as short. The unit changes in steps, the first of them wider, so that all
recordings of limbs share the very constants that were measured: paces of single recordings, also of one leg, differ by
a factor of four. Beyond limbs a unit is never more than half a step off: a whole leg of a human swings at 0.6 Hz, and
in a unit of 20 s a hand of 0.3 s at the start of 2.5 s was not found, with dampers 21 % too weak (24 simulated legs).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# s, middle of the paces (``synth.pace``) of rats' (0.006 to 0.025 s), robot legs' (0.018 to 0.043 s) and slower limbs.
USUAL = 0.022
TWO_STEPS = 20.0  # ratio of one unit to the next but one; limbs from 0.8 to 16 Hz, a step to both sides, have 1 s


def stepped_unit(paces: Sequence[float]) -> float:
    """The unit, s, of recordings of these paces, s: in steps of the root of ``TWO_STEPS``, 1 for limbs."""
    known = [pace for pace in paces if pace > 0.0]
    if not known:
        return 1.0
    steps = 2.0 * np.log(float(np.median(known)) / USUAL) / np.log(TWO_STEPS)
    return 1.0 if abs(steps) <= 1.0 else float(TWO_STEPS ** (0.5 * round(steps)))
