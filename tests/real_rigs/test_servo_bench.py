"""A servo's friction named from its logs, scored on a gain that took no part as its owners score theirs.

Nothing of these data is in the product; where they are absent, these tests say so and skip.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from real_rigs.servo_bench import BENCH, MODELS, SERVOS, logs, owners_error, project, published
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project

pytestmark = pytest.mark.skipif(not BENCH.is_dir(), reason=f"not here: {BENCH}")
SCORED = "400"  # the firmware's gain whose logs only score: as the owners validate


def test_what_is_found_predicts_better_than_each_of_the_owners_six_models(tmp_path: Path) -> None:
    names = {log.name for log in logs("xl330") if log.name.endswith(f"_{SCORED}")}
    found = read_gap_project(project(tmp_path, "xl330", names))
    result = diagnose(found.leg, found.trials, found.tolerance, seed=found.seed)
    ranked = result.as_json()["ranked"]
    assert ranked[0]["effect"] == "gear_load_friction"  # the owners' best models, too, have friction by load
    ours = [np.nanmean(np.abs(trial.after - trial.measured)) for trial in result.trials if trial.scored]
    assert len(ours) == 4
    scored = [log for log in logs("xl330") if log.name in names]
    gain = SERVOS["xl330"]["gain"]
    theirs = {
        model: np.mean([owners_error(log, published("xl330", model), gain) for log in scored]) for model in MODELS
    }
    assert np.mean(ours) < min(theirs.values())
    assert theirs["m1"] / np.mean(ours) > 1.5  # by what their best model gains over Coulomb and viscous friction
