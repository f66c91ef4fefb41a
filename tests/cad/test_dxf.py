"""A drawing gives the same bytes whatever the iteration order of sets; sheets are the printed bracket in layers."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cad_joints import cleared
from synth.cad import EncoderDimensions, JointDimensions, SpringDimensions
from synth.cad.checked_layout import lay_out
from synth.cad.dxf import drawing, flat_brackets
from synth.cad.encoder_seat import build_seat
from synth.cad.joint import BuiltJoint

KNEE = SpringDimensions(3.0, 24.0, 4 + 60 / 360, 120.0)


def written(path: Path) -> bytes:
    with drawing(path) as (_, space):
        space.add_circle((0.0, 0.0), 2.0)
        space.add_lwpolyline([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], close=True)
    return path.read_bytes()


@pytest.mark.parametrize("order", [sorted, lambda names: sorted(names, reverse=True)])
def test_dxf_classes_are_written_in_a_fixed_order(
    order: Callable[[Any], list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ezdxf.entitydb import EntityDB

    usual = written(tmp_path / "usual.dxf")
    in_use = EntityDB.dxf_types_in_use
    monkeypatch.setattr(EntityDB, "dxf_types_in_use", lambda self: order(in_use(self)))
    assert written(tmp_path / "other.dxf") == usual


@pytest.mark.parametrize(("shaft", "floored"), [(8.0, False), (10.0, True), (12.0, True)])
def test_the_sheets_of_an_encoder_s_seat_have_the_floor_that_holds_it(shaft: float, floored: bool) -> None:
    """On shafts of 10 and 12 mm the collar is as wide as the sensor, which fell through one hole of 22.8 mm."""
    encoder = EncoderDimensions(bolt_circle=40.0)
    joint = cleared(
        JointDimensions("knee", KNEE, 110.0, 110.0, range=(80.0, 140.0), shaft_diameter=shaft, encoder=encoder)
    )
    layout = lay_out(joint)
    sheets = [sheet for sheet in flat_brackets(BuiltJoint(joint, layout, ())) if "encoder_seat" in sheet.name]
    # The ring lies on the sheet below it, whose hole the sensor does not pass.
    assert [sheet.name for sheet in sheets][-1] == "knee_encoder_seat_ring"
    assert sheets[-2].holes[0][1] < encoder.body_diameter / 2 - 1.0
    assert any(sheet.name == "knee_encoder_seat_floor" for sheet in sheets) is floored
    # Together they are the printed seat but for its countersinks, which take less than a cylinder each.
    areas = [math.pi * (sheet.outline**2 - sum(radius**2 for _, radius in sheet.holes)) for sheet in sheets]
    volume = sum(area * sheet.thickness for area, sheet in zip(areas, sheets, strict=True))
    printed = build_seat(joint, layout)
    assert sum(sheet.thickness for sheet in sheets) == pytest.approx(printed.BoundingBox().zlen)
    assert printed.Volume() == pytest.approx(volume, rel=0.02)
    assert printed.Volume() <= volume * (1 + 1e-9)
