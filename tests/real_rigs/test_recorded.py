"""The six rigs can be built and read; their diagnosis is ``make rigs``, of which the double pendulum is tested here.

Nothing of these data is in the product; without them these tests are skipped with a message.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from real_rigs.__main__ import half_of, row, said_first
from real_rigs.recorded import RIGS, absent
from synth.files.gap_project import read_gap_project
from synth.fit.recordings import recordings

pytestmark = pytest.mark.skipif(bool(absent()), reason=f"not here: {', '.join(absent())}")


@pytest.mark.parametrize("name", list(RIGS))
def test_every_trial_is_in_one_half_and_can_be_read(name: str, tmp_path: Path) -> None:
    rig = RIGS[name](tmp_path)
    first, second = (read_gap_project(rig.project(tmp_path, half)) for half in (0, 1))
    assert [t.held_out for t in first.trials] == [not t.held_out for t in second.trials]
    assert abs(sum(t.held_out for t in first.trials) - len(first.trials) / 2) <= 0.5
    assert len(first.trials) >= 4
    made = recordings(first.leg, first.trials, ())
    assert all((recording.known_torque is not None) == (name == "driven pendulum") for recording in made)


def test_a_half_of_the_double_pendulum_is_diagnosed_and_reported(tmp_path: Path) -> None:
    halves = [half_of("double pendulum", tmp_path, half) for half in (0, 1)]
    for half in halves:
        assert half["before"] < 0.2  # the authors' model is a good one
        assert half["noise_floor"] < 0.05
        assert half["first"]
    text = row("double pendulum", halves)
    assert ("DISAGREE" in text) == (said_first(halves[0]) != said_first(halves[1]))
    # The main cause is the same from each half: dry friction at the lower joint, which its authors' model lacks.
    for half in halves:
        assert half["verdict"] in ("effect", "tie")
        assert any(joint == "lower" and "friction" in effect for effect, joint in half["explanation"])
        assert half["shrink_of_all"] > 0.6
        assert half["remainder_times_noise"] > 20.0
