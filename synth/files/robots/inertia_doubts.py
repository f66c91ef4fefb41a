"""Inertias that no body has: the largest principal moment exceeds the sum of the two others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.errors import Problem, UserError
from synth.files.robots.robot_tree import Robot

# Of the largest moment. Of a rod or a plate it is the sum of the others, and a file's digits or a CAD's mesh leave less
# than this beside it.
ROUNDING = 1e-3
# m, radius of gyration: below it a negative moment is what a CAD's arithmetic leaves of 0 (iCub's links of 0.5 kg have
# -5e-20 kg m^2, 0.3 nm); no part of a limb is so thin.
NO_SIZE = 1e-6
SLIGHT = 0.1  # of the largest moment: it may be a rounded number; beyond that, the numbers are another body's
SHOWN = 4  # names in a sentence


def require_moments(robot: Robot, groups: Sequence[Sequence[int]]) -> None:
    """Refuse a negative principal moment of inertia of the links' bodies; the robot's other bodies do not matter.

    Raises
    ------
    UserError
        With every such body.
    """
    problems = []
    for body in (robot.bodies[index] for group in groups for index in group):
        moments = np.linalg.eigvalsh(body.inertia)
        if moments[0] < -max(ROUNDING * float(np.abs(moments).max()), body.mass * NO_SIZE**2):
            shown = ", ".join(f"{moment:.4g}" for moment in moments)
            text = f"has the principal moments of inertia {shown} kg m^2; none may be negative"
            problems.append(Problem(text, key=f"link {body.name}"))
    if problems:
        raise UserError(problems)


def inertia_messages(robot: Robot, groups: Sequence[Sequence[int]]) -> list[str]:
    """Sentences on the links' bodies whose inertia is impossible.

    With A <= B <= C the principal moments of any mass distribution, C <= A + B: C - A - B is minus twice the integral
    of the squared distance from the plane of A and B's axes (Landau and Lifshitz, Mechanics, section 32).
    """
    slight, gross = [], []
    for body in (robot.bodies[index] for group in groups for index in group):
        moments = np.linalg.eigvalsh(body.inertia)
        excess = float(moments[2] - moments[0] - moments[1])
        if excess <= max(ROUNDING * float(moments[2]), body.mass * NO_SIZE**2):
            continue
        if excess <= SLIGHT * float(moments[2]):
            slight.append(f"{body.name} {100.0 * excess / float(moments[2]):.2g} %")
        else:
            shown = ", ".join(f"{moment:.3g}" for moment in moments)
            gross.append(f"{body.name}: no body has the principal moments of inertia {shown} kg m^2: the largest is at "
                         "most the sum of the others; check the file's numbers and their unit")  # fmt: skip
    if slight:
        more = f" and {len(slight) - SHOWN} others" if len(slight) > SHOWN else ""
        gross.append(
            "the largest principal moment of inertia exceeds the sum of the others, as of no body, a little: "
            f"{', '.join(slight[:SHOWN])}{more}; it is taken as written"
        )
    return gross
