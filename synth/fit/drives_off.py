"""Drives that a passive motion leaves out."""

from __future__ import annotations

from synth.remarks import Remark
from synth.swing.leg_model import Leg


def drives_off_sentence(leg: Leg) -> str | None:
    """That springs and dampers are chosen for the leg with its drives off; None without a drive."""
    driven = [joint.name for joint in leg.joints if joint.drive is not None]
    if not driven:
        return None
    which = f"the {driven[0]}'s drive is" if len(driven) == 1 else f"the drives of {', '.join(driven)} are"
    return Remark(
        f"{which} taken as off, windings open: springs, dampers and the predicted motion are those of the passive leg",
        remedy="With the drive on, look at the built leg by `synth gap` and trials with its commands or currents.",
    )
