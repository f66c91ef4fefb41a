"""A pair of springs: one of each hand, mirrored at the tongue's floor, in solids, strength and gates."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from cad import DamperDimensions, DimensionError, JointDimensions, LoadDimensions, PrintDimensions, SpringDimensions
from cad.checks import check_arms, check_interference, check_joint
from cad.fitting_layout import damper_screws
from cad.hinge import build_lower
from cad.joint import BuiltJoint, assemble, build_joint
from cad.layout import lay_out
from cad.parts import mesh_of
from cad.strength import UNEVEN, stresses
from cad.travel import manifold

SPRING = SpringDimensions(2.032, 17.018, 6.17, 120.0)
ONE = JointDimensions(
    "ankle", SPRING, 139.0, 138.0, (80.0, 170.0), damper=DamperDimensions(30.0, 12.0, 38.0),
    loads=LoadDimensions(0.9, 0.1), upper_arm_angle=-15.0,
)  # fmt: skip
PAIR = replace(ONE, springs=2)


@pytest.fixture(scope="module")
def pair() -> BuiltJoint:
    return build_joint(PAIR)


def stress_of(dimensions: JointDimensions, name: str) -> float:
    found = stresses(dimensions, lay_out(dimensions), PrintDimensions())
    return next(stress.value for stress in found if stress.name == name)


def test_a_pair_passes_every_gate() -> None:
    joint = build_joint(replace(PAIR, sign=-1, spring=replace(SPRING, hand="left")))
    assert [str(check) for check in check_joint(joint) if not check.passed] == []


def test_the_second_spring_is_the_first_in_a_mirror(pair: BuiltJoint) -> None:
    first, second = pair.springs
    assert (first.name, second.name) == ("ankle_spring", "ankle_spring_2")
    assert [pair.seat(spring)[0].spring.hand for spring in pair.springs] == ["right", "left"]
    mirrored, other = manifold(first.mesh.scaled((1, 1, -1))), manifold(second.mesh)
    assert (mirrored ^ other).volume() == pytest.approx(second.mesh.volume, rel=0.01)  # chords of both
    assert (manifold(first.mesh) ^ other).volume() == 0.0
    for angle in (80.0, 170.0):  # loaded too
        low, high = (pair.mesh_at(spring, angle).vertices for spring in (second, first))
        assert low[:, 2].min() == pytest.approx(-high[:, 2].max(), abs=1e-9)
        assert low[:, 0].max() == pytest.approx(high[:, 0].max(), abs=1e-3)


def test_the_lower_half_is_alike_on_both_sides_and_its_dowels_go_through(pair: BuiltJoint) -> None:
    lower = pair.part("lower").solid
    assert lower.intersect(lower.mirror("XY")).Volume() == pytest.approx(lower.Volume(), rel=1e-6)
    box = pair.part("lower_arm_shaft").solid.BoundingBox()
    assert box.zmin == pytest.approx(-box.zmax)
    assert box.zmax > pair.layout.floor_top + SPRING.wire_diameter
    above, below = (pair.part(f"{half}_keeper").solid.BoundingBox() for half in ("upper", "upper_2"))
    assert (below.zmin, below.zmax) == pytest.approx((-above.zmax, -above.zmin))


def test_gates_see_a_second_spring_without_room_and_without_shafts(pair: BuiltJoint) -> None:
    blind = build_lower(PAIR, replace(pair.layout, mirrored=False))
    parts = tuple(replace(p, solid=blind, mesh=mesh_of(blind)) if p.family == "lower" else p for p in pair.parts)
    failed = [c for c in check_interference(BuiltJoint(PAIR, pair.layout, parts)) if not c.passed]
    assert any(c.name == "overlap" and "the lower half," in c.text for c in failed)
    shaft = pair.part("upper_2_arm_shaft")
    moved = replace(shaft, solid=shaft.solid.translate((1.0, 0.0, 0.0)))
    parts = tuple(moved if p is shaft else p for p in pair.parts)
    failed = [c for c in check_arms(BuiltJoint(PAIR, pair.layout, parts)) if not c.passed]
    assert [c.part for c in failed] == ["ankle_upper_2_arm_shaft"]


def test_two_share_the_torque() -> None:
    """Upper dowels bear half each; the lower ones' seats what both press and what they differ, in closed form."""
    lone, both = lay_out(ONE), lay_out(PAIR)
    assert both.coil_start - both.floor_top == pytest.approx(lone.coil_start - lone.floor_top)
    name = "upper dowel, bending"
    assert stress_of(PAIR, name) == pytest.approx(stress_of(ONE, name) / 2)
    name = "ears' bores, pressure"
    assert stress_of(PAIR, name) == pytest.approx(stress_of(ONE, name))
    force = PAIR.loads.spring_rate * math.radians(139.0 - 80.0) * 1e3 / both.pin_reach / 2
    drift = SPRING.drawn_pitch / (2 * math.pi * SPRING.radius) * both.pin_reach
    arm, floor = both.coil_start - drift - both.floor_top, PAIR.floor_thickness
    weaker = (1 - UNEVEN) * force
    moment = (force - weaker) * (arm + floor / 2)
    pressure = (force + weaker) / (PAIR.pin_diameter * floor) + 6 * moment / (PAIR.pin_diameter * floor**2)
    assert stress_of(PAIR, "lower dowel's seat, pressure") == pytest.approx(pressure)


def test_the_damper_s_screws_keep_off_the_second_arm_s_shafts(pair: BuiltJoint) -> None:
    layout = pair.layout
    pins = (layout.upper.bearing, layout.upper.keeper)

    def nearest(screws: tuple[tuple[float, float], ...]) -> float:
        return min(math.dist(screw, pin) for screw in screws for pin in pins)

    assert nearest(layout.screws) >= nearest(damper_screws(PAIR.damper, None))
    assert all(math.hypot(*screw) == pytest.approx(19.0) for screw in layout.screws)
    reach = math.hypot(*pins[0])
    crowded = replace(PAIR, damper=DamperDimensions(2 * reach - 8.0, 12.0, 2 * reach, 12))
    with pytest.raises(DimensionError, match=r"ankle\.damper\.bolt_circle = .*come within .* of the arm's shafts"):
        lay_out(crowded)
    assert assemble(replace(crowded, springs=1), lay_out(replace(crowded, springs=1))).layout.mirrored is False


@pytest.mark.parametrize("springs", [0, 3, 1.5])
def test_no_other_number_is_drawn(springs: float) -> None:
    with pytest.raises(DimensionError, match=r"ankle\.springs = .*: allowed is 1 or 2"):
        lay_out(replace(ONE, springs=springs))
