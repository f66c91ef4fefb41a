"""``synth gap`` from the command line: complete folders or none, and one clear message for bad input."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from diagnosis.made_effect import CUBIC_DRAG
from diagnosis.made_result import made_result
from synth.cli import main
from synth.commands.progress import Progress
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.files.leg_file import read_leg
from synth.files.trial_list import Trial
from synth.swing import effects

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "gap"
TIME = np.arange(120) * 0.01
NAMES = ("hip", "knee", "ankle")
REST = np.array([105.0, 108.0, 139.0])


class Calls:
    """A diagnosis that records its arguments and returns an invented result."""

    def __init__(self) -> None:
        self.trials: tuple[Trial, ...] = ()
        self.options: dict[str, Any] = {}
        self.result = made_result()

    def diagnose(self, leg: Any, trials: Sequence[Trial], tolerance: Any, **options: Any) -> GapResult:
        self.trials, self.options = tuple(trials), {"tolerance": tolerance, "leg": leg, **options}
        options["progress"]("looking at joints")
        options["progress"]("asking effects")
        return self.result


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Calls:
    """The diagnosis replaced: what surrounds it is tested here."""
    made = Calls()
    monkeypatch.setattr("synth.api.gaps.diagnose", made.diagnose)
    return made


def swing(seed: int, amplitude: float = 20.0, noise: float = 0.05) -> np.ndarray[Any, Any]:
    """(120, 3) deg, a decaying swing with noise."""
    generator = np.random.default_rng(seed)
    motion = amplitude * np.exp(-3.0 * TIME) * np.cos(20.0 * TIME)
    return REST + motion[:, None] * np.array([1.0, -0.8, 0.6]) + generator.normal(0.0, noise, (len(TIME), 3))


def write_trial(path: Path, angles: np.ndarray[Any, Any], order: Sequence[int] = (0, 1, 2), torque: str = "") -> None:
    header = ["time [s]", *(f"{NAMES[j]} [deg]" for j in order)] + ([f"{torque} torque [N*m]"] if torque else [])
    rows = [
        [f"{t:.3f}", *(f"{row[j]:.5f}" for j in order)] + (["0.01"] if torque else [])
        for t, row in zip(TIME, angles, strict=True)
    ]
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")


@pytest.fixture
def project(tmp_path: Path) -> Callable[..., Path]:
    """A function that makes projects from recordings by name and additions to the project file."""

    def made(trials: str = "[trials/*.csv]", extra: str = "", **recordings: np.ndarray[Any, Any]) -> Path:
        folder = tmp_path / "project"
        folder.mkdir()
        shutil.copy(EXAMPLE / "nominal.leg.yaml", folder)
        for name, angles in (recordings or {"a": swing(1), "b": swing(2)}).items():
            write_trial(folder / "trials" / f"{name}.csv", angles)
        path = folder / "gap.yaml"
        path.write_text(f"kind: gap\nleg: nominal.leg.yaml\ntrials: {trials}\n{extra}")
        return path

    return made


def refused(path: Path, capsys: pytest.CaptureFixture[str], lines: int = 1) -> str:
    """Run; the message of a refusal that wrote nothing."""
    before = sorted(path.parent.parent.rglob("*"))
    capsys.readouterr()
    assert main(["gap", str(path), "--out", str(path.parent.parent / "out")]) == 2
    said = capsys.readouterr().err
    messages = [line for line in said.splitlines() if line.startswith("synth: ")]
    assert len(messages) == lines, said
    assert "Traceback" not in said
    assert sorted(path.parent.parent.rglob("*")) == before
    return "\n".join(messages)


def test_a_diagnosis_writes_all_files(
    calls: Calls, project: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = project("[trials/a.csv, {file: trials/b.csv, held_out: true}]", "seed: 5\ntolerance: {mass: 2 %}\n")
    out = tmp_path / "out"
    assert main(["gap", str(path), "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert {"gap.json", "report.html", "diagnosed.leg.yaml", "predicted", "where"} < {p.name for p in out.iterdir()}
    assert calls.result.sentence in said.out
    assert "note: trials/free_2.csv is a copy" in said.out
    assert "note: only one training trial" in said.out
    for stage in ("reading the project", "diagnosing", "looking at joints", "asking effects", "writing"):
        assert stage in said.err
    assert [trial.held_out for trial in calls.trials] == [False, True]
    assert calls.options["seed"] == 5
    assert calls.options["tolerance"].mass == 0.02
    gap = json.loads((out / "gap.json").read_text())
    assert gap["name"] == "dog-sized robot leg"
    assert set(gap["inputs"]) == {"gap.yaml", "nominal.leg.yaml", "trials/a.csv", "trials/b.csv"}
    assert gap["defaults"][0]["key"] == "tolerance.length"
    assert gap["settings"]["seed"] == 5
    assert len(gap["warnings"]) == 2


def test_the_same_input_gives_the_same_bytes(calls: Calls, project: Callable[..., Path], tmp_path: Path) -> None:
    path = project()
    for name in ("one", "two"):
        assert main(["-q", "gap", str(path), "--out", str(tmp_path / name)]) == 0
    files = sorted(p.relative_to(tmp_path / "one") for p in (tmp_path / "one").rglob("*") if p.is_file())
    assert len(files) > 8
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file


def test_a_dry_run_reads_all_and_writes_nothing(
    project: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = project("[trials/a.csv]")
    assert main(["gap", str(path), "--out", str(tmp_path / "out"), "--dry-run"]) == 0
    said = capsys.readouterr().out
    assert "is valid: 1 trials, 2 files" in said
    assert "note: only one training trial" in said
    assert not (tmp_path / "out").exists()


def test_a_users_effect_is_a_candidate(
    calls: Calls, project: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(effects, "from_files", {})
    (tmp_path / "cubic.py").write_text(CUBIC_DRAG)
    known: list[str] = []
    monkeypatch.setattr(Progress, "compiling", lambda *_, **__: None)
    monkeypatch.setattr(
        "synth.api.gaps.diagnose",
        lambda *given, **options: (
            known.extend(effect.name for effect in effects.registered()),
            calls.diagnose(*given, **options),
        )[1],
    )
    command = ["-q", "gap", str(project()), "--effect", str(tmp_path / "cubic.py"), "--out", str(tmp_path / "out")]
    assert main(command) == 0
    assert "cubic_drag" in known
    assert json.loads((tmp_path / "out" / "gap.json").read_text())["inputs"]["cubic.py"]
    assert "cubic_drag" not in [effect.name for effect in effects.registered()]


@pytest.mark.parametrize(
    ("content", "words"), [(None, "no such file"), ("x = 1\n", "holds no EFFECT"), ("1 / 0\n", "ZeroDivisionError")]
)
def test_a_file_without_an_effect_is_refused(
    content: str | None, words: str, project: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = project()
    if content is not None:
        (tmp_path / "mine.py").write_text(content)
    command = ["gap", str(path), "--effect", str(tmp_path / "mine.py"), "--out", str(tmp_path / "out")]
    assert main(command) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_trials_that_never_move_are_refused(project: Callable[..., Path], capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(project(a=swing(1, 0.0), b=swing(2, 0.0)), capsys, lines=2)
    assert "trials/a.csv: does not move" in said
    assert "trials/b.csv: does not move" in said


def test_noise_larger_than_the_motion_is_refused(
    project: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert "is larger than its motion" in refused(project(a=swing(1, 3.0, 4.0)), capsys)


def test_all_trials_held_out_is_refused(project: Callable[..., Path], capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(project("[{file: trials/*.csv, held_out: true}]"), capsys)
    assert "gap.yaml:3: trials: every trial is held out" in said


def test_a_leg_without_springs_and_dampers_is_refused(
    project: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    path = project()
    leg = path.parent / "nominal.leg.yaml"
    leg.write_text(re.sub(r"    (spring|damper): .*\n", "", leg.read_text()))
    said = refused(path, capsys)
    assert "gap.yaml:2: leg: no joint of dog-sized robot leg (hip, knee, ankle) has a spring or a damper" in said


@pytest.mark.parametrize("tolerance", ["{mass: -1 %}", "{spring: 51 %}", "{free_angle: 0.5}"])
def test_a_tolerance_out_of_range_is_refused(
    tolerance: str, project: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert "gap.yaml:4: tolerance." in refused(project(extra=f"tolerance: {tolerance}\n"), capsys)


def test_a_trial_too_short_is_refused(project: Callable[..., Path], capsys: pytest.CaptureFixture[str]) -> None:
    path = project()
    trial = path.parent / "trials" / "a.csv"
    trial.write_text("\n".join(trial.read_text().splitlines()[:10]) + "\n")
    assert "trials/a.csv: 9 samples" in refused(path, capsys)


def test_a_joint_missing_in_the_recording_is_refused(
    project: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    path = project()
    trial = path.parent / "trials" / "a.csv"
    trial.write_text(trial.read_text().replace("ankle [deg]", "ankel [deg]"))
    said = refused(path, capsys, lines=2)
    assert "did you mean ankle?" in said


def test_the_order_of_joint_columns_does_not_matter(calls: Calls, project: Callable[..., Path], tmp_path: Path) -> None:
    path = project()
    assert main(["-q", "gap", str(path), "--out", str(tmp_path / "one")]) == 0
    first = calls.trials[0].angles
    write_trial(path.parent / "trials" / "a.csv", swing(1), order=(2, 0, 1))
    assert main(["-q", "gap", str(path), "--out", str(tmp_path / "two")]) == 0
    assert (calls.trials[0].angles == first).all()


def test_a_torque_column_is_applied_and_noted(
    calls: Calls, project: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = project()
    write_trial(path.parent / "trials" / "a.csv", swing(1), torque="knee")
    assert main(["gap", str(path), "--out", str(tmp_path / "out")]) == 0
    assert "note: trials/a.csv: the torque columns of knee are applied as known torques" in capsys.readouterr().out
    torques = calls.trials[0].torques
    assert torques is not None
    assert (torques == [0.0, 0.01, 0.0]).all()


def test_a_failing_diagnosis_leaves_nothing_behind(
    calls: Calls, project: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls.result = replace(calls.result, sentence=None)  # type: ignore[arg-type]
    monkeypatch.setattr("synth.reports.write_gap_report", lambda *rest: 1 / 0)
    path = project()
    with pytest.raises(ZeroDivisionError):
        main(["-q", "gap", str(path), "--out", str(tmp_path / "out")])
    assert [entry.name for entry in tmp_path.iterdir()] == ["project"]


def test_the_diagnosed_leg_can_be_read(calls: Calls, project: Callable[..., Path], tmp_path: Path) -> None:
    assert main(["-q", "gap", str(project()), "--out", str(tmp_path / "out")]) == 0
    leg = read_leg(tmp_path / "out" / "diagnosed.leg.yaml")
    assert leg.joints[1].effects == {"coulomb_friction": {"torque": 0.048}}
