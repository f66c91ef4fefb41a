"""``synth hopper`` end to end: the example, an interruption, and bad input."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import fields
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import synth
from page_reader import page_of
from result_fields import require_explained
from synth.api.hoppers import read_hopper
from synth.cli import main
from synth.files import hopper_project as files
from synth.hopper.study import sweep_problem
from synth.hopper.study_warnings import warnings_of
from synth.hopper.sweep import run_sweep
from synth.parts.catalogs import Catalogue
from synth.remarks import remarks_json
from synth.reports.openings.hopper_opening import study_opening
from synth.reports.reading import read_result
from synth.reports.section import AbsentResult
from synth.reports.sections import hopper_choice, hopper_models, live_jump

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "hopper" / "hopper.yaml"
SMALL = """\
kind: hopper-design
motors: {use: ["N20 HP 6V 1*0:1", "N20 HP 6V 210:1"]}
lengths: {least: 100 mm, most: 140 mm, step: 20 mm}
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("hopper") / "out"
    assert main(["--quiet", "hopper", str(EXAMPLE), "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def found(result: Path) -> dict:  # type: ignore[type-arg]
    return json.loads((result / "hopper.json").read_text())  # type: ignore[no-any-return]


def test_every_field_has_a_text_in_the_reference(found: dict) -> None:  # type: ignore[type-arg]
    require_explained("hopper.json", found)


def designs(folder: Path) -> list[dict[str, str]]:
    with (folder / "designs.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_designs_have_the_documented_columns(result: Path) -> None:
    rows = designs(result)
    wanted = (
        "motor,gear_ratio,leg_length [m],model,clearance [m],clearance_low [m],clearance_high [m],"
        "relative_height,feasible,limit"
    )
    assert ",".join(rows[0]).startswith(wanted)
    assert len(rows) == 21 * 16
    jumping = [row for row in rows if row["feasible"] == "yes"]
    assert len(jumping) > 100
    for row in jumping:
        low, clear, high = (float(row[f"clearance{end} [m]"]) for end in ("_low", "", "_high"))
        assert 0.0 <= low <= clear <= high
        assert float(row["relative_height"]) == pytest.approx(clear / float(row["leg_length [m]"]), abs=2e-5)


def test_the_best_is_the_highest_and_the_front_beats_all(result: Path, found: dict) -> None:  # type: ignore[type-arg]
    rows = [row for row in designs(result) if row["feasible"] == "yes"]
    heights = [float(row["clearance [m]"]) for row in rows]
    assert found["format"] == "synth/hopper/1"
    assert found["best"]["clearance"]["value"] == pytest.approx(max(heights), abs=1e-6)
    front = [(item["clearance"]["value"], item["relative_height"]["value"]) for item in found["pareto"]]
    assert front == sorted(front, reverse=True)
    for row in rows:
        one, other = float(row["clearance [m]"]), float(row["relative_height"])
        assert any(a >= one - 1e-6 and b >= other - 1e-4 for a, b in front)


def test_the_choice_is_reported_with_neighbours_models_and_warnings(found: dict) -> None:  # type: ignore[type-arg]
    changes = [item["change"] for item in found["neighbours"]]
    # The shortest leg of the sweep is chosen, since the gearboxes of what jumps higher would break.
    assert changes == ["as chosen", "1 cm longer", "one ratio less", "one ratio more"]
    assert {"point_mass", "A", "B", "C", "D", "full"} <= set(found["models"])
    same = found["models"]["A"]["clearance"]["value"], found["models"]["C"]["clearance"]["value"]
    # Two engines, one model: 0.8 % apart for this shortest leg of the sweep.
    assert same[0] == pytest.approx(same[1], rel=0.01)
    texts = found["warnings"]
    assert not any("gear may break" in text for text in texts)
    assert any("rotor inertia estimated" in text for text in texts)
    upright = found["planar"][0]["clearance"]["value"]
    assert upright == pytest.approx(found["best"]["clearance"]["value"], abs=2e-4)
    assert "crouch" not in {item["key"] for item in found["defaults"]}
    assert "leg.stop_rate" in {item["key"] for item in found["defaults"]}


def test_gearbox_stop_leaves_out_what_would_break(tmp_path: Path) -> None:
    text = SMALL.replace("motors: {", "motors: {gearbox: stop, ")
    (tmp_path / "a.yaml").write_text(text)
    assert (
        main(["-q", "hopper", str(tmp_path / "a.yaml"), "--no-cad", "--out", str(tmp_path / "out")]) == 1
    )  # the request is infeasible
    rows = designs(tmp_path / "out")
    assert all("gearbox" in row["limit"] for row in rows if row["gear_ratio"] == "210.59")
    assert all(row["feasible"] == "no" for row in rows if "gearbox" in row["limit"])


def test_a_map_without_jumps_says_so(result: Path, tmp_path: Path) -> None:
    """Without a design to choose the page said that there were fewer than two lengths."""
    shutil.copytree(result, tmp_path / "out")
    content = json.loads((result / "hopper.json").read_text())
    why = "none of the 15 designs lifts off"
    content |= {"best": {}, "map": {}, "pareto": [], "none_because": why}
    (tmp_path / "out" / "hopper.json").write_text(json.dumps(content))
    absent = hopper_choice.map_content(read_result(tmp_path / "out", "hopper.json", "hopper"))
    assert absent == AbsentResult(why)


def test_the_map_opens_on_the_height_that_is_chosen_by(result: Path, tmp_path: Path) -> None:
    """It opened on the clearance, where the design with the best total height may be the lowest."""
    shutil.copytree(result, tmp_path / "out")
    content = json.loads((result / "hopper.json").read_text())
    for choose, height, shown, relative in (
        ("clearance", "clearance", "clearance", "clearance"),
        ("total_height", "clearance", "total height", "clearance"),
        ("total_height", "total", "total height", "total height"),
    ):
        content["settings"] |= {"choose": choose, "height": height}
        (tmp_path / "out" / "hopper.json").write_text(json.dumps(content))
        data = live_jump.designs_data(read_result(tmp_path / "out", "hopper.json", "hopper"))
        assert data is not None
        assert (data["shown"], data["relative"]) == (shown, relative)


def test_jumps_that_no_gearbox_bears_are_not_too_weak(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.yaml").write_text(SMALL.replace("motors: {", "motors: {gearbox: stop, "))
    assert main(["-q", "hopper", str(tmp_path / "a.yaml"), "--no-cad", "--out", str(tmp_path / "out")]) == 1
    why = "9 of 15 designs jump, but all exceed the gearbox's 0.196 N*m (gearbox: stop)"
    assert why in capsys.readouterr().out
    found = json.loads((tmp_path / "out" / "hopper.json").read_text())
    require_explained("hopper.json", found)
    assert found["none_because"] == why
    assert found["warnings"] == [f"{why}: choose a stronger gearbox, a lower supply, or motors: {{gearbox: warn}}"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "9 of 15 designs jump, but all exceed" in page
    assert "stronger gearbox or a lower" in page
    assert "lifts off" not in page
    assert found["map"]["clearance_m"]
    assert not any(cell for row in found["map"]["feasible"] for cell in row)
    assert "Height over ratio and length</b>" not in page  # it is not among what is left out
    assert "No design is within its limits" in page
    swept = synth.hopper(tmp_path / "a.yaml")
    assert swept.headline == f"a: {why}"
    assert swept.jumps
    assert not swept.chosen


UNLIMITED = """\
kind: hopper-design
model: A
motors: {use: ["20D 12V 78.125:1", "N20 HP 6V 75:1"], gearbox: stop}
lengths: {least: 120 mm, most: 120 mm, step: 20 mm}
"""


def test_a_gearbox_without_a_known_limit_is_named_and_not_taken_as_unbreakable(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(UNLIMITED)
    study = synth.hopper(tmp_path / "a.yaml").study
    assert study.best_motor.torque_limit is None
    told = remarks_json(warnings_of(study))["remarks"][0]
    assert told["severity"] == "decide"
    assert told["text"].startswith("gearbox: stop cannot hold back 1 of the 2 motors")
    pushed = float(study.sweep.values["peak_gear_torque"][study.best])
    assert (
        f"Pololu 20D 12V CB; among them the chosen one: the gear of 20D 12V 78.125:1 carries {pushed:.3f} N*m"
        in (told["text"])
    )
    assert "torque_limit [N*m]" in told["remedy"]
    (tmp_path / "a.yaml").write_text(UNLIMITED.replace("stop", "warn"))
    softer = [text for text in warnings_of(synth.hopper(tmp_path / "a.yaml").study) if "held against no limit" in text]
    assert len(softer) == 1
    (tmp_path / "a.yaml").write_text(UNLIMITED.replace('"20D 12V 78.125:1", ', ""))
    assert not any("torque_limit" in text for text in warnings_of(synth.hopper(tmp_path / "a.yaml").study))


STIFF = """\
kind: hopper-design
model: A
motors: {use: ["20D 12V 312.5:1"]}
lengths: {least: 50 mm, most: 50 mm, step: 10 mm}
"""


@pytest.mark.slow  # a sweep of its own
def test_numbers_of_a_jump_that_is_too_stiff_are_null_and_not_what_it_had_reached(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(STIFF)
    assert main(["-q", "hopper", str(tmp_path / "a.yaml"), "--no-cad", "--out", str(tmp_path / "out")]) == 0
    content = json.loads((tmp_path / "out" / "hopper.json").read_text())
    require_explained("hopper.json", content)
    leaning = content["planar"][0]
    assert leaning["limit"].startswith("too stiff")
    assert {key for key, value in leaning.items() if value is not None} == {"lean", "limit"}
    assert content["models"]["A"]["clearance"]["value"] > 0.003
    assert "<h2>Models side by side</h2>" in (tmp_path / "out" / "report.html").read_text()


def test_a_written_tolerance_replaces_the_maker_s(tmp_path: Path) -> None:
    """The catalogue's row states 20 and 50 %."""
    zero = "speed: 0 %, torque: 0 %, rotor_inertia: 0 %, mass: 0 %, joint_damping: 0 %, crouch: 0 deg"
    widths = {}
    for name, text in (("all", f"{zero}, current: 0 %"), ("current", zero)):
        (tmp_path / "a.yaml").write_text(f"{SMALL}tolerance: {{{text}}}\n")
        study = synth.hopper(tmp_path / "a.yaml").study
        assert study.best is not None
        widths[name] = study.high[study.best] - study.low[study.best]
    assert widths["all"] == 0.0
    assert widths["current"] > 1e-4


def test_the_torque_at_the_stop_is_beside_that_of_the_push(result: Path, found: dict) -> None:  # type: ignore[type-arg]
    """The largest torque of jump.csv after takeoff, which the designs are not judged by, and a warning."""
    best = found["best"]
    with (result / "jump.csv").open(newline="") as stream:
        rows = [(float(row["time [s]"]), abs(float(row["gear torque [N*m]"]))) for row in csv.DictReader(stream)]
    after = max(torque for time, torque in rows if time > best["takeoff_time"]["value"])
    stated, limit = best["gear_torque_after_takeoff"]["value"], best["motor_constants"]["torque_limit"]["value"]
    assert after == pytest.approx(stated, rel=1e-6)  # the table has the step of the blow, not only thousandths
    assert best["peak_gear_torque"]["value"] < limit < stated
    (told,) = [text for text in found["warnings"] if "at the leg's stop" in text]
    assert f"{stated:.3f} N*m, above the gearbox's {limit:.3f} N*m" in told
    page = (result / "report.html").read_text()
    assert "Peak gear torque, at the stop" in page
    assert "Designs are judged by the push alone" in page


def test_a_supply_far_above_the_rated_voltage_is_reported(tmp_path: Path) -> None:
    for supply, warned in (("24 V", True), ("9 V", False)):
        (tmp_path / "a.yaml").write_text(SMALL.replace("motors: {", f"motors: {{supply: {supply}, "))
        texts = warnings_of(synth.hopper(tmp_path / "a.yaml").study)
        assert any("times the rated voltage (6 V) of 5 of the 5 motors" in text for text in texts) == warned


def test_a_motor_that_is_too_weak_is_reported_and_does_not_jump(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(SMALL.replace('"N20 HP 6V 1*0:1", "N20 HP 6V 210:1"', '"N20 LP 6V 30:1"'))
    assert (
        main(["-q", "hopper", str(tmp_path / "a.yaml"), "--no-cad", "--out", str(tmp_path / "out")]) == 1
    )  # the request is infeasible
    rows = designs(tmp_path / "out")
    assert all(row["limit"].startswith("too weak") and float(row["clearance [m]"]) == 0.0 for row in rows)
    result = json.loads((tmp_path / "out" / "hopper.json").read_text())
    assert result["best"] == {}
    assert "too weak" in result["warnings"][0]
    assert result["remarks"][0]["severity"] == "decide"


@pytest.mark.parametrize(
    ("asked", "swept"),
    [("least: 50 mm, most: 200 mm, step: 40 mm", [50, 90, 130, 170, 200]),
     ("least: 50 mm, most: 200 mm, step: 50 mm", [50, 100, 150, 200]), ("least: 5 cm, most: 5 cm, step: 1 cm", [50]),
     ("least: 0.1 m, most: 0.4 m, step: 0.1 m", [100, 200, 300, 400]),
     ("least: 60 mm, most: 70 mm, step: 40 mm", [60, 70])],
)  # fmt: skip
def test_both_ends_of_the_lengths_are_swept(asked: str, swept: list[int], tmp_path: Path) -> None:
    """200 mm were left out in silence where steps of 40 mm from 50 mm end at 170 mm."""
    (tmp_path / "a.yaml").write_text(SMALL.replace("least: 100 mm, most: 140 mm, step: 20 mm", asked))
    project, _, _ = read_hopper(tmp_path / "a.yaml")
    assert [1e3 * length for length in project.lengths] == pytest.approx(swept)


def test_a_users_motor_is_one_more_row(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text(
        "part,vendor,gear_ratio [1],voltage [V],no_load_speed [rpm],stall_torque [kgf*mm],stall_current [mA],"
        "no_load_current [mA],mass [g],source\nM1,me,120,6,280,2.0,1600,100,9.5,my bench\n".replace(
            "kgf*mm", "N*mm"
        ).replace("2.0,1600", "200,1600")
    )
    (tmp_path / "a.yaml").write_text(SMALL.replace("{use: [", '{catalogs: [mine.csv], use: ["M1", '))
    assert main(["-q", "hopper", str(tmp_path / "a.yaml"), "--no-cad", "--out", str(tmp_path / "out")]) == 0
    assert {row["motor"] for row in designs(tmp_path / "out")} >= {"M1"}


BAD = [
    ("leg: {crouch: 85 deg}", "leg.crouch", "cannot be reached: the lower links are level"),
    ("leg: {crouch: 62 deg}", "leg.crouch", "no length of the sweep allows the crouch"),
    ("leg: {lower_ratio: 0.1}", "leg.crouch", "too short to meet"),
    ("leg: {extended: 50 deg}", "leg.extended", "extended before it starts"),
    ("leg: {extended: -20 deg}", "leg.extended", "upper links of 140 mm cross"),
    ("leg: {crouch: 39}", "leg.crouch", "has no unit"),
    ("contact: {stiffness: 1e12 N/m}", "contact.stiffness", "at most"),
    ("motors: {use: [N20 XX]}", "motors.use", "matches no gear motor"),
    ("motors: {use: ['N20 HPCB 12V 50:1']}", "motors.use", "no stall torque"),
    ("motors: {gearbox: ignore}", "motors.gearbox", "warn"),
    ("lengths: {least: 0 mm}", "lengths.least", "more than 0"),
    ("lengths: {least: -1 cm}", "lengths.least", "more than 0"),
    ("lengths: {least: 20 cm, most: 10 cm}", "lengths", "is below least"),
    ("lengths: {step: 1e-9 mm}", "lengths.step", "larger step"),
    ("tolerance: {torque: 100 %}", "tolerance.torque", "can be at most 90 %"),
    ("tolerance: {mass: 95 %}", "tolerance.mass", "can be at most 90 %"),
    ("model: E", "model", "not allowed"),
    ("laminate: {modulus: 10 kg}", "laminate.modulus", "mass"),
    ("objectives: [height]", "objectives", "allowed"),
]


@pytest.mark.parametrize(("line", "key", "message"), BAD)
def test_bad_input_is_named_with_its_place(
    line: str, key: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = line.split(":")[0]
    kept = "".join(f"{text}\n" for text in SMALL.splitlines() if not text.startswith(f"{name}:"))
    (tmp_path / "a.yaml").write_text(kept + line + "\n")
    assert main(["-q", "hopper", str(tmp_path / "a.yaml"), "--out", str(tmp_path / "out")]) == 2
    shown = capsys.readouterr().err
    assert key in shown
    assert message in shown
    assert f"a.yaml:{len(kept.splitlines()) + 1}" in shown
    assert not (tmp_path / "out").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["a.yaml"]


LARGE = """\
kind: hopper-design
motors: {use: ["N20 HP *"]}
lengths: {least: 60 mm, most: 180 mm, step: 0.15 mm}
"""


@pytest.mark.slow  # ``make kill`` kills sweeps too
def test_a_killed_sweep_resumes_to_the_same_bytes_and_refuses_another_project(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(LARGE)
    command = [sys.executable, "-m", "synth", "-q", "hopper", "--no-cad", str(tmp_path / "a.yaml"), "--out"]
    whole = subprocess.run([*command, str(tmp_path / "whole")], check=True, timeout=300, capture_output=True)
    assert whole.returncode == 0
    running = subprocess.Popen([*command, str(tmp_path / "killed")], stdout=subprocess.DEVNULL)
    kept = tmp_path / ".killed.sweep"
    deadline = time.monotonic() + 120
    while len(list(kept.glob("chunk_*.npy"))) < 2 and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    os.kill(running.pid, signal.SIGKILL)
    assert running.wait() == -signal.SIGKILL
    before = {path.name: path.stat().st_mtime_ns for path in kept.glob("chunk_*.npy")}
    assert 2 <= len(before) < 5
    assert not (tmp_path / "killed").exists()

    other = tmp_path / "b.yaml"
    shutil.copy(tmp_path / "a.yaml", other)
    other.write_text(LARGE.replace("180 mm", "170 mm"))
    refused = subprocess.run([*command[:-2], str(other), "--out", str(tmp_path / "killed")],
                             capture_output=True, text=True, check=False, timeout=120)  # fmt: skip
    assert refused.returncode == 2
    assert "another project file" in refused.stderr
    assert {path.name: path.stat().st_mtime_ns for path in kept.glob("chunk_*.npy")} == before

    subprocess.run([*command, str(tmp_path / "killed")], check=True, timeout=300, capture_output=True)
    assert not kept.exists()
    for name in ("designs.csv", "hopper.json", "jump.csv"):
        assert (tmp_path / "killed" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_the_report_shows_every_part_of_the_study(result: Path, found: dict) -> None:  # type: ignore[type-arg]
    page = (result / "report.html").read_text()
    for title in ("The chosen leg", "Height over ratio and length", "Models side by side", "The jump", "Parts",
                  "How each number is computed"):  # fmt: skip
        assert f"<h2>{title}</h2>" in page
    assert page.count("<svg") == 4 + 6 + 1  # the opening shows the jump too
    assert "one ratio less" in page
    assert found["best"]["motor"] in page
    assert "shortest of the sweep" in page.split('<section id="warnings"')[1].split("</section>")[0]


@pytest.mark.parametrize(("own", "said"), [(0.13, "higher"), (0.1265, "about as high"), (0.123, "lower"), (None, "")])
def test_what_the_page_says_of_model_c_is_what_its_table_shows(
    own: float | None, said: str, result: Path, tmp_path: Path
) -> None:
    shutil.copytree(result, tmp_path / "out")
    content = json.loads((tmp_path / "out" / "hopper.json").read_text())
    content["models"]["C"]["clearance"]["value"] = 0.127
    content["models"]["C, its own contact"]["clearance"]["value"] = own
    if own is None:
        del content["models"]["C, its own contact"]
    (tmp_path / "out" / "hopper.json").write_text(json.dumps(content))
    shown = hopper_models.SECTION.content(read_result(tmp_path / "out", "hopper.json", "hopper"))
    assert isinstance(shown, dict)
    assert shown["own_contact"].split(":")[0] == (f"With its own contact law C jumps {said}" if said else "")


def test_the_parts_follow_from_the_chosen_design(result: Path, found: dict) -> None:  # type: ignore[type-arg]
    parts = found["parts"]
    assert all((result / file).stat().st_size > 0 for file in parts["files"])
    listed = {item["path"] for item in found["files"]}
    assert set(parts["files"]) <= listed
    folds = parts["layers"][2]["folds_mm"]
    link = found["best"]["leg_length"]["value"] * 1e3
    assert [b - a for a, b in pairwise(folds)] == pytest.approx([link] * 4, rel=1e-6)
    # k = E w t^3 / (12 gap) of 3.8 GPa film, 15 mm wide, 0.1 mm thick
    gap = 3.8e9 * 0.015 * 1e-12 / (12 * 0.0229183)
    assert parts["dimensions"]["hinge_gap"]["value"] == pytest.approx(gap * 1e3, rel=1e-6)
    assert any("links: strip" in note for note in parts["notes"])
    assert parts["missing"] == ["the hip is not complete", "flat links as drawn are not those simulated"]
    severity = {remark["text"]: remark["severity"] for remark in found["remarks"]}
    for words in ("the hip is not complete", "with its flexures (hip", "flat links as drawn"):
        assert [severity[note] for note in parts["notes"] if words in note] == ["decide"]


def test_the_headline_is_that_of_the_leg_that_is_drawn(result: Path, found: dict) -> None:  # type: ignore[type-arg]
    """4.21 cm stood in the headline, 3.6 cm as drawn and an incomplete hip in notes at the page's end."""
    opening = study_opening(read_result(result, "hopper.json", "hopper"))
    drawn, best = found["parts"]["as_drawn"], found["best"]
    assert (
        f"as simulated the foot clears the ground by {100 * best['clearance']['value']:.3g}\u00a0cm" in opening.verdict
    )
    assert (
        f"With flexures and links as drawn the foot clears {drawn['clearance']['value']:.3g}\u00a0cm" in opening.verdict
    )
    assert opening.verdict.endswith("the hip is not complete and flat links as drawn are not those simulated.")
    assert opening.good is False
    assert "enter the drawn flexures' rate" in opening.steps[0]


def test_a_page_has_one_unit_for_heights_and_one_for_lengths(result: Path) -> None:
    """4.21 cm, 0.042 m and -0.00162 m, 50 mm and 0.05 m stood on one page."""
    _, page = page_of(result / "report.html")
    text = page.text.split("How each number is computed")[0].replace("\u00a0", " ")
    assert re.findall(r"(?<![\w·])−?\d[\d.]* m(?![\w·/])", text) == []


def test_one_line_is_a_project_and_every_default_is_stated_with_its_reason(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("kind: hopper-design\n")
    project = files.read_hopper_project(tmp_path / "a.yaml")
    stated = {default.key: default.reason for default in project.defaults}
    sections = {"leg": files.LegSection, "laminate": files.LaminateSection, "flexures": files.FlexureSection,
                "contact": files.ContactSection, "motors": files.MotorSection, "lengths": files.LengthsSection,
                "tolerance": files.ToleranceSection, "parts": files.PartsSection}  # fmt: skip
    wanted = {f"{name}.{item.name}" for name, section in sections.items() for item in fields(section)}
    assert wanted - set(stated) == {"leg.crouch_lower", "laminate.bending"}  # in place of crouch, which is stated
    assert all(stated.values())
    assert {"model", "objectives", "choose", "intervals"} <= set(stated)


def test_crouch_is_given_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.yaml").write_text(SMALL + "leg: {crouch: 40 deg, crouch_lower: 60 deg}\n")
    assert main(["-q", "hopper", str(tmp_path / "a.yaml"), "--out", str(tmp_path / "out")]) == 2
    assert "keep one" in capsys.readouterr().err


@pytest.mark.slow  # model C is compared with A on single jumps too
def test_a_small_sweep_by_model_c_gives_what_a_gives_and_a_large_one_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = {}
    for model in ("A", "C"):
        text = SMALL.replace('"N20 HP 6V 1*0:1"', '"N20 HP 6V 1[05]0:1"')
        (tmp_path / f"{model}.yaml").write_text(text + f"model: {model}\nintervals: front\n")
        out = tmp_path / model
        assert main(["-q", "hopper", str(tmp_path / f"{model}.yaml"), "--no-cad", "--out", str(out)]) == 0
        found[model] = [float(row["clearance [m]"]) for row in designs(out)]
    assert found["C"] == pytest.approx(found["A"], abs=2e-4)
    (tmp_path / "large.yaml").write_text(LARGE + "model: C\n")
    assert main(["-q", "hopper", str(tmp_path / "large.yaml"), "--out", str(tmp_path / "l")]) == 2
    assert "at most 400" in capsys.readouterr().err


def test_the_meaning_of_height_is_a_key_and_old_files_keep_theirs(tmp_path: Path) -> None:
    found = {}
    for name, line in (("old", ""), ("total", "height: total\n"), ("both", "height: total\nchoose: clearance\n")):
        (tmp_path / f"{name}.yaml").write_text(SMALL + line)
        project = files.read_hopper_project(tmp_path / f"{name}.yaml")
        problem, _ = sweep_problem(project, Catalogue.load())
        values = run_sweep(problem).values
        found[name] = (
            project.choose,
            values["relative_height"] * np.array(project.lengths * len(problem.motors)),
            values,
        )
    chosen, height, values = found["old"]
    assert chosen == "clearance"
    np.testing.assert_allclose(height, values["clearance"])
    chosen, height, values = found["total"]
    assert chosen == "total_height"
    np.testing.assert_allclose(height, values["total_height"])
    assert found["both"][0] == "clearance"


@pytest.mark.parametrize(
    ("lines", "chosen", "relative"),
    [("", "clearance", "clearance"), ("height: total\n", "total_height", "total_height"),
     ("height: total\nchoose: clearance\n", "clearance", "total_height"),
     ("choose: total_height\n", "total_height", "clearance"),
     ("choose: energy\nheight: total\n", "total_height", "total_height")],
)  # fmt: skip
def test_screen_and_page_show_the_height_that_is_meant(
    lines: str, chosen: str, relative: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Total and clearance are 6 cm apart; each stands under its own name, with its own interval."""
    (tmp_path / "a.yaml").write_text(SMALL.replace("1*0:1", "150:1") + lines)
    assert main(["-q", "hopper", str(tmp_path / "a.yaml"), "--no-cad", "--out", str(tmp_path / "out")]) == 0
    content = json.loads((tmp_path / "out" / "hopper.json").read_text())
    require_explained("hopper.json", content)
    best, shown = content["best"], capsys.readouterr().out
    low, high = best[chosen]["interval90"]
    assert low < best[chosen]["value"] < high
    assert f"{chosen.replace('_', ' ')} [cm]" in shown
    assert f"{100 * best[chosen]['value']:.1f}" in shown
    assert f"{100 * low:.1f} to {100 * high:.1f}" in shown
    assert f"{relative.replace('_', ' ')} / link" in shown
    assert best["relative_height"]["value"] == pytest.approx(best[relative]["value"] / best["leg_length"]["value"])
    opening = study_opening(read_result(tmp_path / "out", "hopper.json", "hopper"))
    words = {
        "clearance": "the foot clears the ground by",
        "total_height": "the centre of mass rises over the crouch by",
    }
    assert f"{words[chosen]} {100 * best[chosen]['value']:.3g}\u00a0cm" in opening.verdict
    title = f"{chosen.replace('_', ' ')} over gear ratio and link length"
    assert title in (tmp_path / "out" / "report.html").read_text()


def test_only_defaults_that_are_used_are_stated(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(SMALL + "height: total\nleg: {crouch_lower: 60 deg}\n")
    stated = {d.key: d.value for d in files.read_hopper_project(tmp_path / "a.yaml").defaults}
    assert "leg.crouch" not in stated
    assert stated["choose"] == "total_height"
    assert stated["objectives"] == "total_height, relative_height"
