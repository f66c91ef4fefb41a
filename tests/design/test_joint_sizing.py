"""What is told of a joint that grew until it bore its loads."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from cad_joints import cleared
from synth.cad import (
    AdapterDimensions,
    DamperDimensions,
    JointDimensions,
    LegDimensions,
    LoadDimensions,
    PrintDimensions,
    SpringDimensions,
    sized,
)
from synth.cad.leg_joints import link_problems
from synth.design import joint_sizing
from synth.design.drawn_travel import stops_of
from synth.design.joint_sizing import _borne, _grown, dimensions_of, with_least_circle
from synth.files.project_options import CadOptions
from synth.remarks import severity_of

KNEE = JointDimensions("knee", SpringDimensions(3.429, 26.035, 7.17, 120.0), 111.0, 119.0)


def test_the_note_of_a_grown_joint_names_the_adapter_s_grip() -> None:
    """It grew without a word."""
    damper = DamperDimensions(adapter=AdapterDimensions(form="d"))
    asked = cleared(replace(KNEE, damper=damper, loads=LoadDimensions(2.0, 6.0)))
    grown = sized(asked, PrintDimensions())
    assert grown.damper.adapter is not None
    grip = grown.damper.adapter.output_grip
    assert grip > 12.0
    assert f"damper's shaft in the adapter {grip:g} mm instead of 12" in _grown(asked, grown)
    assert _grown(asked, asked) == []


def test_the_least_circle_of_a_damper_s_screws_is_the_largest_of_its_limits() -> None:
    """14 mm was told to be at least 14.2 mm, 15 mm at least 16.8 mm, and 17 mm that the link is too short."""
    small = DamperDimensions(10.0, 8.0, 14.0, 2, 2.2)
    asked = replace(KNEE, shaft_diameter=3.0, wall=1.6, clearance=0.2, damper=small)
    tried = list[float | None]()

    def drawn(circle: float | None) -> JointDimensions:
        tried.append(circle)
        return cleared(asked if circle is None else replace(asked, damper=replace(small, bolt_circle=circle)))

    joint, problem = with_least_circle(drawn)
    assert tried == [None, 14.2, 16.8]
    assert joint.damper.bolt_circle == 16.8
    assert (problem.value, problem.allowed) == (14.0, "at least 16.8 mm")
    (short,) = link_problems(LegDimensions("leg", (replace(joint, link_length=40.0),)))
    least = float(short.allowed.removeprefix("at least ").removesuffix(" mm"))
    assert least > 40.0
    assert link_problems(LegDimensions("leg", (replace(joint, link_length=least),))) == []


def stops_for(stated: bool, yields: tuple[float, float]) -> tuple[object, list[str]]:
    """Travel and stops of a knee that moves from 105 to 175 deg, drawn from 100 to 180; and its notes."""
    design: Any = SimpleNamespace(
        built=SimpleNamespace(joints=(SimpleNamespace(name="knee"),)),
        project=SimpleNamespace(
            target=SimpleNamespace(joints=(SimpleNamespace(range=(1.7, 3.1) if stated else None),))
        ),
    )
    notes: list[str] = []
    return stops_of(design, 0, (100.0, 180.0), yields, notes), notes


@pytest.mark.parametrize(
    ("yields", "travel", "stops"),
    [
        ((90.0, 190.0), (100.0, 180.0), (97.0, 183.0)),  # yields far beyond
        ((99.0, 190.0), (102.5, 180.0), (101.0, 183.0)),  # 2 deg of spare before yield, 1.5 from stop to travel
        ((99.0, 181.0), (102.5, 177.5), (101.0, 179.0)),
        ((100.5, 190.0), (104.0, 180.0), (102.5, 183.0)),  # the motion, a degree beyond it, and the stop: no less
    ],
)
def test_a_travel_that_nobody_states_shrinks_to_the_motion_before_the_spring_yields(
    yields: tuple[float, float], travel: tuple[float, float], stops: tuple[float, float]
) -> None:
    found, notes = stops_for(False, yields)
    assert found == (travel, stops)
    assert notes == []


@pytest.mark.parametrize(
    ("stated", "yields", "needed"), [(False, (100.6, 190.0), "104.0 to 176.0"), (True, (99.0, 190.0), "100.0 to 180.0")]
)
def test_a_spring_that_yields_within_the_motion_or_a_stated_range_is_told(
    stated: bool, yields: tuple[float, float], needed: str
) -> None:
    """The stops stay past the travel: 3 deg, 1.5 of a stated one."""
    found, (note,) = stops_for(stated, yields)
    assert found == ((100.0, 180.0), (98.5, 181.5) if stated else (97.0, 183.0))
    assert f"The wanted travel of {needed} deg and stops 2 deg before yield are not possible together" in note
    assert severity_of(note) == "decide"


def test_all_links_have_the_tube_of_the_joint_that_asks_for_the_largest(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tube ends in two joints, whose sockets are drawn with each joint's own diameter."""

    def drawn(_: Any, tube: tuple[float, float], __: Any, ___: Any, notes: list[str]) -> tuple[list[Any], list[Any]]:
        notes.append("a note of the joints")
        hip = replace(KNEE, name="hip", link_width=tube[0], tube_wall=tube[1])
        width, wall = max(tube, (25.0, 2.0))
        return [hip, replace(KNEE, link_width=width, tube_wall=wall, loads=LoadDimensions(60.0, 3.0))], []

    monkeypatch.setattr(joint_sizing, "_drawn_joints", drawn)
    project = SimpleNamespace(cad=CadOptions(), name="leg")
    solids = dimensions_of(SimpleNamespace(project=project, built=SimpleNamespace(tilt=0.0)))  # type: ignore[arg-type]
    assert [(joint.link_width, joint.tube_wall) for joint in solids.dimensions.joints] == [(25.0, 2.0)] * 2
    assert solids.notes[:-1] == ("a note of the joints",)
    assert solids.notes[-1] == (
        "to bear 59.5 N*m at the stop of knee, the links are of tube 25 x 2 mm instead of 20 x 1.5 mm"
    )


@pytest.mark.parametrize(("stated", "grows"), [((), True), (("cad.tube_wall",), False), (("cad.link_width",), False)])
def test_only_a_tube_that_the_project_leaves_open_is_exchanged(stated: tuple[str, ...], grows: bool) -> None:
    defaults = [SimpleNamespace(key=key) for key in ("cad.link_width", "cad.tube_wall") if key not in stated]
    design: Any = SimpleNamespace(project=SimpleNamespace(defaults=defaults, cad=CadOptions(encoder=False)))
    asked = cleared(replace(KNEE, loads=LoadDimensions(45.0, 1.0)))
    borne = _borne(design, asked, PrintDimensions(), [])
    assert ((borne.link_width, borne.tube_wall) != (20.0, 1.5)) is grows
