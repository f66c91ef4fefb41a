"""What an MJCF file of a leg lacks, in sentences."""

from __future__ import annotations

from synth.arrays import Array
from synth.files.drive_terms import drive_terms
from synth.files.joint_curves import without_held
from synth.files.mjcf import held_effects
from synth.files.mjcf_laws import joint_laws
from synth.swing.leg_model import Leg


def mjcf_omissions(leg: Leg, fastest: Array, deflected: Array | None = None) -> list[str]:
    """Features that MuJoCo's joints lack, and curves that are fitted; the file lists them in comments too.

    ``fastest``, ``deflected`` : as for ``mjcf_text``.
    """
    notes = [f"not held: {', '.join(sorted(leg.effects))} of the base"] if leg.effects else []
    drives = drive_terms(leg)
    for joint, drive, laws in zip(leg.joints, drives, joint_laws(leg, fastest, deflected, drives), strict=True):
        notes += [f"{joint.name}: not held, of the drive: {text}" for text in (drive.lost if drive is not None else ())]
        lost = without_held(joint, held_effects(driven=drive is not None))
        if lost:
            notes.append(f"{joint.name}: not held: {', '.join(lost)}")
        notes += [f"{joint.name}: {text}" for text in laws.notes()]
    return notes
