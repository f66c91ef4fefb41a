"""Layers and mounts of the laminate leg: read back, measured, and compared with the dimensions."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import cadquery as cq
import ezdxf
import pytest

from synth.cad.hopper_joint import (
    TAB,
    HopperDimensions,
    HopperParts,
    _cut_note,
    assembly,
    export_hopper,
    hinges,
    hub,
    layers,
    mount,
)
from synth.cad.limits import DimensionError

LEG = HopperDimensions(
    upper=120.0, lower=120.0, hip_spacing=30.0, width=15.0, thickness=1.7, film=0.1, adhesive=0.015, gap=0.2073,
    adhesive_gap=0.2, crouch=39.0, extended=10.0, shaft=3.0, motor=(12.0, 10.0), round_motor=False, sheet=600.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, HopperParts]:
    folder = tmp_path_factory.mktemp("parts")
    return folder, export_hopper(LEG, folder)


def outlines(path: Path, layer: str = "PLATE") -> list[tuple[float, float, float, float]]:
    """Least x, greatest x, least y, greatest y of each closed outline on a layer."""
    found = []
    for item in ezdxf.readfile(path).modelspace().query(f'LWPOLYLINE[layer=="{layer}"]'):
        assert item.closed
        xs, ys = zip(*((x, y) for x, y, *_ in item.get_points()), strict=True)
        found.append((min(xs), max(xs), min(ys), max(ys)))
    return sorted(found)


def test_fold_lines_are_one_link_apart(written: tuple[Path, HopperParts]) -> None:
    space = ezdxf.readfile(written[0] / "3_film.dxf").modelspace()
    folds = sorted(line.dxf.start.x for line in space.query('LINE[layer=="FOLD"]'))
    assert [b - a for a, b in pairwise(folds)] == pytest.approx([120.0] * 4)
    assert len(outlines(written[0] / "3_film.dxf")) == 1


def test_layers_leave_the_hinge_gap_and_room_to_fold(
    written: tuple[Path, HopperParts],
) -> None:
    for name, gaps in (
        ("1_outer_rigid", [LEG.hinge_gap(f) for _, _, f in hinges(LEG)]),
        ("5_inner_rigid", [LEG.cut_back(f) for _, _, f in hinges(LEG)]),
    ):
        plates = outlines(written[0] / f"{name}.dxf")
        assert len(plates) == 6
        found = [after[0] - before[1] for before, after in pairwise(plates)]
        assert found == pytest.approx(gaps, abs=1e-6)
    for _, _, fold in hinges(LEG):
        corner = LEG.rigid * math.tan(math.radians(fold / 2))  # how far an inner edge moves towards the fold
        assert LEG.cut_back(fold) / 2 >= corner


def test_adhesive_clears_the_hinges_and_holes_pass_every_layer(
    written: tuple[Path, HopperParts],
) -> None:
    made = {layer.name: layer for layer in written[1].layers}
    for rigid, adhesive in (("1_outer_rigid", "2_adhesive"), ("5_inner_rigid", "4_adhesive")):
        for plate, glue in zip(made[rigid].plates, made[adhesive].plates, strict=True):
            assert glue[0] >= plate[0] - 1e-9
            assert glue[1] <= plate[1] + 1e-9
    assert len({layer.holes for layer in made.values()}) == 1
    assert sum(layer.thickness for layer in made.values()) == pytest.approx(LEG.thickness)


def test_the_upper_links_have_holes_where_the_hub_s_arm_has_them(written: tuple[Path, HopperParts]) -> None:
    """From the hip's fold in the strip, and from the shaft axis in the hub; the tab's own are on its other side."""
    _, made = written
    cylinders = cq.Workplane(obj=hub(LEG)).faces("%CYLINDER").vals()
    arm = {round(face.Center().x, 6) for face in cylinders if abs(face.Center().x) > LEG.shaft}
    folds = (made.layers[0].folds[0], made.layers[0].folds[-1])
    inside = {round(abs(x - fold), 6) for fold in folds for x, _ in made.layers[0].holes
              if min(folds) < x < max(folds) and abs(x - fold) < 50.0}  # fmt: skip
    assert inside == arm == {LEG.arm}


def test_what_the_hip_lacks_is_told(written: tuple[Path, HopperParts]) -> None:
    """As long as the drawn hub and link share room."""
    parts = {child.name: child.obj.val().moved(child.loc) for child in assembly(LEG).children}
    assert parts["hub_right"].intersect(parts["upper_right"]).Volume() > 1.0
    assert "the hip is not complete" in written[1].notes[0]
    assert "never to the hip tab" in written[1].notes[0]


def test_link_masses_equal_those_of_the_strip() -> None:
    """Rigid area over the four links, times thickness and density, against density w t per length; gaps apart."""
    outer = layers(LEG)[0]
    links = outer.plates[1:-1]
    area = sum(end - begin for begin, end in links) * LEG.width
    gaps = sum(LEG.hinge_gap(fold) for _, _, fold in hinges(LEG)[1:4]) + LEG.hinge_gap(hinges(LEG)[0][2])
    assert area == pytest.approx((4 * 120.0 - gaps) * 15.0)


def test_mount_and_hub_are_valid_solids_at_their_places(written: tuple[Path, HopperParts]) -> None:
    solid = cq.importers.importStep(str(written[0] / "motor_mount.step")).val()
    assert solid.isValid()
    box = solid.BoundingBox()
    assert box.xlen == pytest.approx(30.0 + 12.2 + 4.0)
    wide, high = 30.0 + 12.2 + 4.0, 10.2 + 4.0
    assert mount(LEG).Volume() == pytest.approx((wide * high - 2 * 12.2 * 10.2) * 12.0, rel=1e-6)
    made = hub(LEG)
    assert made.isValid()
    assert len(cq.Workplane(obj=made).solids().vals()) == 1
    assert mount(replace(LEG, motor=(20.0, 20.0), round_motor=True)).isValid()


def test_the_assembly_is_in_the_crouch_pose() -> None:
    made = assembly(LEG)
    assert {child.name for child in made.children} == {
        "mount", "upper_right", "lower_right", "hub_right", "upper_left", "lower_left", "hub_left"
    }  # fmt: skip
    box = made.toCompound().BoundingBox()
    deepest = 120.0 * (math.cos(math.radians(39.0)) + math.cos(math.radians(LEG.lower_angle(39.0))))
    assert -box.ymin == pytest.approx(deepest, abs=1.0)


def test_the_same_leg_gives_the_same_bytes(written: tuple[Path, HopperParts], tmp_path: Path) -> None:
    again = export_hopper(LEG, tmp_path)
    assert again == written[1]
    for name in again.files:
        assert (tmp_path / name).read_bytes() == (written[0] / name).read_bytes(), name


@pytest.mark.parametrize(
    ("change", "dimension"),
    [({"film": 2.0}, "laminate.thickness"), ({"thickness": 30.0}, "laminate.thickness"),
     ({"hip_spacing": 10.0}, "leg.hip_spacing")],
)  # fmt: skip
def test_impossible_laminate_dimensions_are_named(change: dict[str, float], dimension: str, tmp_path: Path) -> None:
    with pytest.raises(DimensionError, match=dimension):
        export_hopper(replace(LEG, **change), tmp_path / "parts")
    assert not (tmp_path / "parts").exists()


def test_a_strip_longer_than_the_sheet_gives_a_note(tmp_path: Path) -> None:
    assert any("cut it in 2 pieces" in note for note in export_hopper(replace(LEG, sheet=300.0), tmp_path).notes)


def test_every_piece_of_a_cut_strip_fits_the_sheet() -> None:
    marks = hinges(replace(LEG, upper=200.0, lower=200.0))
    end = marks[-1][1] + TAB
    assert _cut_note(marks, end, 414.0).endswith(
        "cut it in 2 pieces at the hinge of foot (414 mm) and join the film there"
    )
    found = re.findall(r"\((\d+) mm\)", _cut_note(marks, end, 300.0))
    edges = [0.0, *map(float, found), end]
    assert max(b - a for a, b in pairwise(edges)) <= 300.0
    assert "does not fit either; use a larger sheet" in _cut_note(marks, end, 150.0)


def test_film_strain_stays_within_its_limit() -> None:
    """Bent evenly over its free length the surface strain is half the thickness times the curvature."""
    for _, _, fold in hinges(LEG):
        curvature = math.radians(fold) / LEG.hinge_gap(fold)
        assert 0.5 * LEG.film * curvature <= 0.05 + 1e-12
        assert LEG.film_strain(fold) == pytest.approx(0.5 * LEG.film * curvature)
    thin = replace(LEG, film=0.005)  # then the rate's gap is the longer one
    assert [thin.hinge_gap(fold) for fold in thin.folds] == [0.2073] * 3


def test_every_piece_is_attached_to_its_frame_until_the_release_cut(written: tuple[Path, HopperParts]) -> None:
    folder, made = written
    dowels = []
    for layer in made.layers:
        path = folder / f"{layer.name}.dxf"
        frame, *slots = sorted(outlines(path, "CUT"), key=lambda box: box[0] - box[1])
        slots.sort()
        assert len(slots) == len(layer.plates) - 1
        for slot, (before, after) in zip(slots, pairwise(layer.plates), strict=True):
            # Once the beam has taken half its kerf on each side, the plates end where they should.
            assert slot[0] - LEG.kerf / 2 == pytest.approx(before[1])
            assert slot[1] + LEG.kerf / 2 == pytest.approx(after[0])
            assert frame[2] < slot[2] < 0.0 < LEG.width < slot[3] < frame[3]  # over the strip, not through the frame
        assert all(after[0] - before[1] > 2.0 for before, after in pairwise(slots))  # what the plate hangs by
        circles = ezdxf.readfile(path).modelspace().query("CIRCLE")
        places = {(c.dxf.center.x, c.dxf.center.y) for c in circles if c.dxf.radius > 1.0}
        assert all(y < -1.0 or y > LEG.width + 1.0 for _, y in places)
        dowels.append(places)
    assert all(places == dowels[0] for places in dowels)
    assert len(dowels[0]) == 6
    ((left, right, low, high),) = outlines(folder / "6_release_cut.dxf", "CUT")
    assert right - left - LEG.kerf == pytest.approx(made.layers[0].plates[-1][1])
    assert high - low - LEG.kerf == pytest.approx(LEG.width)
