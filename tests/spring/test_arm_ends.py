"""The arms of a spring alone pass the load: a pin that presses where the sheet says stands on the wire."""

from __future__ import annotations

import math
from pathlib import Path

import cadquery as cq
import ezdxf
import pytest

from synth.files.shown_units import METRIC
from synth.parts.catalogs import Catalogue
from synth.spring.evaluate import check_spring
from synth.spring.loose_test import arm_to_end
from synth.spring.spring_files import write_request, write_solid
from synth.spring.spring_result import SpringDesign
from synth.spring.spring_task import SameArm, SpringTask
from synth.spring.winding_sheet import request_lines, winding_sheet

WIRE, MEAN, COILS, LOAD = 3e-3, 20e-3, 5 + 1 / 6, 25e-3


def spring(load: float = LOAD, **task: object) -> SpringDesign:
    music = Catalogue.load().find_material("music")
    return check_spring(music, WIRE, MEAN, COILS, SpringTask(0.5, leg_lengths=(load, load), **task))  # type: ignore[arg-type]


def test_the_shortest_arm_within_its_tolerance_still_carries_the_pin() -> None:
    """DIN 2194, grade 3: (0.2 d + 1.6) c, c = 0.8 to 30 mm, 1.3 to 120 mm; half a pin and two wires beyond it."""
    assert arm_to_end(3e-3, 25e-3) == pytest.approx(35.5e-3)  # 25 + 7.5 + (0.6 + 1.6) 1.3 = 35.36
    assert arm_to_end(0.5e-3, 10e-3) == pytest.approx(13.0e-3)  # 10 + 1.25 + (0.1 + 1.6) 0.8 = 12.61
    assert arm_to_end(3e-3, 0.0) == 0.0  # loaded at the coil
    assert arm_to_end(3e-3, 2.0) > 2.0075


def test_wire_and_mass_reach_to_the_ends_while_rate_and_stress_are_those_at_the_load() -> None:
    made = spring()
    end = 35.5e-3
    assert made.leg_lengths == (LOAD, LOAD)
    assert made.arm_lengths == pytest.approx((end, end))
    helix = COILS * math.hypot(math.pi * MEAN, WIRE)
    assert made.wire_length == pytest.approx(helix + 2 * end)
    assert made.mass == pytest.approx(7860 * math.pi / 4 * WIRE**2 * made.wire_length, rel=0.01)
    active = COILS + 2 * LOAD / (3 * math.pi * MEAN)  # Shigley eq. 10-48
    rate = made.elastic_modulus * WIRE**4 / (64 * MEAN * active)  # N m/rad
    assert made.rate == pytest.approx(rate, rel=1e-9)
    assert made.test.distances == (LOAD, LOAD)


def test_both_lengths_are_on_the_sheet_and_on_the_quotation() -> None:
    made = spring()
    assert "each 35.5 mm from the coil to its end; the load acts 25 mm from the coil" in winding_sheet(made)
    assert "Arms: tangent, 35.5 and 35.5 mm from the coil to the end; the load acts 25 mm from the coil" in "\n".join(
        request_lines(made)
    )
    written = made.as_json()
    assert [each["value"] for each in written["leg_lengths"]] == [25.0, 25.0]
    assert [each["value"] for each in written["arm_lengths"]] == [35.5, 35.5]
    clamped = spring(free_arm=SameArm(LOAD))  # a joint holds it to its end
    assert clamped.arm_lengths == clamped.leg_lengths
    assert "the load acts" not in winding_sheet(clamped)


def test_the_measured_solid_reaches_beyond_the_pin(tmp_path: Path) -> None:
    """By the STEP file: its volume over the wire's section, and the far end of the arm's tangent from the axis."""
    made = spring()
    write_solid(made, tmp_path)
    solid = cq.importers.importStep(str(tmp_path / "spring.step")).val()
    length = solid.Volume() / (math.pi / 4 * (WIRE * 1e3) ** 2)
    assert length == pytest.approx(made.wire_length * 1e3, rel=2e-3)
    reach = max(math.hypot(vertex.X, vertex.Y) for vertex in solid.Vertices())
    assert reach >= math.hypot(LOAD * 1e3 + 2 * WIRE * 1e3, MEAN * 1e3 / 2)


def test_the_drawing_for_the_quotation_has_the_arms_to_their_ends(tmp_path: Path) -> None:
    write_request(spring(), METRIC, tmp_path / "q.dxf")
    drawn = ezdxf.readfile(tmp_path / "q.dxf")
    texts = " ".join(entity.dxf.text for entity in drawn.modelspace().query("TEXT"))
    assert "35.5" in texts
