"""A joint's damper and spring in MuJoCo's terms, with sentences on what these terms do not hold exactly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees

from synth.arrays import Array
from synth.files.drive_terms import DriveTerms
from synth.files.joint_curves import DampingTerms, damping_terms, drag_terms, without_drag
from synth.files.joint_springs import SpringTerms, reach_of, spring_terms
from synth.files.mjcf_backlash import play_of
from synth.files.mjcf_springs import polynomial, spring_attributes
from synth.swing.leg_model import Joint, Leg

TOLD = 1e-3  # of the torque: a damper's error above it is reported


@dataclass(frozen=True)
class JointLaws:
    """``damper`` up to ``fastest`` rad/s, with what a drive's winding brakes; ``spring``, None without one.

    ``drag`` : what does not act behind the joint's backlash with these two, but on the joint itself.
    """

    damper: DampingTerms
    fastest: float
    spring: SpringTerms | None
    drag: DampingTerms

    def attributes(self, joint: Joint) -> dict[str, str]:
        """Spring and polynomial damping as attributes of the joint's hinge."""
        found = {} if self.spring is None else spring_attributes(self.spring, joint.rest)
        if any(self.damper.polynomial):
            found["damping"] = polynomial(self.damper.polynomial)
        return found

    def drag_attributes(self) -> dict[str, str]:
        """Drag as an attribute of the hinge beside which an arm has spring and damper."""
        return {"damping": polynomial(self.drag.polynomial)} if any(self.drag.polynomial) else {}

    def notes(self) -> list[str]:
        """How far fitted curves hold, and their largest errors there; empty where all is exact."""
        found = []
        if self.spring is not None and self.spring.fitted:
            text = f"the spring's curve is fitted up to {degrees(self.spring.reach):.3g} deg of deflection, there at "
            found.append(f"{text}most {self.spring.error:.2%} of its torque off; beyond, it goes on straight")
        for name, terms in (("damper", self.damper), ("drag", self.drag)):
            if terms.error > TOLD:
                text = f"the {name}'s curve is at most {terms.error:.1%} of its torque off up to {self.fastest:.3g} "
                found.append(f"{text}rad/s, and not fitted beyond")
        return found


def joint_laws(
    leg: Leg, fastest: Array, deflected: Array | None, drives: Sequence[DriveTerms | None]
) -> list[JointLaws]:
    """The laws of a leg's joints.

    ``fastest`` : (n,) rad/s, up to which each damper's curve is represented. ``deflected`` : (n,) rad, largest
    deflection of each spring in the known motion, up to which, and up to the joint's range, its curve is represented;
    None: the motion is unknown.
    """
    found = []
    for index, (joint, drive) in enumerate(zip(leg.joints, drives, strict=True)):
        speed = float(fastest[index])
        inside, drag = joint, DampingTerms((), (), (0.0, 0.0, 0.0), 0.0)
        if play_of(joint, driven=drive is not None):
            inside, drag = without_drag(joint), drag_terms(joint, speed)
        damper = damping_terms(inside, speed)
        if drive is not None:
            linear, square, cube = damper.polynomial
            damper = replace(damper, polynomial=(linear + drive.braking, square, cube))
        reach = reach_of(joint, None if deflected is None else float(deflected[index]))
        found.append(JointLaws(damper, speed, None if joint.spring is None else spring_terms(joint, reach), drag))
    return found
