"""Hard stops: they touch at their angles on exact solids, before the spring yields, and before anything else."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from cad_joints import cleared
from synth.cad import DimensionError, JointDimensions, SpringDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.hinge import build_lower, build_upper
from synth.cad.joint import BuiltJoint, build_joint
from synth.cad.stops import contact_angle
from synth.cad.travel import Bodies, check_travel, stop_contacts

SPRING = SpringDimensions(2.5, 20.0, 4 + 60 / 360, 120.0)
KNEE = JointDimensions("knee", SPRING, 115.0, 118.0, range=(90.0, 140.0), stops=(84.0, 151.0))


@pytest.mark.parametrize(("sign", "closes"), [(1, -1), (-1, -1), (1, 1)])
def test_stops_touch_at_their_angles_on_the_exact_solids(sign, closes):
    joint = build_joint(cleared(replace(KNEE, sign=sign, closes=closes)))
    upper, lower = joint.part("upper"), joint.part("lower")
    for stop, way in ((84.0, -1.0), (151.0, 1.0)):
        assert upper.solid.intersect(joint.solid_at(lower, stop - way * 0.05)).Volume() < 1e-6
        assert upper.solid.intersect(joint.solid_at(lower, stop + way * 0.2)).Volume() > 1e-3
    for (found, parts), stop in zip(stop_contacts(Bodies(joint)), (84.0, 151.0), strict=True):
        assert found == pytest.approx(stop, abs=0.1)
        assert parts == "knee_upper with knee_lower"


def test_the_contact_angle_of_flank_and_cylinder_equals_the_closed_form():
    # Axis at (10, 30), radius 3: seen under atan(10/30) from y, the tangent asin(3/sqrt(1000)) further out.
    found = contact_angle(27.0, 6.0, 13.0)
    assert found == pytest.approx(math.degrees(math.atan2(10, 30) + math.asin(3 / math.sqrt(1000))))


def test_a_joint_without_stops_fails_its_gate():
    dimensions = cleared(KNEE)
    layout = lay_out(dimensions)
    bare = replace(layout, stops=tuple(replace(stop, outer=1.0) for stop in layout.stops))
    upper, lower = build_upper(dimensions, layout), build_lower(dimensions, bare)
    joint = build_joint(dimensions)
    from synth.cad.parts import mesh_of

    parts = tuple(
        replace(p, solid=solid, mesh=mesh_of(solid).scaled((joint.layout.flips[0], 1, joint.layout.flips[1])))
        if (solid := {"knee_upper": upper, "knee_lower": lower}.get(p.name)) is not None
        else p
        for p in joint.parts
    )
    low, high, *_ = check_travel(Bodies(BuiltJoint(dimensions, layout, parts)))
    assert (low.name, high.name) == ("stops", "stops")
    assert not low.passed
    assert not high.passed


def test_stops_lie_past_the_travel_and_before_yield():
    with pytest.raises(DimensionError, match=r"knee\.stops = .*the wanted travel lies between the stops"):
        lay_out(replace(KNEE, stops=(89.9, 151.0)))
    with pytest.raises(DimensionError, match=r"knee\.stops = .*within 85 to 160 deg; the spring would yield"):
        lay_out(replace(KNEE, yields=(85.0, 160.0)))
    joint = build_joint(cleared(replace(KNEE, yields=(80.0, 160.0))))
    gate = next(check for check in check_travel(Bodies(joint)) if check.name == "stops before yield")
    assert gate.passed
    assert gate.value == pytest.approx(4.0)
