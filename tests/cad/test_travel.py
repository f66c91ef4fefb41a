"""The free travel by bisection, against exact solids, and that a part in the way is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cad import JointDimensions, SpringDimensions, clear_upper_arm_angle
from cad.joint import BuiltJoint, assemble
from cad.layout import lay_out
from cad.parts import Mesh
from cad.pose import pose_spring
from cad.travel import CHORDS, CONTACT_ANGLE, Bodies, check_spring_room, check_travel, first_contact, free_travel, poses


@pytest.fixture(scope="module")
def knee(leg):
    return leg.joints[1]


def test_the_contact_angle_is_that_of_the_exact_solids(knee):
    found = free_travel(Bodies(knee))
    assert found.low < knee.dimensions.range[0]
    assert found.stop_low.split(" with ")[0].startswith("knee_upper")
    upper = knee.part("upper").solid

    def shared(angle):
        return upper.intersect(knee.solid_at(knee.part("lower"), angle)).Volume()

    assert shared(found.low + 0.1) < 1e-6
    assert shared(found.low - 2 * CONTACT_ANGLE) > 0.0


def test_a_travel_that_the_hinge_cannot_give_is_stopped(knee):
    found = free_travel(Bodies(knee))
    wider = replace(knee.dimensions, range=(found.low - 5.0, 160.0))
    low, high, shaft = check_travel(Bodies(BuiltJoint(wider, knee.layout, knee.parts)))
    assert not low.passed
    assert high.passed
    assert shaft.passed
    assert low.value == pytest.approx(found.low, abs=2 * CONTACT_ANGLE)
    assert low.angle == wider.range[0]


def test_a_thin_part_in_the_way_is_found_at_its_degree(knee):
    bodies = Bodies(knee)
    assert first_contact(bodies, 119.0, 160.0) is None
    # A needle of 1.2 mm where the lower half's socket comes by, fixed to the upper half.
    shaft = knee.part("upper_keeper")
    reach = knee.layout.lower_bottom + 5.0
    needle = Mesh(
        np.asarray(shaft.mesh.vertices - shaft.mesh.vertices.mean(axis=0)) * [0.3, 0.3, 1.0], shaft.mesh.faces
    )
    turned = needle.turned(0.0, (reach, 0.0, 0.0)).turned(-90.0 + knee.dimensions.rotation(150.0))
    parts = tuple(replace(p, mesh=turned) if p is shaft else p for p in knee.parts)
    found = first_contact(Bodies(BuiltJoint(knee.dimensions, knee.layout, parts)), 119.0, 160.0)
    assert found is not None
    # The socket's half width is seen under asin(13.1/(its distance)) from the axis.
    assert 119.0 < found < 150.0


def test_a_spring_that_is_too_wide_for_its_pocket_is_stopped(knee):
    """The drawn pocket keeps; the spring is a millimetre wider than it was drawn for."""
    spring = replace(knee.dimensions.spring, mean_diameter=knee.dimensions.spring.mean_diameter + 2.0)
    swollen = BuiltJoint(replace(knee.dimensions, spring=spring), knee.layout, knee.parts)
    failed = [check for check in check_spring_room(Bodies(swollen)) if not check.passed]
    assert any("the lower half," in check.text for check in failed)
    assert all(check.angle is not None for check in failed)


@pytest.mark.parametrize(("clearance", "share"), [(0.4, 0.05), (2.0, None)])
def test_a_closed_coil_has_a_mandrel_s_tenth_and_the_clearance_round_its_arbor(clearance, share):
    """A tenth of a small coil is less than a large clearance; the gate sees an arbor that has the tenth alone."""
    spring = SpringDimensions(2.032, 17.018, 6 + 60 / 360, 120.0)
    dimensions = JointDimensions("ankle", spring, 139.0, 139.0, (110.0, 160.0), shaft_diameter=5.0, plate=8.0)
    dimensions = replace(dimensions, clearance=clearance)
    layout = lay_out(dimensions)
    inside = 2 * layout.radius_closed - spring.wire_diameter
    room = inside / 2 - layout.arbor_radius
    assert room == pytest.approx(clearance if share is None else share * inside)
    assert layout.arbor_radius > dimensions.shaft_diameter / 2
    gap = check_spring_room(Bodies(assemble(dimensions, layout)))[-1]
    assert gap.name == "spring gap"
    assert gap.value > min(room, clearance) - 2 * CHORDS
    thick = replace(layout, arbor_radius=0.9 * inside / 2)
    gap = check_spring_room(Bodies(assemble(dimensions, thick)))[-1]
    assert gap.passed is (0.05 * inside > clearance / 2)
    if not gap.passed:
        assert gap.value == pytest.approx(0.05 * inside, abs=2 * CHORDS)


def test_the_upper_arm_of_an_opened_coil_which_is_lower_has_its_way_and_its_shafts():
    """It has fewer turns. Found by make fuzz: drawn for the unloaded height the arm met the cup's wall."""
    spring = SpringDimensions(10.0, 80.0, 4 + 60 / 360, 120.0)
    dimensions = JointDimensions("hip", spring, 60.0, 60.0, (50.0, 180.0), clearance=0.3)
    dimensions = replace(dimensions, upper_arm_angle=clear_upper_arm_angle(dimensions))
    joint = assemble(dimensions, layout := lay_out(dimensions))
    opened = pose_spring(dimensions, layout, 180.0).spring
    arm = layout.coil_start + opened.drawn_coils * opened.drawn_pitch - spring.wire_diameter / 2
    # The coil opens a little less than the joint, as its arms turn on their shafts.
    assert layout.upper.bottom + 1.0 <= arm < layout.upper.bottom + 1.0 + 0.1 * layout.coil_drop
    assert all(check.passed for check in check_spring_room(Bodies(joint)))
    higher = replace(layout, notch_bottom=layout.notch_bottom + layout.coil_drop)
    failed = [check for check in check_spring_room(Bodies(assemble(dimensions, higher))) if not check.passed]
    assert any(check.name == "overlap" and "the lower half," in check.text for check in failed)


def test_a_bore_that_is_not_round_is_seen_as_the_shaft_turns(knee):
    """A D bore in the ear lets the shaft in as it is drawn, and not when it turns."""
    from cad.arm_shaft import build_d_bore
    from cad.parts import mesh_of

    upper = knee.part("upper")
    plug = build_d_bore(8.0, 0.1, knee.layout.gap, knee.layout.gap + knee.dimensions.plate)
    import cadquery as cq

    ring = cq.Solid.makeCylinder(5.0, knee.dimensions.plate, cq.Vector(0, 0, knee.layout.gap)).cut(plug)
    parts = tuple(replace(p, mesh=mesh_of(upper.solid.fuse(ring))) if p is upper else p for p in knee.parts)
    keyed = Bodies(BuiltJoint(knee.dimensions, knee.layout, parts))
    assert keyed.round_overlap() > 1.0
    assert Bodies(knee).round_overlap() < 0.05


def test_poses_hold_both_ends_and_are_a_degree_apart():
    found = poses(60.0, 62.5, 1.0, 61.1)
    assert (found[0], found[-1]) == (60.0, 62.5)
    assert 61.1 in found
    assert max(np.diff(found)) <= 1.0
