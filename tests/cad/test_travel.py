"""The free travel by bisection against exact solids, and the detection of obstacles."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cad_joints import cleared
from synth.cad import DamperDimensions, JointDimensions, SpringDimensions, kernel
from synth.cad.arm_shaft import build_pin, cross_hole
from synth.cad.checked_layout import lay_out
from synth.cad.joint import BuiltJoint, assemble
from synth.cad.near_body import NearBody
from synth.cad.parts import BuiltPart, Mesh, mesh_of
from synth.cad.pose import loaded_line
from synth.cad.travel import Bodies, check_spring_room, check_within, first_contact, poses, turn_solid


@pytest.fixture(scope="module")
def knee(leg):
    return leg.joints[1]


def test_a_thin_obstacle_is_found_at_its_angle(knee):
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


def test_a_spring_too_wide_for_its_pocket_fails_the_gate(knee):
    """The pocket is unchanged; the spring is a millimetre wider than the drawn one."""
    spring = replace(knee.dimensions.spring, mean_diameter=knee.dimensions.spring.mean_diameter + 2.0)
    swollen = BuiltJoint(replace(knee.dimensions, spring=spring), knee.layout, knee.parts)
    failed = [check for check in check_spring_room(Bodies(swollen)) if not check.passed]
    assert any("the lower half" in check.text for check in failed)


@pytest.mark.parametrize(("clearance", "share"), [(0.4, 0.05), (2.0, None)])
def test_a_closed_coil_keeps_its_clearance_to_the_arbor(clearance, share):
    """A tenth of a small coil is less than a large clearance."""
    spring = SpringDimensions(2.032, 17.018, 6 + 60 / 360, 120.0)
    dimensions = JointDimensions("ankle", spring, 139.0, 139.0, (110.0, 160.0), shaft_diameter=5.0, plate=8.0)
    wide = DamperDimensions(bolt_circle=56.0)
    dimensions = cleared(replace(dimensions, clearance=clearance, damper=wide))
    layout = lay_out(dimensions)
    line = loaded_line(dimensions, layout, dimensions.stop_angles[0])
    inside = 2 * float(np.hypot(line[:, 0], line[:, 1]).min()) - spring.wire_diameter
    room = inside / 2 - layout.space.arbor_radius
    assert room == pytest.approx(clearance if share is None else share * inside, abs=0.01)
    assert layout.space.arbor_radius > dimensions.shaft_diameter / 2
    gap = check_spring_room(Bodies(assemble(dimensions, layout)))[-1]
    assert gap.name == "spring gap"
    assert gap.passed


def test_the_lower_lying_arm_of_an_opened_coil_is_clear():
    """It has fewer turns. Found by make fuzz: drawn for the unloaded height the arm met the cup's wall."""
    spring = SpringDimensions(6.0, 60.0, 4 + 60 / 360, 120.0)
    dimensions = cleared(JointDimensions("hip", spring, 60.0, 60.0, (50.0, 150.0), clearance=0.3))
    joint = assemble(dimensions, layout := lay_out(dimensions))
    assert [str(check) for check in check_spring_room(Bodies(joint)) if not check.passed] == []
    higher = replace(layout, notch_bottom=layout.notch_bottom + spring.wire_diameter)
    failed = [check for check in check_spring_room(Bodies(assemble(dimensions, higher))) if not check.passed]
    assert any(check.name == "overlap" and "the lower half" in check.text for check in failed)


def lab_hip(**changed) -> JointDimensions:
    """The hip of the lab's dog, as drawn for the lab's project: a pair of thick springs of small index."""
    spring = SpringDimensions(5.2578, 21.11422118, 2 + 60 / 360, 120.0, free_arm=17.3)
    damper = DamperDimensions(outer_diameter=40.0, body_length=16.0, bolt_circle=50.0, bolt_count=4, bolt_diameter=3.4)
    hip = JointDimensions(
        "hip", spring, 103.9254767, 104.0344118, (98.0, 110.0), zero_angle=90.0, springs=2, upper_arm_angle=-90.0,
        damper=damper, shaft_diameter=8.0,
    )  # fmt: skip
    return replace(hip, **changed)


def cap_gap(dimensions: JointDimensions, joint: BuiltJoint, angle: float) -> float:
    """Least gap (mm) of the loaded springs outside their seats to the lower caps."""
    bodies, turn = Bodies(joint), joint.turn("lower", angle)
    caps = [solid for name, solid in bodies.solids.items() if "lower_cap" in name]
    return min(float(turn_solid(coil, -turn).min_gap(cap, 1.0)) for coil in bodies.coils(angle) for cap in caps)


def test_steep_arms_keep_half_the_clearance_to_the_caps():
    """The arm leans towards the cap: of a thick wire that took more than half of the clearance (0.1725 of 0.4 mm)."""
    dimensions = lab_hip()
    layout = lay_out(dimensions)
    # Closed form: the section's point next to the cap, a clearance before the seat, at the stop that opens the coil.
    slope = layout.upper.slope + layout.space.drop / 2 / layout.free_arm
    lean = np.arctan(slope)
    left = dimensions.clearance * np.cos(lean) - dimensions.spring.wire_diameter / 2 * np.sin(lean)
    assert left < dimensions.clearance / 2
    for arm in (layout.upper, layout.lower):
        assert left + arm.relief == pytest.approx(dimensions.clearance / 2)
    thin = replace(dimensions, spring=replace(dimensions.spring, wire_diameter=3.0))
    assert lay_out(thin).upper.relief == 0.0


