"""What a command ends with: its table, notes of one line, and the result itself where it is asked for."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest

from synth.cli import main
from synth.commands import init
from synth.commands.answers import MOST_NOTES, NOTE_LETTERS, offered, tell_notes
from synth.commands.progress import Progress

FIT = Path(init.__file__).resolve().parent.parent / "examples" / "fit" / "fit.yaml"


def fitted(capsys: pytest.CaptureFixture[str], out: Path, *words: str) -> tuple[str, str, str]:
    """Output, messages, and what was written."""
    assert main(["fit", str(FIT), "--out", str(out), *words]) == 0
    shown = capsys.readouterr()
    return shown.out, shown.err, (out / "fit.json").read_text()


def test_a_fit_ends_with_its_table_and_quiet_prints_just_that(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    said, _, _ = fitted(capsys, tmp_path / "a")
    table, messages, written = fitted(capsys, tmp_path / "b", "-q")
    assert messages == ""
    assert table in said
    head, _, *rows, count = table.splitlines()
    assert head.split("  ")[0] == "joint"
    found = json.loads(written)
    assert [row.split()[0] for row in rows] == list(found["joints"])
    for row, joint in zip(rows, found["joints"].values(), strict=True):
        words = row.split()
        assert float(words[1]) == pytest.approx(joint["spring_rate"]["value"], rel=0.01)
        low, high = joint["spring_rate"]["interval90"]
        assert float(words[2]) <= float(words[1]) <= float(words[4])
        assert (float(words[2]), float(words[4])) == pytest.approx((low, high), rel=0.01)
    assert count == f"{len(found['warnings'] + found['not_separable'])} warnings"


def test_json_on_stdout_is_the_file_and_nothing_else(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    said, messages, written = fitted(capsys, tmp_path / "a", "--json")
    assert json.loads(said) == json.loads(written)
    assert "fit.json" in messages
    said, messages, _ = fitted(capsys, tmp_path / "b", "--json", "-q")
    assert json.loads(said) == json.loads(written)
    assert messages == ""


def test_a_spring_s_result_can_be_printed(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--rate", "1.7 N*m/rad", "--travel", "40 deg", "--json", "-"]
    assert main(["spring", *words]) == 0
    assert json.loads(capsys.readouterr().out)["format"] == "synth/spring/1"


def test_notes_are_few_one_line_each_and_the_rest_is_counted(tmp_path: Path) -> None:
    out = io.StringIO()
    notes = [
        "something to know",
        "it may break before 100 000 full turns",
        *(f"note {i} " + "long " * 60 for i in range(9)),
    ]
    tell_notes(Progress(results=out, messages=io.StringIO()), notes, tmp_path / "design.json")
    lines = out.getvalue().splitlines()
    assert len(lines) == MOST_NOTES + 1
    assert lines[0] == "note: it may break before 100 000 full turns"  # what could change a decision comes first
    assert all(len(line) <= NOTE_LETTERS + len("note: ") for line in lines[:-1])
    assert lines[-1] == f"and {len(notes) - MOST_NOTES} more notes: {tmp_path / 'report.html'}"


@pytest.mark.parametrize(("rate", "is_offered"), [(0.03, False), (0.3, True), (1.0, True), (3.9, True), (30.0, False)])
def test_a_spring_far_from_the_wanted_rate_is_not_offered(rate: float, is_offered: bool) -> None:
    assert offered({"rate": {"value": rate, "unit": "N*m/rad"}}, 1.0) is is_offered
    assert offered({"part": "unknown"}, 1.0)
