"""The drawing of a damper: known sizes are used, unknown ones are named with their keys."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from synth.design.damper_drawing import damper_of
from synth.design.damper_sizes import ASKED, drawn_damper
from synth.files.project_options import DamperShape
from synth.remarks import severity_of

KNOWN = {
    "outer_diameter": 0.042, "body_length": 0.018, "bolt_circle": 0.054, "bolts": 3, "bolt_diameter": 0.0045,
    "shaft_side": "bore", "shaft_form": "square", "shaft_size": 0.006,
}  # fmt: skip


def test_known_sizes_are_drawn_and_none_is_requested() -> None:
    found = drawn_damper(KNOWN, 8.0, "cad.dampers.hip")
    sizes = (found.outer_diameter, found.body_length, found.bolt_circle, found.bolt_diameter)
    assert sizes == pytest.approx((42.0, 18.0, 54.0, 4.5))
    assert (found.bolt_count, found.adapter) == (3, None)
    assert (found.bore.form, found.bore.size) == ("square", pytest.approx(6.0))
    assert found.unknown == ()


def test_unknown_sizes_are_named_with_their_keys() -> None:
    found = drawn_damper({}, 8.0, "cad.dampers.hip")
    assert len(found.unknown) == len(ASKED)
    assert "the circle of its screws (cad.dampers.hip.bolt_circle)" in found.unknown
    one = drawn_damper({key: value for key, value in KNOWN.items() if key != "bolts"}, 8.0, "cad.dampers.hip")
    assert one.unknown == ("their number (cad.dampers.hip.bolts)",)


@pytest.mark.parametrize("form", ["round", "d", "square", "hex"])
def test_a_damper_with_its_own_shaft_gets_an_adapter(form: str) -> None:
    found = drawn_damper({**KNOWN, "shaft_side": "shaft", "shaft_form": form}, 8.0, "cad.dampers.hip")
    assert found.adapter is not None
    assert (found.adapter.form, found.adapter.output_diameter) == (form, pytest.approx(6.0))
    assert found.adapter.output_grip >= 2 * 6.0


def test_screws_of_a_small_damper_lie_outside_the_collar() -> None:
    """Of a damper of 11 mm nothing else is known; the collars of 8 and 10 mm shafts are 16 and 20 mm wide."""
    found = drawn_damper({"outer_diameter": 0.011}, 8.0, "cad.dampers.hip")
    assert found.bolt_circle == pytest.approx(30.0)


def test_a_damper_that_nothing_drives_is_refused_where_measured_and_said_where_assumed() -> None:
    measured = drawn_damper({**KNOWN, "shaft_form": "round", "shaft_size": 0.008}, 8.0, "cad.dampers.hip")
    assert [problem.dimension for problem in measured.problems("hip.damper.")] == ["hip.damper.bore.hub"]
    held = drawn_damper({**KNOWN, "shaft_form": "round", "hub": "clamp"}, 8.0, "cad.dampers.hip")
    assert not held.problems()
    assert not held.bore.slips
    for shape, decides in ((DamperShape(), 1), (DamperShape(shaft_side="bore", shaft_form="square"), 0)):
        alone = SimpleNamespace(pieces=1, ratio=1.0)
        option = SimpleNamespace(row=None, arrangement=alone, part="", label="a damper", turns=None)
        cad = SimpleNamespace(damper_shafts={}, dampers={"hip": shape})
        design: Any = SimpleNamespace(
            dampers=SimpleNamespace(chosen=[option]),
            built=SimpleNamespace(joint_names=("hip",)),
            project=SimpleNamespace(cad=cad),
        )
        notes: list[str] = []
        assert not damper_of(design, 0, 8.0, notes).problems()
        decisive = [note for note in notes if severity_of(note) == "decide"]
        assert len(decisive) == decides
        assert all("which would slip" in note for note in decisive)
