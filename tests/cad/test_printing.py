"""Walls, overhang, orientation and bed on bodies with known answers."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from synth.cad.checked_layout import clear_upper_arm_angle
from synth.cad.dimensions import JointDimensions, SpringDimensions
from synth.cad.fittings import PrintDimensions
from synth.cad.joint import build_joint
from synth.cad.parts import Mesh
from synth.cad.print_file import laid
from synth.cad.printing import (
    WAYS_UP,
    PrintPlan,
    best_of,
    check_printing,
    contact,
    hanging_faces,
    on_bed,
    overhang,
    thin_points,
    wall_thickness,
)
from synth.cad.travel import manifold

pytest.importorskip("manifold3d")


def mesh_of(solid) -> Mesh:
    found = solid.to_mesh()
    return Mesh(np.asarray(found.vert_properties, dtype=float)[:, :3], np.asarray(found.tri_verts, dtype=np.int64))


def box(x, y, z, at=(0.0, 0.0, 0.0)):
    import manifold3d

    return manifold3d.Manifold.cube((x, y, z)).translate(at)


def rod(height, radius):
    import manifold3d

    return manifold3d.Manifold.cylinder(height, radius, circular_segments=256)


def test_the_wall_thickness_of_a_box_is_measured():
    shell = mesh_of(box(40, 30, 20) - box(36, 26, 16, (2, 2, 2)))
    _, thickness = wall_thickness(shell)
    assert np.percentile(thickness, [0, 1, 50]) == pytest.approx([2.0] * 3, abs=1e-4)  # the rest runs along a wall
    assert len(thin_points(shell, 1.9)) == 0
    thin = mesh_of(box(40, 30, 20) - box(36, 26, 17.5, (2, 2, 2)))
    points = thin_points(thin, 1.2)
    assert len(points) > 50
    assert np.all(points[:, 2] > 19.4)  # the lid of 0.5 mm


def test_a_table_s_underside_needs_support_but_not_upside_down():
    table = mesh_of(box(30, 30, 4, (0, 0, 20)) + box(10, 10, 21, (10, 10, 0)))
    assert overhang(table, WAYS_UP["+z"], 45.0) == pytest.approx(30 * 30 - 10 * 10)
    assert overhang(table, WAYS_UP["-z"], 45.0) == 0.0


@pytest.mark.parametrize(("lean", "needs"), [(40.0, False), (50.0, True)])
def test_a_leaning_wall_needs_support_beyond_the_limit(lean, needs):
    import manifold3d

    shift = 20.0 * math.tan(math.radians(lean))
    corners = [(x + (shift if z else 0.0), y, z) for x in (0, 5) for y in (0, 10) for z in (0.0, 20.0)]
    mesh = mesh_of(manifold3d.Manifold.hull_points(np.array(corners)))
    assert bool(len(hanging_faces(mesh, WAYS_UP["+z"], 45.0))) is needs


def test_a_part_is_turned_to_fit_the_bed():
    mesh = mesh_of(box(150, 300, 100))
    assert on_bed(mesh, WAYS_UP["+z"], (320.0, 160.0, 154.0)) == ((300.0, 150.0, 100.0), True)
    assert not on_bed(mesh, WAYS_UP["+y"], (320.0, 160.0, 154.0))[1]
    assert not on_bed(mesh, WAYS_UP["+z"], (320.0, 140.0, 154.0))[1]


def test_the_contact_with_the_bed_is_that_of_the_flat_faces_there():
    table = mesh_of(box(30, 30, 4, (0, 0, 20)) + box(10, 10, 21, (10, 10, 0)))
    assert contact(table, WAYS_UP["+z"]) == pytest.approx(100.0)
    assert contact(table, WAYS_UP["-z"]) == pytest.approx(900.0)
    cylinder = mesh_of(rod(20.0, 5.0))
    assert contact(cylinder, WAYS_UP["+z"]) == pytest.approx(math.pi * 25.0, rel=0.01)
    assert contact(cylinder, WAYS_UP["+x"]) < 0.05 * 20.0 * 10.0


def test_of_alike_overhangs_the_one_with_more_contact_is_taken():
    def plan(up, hangs, lies, high=10.0, *, strong=True):
        return PrintPlan("part", up, hangs, 0.1, (89.0, 47.0, high), True, strong, lies)

    assert best_of([plan("+z", 2109.0, 62.0), plan("-z", 2300.0, 2400.0)]).up == "-z"
    assert best_of([plan("+z", 900.0, 62.0), plan("-z", 2300.0, 2400.0)]).up == "+z"
    assert best_of([plan("+z", 0.0, 470.0), plan("-y", 40.0, 480.0)]).up == "+z"
    assert best_of([plan("+z", 64.0, 588.0, 30.0), plan("-z", 64.0, 588.0, 20.0)]).up == "-z"
    assert best_of([plan("+y", 100.0, 900.0, strong=False), plan("+z", 2109.0, 62.0)]).up == "+z"
    assert plan("+z", 2109.0, 62.0).wobbly
    assert not plan("+z", 894.0, 3186.0).wobbly


@pytest.mark.parametrize("up", WAYS_UP)
def test_a_part_is_laid_in_its_print_orientation(up):
    mesh = mesh_of(box(3, 5, 7) + box(1, 1, 1, (3, 0, 0)))
    turned = laid(mesh, up)
    assert turned.volume == pytest.approx(mesh.volume)
    assert turned.vertices.min(axis=0) == pytest.approx([0, 0, 0])
    axis = int(np.argmax(np.abs(WAYS_UP[up])))
    assert np.ptp(turned.vertices[:, 2]) == pytest.approx(np.ptp(mesh.vertices[:, axis]))
    # What pointed up points up: the highest points are those that lay furthest that way.
    old = mesh.vertices @ np.array(WAYS_UP[up])
    assert np.allclose(turned.vertices[:, 2], old - old.min())


@pytest.mark.parametrize("across", [False, True], ids=["wide", "deep"])
def test_plates_hold_every_printed_part_without_overlap(leg, across):
    """Found on a leg of three joints: one file held all rows, whatever the bed's depth; a deep bed was a wide one."""
    from synth.cad.print_file import plates
    from synth.cad.printing import plan_part

    printing = leg.dimensions.printing
    if across:
        printing = replace(printing, bed=(printing.bed[1], printing.bed[0], printing.bed[2]))
    plans = [(part, plan_part(joint, part, printing)) for joint in leg.joints for part in joint.parts if part.printed]
    found = plates(plans, printing.bed)
    assert sorted(part.name for plate in found for part, _ in plate) == sorted(part.name for part, _ in plans)
    assert len(found) > 1
    wide, deep = printing.bed[:2]
    for plate in found:
        boxes = [(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for _, mesh in plate]
        for low, high in boxes:
            assert low.min() >= -1e-9
            assert high[0] <= wide + 1e-9
            assert high[1] <= deep + 1e-9
        for index, (low, high) in enumerate(boxes):
            for other_low, other_high in boxes[index + 1 :]:
                assert np.any((high[:2] <= other_low[:2]) | (other_high[:2] <= low[:2]))
    for part, mesh in (item for plate in found for item in plate):
        assert mesh.volume == pytest.approx(part.mesh.volume, rel=1e-9)  # turned, not mirrored


@pytest.mark.parametrize(("wall", "thinnest", "passes"), [(1.5, 1.2, True), (1.5, 1.5, False), (1.9, 1.2, True)])
def test_what_the_flats_for_the_cross_screw_leave_of_a_socket_is_a_wall(
    wall: float, thinnest: float, passes: bool
) -> None:
    """With a wall of 1.5 mm 0.97 mm were left under head and nut, and all checks passed: the flats are small.

    The socket now grows until 1.2 mm are left; a printer that asks for more has its check.
    """
    knee = JointDimensions("knee", SpringDimensions(3.429, 26.035, 7.17, 120.0), 111.0, 119.0, wall=wall)
    joint = build_joint(replace(knee, upper_arm_angle=clear_upper_arm_angle(knee)))
    found = check_printing(joint, PrintDimensions(thinnest=thinnest))
    sockets = [check for check in found if "socket" in check.text]
    assert [check.part for check in sockets] == ["knee_upper", "knee_lower"]
    assert [check.passed for check in sockets] == [passes] * 2
    # Independently: a ray into the half as drawn, beside the screw's hole, where the tube's bore has receded.
    layout, aside, bore = joint.layout, 2.2, 10.1
    at = (aside, layout.upper_bottom + layout.socket_depth / 2)
    first, second = manifold(joint.part("upper").mesh).ray_cast((*at, 100.0), (*at, 0.0))[:2]
    receded = bore - (bore**2 - aside**2) ** 0.5
    assert first.position[2] - second.position[2] == pytest.approx(sockets[0].value + receded, abs=0.02)
