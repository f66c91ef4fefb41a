"""What commands print at their end: the table, notes of one line, and the result as JSON."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from typing import Any

import pytest

from synth.cli import main
from synth.commands import init
from synth.commands.answers import MOST_NOTES, NOTE_LETTERS, fit_text, gap_text, is_near_enough, tell_notes
from synth.commands.progress import Progress
from synth.remarks import decisive, noted

FIT = Path(init.__file__).resolve().parent.parent / "examples" / "fit" / "fit.yaml"


def fitted(capsys: pytest.CaptureFixture[str], out: Path, *words: str) -> tuple[str, str, str]:
    """Output, messages, and what was written."""
    assert main(["fit", str(FIT), "--out", str(out), *words]) == 0
    shown = capsys.readouterr()
    return shown.out, shown.err, (out / "fit.json").read_text()


def test_a_wide_interval_is_rounded_as_on_the_page() -> None:
    rate = {"value": 0.4913, "unit": "N*m/rad", "interval90": [0.4, 6.0]}
    joint = {"spring_rate": rate, "free_angle": {"value": 100.0, "unit": "deg"}}
    row = fit_text({"joints": {"hip": joint}, "rms": {}, "warnings": []}).splitlines()[2]
    assert row.split()[:5] == ["hip", "0.49", "0.4", "to", "6"]


def test_the_free_angle_of_a_spring_that_may_not_be_there_is_unknown() -> None:
    """It was printed as 63 deg, -785 to 786."""
    rate = {"value": 2e-4, "unit": "N*m/rad", "interval90": [0.0, 2e-3]}
    free = {"value": 63.0, "unit": "deg", "interval90": [-785.0, 786.0]}
    row = fit_text({"joints": {"hip": {"spring_rate": rate, "free_angle": free}}, "rms": {}}).splitlines()[2]
    assert row.split()[-2:] == ["unknown", "-"]


def test_a_fit_prints_its_table_also_with_quiet(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
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


def test_notes_are_limited_to_one_line_each_and_counted(tmp_path: Path) -> None:
    out = io.StringIO()
    notes = [
        noted("something to know"),
        decisive("it may break before 100 000 full turns"),
        *(f"note {i} " + "long " * 60 for i in range(9)),
    ]
    tell_notes(Progress(results=out, messages=io.StringIO()), notes, tmp_path / "design.json")
    lines = out.getvalue().splitlines()
    assert len(lines) == MOST_NOTES + 1
    assert (
        lines[0] == "note: it may break before 100 000 full turns"
    )  # sentences that could change a decision come first
    assert all(len(line) <= NOTE_LETTERS + len("note: ") for line in lines[:-1])
    assert lines[-1] == f"and {len(notes) - MOST_NOTES} more notes: {tmp_path / 'report.html'}"


@pytest.mark.parametrize(("rate", "is_offered"), [(0.03, False), (0.3, True), (1.0, True), (3.9, True), (30.0, False)])
def test_a_spring_far_from_the_wanted_rate_is_not_offered(rate: float, is_offered: bool) -> None:
    assert is_near_enough({"rate": {"value": rate, "unit": "N*m/rad"}}, 1.0) is is_offered
    assert is_near_enough({"part": "unknown"}, 1.0)


def printed(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    """The JSON on standard output; nothing else is there."""
    assert main([*words, "--json", "-q"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    found: dict[str, Any] = json.loads(shown.out)
    return found


def test_the_catalogue_answers_in_json(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    families = printed(capsys, "catalog", "list")["families"]
    assert all(item["rows"] == sum(list(item.values())[2:]) for item in families)
    dampers = printed(capsys, "catalog", "list", "dampers")["rows"]
    assert len(dampers) == next(item["rows"] for item in families if item["family"] == "dampers")
    (damper,) = printed(capsys, "catalog", "show", "6597K19")["rows"]
    assert damper["max_torque"] == {"value": pytest.approx(0.218908, rel=1e-5), "unit": "N*m"}
    assert damper in dampers
    near = printed(capsys, "catalog", "alike", "6597K19")["alike"]
    assert [item["distance"] for item in near] == sorted(item["distance"] for item in near)
    assert printed(capsys, "catalog", "check")["files"] == []
    wish = tmp_path / "knee.yaml"
    wish.write_text("kind: part-wish\ndamper: {torque: 0.2 N*m, speed: 50 rpm}\n")
    (wished,) = printed(capsys, "catalog", "show", str(wish))["wishes"]
    assert wished["fit"]
    assert all(item["why"] for item in wished["do_not"])
    assert len(wished["fit"]) + len(wished["do_not"]) >= sum(row["status"] == "complete" for row in dampers)


def test_init_import_and_warmup_answer_in_json(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = printed(capsys, "init", "import", str(tmp_path / "p"))
    assert made["command"][:2] == ["synth", "import"]
    done = printed(capsys, *made["command"][1:])
    assert done == json.loads((tmp_path / "p" / "result" / "import.json").read_text())
    assert {"trc", "sleap"} <= {item["name"] for item in printed(capsys, "import", "--list")["formats"]}
    monkeypatch.setattr(Progress, "compiling", lambda *_, **__: None)
    warmed = printed(capsys, "warmup", "--links", "2")
    assert warmed["links"] == [2]
    assert set(warmed["compiled_now"]) <= {2}


def test_an_import_prints_one_row_per_recording_also_with_quiet(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["init", "import", str(tmp_path / "p"), "-q"]) == 0
    project = str(tmp_path / "p" / "import.yaml")
    assert main(["import", project, "--out", str(tmp_path / "o"), "-q"]) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    head, _, *rows = shown.out.splitlines()
    assert head.split()[:2] == ["recording", "samples"]
    trials = json.loads((tmp_path / "o" / "import.json").read_text())["trials"]
    assert [(row.split()[0], int(row.split()[1])) for row in rows] == [(t["source"], t["samples"]) for t in trials]


def test_the_rates_of_an_insect_are_not_shown_as_zero() -> None:
    """A leg of 2 mm has springs of 2e-7 N m/rad; with six decimals its whole table was zero."""
    joint = {
        "spring_rate": {"value": 2.3561e-7, "unit": "N*m/rad", "interval90": [2.3301e-7, 2.3821e-7]},
        "damper_rate": {"value": 1.2798e-9, "unit": "N*m*s/rad", "interval90": [1.267e-9, 1.292e-9]},
        "free_angle": {"value": 104.9968, "unit": "deg", "interval90": [104.9913, 105.0023]},
    }
    text = fit_text({"joints": {"hip": joint}, "rms": {"hip": {"value": 0.0998, "unit": "deg"}}})
    row = text.splitlines()[2].split()
    assert row[:5] == ["hip", "2.356e-07", "2.330e-07", "to", "2.382e-07"]
    assert row[5:9] == ["1.280e-09", "1.267e-09", "to", "1.292e-09"]
    assert row[9] == "104.9968"


def gap(remainder: float) -> dict[str, Any]:
    """What the answer reads of ``gap.json``: five of more causes, a remainder in deg."""
    cause = {"effect": "backlash", "joint": "knee", "probability": 0.05, "shrink": None}
    where = {"joint": {"hip": 0.5, "knee": 0.5}, "phase": {"settle": 1.0}}
    left = {"rms": {"value": remainder, "unit": "deg"}, "share": 0.1, "times_noise": 0.0, "where": where}
    known = {"verdict": "none", "explanation": [], "ranked": [cause] * 6, "remainder": left}
    return {**known, "probability_none": 0.46, "probability_unknown": 0.0}


def test_a_gap_s_probabilities_add_up_on_the_screen() -> None:
    assert re.search(r"all others +29%", gap_text(gap(0.1)))


def test_the_screen_lists_every_cause_that_the_sentence_names() -> None:
    """A spring 43 % too soft was a rival in the sentence, and not among the five most probable causes."""
    found, joint = gap(0.1), "ankle"
    names = ["backlash", "link_mass", "latency", "armature", "link_inertia", "spring_rate", "encoder_scale"]
    found["ranked"] = [
        {"effect": name, "joint": joint, "probability": 0.1, "shrink": {"value": 0.1 * k}}
        for k, name in enumerate(names)
    ]
    assert "spring rate" not in gap_text(found)
    tie = [[{"effect": "backlash", "joint": joint}], [{"effect": "spring_rate", "joint": joint}]]
    shown = gap_text({**found, "verdict": "tie", "explanation": tie[0], "tied": tie[1:]})
    assert "spring rate" in shown
    assert "encoder scale" not in shown
    assert "encoder scale" in gap_text({**found, "verdict": "unknown"})  # "alone encoder scale 60 %"


def test_an_error_far_above_the_noise_is_not_no_missing_effect_on_the_screen() -> None:
    found = gap(0.1)
    assert re.search(r"no missing effect +46%", gap_text(found))
    found["remainder"]["times_noise"] = 87.0
    assert re.search(r"the design as it is +46%", gap_text(found))
    found["remainder"]["times_noise"] = 247.0
    assert "250 times the noise" in gap_text(found)  # not 2.5e+02


def test_a_cause_that_reduces_nothing_has_no_minus() -> None:
    found = gap(0.1)
    found["ranked"] = [{**found["ranked"][0], "shrink": {"value": shrink}} for shrink in (-0.004, 0.004, -0.04)]
    assert re.findall(r"-?\d+%$", gap_text(found), flags=re.MULTILINE)[:3] == ["0%", "0%", "-4%"]


def test_no_remainder_lies_nowhere() -> None:
    assert gap_text(gap(0.1)).endswith("most at: hip, settle")
    assert "most at" not in gap_text(gap(0.0))
