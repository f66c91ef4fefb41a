"""The assembly sequence uses every part once, each after the parts that it needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cad_joints import cleared
from synth.cad import (
    AdapterDimensions,
    BoreDimensions,
    DamperDimensions,
    EncoderDimensions,
    JointDimensions,
    LoadDimensions,
    SpringDimensions,
)
from synth.cad.assembly import assembly, exploded_view, numbers_at
from synth.cad.joint import build_joint
from synth.cad.parts import Mesh
from synth.cad.travel import Bodies

KNEE = JointDimensions("knee", SpringDimensions(3.0, 24.0, 4 + 60 / 360, 120.0), 110.0, 110.0, range=(80.0, 140.0))


@pytest.mark.parametrize(
    "change",
    [
        {"encoder": EncoderDimensions(), "damper": DamperDimensions(adapter=AdapterDimensions())},
        {"springs": 2, "damper": DamperDimensions(bore=BoreDimensions("square", 14.0))},
    ],
    ids=["encoder and adapter", "pair and insert"],
)
def test_assembly_uses_every_part_once_in_a_feasible_order(change):
    joint = build_joint(cleared(replace(KNEE, **change)))
    steps = assembly(joint)
    listed = [name for step in steps for name in step.parts]
    assert sorted(listed) == sorted(part.name for part in joint.parts)
    at = {name.removeprefix("knee_"): number for number, step in enumerate(steps) for name in step.parts}
    order = ["upper", "bearing_a", "damper_bracket", "spring", "seat", "collar_a", "shaft", "pin", "collar_b", "damper"]
    found = [at[name] for name in order]
    assert found == sorted(found)
    apart = exploded_view(joint)
    assert len(apart) == len(joint.parts)
    numbered = [int(words) for words, _ in numbers_at(apart)]
    assert set(numbered) == {number for _, _, number in apart}
    assert set(numbered) == {*range(1, len(steps) + 1)}
    assert sorted(numbered).count(at["shaft"] + 1) == 2  # the lower half, and the shaft away from it
    middles = {part.name: mesh.vertices.mean(axis=0) for part, mesh, _ in apart}
    # With the lower half, not where that was before it was drawn below.
    assert np.linalg.norm(middles["knee_lower_socket_screw"] - middles["knee_lower"]) < 60.0


@pytest.mark.parametrize(
    ("travel", "words"),
    [
        (None, ""),
        (70.0, "Its ends are then at 75.0 and 145.0 deg of the joint, 2.0 deg beyond its stops"),
        (60.0, "Its ends are then at 80.0 and 140.0 deg of the joint, 3.0 deg before its stops: turn it no further"),
    ],
)
def test_the_ends_of_a_damper_are_set_to_the_stops(travel, words):
    joint = build_joint(cleared(replace(KNEE, stops=(77.0, 143.0), damper=DamperDimensions(travel=travel))))
    (said,) = [step.text for step in assembly(joint) if step.text.startswith("put the damper on")]
    assert words in said
    assert ("with the joint at 110.0 deg, half way between its stops" in said) is (travel is not None)


@pytest.mark.parametrize(
    ("hub", "words"),
    [
        ("unknown", "its hub must turn with the shaft, which must hold 1.91 N*m"),
        ("set_screw", "set screw on the flat of the shaft's end, which must hold 1.91 N*m"),
        ("clamp", "tighten its hub's clamp on the shaft, which must hold 1.91 N*m"),
    ],
)
def test_the_step_of_a_round_bore_says_what_turns_the_damper(hub, words):
    damper, loads = DamperDimensions(bore=BoreDimensions("round", hub=hub)), LoadDimensions(damper_torque=1.91)
    steps = assembly(build_joint(cleared(replace(KNEE, damper=damper, loads=loads))))
    assert [words in step.text for step in steps if step.text.startswith("put the damper on")] == [True]


def test_an_unknown_hub_is_looked_at_before_the_shaft_is_in():
    steps = [step.text for step in assembly(build_joint(cleared(KNEE)))]
    seen = next(k for k, text in enumerate(steps) if "first see what turns the damper with it" in text)
    assert seen + 1 == next(k for k, text in enumerate(steps) if "push the shaft through" in text)


def test_the_free_angle_is_measured_before_the_damper_is_on():
    steps = [step.text for step in assembly(build_joint(cleared(KNEE)))]
    read = next(k for k, text in enumerate(steps) if "read the angle at which it comes to rest" in text)
    assert read + 1 == next(k for k, text in enumerate(steps) if text.startswith("put the damper on"))
    assert "0 on its scale (the longest marks meet)" in steps[read]
    assert (
        steps[read].index("0 on its scale") < steps[read].index("damper still off") < steps[read].index("the setting")
    )


def test_a_number_is_seen_before_parts_that_stand_in_front(tmp_path):
    """Step 13 of an assembly was hidden: its screw lies more than 60 mm behind another part."""
    from synth.cad.preview import Camera, PreviewError

    corners = np.array([(0, 0, 0), (40, 0, 0), (0, 40, 0), (0, 0, 40)], dtype=float)
    near = Mesh(corners, np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]))
    far = near.turned(0.0, (0.0, 0.0, -300.0))
    try:
        camera = Camera()
    except PreviewError as error:
        pytest.skip(str(error))
    for name, labels in (("with", [("13", (10.0, 10.0, -290.0))]), ("without", [])):
        camera.draw([(near, (0.2, 0.4, 0.8)), (far, (0.8, 0.4, 0.2))], tmp_path / name, (0.0, 0.0, 1.0), labels=labels)
    camera.close()
    assert (tmp_path / "with").read_bytes() != (tmp_path / "without").read_bytes()


def test_a_joint_whose_free_angle_is_beyond_a_stop_says_how_to_find_it_and_is_filed_within_its_travel():
    """Its halves overlapped by 3450 mm^3 in the files, and an angle was to be read at which it cannot rest."""
    joint = build_joint(cleared(replace(KNEE, free_angle=20.0, rest_angle=100.0, range=(60.0, 140.0))))
    dimensions, bodies = joint.dimensions, Bodies(joint)
    assert not dimensions.rests_free
    assert dimensions.filed_angle == 60.0
    assert bodies.overlap(dimensions.free_angle) > 1000.0
    halves = [joint.filed_mesh(joint.part(half)).manifold for half in ("upper", "lower")]
    assert float((halves[0] ^ halves[1]).volume()) == pytest.approx(0.0, abs=0.05)
    (spring,) = joint.springs
    assert joint.filed_mesh(spring) is spring.mesh  # as it is wound, not bent
    step = next(step.text for step in assembly(joint) if "free angle" in step.text)
    assert "beyond the stop at 57.0 deg" in step
    assert "A - M (B - A)/(N - M)" in step
    assert "read the angle at which it comes to rest" not in step


def test_files_are_at_the_free_angle_where_the_stops_allow_it():
    """Between the travel's end and the stop too; beyond, at the end of the travel next to it."""
    for free, filed in ((58.0, 58.0), (100.0, 100.0), (57.0, 60.0), (20.0, 60.0), (150.0, 140.0)):
        assert replace(KNEE, free_angle=free, rest_angle=100.0, range=(60.0, 140.0)).filed_angle == filed
