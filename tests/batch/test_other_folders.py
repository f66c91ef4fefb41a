"""``synth gap`` and ``synth leg`` on folders; the machinery that they share with fits is tested there."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextvars import Context
from pathlib import Path
from typing import Any

import pytest

from diagnosis.made_result import made_result
from page_reader import check_words, drawings, page_of
from synth.api import leg_folder
from synth.batch.task_outcome import TaskOutcome, performed
from synth.cli import main
from synth.errors import Problem, UserError

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"


@pytest.fixture(autouse=True)
def _in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """No processes: what is patched here counts there too."""

    def run(function: Callable[[Any], Any], calls: Iterable[tuple[str, Any]], workers: int) -> Iterator[Any]:
        for name, argument in calls:
            ended: TaskOutcome = Context().run(performed, function, argument)  # a worker writes no folder
            yield name, ended

    monkeypatch.setattr("synth.commands.project_folder.run_here", run)
    monkeypatch.setattr("synth.commands.progress.Progress.compiling", lambda *rest, **options: None)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_folder_of_gaps_gives_one_page_and_resumes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[str] = []

    def diagnose(leg: Any, *rest: Any, **options: Any) -> Any:
        asked.append(leg.name)
        return made_result()

    monkeypatch.setattr("synth.api.gaps.diagnose", diagnose)
    projects = tmp_path / "rigs"
    for name in ("first", "second"):
        shutil.copytree(EXAMPLES / "gap", projects / name)
    bad = projects / "third" / "gap.yaml"
    bad.parent.mkdir()
    bad.write_text("kind: gap\n")
    words = ["gap", str(projects), "--out", str(tmp_path / "out")]
    assert main([*words, "--dry-run"]) == 2
    assert not (tmp_path / "out").exists()
    capsys.readouterr()
    assert main(["-q", *words]) == 2
    said = capsys.readouterr().err
    assert "synth: 1 of 3 projects could not be diagnosed:\nsynth: third:" in said
    found = json.loads((tmp_path / "out" / "gaps.json").read_text())
    assert (found["format"], [leg["name"] for leg in found["legs"]]) == ("synth/gaps/1", ["first", "second"])
    own = json.loads((tmp_path / "out" / "legs" / "first" / "gap.json").read_text())
    assert found["legs"][0]["verdict"] == own["verdict"]
    assert found["legs"][0]["ranked"][0]["probability"] == own["ranked"][0]["probability"]
    rows = rows_of(tmp_path / "out" / "gaps.csv")
    assert [(row["leg"], row["state"]) for row in rows] == [
        ("first", "diagnosed"), ("second", "diagnosed"), ("third", "failed"),
    ]  # fmt: skip
    assert float(rows[0]["before [deg]"]) == pytest.approx(own["gap"]["before"]["value"])
    html, page = page_of(tmp_path / "out" / "report.html")
    text = " ".join(page.text.split())
    assert "2 of 3 projects were diagnosed" in text
    assert "Correct third" in text
    assert "Could not be diagnosed" in text
    assert "legs/second/report.html" in html
    for drawing in drawings(html):
        check_words(drawing)
    assert len(asked) == 2
    bad.write_text((projects / "first" / "gap.yaml").read_text())
    for name in ("nominal.leg.yaml", "trials"):
        copy = shutil.copytree if (projects / "first" / name).is_dir() else shutil.copy
        copy(projects / "first" / name, bad.parent / name)
    assert main(["-q", *words]) == 0
    assert len(asked) == 3  # the others were kept
    assert not (tmp_path / ".out.gaps").exists()


def test_options_of_a_single_gap_are_refused_for_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(EXAMPLES / "gap", tmp_path / "rigs" / "one")
    words = ["gap", str(tmp_path / "rigs"), "--out", str(tmp_path / "out")]
    assert main([*words, "--check"]) == 2
    assert "is a folder; this is for one project" in capsys.readouterr().err
    one = ["gap", str(tmp_path / "rigs" / "one" / "gap.yaml"), "--out", str(tmp_path / "out")]
    assert main([*one, "--workers", "2"]) == 2
    assert "--workers applies to a folder of projects or to --rehearse" in capsys.readouterr().err


def test_a_folder_of_designs_lists_the_infeasible_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    projects = tmp_path / "robots"
    for name in ("first", "second"):
        shutil.copytree(EXAMPLES / "leg", projects / name)
    quantities = {"value": 1.5, "unit": "deg"}
    content = {
        "joints": {
            "knee": {
                "wanted": {"spring_rate": {"value": 1.7, "unit": "N*m/rad"}},
                "spring": {"make": {"rate": {}}},
                "damper": {"part": "6597K19"},
            }
        },
        "response": {
            "wanted_to_built": {"rms": quantities, "joints": {"knee": quantities}},
            "animal_to_wanted": {"joints": {"knee": quantities}, "another_motion": ["knee"]},
        },
        "solids": {
            "drawn": False,
            "checks": [{"passed": False, "text": "knee: the pin is weak"}, {"passed": True, "text": "fine"}],
        },
        "warnings": [{"joint": "knee", "text": "a note"}],
    }

    def made(task: leg_folder.LegTask) -> dict[str, bytes]:
        assert task.project.parts.system == "inch"
        if "second" in str(task.project.path):
            raise UserError(Problem("no damper is strong enough"))
        return {"design.json": json.dumps(content).encode(), "report.html": b"<p>"}

    monkeypatch.setattr("synth.api.leg_folder.leg_files", made)
    words = ["-q", "leg", str(projects), "--system", "inch", "--out", str(tmp_path / "out")]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "1 of 2 projects have failed checks:\nsynth: first: knee: the pin is weak\n" in said
    assert "1 of 2 projects could not be designed:\nsynth: second: no damper is strong enough" in said
    rows = rows_of(tmp_path / "out" / "legs.csv")
    assert [(row["leg"], row["state"], row["spring"], row["damper"]) for row in rows] == [
        ("first", "check failed", "to make", "6597K19"), ("second", "failed", "", ""),
    ]  # fmt: skip
    text = " ".join(page_of(tmp_path / "out" / "report.html")[1].text.split())
    assert "The joints of first fail a check" in text
    assert "The links of first do not make the animal's motion" in text
    assert [row["animal's motion"] for row in rows] == ["another", ""]
    assert "knee: the pin is weak" in text
