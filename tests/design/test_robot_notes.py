"""The known motion reaches the MJCF of a designed and of a diagnosed leg, and its omissions reach the notes."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from files.test_mjcf_springs import HARD, one_joint
from synth.api.gaps import Gap
from synth.design.robot_files import write_robots
from synth.files.simulator_files import write_simulator_files
from synth.remarks import severity_of

SOFTENED = one_joint({HARD: {"softening": 1.0}}, sign=-1)
TIME = np.linspace(0.0, 1.0, 50)
MOTION = SOFTENED.rest[0] + 1.0 * np.exp(-TIME)[:, None]  # a radian of deflection at first
SAID = "the spring's curve is fitted up to 63 deg of deflection"


def test_a_designed_leg_s_fitted_spring_is_in_its_notes(tmp_path: Path) -> None:
    design: Any = SimpleNamespace(
        wanted=SimpleNamespace(releases=[SimpleNamespace(time=TIME)]), built_motions=(MOTION,), built=SOFTENED,
        drawn=None, links=(),
    )  # fmt: skip
    notes = [text for text in write_robots(design, (), tmp_path) if text.startswith("leg.mjcf.xml")]
    assert [SAID in text for text in notes] == [True]
    assert severity_of(notes[0]) == "note"
    assert SAID in (tmp_path / "leg.mjcf.xml").read_text()
    linear: Any = SimpleNamespace(**{**vars(design), "built": one_joint({})})
    assert not any(text.startswith("leg.mjcf.xml") for text in write_robots(linear, (), tmp_path))


def test_a_diagnosed_leg_s_spring_is_fitted_over_the_trials(tmp_path: Path) -> None:
    measured = SOFTENED.to_measured(MOTION)
    measured[:5] = np.nan  # samples that do not count
    trial = SimpleNamespace(measured=measured, after=SOFTENED.to_measured(MOTION))
    found = Gap(cast("Any", None), cast("Any", SimpleNamespace(diagnosed=SOFTENED, trials=(trial,))))
    np.testing.assert_allclose(found._deflected(), 1.0)
    lost = write_simulator_files(SOFTENED, np.full(1, 5.0), tmp_path, deflected=found._deflected())
    assert any(SAID in text for text in lost["leg.mjcf.xml"])
