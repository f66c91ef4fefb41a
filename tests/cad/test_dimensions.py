"""Dimensions: ranges, reasons, the arm offset, and the coil count that an included angle needs."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cad_joints import cleared
from synth.cad import (
    DamperDimensions,
    DimensionError,
    JointDimensions,
    LegDimensions,
    SpringDimensions,
    arm_offset,
    clear_upper_arm_angle,
)
from synth.cad.checked_layout import lay_out
from synth.cad.dimensions import coil_fraction
from synth.cad.leg_joints import lay_out_leg

SPRING = SpringDimensions(3.429, 26.035, 7.17, 120.0)
KNEE = JointDimensions("knee", SPRING, 111.0, 119.0)
DRAWN = cleared(KNEE)


def check(dimensions):
    found = dimensions.problems()
    if found:
        raise DimensionError(found)


def included_angle_of(coils):
    """Deg in [0, 360), of two tangent arms on ``coils`` turns."""
    return (180.0 - 360.0 * (coils % 1.0)) % 360.0


def test_arm_offset_has_the_thesis_values():
    # Section 4.2 of the thesis: ankle 139 - 120 = +19, knee 111 - 120 = -9 deg.
    assert arm_offset(139.0, 120.0) == 19.0
    assert arm_offset(111.0, 120.0) == -9.0
    assert KNEE.arm_offset == -9.0


@given(st.floats(6.0, 354.0), st.integers(1, 20))
def test_coils_and_included_angle_are_inverse_functions(angle, whole):
    assert included_angle_of(whole + coil_fraction(angle)) == pytest.approx(angle, abs=1e-9)


def test_catalogue_coils_are_adjusted_to_the_nominal_angle():
    # Lee's 7.17 coils at "120 deg" make 118.8 deg with tangent arms; 7 + (180 - 120)/360 makes 120.
    assert included_angle_of(7.17) == pytest.approx(118.8)
    assert pytest.approx(7 + 60 / 360) == SPRING.drawn_coils
    assert included_angle_of(1.04) == pytest.approx(165.6)


def test_the_thesis_hip_spring_is_refused_as_contradictory():
    with pytest.raises(DimensionError, match=r"coils = 1.04.*tangent arms at 105 deg"):
        check(SpringDimensions(4.7625, 36.5, 1.04, 105.0))


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"wire_diameter": 40.0}, "wire_diameter = 40: allowed is 0.2 to 12 mm"),
        ({"wire_diameter": float("nan")}, "wire_diameter"),
        ({"wire_diameter": "3 mm"}, "wire_diameter = '3 mm'"),
        ({"mean_diameter": 8.0}, "mean_diameter = 8.*spring index"),
        ({"pitch": 3.4}, "pitch = 3.4.*would intersect"),
        ({"hand": "both"}, "hand = 'both'"),
    ],
)
def test_an_impossible_spring_is_refused_by_name(change, named):
    with pytest.raises(DimensionError, match=named):
        check(replace(SPRING, **change))


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"clearance": -0.4}, r"knee\.clearance = -0.4: allowed is 0.1 to 2 mm"),
        ({"shaft_diameter": 20.0}, r"knee\.shaft_diameter = 20.*no dowel pin is sold that ends inside"),
        ({"range": (20.0, 160.0)}, r"knee\.range.*the links would meet"),
        ({"range": (160.0, 60.0)}, r"knee\.range"),
        ({"rest_angle": 10.0}, r"knee\.rest_angle = 10"),
        ({"sign": 0}, r"knee\.sign = 0"),
        ({"name": "../knee"}, "name = '../knee'"),
        ({"name": "<b>"}, "name = '<b>'"),
        ({"upper_arm_angle": 0.0}, r"knee\.upper_arm_angle = 0.*lower link"),
        ({"spring": replace(SPRING, free_arm=12.0)}, r"knee\.spring\.free_arm = 12: allowed is at least 18\."),
        ({"damper": DamperDimensions(40.0, 16.0, 40.0)}, r"knee\.damper\.bolt_circle = 40: allowed is at least 45.4"),
        ({"tube_wall": 10.0}, r"knee\.tube_wall"),
    ],
)
def test_an_impossible_joint_is_refused_by_name(change, named):
    with pytest.raises(DimensionError, match=named):
        lay_out(replace(DRAWN, **change))


def test_every_problem_is_reported_at_once():
    bad = replace(KNEE, clearance=-1.0, wall=50.0, spring=replace(SPRING, wire_diameter=-1.0))
    with pytest.raises(DimensionError) as caught:
        lay_out_leg(LegDimensions("leg", (bad, bad)))
    named = {problem.dimension for problem in caught.value.problems}
    assert {"knee.clearance", "knee.wall", "knee.spring.wire_diameter", "name"} <= named


def test_a_link_shorter_than_its_hinges_is_refused():
    with pytest.raises(DimensionError, match=r"knee\.link_length = 90: allowed is at least") as caught:
        lay_out_leg(LegDimensions("leg", (replace(DRAWN, link_length=90.0), replace(DRAWN, name="ankle"))))
    least = float(caught.value.problems[0].allowed.split()[-2])
    lay_out_leg(LegDimensions("leg", (replace(DRAWN, link_length=least + 0.1), replace(DRAWN, name="ankle"))))


def test_a_link_shorter_than_its_one_hinge_is_refused_with_one_hinge():
    with pytest.raises(DimensionError, match="its one hinge and the tube's socket are as long") as caught:
        lay_out_leg(LegDimensions("leg", (replace(DRAWN, link_length=30.0),)))
    least = float(caught.value.problems[0].allowed.split()[-2])
    lay_out_leg(LegDimensions("leg", (replace(DRAWN, link_length=least + 0.1),)))


def test_the_stated_shortest_arm_is_accepted():
    with pytest.raises(DimensionError) as caught:
        lay_out(replace(DRAWN, spring=replace(SPRING, free_arm=5.0)))
    least = float(caught.value.problems[0].allowed.split()[-2])
    lay_out(replace(DRAWN, spring=replace(SPRING, free_arm=least + 0.01)))


def test_the_default_upper_arm_angle_is_clear_of_the_travel():
    straight = replace(KNEE, zero_angle=0.0, free_angle=-20.0, rest_angle=-20.0, range=(-60.0, 20.0))
    for joint in (KNEE, straight):
        with pytest.raises(DimensionError, match="upper_arm_angle"):
            lay_out(joint)
        lay_out(replace(joint, upper_arm_angle=clear_upper_arm_angle(joint)))


def test_importing_cad_loads_no_kernel():
    code = "import sys, synth.cad; synth.cad.JointDimensions; print(*sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = answer.stdout.split()
    assert not {"cadquery", "numpy"} & {*loaded}
    ours = {name.split(".")[1] for name in loaded if name.startswith("synth.")}
    assert ours == {"cad", "compiling"}  # the root asks `compiling` for one function
