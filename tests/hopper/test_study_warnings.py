"""What a study warns of: lengths at an edge, and torques whose interval passes the gearbox's limit."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

import pytest

from hopper.hoppers import catalogue
from synth.files.hopper_project import read_hopper_project
from synth.hopper import study as studying
from synth.hopper.study import Study
from synth.hopper.study_warnings import warnings_of

PROJECT = """\
kind: hopper-design
model: full
motors: {{use: ["N20 {motor}"], gearbox: {gearbox}}}
lengths: {{least: {least} mm, most: {most} mm, step: 2 mm}}
leg: {{crouch: 39.0 deg, extended: 10 deg}}
"""


@pytest.fixture(autouse=True)
def without_other_models(monkeypatch: pytest.MonkeyPatch) -> None:
    """The choice by every model takes a minute, and no warning here looks at it."""
    monkeypatch.setattr(studying, "run_ladder", lambda *given: ((), {}))
    monkeypatch.setattr(studying, "_lean_design", lambda *given: None)


def studied(
    folder: Path, least: int, most: int, gearbox: str = "stop", motor: str = "HP 6V 75:1", more: str = ""
) -> Study:
    """The study of a small sweep of one motor; ``more`` : further lines of the project."""
    text = PROJECT.format(least=least, most=most, gearbox=gearbox, motor=motor)
    (folder / "a.yaml").write_text(text + more)
    return studying.study(read_hopper_project(folder / "a.yaml"), catalogue(), None, lambda stage: nullcontext())


@pytest.mark.parametrize(
    ("least", "most", "more", "length", "words"),
    [
        (30, 60, "", 44, "the shortest in reach, set by the crouch: 4.0 deg before the lower links lock"),
        (44, 60, "", 44, "the shortest of the sweep"),
        (48, 50, "", 48, ""),
        (90, 100, "choose: peak_gear_torque\n", 90, "the shortest of the sweep"),
    ],
)
def test_a_choice_at_the_edge_of_reach_or_sweep_is_named(
    tmp_path: Path, least: int, most: int, more: str, length: int, words: str
) -> None:
    """An optimum beside lengths whose crouch is out of reach had no warning: only the ends of the sweep had one."""
    study = studied(tmp_path, least, most, more=more)
    assert round(1000.0 * study.best_leg.length) == length
    told = [text for text in warnings_of(study) if "the chosen length is" in text]
    assert len(told) == bool(words)
    assert all(text.startswith(f"the chosen length is {words}") for text in told)
