"""Exported files: names, colours, units, and repeatable bytes."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import pytest

from cad_joints import cleared
from synth.cad import GateError, JointDimensions, LegDimensions, SpringDimensions, build_leg, check_leg, export_leg
from synth.cad.export import write_step
from synth.cad.step_text import normalised_step

JOINT = cleared(
    JointDimensions("left knee", SpringDimensions(2.0, 16.0, 4.17, 120.0, hand="left"), 120.0, 130.0, sign=-1)
)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    built = build_leg(LegDimensions("one", (JOINT,)))
    folder = tmp_path_factory.mktemp("parts")
    return built, folder, export_leg(built, folder, pictures=False)


def volume(solid):
    """Volume, mm^3, to 1e-9: the kernel's plain way takes a fixed number of points a face and is up to 1e-5 off."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid.wrapped, found, 1e-9, False, False)
    return found.Mass()


def test_every_part_is_there_as_step_and_stl(exported):
    built, folder, files = exported
    assert {file.path for file in files} == {path.name for path in folder.iterdir()}
    for part in built.parts:
        assert {file.kind for file in files if file.part == part.name} == {"step", "stl"}
    assert {"leg_assembly.step", "left_knee_assembly.stl", "left_knee_spring.step"} <= {file.path for file in files}


def test_the_same_leg_gives_the_same_bytes(exported, tmp_path):
    _, folder, files = exported
    again = build_leg(LegDimensions("one", (JOINT,)))
    export_leg(again, tmp_path, checks=(), pictures=False)
    assert [f.path for f in files if (folder / f.path).read_bytes() != (tmp_path / f.path).read_bytes()] == []


def test_step_round_trips_names_colours_and_volumes(exported):
    import cadquery as cq

    built, folder, _ = exported
    assembly = cq.Assembly.importStep(str(folder / "leg_assembly.step"))
    back = {child.name: child for child in assembly.children}
    assert set(back) == {part.name for part in built.parts}
    for part in built.parts:
        red, green, blue, _ = back[part.name].color.toTuple()
        assert (red, green, blue) == pytest.approx(part.colour, abs=0.005)
        assert volume(back[part.name].obj) == pytest.approx(volume(part.solid), rel=1e-8)


def test_single_part_step_has_one_solid_in_millimetres(exported):
    import cadquery as cq

    built, folder, _ = exported
    for part in built.parts:
        shape = cq.importers.importStep(str(folder / f"{part.name}.step"))
        assert shape.solids().size() == 1
        assert volume(shape.val()) == pytest.approx(volume(part.solid), rel=1e-8)
    assert "MILLI" in (folder / "left_knee_upper.step").read_text()


def test_stl_is_closed_and_has_the_solid_s_volume(exported):
    import trimesh

    built, folder, _ = exported
    for part in built.parts:
        mesh = trimesh.load_mesh(folder / f"{part.name}.stl")
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(part.solid.Volume(), rel=5e-3)


def test_nothing_is_written_when_a_gate_fails(exported, tmp_path):
    built, _, _ = exported
    results = check_leg(built)
    bad = (*results[:-1], replace(results[-1], passed=False))
    with pytest.raises(GateError):
        export_leg(built, tmp_path / "parts", checks=bad)
    assert not (tmp_path / "parts").exists()


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written_is_an_os_error(exported, tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OSError, match="parts"):
        export_leg(exported[0], tmp_path / "parts", checks=(), pictures=False)


def test_a_file_instead_of_the_folder_is_an_os_error(exported, tmp_path):
    (tmp_path / "parts").write_text("")
    with pytest.raises(OSError, match="parts"):
        export_leg(exported[0], tmp_path / "parts", checks=(), pictures=False)


def test_normalising_step_refuses_an_unknown_layout():
    text = (
        "FILE_NAME('x','2026-01-01T00:00:00',('A'));\n"
        "#1 = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(#2),#9);\n"
        "#2 = OVER_RIDING_STYLED_ITEM();\nENDSEC;\n"
    )
    with pytest.raises(ValueError, match="unknown style"):
        normalised_step(text)


def test_colours_begin_with_a_statement_and_not_with_a_name_that_holds_its_word():
    style = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"
    text = f"FILE_NAME('x','2026-01-01T00:00:00',('A'));\nDATA;\n#7 = PRODUCT('#1 = {style}(',#3);\nENDSEC;\n"
    assert normalised_step(text) == text.replace("2026", "2000")
    text = text.replace("'#1 = ", "'na\u00efve #1 = ")
    assert "na\\X2\\00EF\\X0\\ve" in normalised_step(text)


def test_pictures_are_not_blank(leg, tmp_path):
    import numpy as np
    from matplotlib.image import imread

    from synth.cad.export import PreviewError, draw_leg

    one = build_leg(LegDimensions("one", (JOINT,)))
    try:
        files = draw_leg(one, tmp_path)
    except PreviewError as error:
        pytest.skip(str(error))
    assert {file.path for file in files} >= {"leg.png", "left_knee.png", "left_knee_inside.png", "left_knee_spring.png"}
    for file in files:
        pixels = imread(tmp_path / file.path)[..., :3]
        inked = np.any(pixels < 0.97, axis=-1)
        assert 0.02 < inked.mean() < 0.9
        assert not inked[[0, -1]].any()  # nothing is cut off at the border


def test_a_machine_without_graphics_gets_a_message_not_a_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    """A minimal Debian has libGL without libEGL: vtk would then open an X window, find no screen and crash."""
    import ctypes

    from synth.cad.preview import Camera, PreviewError

    def missing(name: str) -> None:
        raise OSError(f"{name}: cannot open shared object file")

    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(ctypes, "CDLL", missing)
    with pytest.raises(PreviewError, match="apt-get install libegl1"):
        Camera()


def test_unicode_joint_names_round_trip_through_step(tmp_path: Path) -> None:
    assembly = cq.Assembly(name="part").add(cq.Workplane().box(1, 2, 3), name="Hüfte_膝.1_upper")
    write_step(assembly, tmp_path / "x.step")
    text = (tmp_path / "x.step").read_text(encoding="ascii")
    assert r"'H\X2\00FC\X0\fte_\X2\819D\X0\.1_upper'" in text
    assert [child.name for child in cq.Assembly.importStep(str(tmp_path / "x.step")).children] == ["Hüfte_膝.1_upper"]
