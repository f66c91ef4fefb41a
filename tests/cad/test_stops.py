"""Hard stops: they touch at their angles on exact solids, before the spring yields, and before anything else.

On the same solids: the scale by which a seat is set, and the sunk heads of the damper's bracket.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cad_joints import cleared
from synth.cad import DimensionError, JointDimensions, SpringDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.hinge import build_lower, build_upper, ring_sector
from synth.cad.joint import BuiltJoint, build_joint, orient
from synth.cad.outline import unit
from synth.cad.stops import contact_angle
from synth.cad.travel import Bodies, check_travel, stop_contacts

SPRING = SpringDimensions(2.5, 20.0, 4 + 60 / 360, 120.0)
KNEE = JointDimensions("knee", SPRING, 115.0, 118.0, range=(90.0, 140.0), stops=(84.0, 151.0))


@pytest.fixture(scope="module", params=[(1, -1), (-1, -1), (1, 1)], ids=["knee", "sign", "closes"])
def drawn(request):
    sign, closes = request.param
    return build_joint(cleared(replace(KNEE, sign=sign, closes=closes)))


def canonical(joint, suffix):
    """Vertices (n, 3) of a part's mesh in the frame of the layout."""
    x, z = joint.layout.flips
    return joint.part(suffix).mesh.scaled((x, 1, z)).vertices


def filled(joint, suffix, ring, sector, heights):
    """Share of a sector of a ring (radii in mm, between two angles in deg and two heights in mm) that a part fills."""
    tool = orient(ring_sector(*ring, sector, *heights), joint.layout.flips)
    return joint.part(suffix).solid.intersect(tool).Volume() / tool.Volume()


def test_stops_touch_at_their_angles_on_the_exact_solids(drawn):
    joint = drawn
    upper, lower = joint.part("upper"), joint.part("lower")
    for stop, way in ((84.0, -1.0), (151.0, 1.0)):
        assert upper.solid.intersect(joint.solid_at(lower, stop - way * 0.05)).Volume() < 1e-6
        assert upper.solid.intersect(joint.solid_at(lower, stop + way * 0.2)).Volume() > 1e-3
    for (found, parts), stop in zip(stop_contacts(Bodies(joint)), (84.0, 151.0), strict=True):
        assert found == pytest.approx(stop, abs=0.1)
        assert parts == "knee_upper with knee_lower"


def test_a_horn_ends_a_millimetre_past_the_line_on_which_it_is_met(drawn):
    """The web's corner, r round at the distance c of the axis, touches a flank at sqrt(c^2 - r^2) from the axis."""
    layout = drawn.layout
    round_, x = layout.web_thickness / 2, layout.socket_outer - layout.web_thickness / 2
    touched = math.sqrt(x**2 + (layout.web_radius + round_) ** 2 - round_**2)
    points = canonical(drawn, "lower")
    points = points[(points[:, 2] < layout.floor_top + 1e-6) & (points[:, 2] > layout.floor_bottom - 1e-6)]
    for stop in layout.stops:
        along, across = (points[:, :2] @ unit(stop.flank + turn) for turn in (0.0, 90.0))
        assert along[np.abs(across) < 1e-4].max() == pytest.approx(touched + 1.0, abs=1e-3)


def test_the_scale_of_a_seat_is_a_vernier_of_one_degree(drawn):
    """Marks 5 deg apart on the ear and 4 on the plate: those numbered k meet where the seat is turned by k deg."""
    plate, top = drawn.layout.plate, drawn.layout.gap_b + drawn.layout.ear
    for k in range(-2, 3):
        for suffix, ring, face, at in (
            ("upper", (plate.radius + 2.3, plate.radius + 3.3), top, plate.window + 5.0 * k),
            ("seat", (plate.radius - 0.2, plate.radius + 0.2), plate.top, plate.window + 5.0 * k - 1.0 * k),
        ):
            half, heights = math.degrees(0.24 / ring[1]), (face - 0.45, face - 0.05)  # of a mark of half a millimetre
            assert filled(drawn, suffix, ring, (at - half, at + half), heights) < 0.01
            assert filled(drawn, suffix, ring, (at + 2.0 - half, at + 2.0 + half), heights) > 0.99


def test_the_pit_of_the_scale_lies_where_the_free_angle_grows(drawn):
    """To be unloaded at a larger angle, the lower half has turned by that from its sense; the upper arm goes with it.

    Seen from +z a measured angle turns the lower half counter-clockwise for a sign of +1, clockwise for -1.
    """
    plate, flips = drawn.layout.plate, drawn.layout.flips
    top, way = drawn.layout.gap_b + drawn.layout.ear, drawn.dimensions.sign * flips[0]  # a mirror turns senses round
    end = plate.travel + 10.0  # of the window
    ring, heights = (plate.radius - 2.8, plate.radius - 1.9), (top - 0.4, top - 0.1)
    sides = [sorted(plate.window + side * (end - before) for before in (2.0, 6.0)) for side in (way, -way)]
    shares = [filled(drawn, "upper", ring, sector, heights) for sector in sides]
    assert shares[1] > 0.99
    assert shares[0] < 0.5


def test_heads_of_the_bracket_s_screws_lie_below_the_face_on_which_the_tongue_turns(drawn):
    """A head that is level with it would rub where print stands up; 0.3 mm are left."""
    for number in range(1, drawn.dimensions.damper.bolt_count + 1):
        head = canonical(drawn, f"bracket_screw_{number}")[:, 2].max()
        assert -drawn.layout.gap_a - head == pytest.approx(0.3, abs=1e-6)


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
    for first, passed, spare in ((80.0, True, 4.0), (85.0, False, -1.0)):
        joint = build_joint(cleared(replace(KNEE, yields=(first, 160.0))))
        gate = next(check for check in check_travel(Bodies(joint)) if check.name == "stops before yield")
        assert gate.passed is passed
        assert gate.value == pytest.approx(spare)
