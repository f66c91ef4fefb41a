"""A joint that cannot be drawn is refused by the project's key, or by what decides it; every number has its unit."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

import pytest

from synth.cad import PrintDimensions
from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import shaft_sizes
from synth.cad.limits import DimensionError, DimensionProblem, limit_of
from synth.design.drawing_refusals import not_drawable
from synth.files.project_options import SHAFTS, CadOptions, DamperShape
from synth.files.schema import quantity_of


def refused(dimension: str, value: object, *, stated: bool = False) -> str:
    """The message of one dimension of a leg with the joints a and b.c."""
    joint = SimpleNamespace(range=(0.0, 1.0) if stated else None)
    shape = DamperShape(bolt_circle=0.05) if stated else DamperShape()
    project: Any = SimpleNamespace(
        path=Path("p.yaml"),
        cad=CadOptions(dampers={"b.c": shape}),
        target=SimpleNamespace(joint_names=("a", "b.c"), joints=(joint, joint)),
    )
    problem = DimensionProblem(dimension, value, "other", "a reason")
    return str(not_drawable(DimensionError(problem), project))


@pytest.mark.parametrize(
    ("dimension", "value", "stated", "words"),
    [
        ("a.shaft_diameter", 6.35, False, "p.yaml: cad.shaft_diameter: 6.35 mm: allowed is other; a reason"),
        ("b.c.damper.bolt_circle", 50.0, True, "p.yaml: cad.dampers.b.c.bolt_circle: 50 mm: allowed is other"),
        ("b.c.damper.bolt_circle", 50.0, False, "cad.dampers.b.c.bolt_circle: not stated in the project; of b.c's"),
        ("b.c.damper.bore.size", 5.0, False, "p.yaml: cad.dampers.b.c.shaft_size: "),
        ("b.c.damper.bore.hub", "clamp", False, "p.yaml: cad.dampers.b.c.hub: "),
        ("a.upper_arm_angle", 0.0, False, "a: the direction of the upper arm, which the program chooses, is 0 deg: "),
        ("a.upper_arm_angle", 0.0, False, "a smaller range of a in the target leg, or another spring (select.joints.a"),
        ("a.range", (1.0, 99.0), True, "cad: the range of a in the target leg is 1 to 99 deg: allowed is other"),
        ("a.range", (1.0, 99.0), False, "the drawn travel, that of the motion with a margin, is 1 to 99 deg"),
        ("a.spring.free_arm", 3.0, False, "cad: a: free arm of the spring is 3 mm: "),
        ("a.link_width", 70.0, False, "p.yaml: cad.link_width: 70 mm: allowed is other; a reason"),
        ("a.tube_wall", 9.0, False, "p.yaml: cad.tube_wall: 9 mm: allowed is other; a reason"),
        ("a.plate", 9.0, False, "cad: a: plate, which the program chooses, is 9 mm: "),
    ],
)
def test_a_refusal_names_a_key_or_what_decides(dimension: str, value: object, stated: bool, words: str) -> None:
    """Keys were named that no project has (j.upper_arm_angle), and numbers without units."""
    text = refused(dimension, value, stated=stated)
    assert words in text
    assert "--no-cad" in text
    assert "{joint}" not in text


def test_what_no_drawing_takes_is_refused_when_a_project_is_read() -> None:
    """The limits of the options are those of the drawing."""
    assert tuple(round(size * 1e3, 9) for size in SHAFTS) == shaft_sizes()
    hints = get_type_hints(CadOptions, include_extras=True)
    for family, name, of, factor in (
        (JointDimensions, "clearance", "clearance", 1e3),
        (JointDimensions, "wall", "wall", 1e3),
        (JointDimensions, "link_width", "link_width", 1e3),
        (JointDimensions, "tube_wall", "tube_wall", 1e3),
        (PrintDimensions, "print_strength", "strength", 1e-6),
        (PrintDimensions, "print_density", "density", 1e-3),
        (PrintDimensions, "between_layers", "between_layers", 1.0),
        (PrintDimensions, "safety", "safety", 1.0),
    ):
        limit, marks = limit_of(family, of), hints[name].__metadata__
        asked = next(mark for mark in marks if hasattr(mark, "least"))
        assert (asked.least * factor, asked.most * factor) == pytest.approx((limit.low, limit.high))
    assert quantity_of(hints["bed"]) is not None
