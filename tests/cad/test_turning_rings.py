"""Rings that hold a turning body at every angle, and what they leave to be tested pose by pose."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from synth.cad.free_wire import FreeWire, free_wire
from synth.cad.joint import BuiltJoint
from synth.cad.parts import BuiltPart, Mesh
from synth.cad.travel import Bodies, check_spring_room, check_within, gather_meshes, spring_overlaps, turn_solid
from synth.cad.turning_rings import Ring, body_of, meeting_place, rings_of


@pytest.fixture(scope="module")
def knee(leg) -> BuiltJoint:
    return leg.joints[1]


@pytest.fixture(scope="module")
def bodies(knee) -> Bodies:
    return Bodies(knee)


def with_needle(knee: BuiltJoint, place: tuple[float, float, float], size: float) -> BuiltJoint:
    """The joint with a screw of the upper half thinned to a needle about a place."""
    screw = knee.part("upper_screw_1")
    vertices = np.asarray(screw.mesh.vertices - screw.mesh.vertices.mean(axis=0)) * [0.1, 0.1, size]
    needle = Mesh(vertices, screw.mesh.faces).turned(0.0, place)
    return BuiltJoint(
        knee.dimensions, knee.layout, tuple(replace(p, mesh=needle) if p is screw else p for p in knee.parts)
    )


def test_a_ring_has_its_volume():
    ring = body_of([Ring(3.0, 5.0, -1.0, 2.0)])
    assert ring.volume() == pytest.approx(np.pi * (25.0 - 9.0) * 3.0, rel=2e-3)
    assert body_of([]).is_empty()


@pytest.mark.parametrize("suffix", ["shaft", "collar_a", "thrust_washer_b", "pin"])
def test_rings_hold_a_part_at_every_angle(knee, suffix):
    part = knee.part(suffix)
    held = body_of(rings_of(part.mesh))
    for angle in (0.0, 17.0, 111.0):
        assert (turn_solid(part.mesh.manifold, angle) - held).volume() == pytest.approx(0.0, abs=1e-9)


def test_the_meeting_place_holds_all_that_two_halves_have_in_common(bodies):
    meshes = {group: [p.mesh for p in bodies.parts[group] if p.name in bodies.names[group]] for group in bodies.parts}
    place = meeting_place(meshes["upper"], meshes["lower"])
    for turn in range(0, 360, 24):
        lower = turn_solid(bodies.moving["lower"], turn)
        whole = float((bodies.moving["upper"] ^ lower).volume())
        cut = float((bodies.meeting["upper"] ^ turn_solid(bodies.meeting["lower"], turn)).volume())
        assert cut == pytest.approx(whole, abs=1e-3)
    common = bodies.moving["upper"] ^ turn_solid(bodies.moving["lower"], 160.0)
    assert common.volume() > 10.0
    assert (common - place).volume() == pytest.approx(0.0, abs=1e-6)


def test_a_body_round_the_axis_is_met_within():
    """The ring lies in the middle of a solid cylinder, whose surface it does not reach."""
    whole, inside = (body_of([ring]) for ring in (Ring(0.0, 9.0, -5.0, 5.0), Ring(3.0, 4.0, -2.0, 2.0)))
    meshes = []
    for body in (whole, inside):
        found = body.to_mesh()
        meshes.append(Mesh(np.array(found.vert_properties, dtype=float), np.array(found.tri_verts, dtype=np.int64)))
    place = meeting_place(meshes[:1], meshes[1:])
    assert (inside - place).volume() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("sides", [None, 10])
def test_arms_and_coil_make_up_the_wire(knee, sides):
    angle = knee.dimensions.stop_angles[1]
    wire = free_wire(knee.dimensions, knee.layout, angle, sides)
    first, last = wire.coil
    coil = FreeWire(wire.sections[first : last + 1], wire.ends, (0, last - first), wire.signs)
    vertices = np.vstack([coil.sections.reshape(-1, 3), coil.sections[0].mean(axis=0), coil.sections[-1].mean(axis=0)])
    middle = replace(coil, ends=vertices[-2:]).whole()
    assert wire.arms().volume + middle.volume == pytest.approx(wire.whole().volume, rel=1e-9)
    held = body_of([wire.coil_ring()])
    assert (middle.manifold - held).volume() == pytest.approx(0.0, abs=1e-6)


def test_a_free_coil_is_cleared_for_every_angle_at_once(bodies, knee):
    angles = knee.dimensions.stop_angles
    wires = [bodies.wires(angle)[0] for angle in angles]
    assert bodies.clear_of_coils(wires) == ["upper", "lower"]
    assert {group: volume for group, (volume, _) in spring_overlaps(bodies).items()} == {"upper": 0.0, "lower": 0.0}


@pytest.mark.parametrize("radius", [9.0, 12.0, 15.0])
def test_a_needle_among_the_coils_is_found(knee, radius):
    """No ring clears it, so the poses are tested with the whole spring; 15 mm is beside the coil's mean radius 13.0."""
    joint = with_needle(knee, (0.0, radius, knee.layout.coil_start + knee.layout.coil_height / 2), 1.0)
    bodies = Bodies(joint)
    whole = max(float((bodies.coils(angle)[0] ^ bodies.halves["upper"]).volume()) for angle in (75.0, 119.0, 151.0))
    failed = [c for c in check_spring_room(bodies) if c.name == "overlap" and "upper" in c.text and not c.passed]
    assert bool(failed) == (whole > 0.05)


def test_gathered_bodies_that_touch_have_the_volume_of_both(knee):
    parts: list[BuiltPart] = [knee.part(suffix) for suffix in ("thrust_washer_a", "collar_a")]
    together = gather_meshes([part.mesh for part in parts])
    assert together.volume() == pytest.approx(sum(part.mesh.volume for part in parts), rel=1e-6)


def test_a_part_pushed_into_its_neighbours_is_named(knee):
    collar = knee.part("collar_b")
    pushed = replace(collar, mesh=collar.mesh.turned(0.0, (2.0, 0.0, 0.0)))
    joint = BuiltJoint(knee.dimensions, knee.layout, tuple(pushed if p is collar else p for p in knee.parts))
    [lower] = [check for check in check_within(Bodies(joint)) if "lower half" in check.text]
    assert not lower.passed
    assert f"{knee.part('shaft').name} in {collar.name}" in lower.text


def test_a_joint_sent_to_another_process_is_the_same(knee):
    copy = pickle.loads(pickle.dumps(knee))
    for part, other in zip(knee.parts, copy.parts, strict=True):
        np.testing.assert_array_equal(part.mesh.vertices, other.mesh.vertices)
        assert float(other.solid.Volume()) == pytest.approx(float(part.solid.Volume()), rel=1e-12)
