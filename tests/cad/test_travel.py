"""The free travel by bisection, against exact solids, and that a part in the way is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cad import JointDimensions, SpringDimensions
from cad.checked_layout import lay_out
from cad.joint import BuiltJoint, assemble
from cad.parts import Mesh
from cad.pose import loaded_line
from cad.travel import Bodies, check_spring_room, first_contact, poses
from cad_joints import cleared


@pytest.fixture(scope="module")
def knee(leg):
    return leg.joints[1]


def test_a_thin_part_in_the_way_is_found_at_its_degree(knee):
    bodies = Bodies(knee)
    assert first_contact(bodies, 119.0, 162.0) is None
    # A needle of 1.2 mm where the lower half's socket comes by, fixed to the upper half.
    shaft = knee.part("upper_screw_1")
    reach = knee.layout.lower_bottom + 5.0
    needle = Mesh(
        np.asarray(shaft.mesh.vertices - shaft.mesh.vertices.mean(axis=0)) * [0.1, 0.1, 1.0], shaft.mesh.faces
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
    assert any("the lower half" in check.text for check in failed)


@pytest.mark.parametrize(("clearance", "share"), [(0.4, 0.05), (2.0, None)])
def test_a_closed_coil_has_a_mandrel_s_tenth_and_the_clearance_round_its_arbor(clearance, share):
    """A tenth of a small coil is less than a large clearance."""
    spring = SpringDimensions(2.032, 17.018, 6 + 60 / 360, 120.0)
    dimensions = JointDimensions("ankle", spring, 139.0, 139.0, (110.0, 160.0), shaft_diameter=5.0, plate=8.0)
    dimensions = cleared(replace(dimensions, clearance=clearance))
    layout = lay_out(dimensions)
    line = loaded_line(dimensions, layout, dimensions.stop_angles[0])
    inside = 2 * float(np.hypot(line[:, 0], line[:, 1]).min()) - spring.wire_diameter
    room = inside / 2 - layout.space.arbor_radius
    assert room == pytest.approx(clearance if share is None else share * inside, abs=0.01)
    assert layout.space.arbor_radius > dimensions.shaft_diameter / 2
    gap = check_spring_room(Bodies(assemble(dimensions, layout)))[-1]
    assert gap.name == "spring gap"
    assert gap.passed


def test_the_upper_arm_of_an_opened_coil_which_is_lower_has_its_way():
    """It has fewer turns. Found by make fuzz: drawn for the unloaded height the arm met the cup's wall."""
    spring = SpringDimensions(6.0, 60.0, 4 + 60 / 360, 120.0)
    dimensions = cleared(JointDimensions("hip", spring, 60.0, 60.0, (50.0, 150.0), clearance=0.3))
    joint = assemble(dimensions, layout := lay_out(dimensions))
    assert [str(check) for check in check_spring_room(Bodies(joint)) if not check.passed] == []
    higher = replace(layout, notch_bottom=layout.notch_bottom + spring.wire_diameter)
    failed = [check for check in check_spring_room(Bodies(assemble(dimensions, higher))) if not check.passed]
    assert any(check.name == "overlap" and "the lower half" in check.text for check in failed)


def test_a_bore_that_is_not_round_is_seen_as_the_shaft_turns(knee):
    """A D bore in the ear lets the shaft in as it is drawn, and not when it turns."""
    from cad.arm_shaft import build_d_bore
    from cad.parts import mesh_of

    upper = knee.part("upper")
    plug = build_d_bore(8.0, 0.1, knee.layout.gap_b, knee.layout.gap_b + knee.dimensions.plate)
    import cadquery as cq

    ring = cq.Solid.makeCylinder(5.0, knee.dimensions.plate, cq.Vector(0, 0, knee.layout.gap_b)).cut(plug)
    parts = tuple(replace(p, mesh=mesh_of(upper.solid.fuse(ring))) if p is upper else p for p in knee.parts)
    keyed = Bodies(BuiltJoint(knee.dimensions, knee.layout, parts))
    assert keyed.round_overlap() > 1.0
    assert Bodies(knee).round_overlap() < 0.05


def test_poses_hold_both_ends_and_are_a_degree_apart():
    found = poses(60.0, 62.5, 1.0, 61.1)
    assert (found[0], found[-1]) == (60.0, 62.5)
    assert 61.1 in found
    assert max(np.diff(found)) <= 1.0
