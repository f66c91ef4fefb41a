"""Parts of the check of suggested commands: a chirp within the known limits, a log played on the true rig."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from blind.next_command import (
    ANGLE,
    AWAY,
    LENGTH,
    WAYS,
    Case,
    Few,
    causes,
    chirp,
    is_open,
    limits_of,
    named,
    played,
    reached,
    suggested,
    table,
)
from blind.servos import LIBRARY, _setup, _write
from blind.views import View
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.diagnosis.plants.swinging_chain.chain_menu import menu, variations
from synth.diagnosis.plants.swinging_chain.command_shapes import COMMAND_RATE
from synth.files.gap_project import read_gap_project


@pytest.fixture
def case() -> Case:
    """A rig without a fault that followed two slow sines."""
    rich = _setup(np.random.default_rng(4))
    t = rich.times
    commands = [size * np.sin(2.0 * np.pi * rate * t) for size, rate in ((0.5, 0.4), (0.3, 0.8))]
    setup = Few(rich.design, rich.supply, tuple(np.stack([c] * len(rich.design.joints), axis=1) for c in commands))
    return Case("next_test", setup, rich.design, 1e-5, setup.moved(rich.design), ("servo_gain", 0), rich.design, rich)


def test_a_chirp_uses_the_limits_and_keeps_them(case: Case) -> None:
    time, command = chirp(case)
    speed, torque = reached(case.setup, case.rig, time, command)
    assert np.abs(command).max() <= ANGLE + 1e-9
    assert max(speed, torque) <= 1.0
    assert max(speed, torque, np.abs(command).max() / ANGLE) > 0.95
    assert len(time) == len(command) == round(COMMAND_RATE * LENGTH)


def test_all_suggested_commands_keep_the_stated_limits(case: Case, tmp_path: Path) -> None:
    """The design's own motion, in the generator's engine, not the program's."""
    _write(np.random.default_rng(1), case.setup, case.whole, case.floor, case.labels, tmp_path / "case")
    stated = {"next_command": {"length": f"{LENGTH} s", "limits": limits_of(case.setup)}}
    path = tmp_path / "case" / "gap.yaml"
    path.write_text(path.read_text() + json.dumps(stated)[1:-1] + "\n")
    project = read_gap_project(path)
    scene, _ = scene_of(project.leg, project.trials, project.tolerance, 0)
    about = project.leg, scene.bench, scene.given, project.next_command
    items = menu(*about)
    first = variations(*about, items, 0)
    items += [*first, *variations(*about, first[:1], 1)]
    assert len(items) > 40
    used = []
    for item in items:
        assert item.command is not None
        time, wanted = item.command
        command = np.stack(list(wanted.values()), axis=1)
        assert len(time) == round(COMMAND_RATE * LENGTH)
        assert np.abs(command).max() <= ANGLE + 1e-9
        used.append(max(reached(case.setup, case.rig, time, command)))
    assert max(used) < 1.05  # held samples move the rig a little more than straight lines between them
    assert np.median(used) > 0.5


def test_a_played_command_is_a_log_to_learn_from(case: Case, tmp_path: Path) -> None:
    """The rig equals the design, so the design follows the log within the noise; only the last known log scores."""
    rng = np.random.default_rng(1)
    _write(rng, case.setup, case.whole, case.floor, case.labels, tmp_path / "case")
    header = "time [s]," + ",".join(f"{joint} command [deg]" for joint in case.labels)
    time, command = chirp(case)
    table_ = np.column_stack([time, np.degrees(command)])
    np.savetxt(tmp_path / "next_command.csv", table_, "%.10g", ",", header=header, comments="")
    told = suggested(tmp_path)
    assert told is not None
    np.testing.assert_allclose(told[1], command, atol=1e-9)
    played(case, told, tmp_path / "case", tmp_path / "again")
    found = read_gap_project(tmp_path / "again" / "gap.yaml").trials
    assert [trial.name for trial in found if not trial.held_out] == [AWAY, "log_1.csv"]
    assert len(found[0].time) == round(COMMAND_RATE * LENGTH)
    assert suggested(tmp_path / "case") is None


def test_points_are_those_of_the_causes_named_alone() -> None:
    def is_right(key: Sequence[str]) -> bool:
        return tuple(key) == ("servo_gain", "joint1")

    right = View("effect", ((("servo_gain", "joint1"), 0.9),))
    wrong = View("effect", ((("armature", "joint1"), 0.9),))
    unsaid = View("tie", right.ranked, (("servo_gain", "joint1"),), ((("armature", "joint1"),),))
    assert named(right, is_right)
    assert not named(wrong, is_right)
    assert not named(unsaid, is_right)
    small = (("servo_gain", "joint1"), ("coulomb_friction", "joint1"))  # what is tied stands beside the right cause
    assert named(View("tie", right.ranked, (("servo_gain", "joint1"),), (small,)), is_right)
    said = {"a": dict.fromkeys(("before", *WAYS), True), "b": {"before": False, "chirp": False, "suggested": True}}
    said |= {"c": {"before": True}}  # nothing was recorded
    found = table(said)
    assert (found["points_over_chirp"], found["chirp"]["of"]) == (50.0, 2)
    assert found["points_interval90"] == [0.0, 100.0]  # of two pairs
    assert is_open(unsaid, is_right)
    assert is_open(View("unknown", wrong.ranked), is_right)
    assert not any(is_open(view, is_right) for view in (right, wrong, View("none", wrong.ranked)))
    assert sorted(causes(1, len(LIBRARY))) == sorted(LIBRARY)
