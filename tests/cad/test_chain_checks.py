"""Parts of different joints that meet as the leg folds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cad_joints import cleared
from synth.cad import DamperDimensions, JointDimensions, LegDimensions, SpringDimensions, build_leg
from synth.cad.chain_checks import (
    Shadow,
    chain_notes,
    chain_results,
    check_chain,
    confirmed,
    find_meetings,
    near_meetings,
    shadows_of,
)
from synth.design.chain_work import check_chain_of
from synth.side_processes import packed

SPRING = SpringDimensions(2.032, 17.018, 6.17, 120.0)
THICK = SpringDimensions(3.429, 26.035, 7.17, 120.0)  # its tongue reaches where the ears of the other joints are
SMALL, WIDE = DamperDimensions(30.0, 12.0, 38.0), DamperDimensions(90.0, 16.0, 104.0)


def joint(name, travel, length, damper=SMALL, spring=SPRING):
    rest = sum(travel) / 2
    drawn = JointDimensions(
        name, spring, rest, rest, range=travel, zero_angle=180.0, link_length=length, damper=damper, link_width=12.0
    )
    return cleared(drawn)


@pytest.fixture(scope="module")
def folding():
    """A knee that folds to 25 deg between links hardly longer than their hinges, and a foot that folds on."""
    joints = (
        joint("hip", (150.0, 200.0), 168.0, spring=THICK),
        joint("knee", (25.0, 80.0), 151.0, WIDE),
        joint("ankle", (120.0, 200.0), 151.0, WIDE),
    )
    return build_leg(LegDimensions("short", joints))


def test_what_a_folding_joint_brings_against_another_fails_by_name_and_pose(folding):
    checks = {check.part: check for check in check_chain(folding)}
    assert {name: check.passed for name, check in checks.items()} == {
        "hip_link": True,
        "knee_link": False,
        "ankle_link": True,
    }
    assert "hip_" in checks["knee_link"].text
    assert "with knee at 25 deg" in checks["knee_link"].text


def test_a_pose_of_several_joints_is_named_and_no_failure(folding):
    notes = chain_notes(find_meetings(folding))
    assert any(
        "hip_damper_bracket meets ankle_damper with hip at 183.3 deg and knee at 25 deg" in each for each in notes
    )
    assert all("deg and " in each for each in notes)


def test_the_parts_overlap_where_the_leg_is_drawn_in_that_pose(folding):
    """The leg's own placements, with the joints at rest at those angles, put the parts' meshes into each other."""
    for meeting in find_meetings(folding):
        angles = dict(meeting.angles)
        joints = tuple(replace(j, rest_angle=angles.get(j.name, j.rest_angle)) for j in folding.dimensions.joints)
        places = replace(folding, dimensions=replace(folding.dimensions, joints=joints)).placements()
        meshes = {}
        for drawn, link, at, place in zip(folding.joints, folding.links, joints, places, strict=True):
            for part in (*drawn.parts, link):
                if part.name in (meeting.first, meeting.second):
                    mesh = drawn.mesh_at(part, at.rest_angle).turned(place.turn, (place.x, place.y, 0.0))
                    meshes[part.name] = mesh.manifold
        volume = (meshes[meeting.first] ^ meshes[meeting.second]).volume()
        assert volume == pytest.approx(meeting.volume, rel=1e-6)


def test_joints_that_other_processes_built_give_the_same_checks(folding):
    pairs = list(zip(folding.joints, folding.links, strict=True))
    shadows = [shadows_of(index, *pair) for index, pair in enumerate(pairs)]
    built = [(packed(drawn), packed(link)) for drawn, link in pairs]
    checks, notes = check_chain_of(folding.dimensions, built, shadows)
    meetings = find_meetings(folding)
    assert checks == chain_results(folding.dimensions, meetings)
    assert notes == chain_notes(meetings)


def square(part, half, x, y, low=0.0, high=1.0):
    return Shadow(part, half, np.array([(x - 1, y - 1), (x + 1, y - 1), (x + 1, y + 1), (x - 1, y + 1)]), low, high)


def test_shadows_are_placed_along_the_chain():
    """Straight, the next joint is a link further down; folded by 90 deg, the one after that is beside it."""
    joints = (
        joint("hip", (180.0, 181.0), 156.0),
        joint("knee", (90.0, 180.0), 151.0),
        joint("ankle", (150.0, 200.0), 151.0),
    )
    leg = LegDimensions("leg", joints)
    way = joints[1].rotation(90.0)
    thigh = square("thigh", (0, "lower"), math.copysign(151.0, math.sin(math.radians(way))), -156.0)
    ankle = square("ankle_upper", (2, "upper"), 0.0, 0.0)
    ((halves, poses),) = near_meetings(leg, [thigh, ankle]).items()
    assert halves == ((0, "lower"), (2, "upper"))
    assert [pose for pose, _ in poses] == [{1: 90.0}]
    assert near_meetings(leg, [thigh, replace(ankle, low=1.0, high=2.0)]) == {}  # beside each other along the hinges
    assert near_meetings(leg, [replace(thigh, half=(0, "upper"))]) == {}


def test_a_leg_that_folds_less_passes_without_a_mesh(folding):
    wide = tuple(replace(each, range=(140.0, 170.0), rest_angle=150.0) for each in folding.dimensions.joints)
    leg = replace(folding, dimensions=replace(folding.dimensions, joints=wide))
    assert find_meetings(leg) == []
    assert all(check.passed for check in chain_results(leg.dimensions, []))
    assert confirmed(leg, {}) == []
    one = replace(leg.dimensions, joints=wide[:1])
    assert chain_results(one, []) == []
