"""Backlash in MJCF: spring and damper act on a light arm beside the link, which a tendon holds within the play.

The joint keeps its name and is the hinge itself. Beside its link hangs a body ``NAME arm`` on the same axis: its hinge
has the joint's spring and damper, and the fixed tendon ``NAME backlash``, the difference of both angles, is limited to
half the play either way. In the model of the effect this arm has no mass. Here it has a hundredth of the inertia that
the joint turns in the straight pose, more with a damper so stiff that steps would become tiny. Set its angle together
with the joint's.

Where a damper's curve bends, the two models differ beside this: here the curve acts at the arm's own rate, in the
effect as its secant at the joint's rate.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from synth.swing.leg_model import Joint

# The arm's inertia over that which the joint turns. Three joints with a play of 2 deg and linear dampers, swinging for
# 1.5 s (tests/files/test_mjcf.py), are 0.02 deg off the model without mass with 0.01, 0.04 with 0.02, 0.11 with 0.05.
SHARE, LARGEST_SHARE = 0.01, 0.05
LEAST_STEP = 2e-5  # s: a second in 50 000 steps takes MuJoCo about a second
ARM_MASS = 1e-6  # kg: a body of MuJoCo needs one; it is below a hundred-thousandth of any link
# A limit of 1 ms is as stiff as steps of 0.5 ms allow (MuJoCo asks for two steps), and holds all but a thousandth of
# what presses the arm against its flank.
HARD = {"solreflimit": "0.001 1", "solimplimit": "0.999 0.999 1"}


def play_of(joint: Joint, *, driven: bool) -> float:
    """Width of the joint's backlash, rad; 0 if it has none, or if a drive acts on the joint."""
    return 0.0 if driven else joint.effects.get("backlash", {}).get("gap", 0.0)


def arm_name(joint: str) -> str:
    """Name of the body and of the hinge that hold a joint's spring and damper."""
    return f"{joint} arm"


def arm_weight(stiffest: float, weight: float) -> float:
    """Inverse inertia (1/(kg m^2)) of the arm.

    ``stiffest`` : largest damper rate (N m s/rad). ``weight`` : inverse of the inertia that the joint turns.
    """
    return weight / min(LARGEST_SHARE, max(SHARE, LEAST_STEP * stiffest * weight))


def add_arm(parent: Element, joint: str, height: float, weight: float, hinge: dict[str, str]) -> None:
    """The arm beside the link: ``weight`` is its inverse inertia (1/(kg m^2)), ``hinge`` its laws."""
    body = SubElement(parent, "body", name=arm_name(joint), pos=f"0 0 {-height:.10g}")
    SubElement(body, "joint", {"name": arm_name(joint), "axis": "0 -1 0", **hinge})
    size = f"{1.0 / weight:.10g}"
    SubElement(body, "inertial", pos="0 0 0", mass=f"{ARM_MASS:.10g}", diaginertia=f"{size} {size} {size}")


def add_limit(tendons: Element, joint: str, gap: float) -> None:
    """The tendon that keeps the arm within the play."""
    limit = {"name": f"{joint} backlash", "range": f"{-0.5 * gap:.10g} {0.5 * gap:.10g}", **HARD}
    fixed = SubElement(tendons, "fixed", limit)
    SubElement(fixed, "joint", joint=joint, coef="1")
    SubElement(fixed, "joint", joint=arm_name(joint), coef="-1")
