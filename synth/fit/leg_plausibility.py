"""A leg's links that no rigid body or limb has, each in a sentence with what to check."""

from __future__ import annotations

from math import hypot

from synth.remarks import at_joint, decisive
from synth.swing.leg_model import Leg

MASS_RATIO = 1e3  # between two links of one leg: a whale's thigh and a rat's foot
# Between two links of one leg: one in mm read as m is a thousand times too long, and a hip's two axes that nearly meet
# are some hundred times nearer than a knee.
LENGTH_RATIO = 300.0


def leg_doubts(leg: Leg) -> list[str]:
    """Sentences on links that are impossible for a rigid body or a limb."""
    messages: list[str] = []
    for joint in leg.joints:
        link, name = joint.link, joint.name
        reach = max(link.length, 2.0 * hypot(link.com, link.com_across))
        if link.inertia > link.mass * reach**2:
            times = link.inertia / (link.mass * reach**2)
            text = (
                f"the link's inertia is {times:.2g} times its mass by its length squared, more than any "
                "distribution of that mass along it has; check the units of inertia, mass and length"
            )
            messages.append(at_joint(name, text, "decide"))
        if not 0.0 <= link.com <= link.length:
            text = (
                f"the link's centre of mass lies {1e3 * link.com:.4g} mm from its joint, outside the link's "
                f"{1e3 * link.length:.4g} mm; correct only with a counterweight"
            )
            messages.append(at_joint(name, text))
    ranked = sorted(leg.joints, key=lambda joint: joint.link.mass)
    light, heavy = ranked[0], ranked[-1]
    if heavy.link.mass > MASS_RATIO * light.link.mass:
        text = (
            f"{heavy.name} and {light.name}: link masses of {heavy.link.mass:.3g} and {light.link.mass:.3g} kg, more "
            f"than {MASS_RATIO:.0f} to one; check their units (g, kg)"
        )
        messages.append(decisive(text))
    ranked = sorted(leg.joints, key=lambda joint: joint.link.length)
    short, long = ranked[0], ranked[-1]
    if long.link.length > LENGTH_RATIO * short.link.length:
        text = (
            f"{long.name} and {short.name}: link lengths of {1e3 * long.link.length:.4g} and "
            f"{1e3 * short.link.length:.4g} mm, more than {LENGTH_RATIO:.0f} to one; check their units (mm, m)"
        )
        messages.append(decisive(text))
    return messages
