"""A motion far too fast or slow for a limb of its size: its clock is probably in another unit."""

from __future__ import annotations

import numpy as np

from synth.pace import SINUSOID_PACE
from synth.swing.leg_model import Leg

SLOWEST, FASTEST = 0.01, 300.0  # of the pendulum frequency sqrt(g/L): a rat's and a robot dog's legs swing at 3


def pace_doubt(leg: Leg, pace: float) -> str:
    """A sentence on a recorded motion of that ``pace`` (s, ``synth.pace``) if no limb of the leg's size moves so.

    Empty if one may, if there is no motion (nan), or without gravity, which sets the scale.
    """
    length = sum(joint.link.length for joint in leg.joints)
    if leg.gravity <= 0.0 or not np.isfinite(pace):
        return ""
    natural, rate = float(np.sqrt(leg.gravity / length)), SINUSOID_PACE / pace
    if SLOWEST * natural < rate < FASTEST * natural:
        return ""
    hint = "are the times milliseconds, labelled as seconds?"
    hint = hint if rate < natural else "seconds labelled as milliseconds would: is the clock right?"
    return (
        f"the recorded motion swings at about {rate / (2 * np.pi):.2g} Hz, a leg of {1e3 * length:.4g} mm "
        f"hangs and swings at {natural / (2 * np.pi):.2g} Hz, and limbs of this size lie between "
        f"{SLOWEST:g} and {FASTEST:g} times that; {hint}"
    )
