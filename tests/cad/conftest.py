"""The thesis' leg, built once for all CAD tests."""

from __future__ import annotations

from dataclasses import replace

import pytest

from synth.cad import (
    BuiltLeg,
    DamperDimensions,
    JointDimensions,
    LegDimensions,
    SpringDimensions,
    build_leg,
    clear_upper_arm_angle,
)

KNEE_SPRING = SpringDimensions(3.429, 26.035, 7.17, 120.0)
ANKLE_SPRING = SpringDimensions(2.032, 17.018, 6.17, 120.0)
# The thesis' hip has 105 deg at 1.04 coils, which tangent arms cannot have: 1.04 coils give 165.6 deg.
HIP_SPRING = SpringDimensions(4.7625, 36.5, 1.04, 165.6)


def thesis_leg() -> LegDimensions:
    """Springs of the thesis' Table 7, free angles of its Table 4 and text; all else our defaults."""
    joints = (
        JointDimensions("hip", HIP_SPRING, 105.0, 105.0, range=(60.0, 150.0), zero_angle=90.0, link_length=222.0),
        JointDimensions("knee", KNEE_SPRING, 111.0, 119.0, range=(60.0, 160.0), link_length=220.0),
        JointDimensions(
            "ankle",
            ANKLE_SPRING,
            139.0,
            138.0,
            range=(80.0, 170.0),
            sign=-1,
            link_length=160.0,
            damper=DamperDimensions(30.0, 12.0, 38.0),
        ),
    )
    drawn = (replace(joint, upper_arm_angle=clear_upper_arm_angle(joint)) for joint in joints)
    return LegDimensions("dog", tuple(drawn))


@pytest.fixture(scope="session")
def leg() -> BuiltLeg:
    return build_leg(thesis_leg())
