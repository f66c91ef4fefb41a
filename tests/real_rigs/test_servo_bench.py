"""A servo's friction identified from its logs, scored on a held-out gain as its owners score theirs.

Nothing of these data is in the product; without them these tests are skipped with a message.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from real_rigs.servo_bench import BENCH, MODELS, SERVOS, command_lead, logs, owners_error, project, published
from synth.cli import main
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project
from synth.files.recording import read_recording

pytestmark = pytest.mark.skipif(not BENCH.is_dir(), reason=f"not here: {BENCH}")
SCORED = "400"  # the firmware's gain whose logs only score: as the owners validate


@pytest.mark.slow
def test_what_is_found_predicts_better_than_each_of_the_owners_six_models(tmp_path: Path) -> None:
    """Found without a hint, alone, beside a current limit or in a tie: what stands first is what predicts.

    Learnt from the four logs at one gain (800), for time; the owners' numbers come from all their logs.
    """
    names = {log.name for log in logs("xl330") if log.name.endswith(f"_{SCORED}")}
    found = read_gap_project(project(tmp_path, "xl330", names, gains={400.0, 800.0}))
    result = diagnose(found.leg, found.trials, found.tolerance, seed=found.seed)
    ranked = result.as_json()["ranked"]
    assert ranked[0]["effect"] == "gear_friction"  # the owners' best models, too, have friction by load
    ours = [np.nanmean(np.abs(trial.after - trial.measured)) for trial in result.trials if trial.scored]
    assert len(ours) == 4
    scored = [log for log in logs("xl330") if log.name in names]
    gain = SERVOS["xl330"]["gain"]
    theirs = {
        model: np.mean([owners_error(log, published("xl330", model), gain) for log in scored]) for model in MODELS
    }
    assert np.mean(ours) < min(theirs.values())
    assert theirs["m1"] / np.mean(ours) > 1.5  # gain of their best model over Coulomb and viscous friction


@pytest.mark.parametrize(("servo", "share"), [("xl330", 0.67), ("feetech", 0.66)])
def test_commands_left_before_their_rows_were_stamped(servo: str, share: float) -> None:
    """By two thirds of a turn of the recorder's loop on both servos: its order of work, not a servo's delay."""
    steps = [np.median(np.diff(log.columns["timestamp"])) for log in logs(servo) if log.trajectory == "sin_time_square"]
    assert command_lead(servo) / np.median(steps) == pytest.approx(share, abs=0.02)


def test_import_of_the_benchs_own_logs_is_the_project_that_is_written_by_hand(tmp_path: Path) -> None:
    project(tmp_path, "xl330", set())
    for path in BENCH.glob("xl330__*kp400*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    text = "kind: import\nleg: xl330_400.leg.yaml\nfiles: [xl330__*.csv]\ntime: {column: timestamp, unit: s}\n"
    text += "supply: {column: input_volts, unit: V}\n"
    text += "joints: {arm: {column: position, unit: rad, command: goal_position, enabled: torque_enable}}\n"
    (tmp_path / "import.yaml").write_text(text)
    assert main(["--quiet", "import", str(tmp_path / "import.yaml"), "--out", str(tmp_path / "out")]) == 0
    found = read_gap_project(tmp_path / "out" / "gap.yaml")
    assert len(found.trials) == 4
    for trial in found.trials:
        name = next(log.name for log in logs("xl330") if log.kp == 400.0 and f"__{log.trajectory}__" in trial.name)
        by_hand = read_recording(tmp_path / f"{name}.csv", found.leg)
        assert trial.signals is not None
        assert by_hand.signals is not None
        np.testing.assert_allclose(trial.angles, by_hand.angles, atol=1e-9)
        np.testing.assert_allclose(trial.signals.command, by_hand.signals.command, atol=1e-9)
        np.testing.assert_allclose(trial.signals.supply, by_hand.signals.supply)
