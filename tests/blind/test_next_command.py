"""Parts of the check of suggested commands: a chirp within the known limits, a log played on the true rig."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from blind.next_command import AWAY, Case, Few, causes, chirp, named, played, suggested, table
from blind.servos import LIBRARY, _setup, _write
from blind.views import View
from synth.files.gap_project import read_gap_project


@pytest.fixture
def case() -> Case:
    """A rig without a fault that followed two slow sines."""
    rich = _setup(np.random.default_rng(4))
    t = rich.times
    commands = [size * np.sin(2.0 * np.pi * rate * t) for size, rate in ((0.5, 0.4), (0.3, 0.8))]
    setup = Few(rich.design, rich.supply, tuple(np.stack([c] * len(rich.design.joints), axis=1) for c in commands))
    return Case("next_test", setup, rich.design, 1e-5, setup.moved(rich.design), [["servo_gain", "joint1"]])


def test_a_chirp_keeps_the_limits_of_the_known_commands(case: Case) -> None:
    time, command = chirp(case)
    assert np.abs(command).max() <= 0.5 + 1e-9
    fastest = np.abs(np.diff(command, axis=0)).max() * 100.0
    assert 0.8 < fastest / (2.0 * np.pi * 0.8 * 0.3) < 1.01  # the quicker of the two sines
    assert (len(time), len(command)) == (600, 600)


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
    assert len(found[0].time) == 600
    assert suggested(tmp_path / "case") is None


def test_points_are_those_of_the_named_causes() -> None:
    right = View("effect", ((("servo_gain", "joint1"), 0.9),))
    wrong, unsaid = View("tie", ((("armature", "joint1"), 0.9),)), View("unknown", right.ranked)
    answers = {"a": {"right": [["servo_gain", "joint1"]]}, "b": {"right": [["servo_gain", "joint1"]]}}
    assert named(right, answers["a"]["right"])
    assert not named(wrong, answers["a"]["right"])
    assert not named(unsaid, answers["a"]["right"])
    found = table(answers, {"chirp": {"a": right, "b": wrong}, "suggested": {"a": right, "b": right}})
    assert found["points_over_chirp"] == 50.0
    assert sorted(causes(1, len(LIBRARY))) == sorted(LIBRARY)
