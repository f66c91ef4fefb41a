"""The clamped arms: no play, the designed rate and the arm offset, measured on solids that went through STEP."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from cad_joints import cleared
from synth.cad import JointDimensions, SpringDimensions
from synth.cad.arm_layout import seat_size
from synth.cad.checks import check_arms
from synth.cad.dimensions import coil_fraction
from synth.cad.export import write_step
from synth.cad.flexed_wire import effective_length
from synth.cad.hardware import insert_of, inserts, screw_of, screws
from synth.cad.joint import BuiltJoint, build_joint
from synth.cad.layout import jaw_height
from synth.cad.parts import Mesh
from synth.cad.play import PLAY_LIMIT, check_play, joint_play
from synth.cad.spring_solid import measured_arms, measured_stiff_length
from synth.cad.travel import Bodies

CASES = [
    (sign, zero, hand, closes)
    for (sign, hand), (zero, closes) in zip(
        itertools.cycle(itertools.product((1, -1), ("right", "left"))),
        [(0.0, -1), (90.0, -1), (180.0, 1), (-45.0, -1), (137.0, 1), (90.0, 1), (180.0, -1), (270.0, -1)],
        strict=False,
    )
]


def joint_of(sign, zero, hand, closes):
    """A knee's joint whatever its angles are measured from: 70 deg from straight when free."""
    included = 130.0
    spring = SpringDimensions(2.5, 20.0, 4 + coil_fraction(included), included, hand=hand)
    free = zero - 70.0
    return cleared(
        JointDimensions(
            "knee",
            spring,
            free,
            free + 5.0,
            range=(free - 25.0, free + 30.0),
            zero_angle=zero,
            sign=sign,
            closes=closes,
        )
    )


@pytest.fixture(scope="module")
def knee():
    return build_joint(joint_of(1, 180.0, "right", -1))


def from_step(solid, path):
    import cadquery as cq

    write_step(cq.Assembly(name="whole").add(solid, name="part"), path)
    return cq.importers.importStep(str(path)).solids().vals()[0]


@pytest.mark.parametrize(("sign", "zero", "hand", "closes"), CASES)
def test_rate_and_arm_offset_of_the_exported_step_equal_the_design(sign, zero, hand, closes, tmp_path):
    joint = build_joint(joint_of(sign, zero, hand, closes))
    dimensions = joint.dimensions
    spring = from_step(joint.part("spring").solid, tmp_path / "spring.step")
    free = dimensions.free_angle
    caps = {
        half: from_step(joint.solid_at(joint.part(f"{half}_cap"), free), tmp_path / f"{half}.step")
        for half in ("upper", "lower")
    }
    arms = measured_arms(spring)
    lower, upper = arms if joint.layout.flips[1] > 0 else arms[::-1]
    frees = (lower.start_of(caps["lower"], 0.0), upper.start_of(caps["upper"], 0.0))
    found = measured_stiff_length(spring, dimensions.spring.wire_diameter, frees)
    wanted = effective_length(dimensions.spring.radius, dimensions.spring.drawn_coils, joint.layout.free_arm)
    assert found == pytest.approx(wanted, rel=1e-4)
    # The lower arm from its link's centre line, seen from +z: by the offset towards smaller measured angles.
    link = -90.0 + dimensions.rotation(free)
    off = (lower.seen_angle() - link) * -sign
    assert math.remainder(off - dimensions.arm_offset, 360.0) == pytest.approx(0.0, abs=1e-3)
    # And the upper arm at its stated angle: from the direction in which the measured angle is zero.
    reference = -90.0 + dimensions.rotation(0.0)  # the lower link's direction at a measured angle of 0
    off = (upper.seen_angle() - reference) * sign
    assert math.remainder(off - dimensions.upper_arm_angle, 360.0) == pytest.approx(0.0, abs=1e-3)


def test_a_wrong_drawn_rate_fails_the_gate(knee):
    drawn = effective_length(knee.dimensions.spring.radius, knee.dimensions.spring.drawn_coils, knee.layout.free_arm)
    for off, passes in ((1.004, True), (1.006, False), (0.994, False)):
        spring = replace(knee.dimensions.spring, stiff_length=drawn * off)
        levers = check_arms(BuiltJoint(replace(knee.dimensions, spring=spring), knee.layout, knee.parts))[-1]
        assert levers.name == "levers"
        assert levers.passed is passes


@pytest.mark.parametrize("springs", [1, 2])
def test_a_clamped_spring_has_no_play(springs):
    joint = build_joint(cleared(replace(joint_of(-1, 90.0, "left", -1), springs=springs)))
    (check,) = check_play(Bodies(joint))
    assert check.passed
    assert check.value < 0.01


def loosened(joint, part, shift):
    """The joint with one part's mesh shifted, mm."""
    cap = joint.part(part)
    moved = replace(cap, mesh=Mesh(cap.mesh.vertices + np.array(shift), cap.mesh.faces))
    return BuiltJoint(joint.dimensions, joint.layout, tuple(moved if p is cap else p for p in joint.parts))


def test_a_loose_cap_gives_the_closed_form_play(knee):
    """A cap g away lets either end of the arm rise by g, and so go g aside between the flanks of 45 deg."""
    gap, up = 0.3, knee.layout.flips[1]
    loose = loosened(knee, "lower_cap", (0.0, 0.0, gap * up))
    found = joint_play(Bodies(loose))
    assert min(found.high, -found.low) > PLAY_LIMIT
    length = knee.layout.seat.length + 1.0  # rays on the last millimetre still meet the V
    most = math.degrees(2 * gap / (length - 2.0))
    assert max(found.high, -found.low) < 1.5 * most
    assert not check_play(Bodies(loose))[0].passed


def test_without_a_cap_the_play_is_large(knee):
    parts = tuple(p for p in knee.parts if "lower_cap" not in p.name and "lower_screw" not in p.name)
    found = joint_play(Bodies(BuiltJoint(knee.dimensions, knee.layout, parts)))
    assert found.width > 2.0


@pytest.mark.parametrize("wire", [0.5, 1.0, 2.0, 3.0, 4.5, 8.0])
def test_screws_engage_one_and_a_half_diameters_and_end_inside(wire):
    spring = SpringDimensions(wire, 8 * wire, 4.25, 90.0)
    dimensions = JointDimensions("a", spring, 100.0, 100.0, range=(90.0, 110.0))
    seat = seat_size(dimensions)
    screw, insert = screw_of(seat.screw), insert_of(seat.screw)
    assert seat.screw_length in screw.lengths
    engaged = seat.screw_length - seat.cap - seat.gap
    assert 1.5 * screw.size <= engaged + 1e-9
    assert engaged <= insert.length
    assert seat.cap >= dimensions.cap
    assert jaw_height(seat) > wire / 2


def test_tables_of_screws_and_inserts_are_consistent():
    assert [screw.size for screw in screws()] == sorted(inserts())
    for screw in screws():
        assert screw.standard.startswith("ISO ")
        assert screw.size < screw.hole < screw.head_diameter < screw.washer
        assert list(screw.lengths) == sorted(screw.lengths)
        assert insert_of(screw.size).hole > screw.size
        assert insert_of(screw.size).length >= 1.5 * screw.size