def test_a_pair_of_thick_springs_keeps_its_gap_at_both_stops():
    dimensions = lab_hip()
    joint = assemble(dimensions, lay_out(dimensions))
    assert [str(check) for check in check_spring_room(Bodies(joint)) if not check.passed] == []
    least = min(cap_gap(dimensions, joint, angle) for angle in dimensions.stop_angles)
    assert least == pytest.approx(dimensions.clearance / 2, abs=0.02)
    for part in joint.parts:
        if part.family == "cap":
            assert float(part.solid.Volume()) == pytest.approx(part.exact_volume, rel=1e-6)


def test_a_bore_that_is_not_round_is_detected_in_rotation(knee):
    """A square ring in the ear lets a squared collar in as it is drawn, and not when it turns."""
    from synth.cad.arm_shaft import build_section
    from synth.cad.parts import mesh_of

    upper, collar = knee.part("upper"), knee.part("collar_b")
    low, high = collar.mesh.vertices[:, 2].min(), collar.mesh.vertices[:, 2].max()
    ring = build_section("square", 20.0, 0.0, low, high).cut(build_section("square", 15.2, 0.0, low - 1, high + 1))
    squared = collar.solid.intersect(build_section("square", 15.0, 0.0, low, high))
    changed = {upper.name: upper.solid.fuse(ring), collar.name: squared}
    parts = tuple(replace(p, mesh=mesh_of(changed[p.name])) if p.name in changed else p for p in knee.parts)
    keyed = Bodies(BuiltJoint(knee.dimensions, knee.layout, parts))
    assert float((keyed.halves["upper"] ^ keyed.solids[collar.name]).volume()) < 0.05
    assert keyed.round_overlap() > 1.0
    assert Bodies(knee).round_overlap() < 0.05


def test_poses_hold_both_ends_and_are_a_degree_apart():
    found = poses(60.0, 62.5, 1.0, 61.1)
    assert (found[0], found[-1]) == (60.0, 62.5)
    assert 61.1 in found
    assert max(np.diff(found)) <= 1.0


def test_what_lies_near_a_spring_is_as_good_as_the_whole_half(knee):
    """Overlap and gap of springs that are moved into the halves, with the half cut to their boxes and whole."""
    bodies = Bodies(knee)
    for half in bodies.halves.values():
        near = NearBody(half)
        for angle, shift in ((110.0, (0.0, 0.0, 0.0)), (140.0, (1.5, 0.0, 0.0)), (125.0, (0.0, 0.0, 40.0))):
            [coil] = bodies.coils(angle)
            moved = coil.translate(shift)
            whole, part = (float((moved ^ body).volume()) for body in (half, near.near(moved)))
            assert part == pytest.approx(whole, abs=1e-3)
            gap = float(moved.min_gap(half, 0.8))
            assert float(moved.min_gap(near.near(moved, 0.8), 0.8)) == pytest.approx(gap, abs=1e-5)
    assert (
        sum(float((bodies.coils(140.0)[0].translate((1.5, 0, 0)) ^ half).volume()) for half in bodies.halves.values())
        > 1.0
    )


def test_a_cut_is_made_again_for_a_box_that_it_does_not_hold(knee):
    near = NearBody(Bodies(knee).halves["upper"])
    low, high = np.array([-5.0, -5.0, -5.0]), np.array([5.0, 5.0, 30.0])
    first = near.within(low, high)
    assert near.within(low - 1.0, high) is first
    assert near.within(low - 30.0, high).volume() > first.volume()
    assert near.within(low - 30.0, high) is near.within(low, high)


@pytest.mark.parametrize(("aside", "passed"), [(0.0, True), (0.05, False)])
def test_chords_of_a_thick_pin_in_its_hole_are_no_overlap(aside, passed):
    """6 x 60 mm, of a shaft of 20 mm: the meshes have 0.056 mm^3 in common, the solids none; 0.05 mm aside, 12."""
    hole = cross_hole(0.0, 3.0, 100.0, 17.0)
    hub = kernel.cylinder(31.0, 40.0, (0.0, 0.0, -20.0)).cut(kernel.cylinder(10.0, 50.0, (0.0, 0.0, -25.0)), hole)
    solids = {"hub": hub.Solids()[0], "pin": build_pin(6.0, 60.0, aside, 17.0)}
    parts = [
        BuiltPart(name, "pin", "lower", solid, mesh_of(solid), False, None, "bought") for name, solid in solids.items()
    ]
    meshes = {part.name: part.mesh.manifold for part in parts}
    assert (meshes["hub"] ^ meshes["pin"]).volume() > 0.05
    (check,) = check_within(SimpleNamespace(parts={"lower": parts}, solids=meshes))
    assert check.passed is passed
    assert passed or check.value > 10.0
