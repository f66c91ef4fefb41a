"""``synth gap`` on recorded jumps and pull-ups, through the command line."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hopper.recorded import DESIGN, PART, Effects, jumped, pulled, write
from synth.cli import main
from synth.commands import init
from synth.diagnosis.next_experiment import INFORMATION_DIGITS
from synth.diagnosis.plants.jumping_leg.jump_across import DesignTrends, JumpAcrossDesigns, _slopes
from synth.diagnosis.plants.jumping_leg.jump_predict import JumpPredictor
from synth.jump.jump_lanes import JumpLanes

HEAD = 'kind: gap\nleg: hopper.yaml\nmotor: "N20 HP 6V 150:1"\nlength: 120 mm\n'
DAMPED: Effects = {"joint_damping": {"damping": 6e-4}}


def project(folder: Path, trials: str, head: str = HEAD, design: str = DESIGN) -> Path:
    (folder / "hopper.yaml").write_text(design)
    (folder / "gap.yaml").write_text(f"{head}trials:\n{trials}")
    return folder / "gap.yaml"


def run(file: Path, *more: str) -> dict[str, Any]:
    assert main(["-q", "gap", str(file), "--out", str(file.parent / "out"), *more]) == 0
    return json.loads((file.parent / "out" / "gap.json").read_text())  # type: ignore[no-any-return]


DESIGNS = [(0.12, 150), (0.10, 150), (0.14, 150), (0.12, 100), (0.13, 100), (0.11, 150)]


@pytest.fixture(scope="module")
def damped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Jumps of six designs whose joints damp more than the design says, two of them held out."""
    folder = tmp_path_factory.mktemp("damped")
    lines = ""
    for k, (length, ratio) in enumerate(DESIGNS):
        write(folder / f"jumps/{k}.csv", jumped(length, ratio, DAMPED, seed=k))
        held = ", held_out: true" if k >= 4 else ""
        lines += f'  - {{file: jumps/{k}.csv, length: {length * 1e3:g} mm, motor: "{PART.format(ratio)}"{held}}}\n'
    file = project(folder, lines)
    run(file)
    return folder / "out"


@pytest.fixture(scope="module")
def found(damped: Path) -> dict[str, Any]:
    return json.loads((damped / "gap.json").read_text())  # type: ignore[no-any-return]


def test_the_missing_effect_is_named_as_the_file_formats_have_it(found: dict[str, Any]) -> None:
    assert found["format"] == "synth/gap/1"
    assert found["verdict"] == "effect"
    (cause,) = found["explanation"]
    assert (cause["effect"], cause["joint"]) == ("joint_damping", "all")
    damping = cause["parameters"]["damping"]
    assert damping["unit"] == "N*m*s/rad"
    assert damping["interval90"][0] < 6e-4 < damping["interval90"][1]
    chances = [entry["probability"] for entry in found["ranked"]]
    assert chances == sorted(chances, reverse=True)
    assert chances[0] > 0.9
    assert sum(chances) + found["probability_none"] + found["probability_unknown"] == pytest.approx(1.0)
    assert "The joints have more damping" in found["sentence"]


def test_shares_sum_to_one_and_figures_are_on_the_trials_held_out(found: dict[str, Any]) -> None:
    for shares in found["where"].values():
        assert sum(shares.values()) == pytest.approx(1.0)
    assert set(found["where"]["phase"]) == {"release", "swing", "settle", "rest"}
    gap = found["gap"]
    assert gap["scored_on"] == ["jumps/4.csv", "jumps/5.csv"]
    assert gap["as_designed"]["value"] > gap["before"]["value"] > gap["after"]["value"]
    assert gap["after"]["value"] < 1.3 * gap["noise_floor"]["value"]
    assert 0.0 < gap["shrink"]["value"] <= 1.0


def test_the_prediction_is_beside_the_measurement(damped: Path, found: dict[str, Any]) -> None:
    assert [trial["file"] for trial in found["trials"]] == found["gap"]["scored_on"]
    with (damped / found["trials"][0]["predicted"]).open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0])[:4] == ["time [s]", "hip measured [deg]", "hip before [deg]", "hip after [deg]"]
    away = np.array([float(row["hip after [deg]"]) - float(row["hip measured [deg]"]) for row in rows])
    assert np.sqrt(np.mean(away**2)) == pytest.approx(found["trials"][0]["rms"]["hip"]["after"]["value"], rel=1e-6)
    rise = found["trials"][0]["rise"]
    assert rise["after"]["value"] == pytest.approx(rise["measured"]["value"], rel=0.03)
    assert rise["as_designed"]["value"] > 1.1 * rise["measured"]["value"]


def test_the_next_trial_is_an_entry_of_a_project(found: dict[str, Any]) -> None:
    following = found["next_experiment"]
    assert following["trial"]["file"].endswith(".csv")
    assert set(following["trial"]) <= {"file", "motor", "length", "payload", "supply", "lean"}
    bits = [round(item["information"]["value"], INFORMATION_DIGITS) for item in following["menu"]]
    assert bits == sorted(bits, reverse=True)
    assert bits[0] >= 0.0
    assert "hip" in following["release"]


def test_the_page_shows_every_result(damped: Path, found: dict[str, Any]) -> None:
    page = (damped / "report.html").read_text()
    for title in ("Where the gap lies", "Which effect causes it", "Reduction of the gap",
                  "How high, and across designs", "What to record next"):  # fmt: skip
        assert f"<h2>{title}</h2>" in page
    assert found["sentence"].split(",")[0] in page.replace("&#39;", "'")
    assert "Left out" not in page
    # A jump is cut before it could settle or rest: both stood there with 0 %.
    assert ">swing<" in page
    assert ">settle<" not in page
    assert ">rest<" not in page
    assert (found["where"]["phase"]["settle"], found["where"]["phase"]["rest"]) == (0.0, 0.0)


def test_the_page_names_no_file_that_is_not_there(damped: Path) -> None:
    """It told of diagnosed.leg.yaml, which only the diagnosis of a swinging leg writes."""
    page = (damped / "report.html").read_text()
    named = set(re.findall(r"<code>([\w.]+\.(?:yaml|json))</code>", page))
    assert "gap.json" in named
    assert {name for name in named if not (damped / name).is_file()} == set()


def test_the_example_s_cause_is_found_from_another_engines_jumps(tmp_path: Path) -> None:
    """MuJoCo's recordings, damping by another law; the error of the predicted rise is gone on all designs."""
    example = Path(init.__file__).resolve().parent.parent / "examples" / "hopper"
    assert main(["-q", "gap", str(example / "gap.yaml"), "--out", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "gap.json").read_text())
    (cause,) = found["explanation"]
    truth = json.loads((example / "truth.json").read_text())[cause["effect"]]
    assert cause["parameters"]["damping"]["value"] == pytest.approx(truth["damping"]["value"], rel=0.3)
    page = (example.parents[2] / "docs" / "jumping_legs.md").read_text(encoding="utf-8")
    stated = f"{cause['parameters']['damping']['value']:.1e} of {truth['damping']['value']:.1e}".replace("e-0", "e-")
    assert stated in page
    designs = found["across"]["designs"]
    assert len({(d["leg_length"]["value"], d["gear_ratio"]) for d in designs}) == 7
    errors = {stage: np.mean([d["error"][stage]["value"] for d in designs]) for stage in ("as_designed", "after")}
    assert errors["as_designed"] > 10.0
    assert abs(errors["after"]) < 6.0
    assert set(found["across"]["slope"]) == {"length", "gear_ratio"}


def test_without_effects_nothing_is_missing_and_each_trial_is_predicted_by_the_others(tmp_path: Path) -> None:
    for k in range(3):
        write(tmp_path / f"{k}.csv", jumped(seed=10 + k))
    found = run(project(tmp_path, "  - '[0-2].csv'\n"))
    assert found["verdict"] == "none"
    assert found["gap"]["scored_on"] == ["0.csv", "1.csv", "2.csv"]
    assert found["gap"]["as_designed"]["value"] < 0.2
    assert any("leans" in item for item in found["warnings"])
    assert "is unknown" in found["across"]["says"][0]


def test_pull_ups_alone_determine_the_damping_only(tmp_path: Path) -> None:
    lines = ""
    for k, length in enumerate((0.10, 0.12, 0.14)):
        write(tmp_path / f"{k}.csv", pulled(length, DAMPED, seed=k))
        lines += f"  - {{file: {k}.csv, length: {length * 1e3:g} mm}}\n"
    found = run(project(tmp_path, lines))
    assert [entry["effect"] for entry in found["ranked"]] == ["joint_damping"]
    assert found["verdict"] == "effect"
    assert found["explanation"][0]["parameters"]["damping"]["value"] == pytest.approx(6e-4, rel=0.15)
    assert any("pull-ups only" in item for item in found["warnings"])
    assert found["trials"][0]["kind"] == "pull-up"


def test_the_same_input_gives_the_same_bytes_and_dry_run_writes_nothing(tmp_path: Path) -> None:
    write(tmp_path / "a.csv", jumped(seed=1))
    write(tmp_path / "b.csv", jumped(seed=2))
    file = project(tmp_path, "  - '[ab].csv'\n")
    assert main(["-q", "gap", str(file), "--out", str(tmp_path / "out"), "--dry-run"]) == 0
    assert not (tmp_path / "out").exists()
    run(file)
    first = {path.name: path.read_bytes() for path in (tmp_path / "out").rglob("*.*")}
    run(file)
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").rglob("*.*")} == first


BAD = [
    ("  - a.csv\n", "kind: gap\nleg: hopper.yaml\nlength: 12 cm\n", '"motor" missing'),
    ("  - a.csv\n", "kind: gap\nleg: hopper.yaml\n", '"motor" and "length" missing'),
    ("  - a.csv\n", HEAD.replace("HP 6V", "XX 6V"), "no gear motor"),
    ("  - a.csv\n", HEAD.replace("120 mm", "120"), "has no unit"),
    ("  - a.csv\n", HEAD.replace("120 mm", "1 mm"), "too short to meet"),
    ("  - {file: a.csv, held_out: true}\n", HEAD, "every trial is held out"),
    ("  - {file: a.csv, tip_mass: 5 g}\n", HEAD, '"tip_mass" is not a key here'),
    ("  - [a.csv]\n", HEAD, "a mapping"),
    ("  - a.csv\n  - '*.csv'\n", HEAD, "listed twice"),
    ("  - none.csv\n", HEAD, "does not exist"),
    ("  - still.csv\n", HEAD, "does not move"),
    ("  - wide.csv\n", HEAD, "fold from"),
    ("  - short.csv\n", HEAD, "at least 20"),
    ("  - stretched.csv\n", HEAD, "from the stop"),
    ("  - a.csv\n", HEAD + "tolerance: {motor: 80 %}\n", "can be at most"),
    ("  - a.csv\n", HEAD + "tolerance: {hip: 1 %}\n", '"hip" is not a key here'),
]


@pytest.mark.parametrize(("trials", "head", "message"), BAD)
def test_bad_input_is_named(
    trials: str, head: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    time = np.arange(0.0, 0.2, 1e-3)
    write(tmp_path / "a.csv", jumped())
    write(tmp_path / "still.csv", np.column_stack([time, 0.5 + 0 * time, 0.6 + 0 * time]))
    write(tmp_path / "wide.csv", np.column_stack([time, 0.01 + 0 * time, 7 * time]))
    write(tmp_path / "short.csv", jumped()[:10])
    write(tmp_path / "stretched.csv", np.column_stack([time, 0.01 + 0 * time, 0.2 + time]))
    file = project(tmp_path, trials, head)
    assert main(["-q", "gap", str(file), "--out", str(tmp_path / "out")]) == 2
    shown = capsys.readouterr().err
    assert message in shown
    assert "Traceback" not in shown
    assert not (tmp_path / "out").exists()


def test_a_model_without_motion_and_a_swinging_legs_effect_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / "a.csv", jumped())
    file = project(tmp_path, "  - a.csv\n", design=DESIGN + "model: point_mass\n")
    assert main(["-q", "gap", str(file), "--out", str(tmp_path / "out")]) == 2
    assert "does not predict a motion" in capsys.readouterr().err
    file = project(tmp_path, "  - a.csv\n")
    own = Path(__file__).resolve().parents[2] / "docs" / "examples" / "effects" / "cubic_drag.py"
    assert main(["-q", "gap", str(file), "--out", str(tmp_path / "out"), "--effect", str(own)]) == 2
    assert "swinging legs" in capsys.readouterr().err


def test_copies_of_a_recording_count_once(tmp_path: Path) -> None:
    write(tmp_path / "a.csv", jumped())
    (tmp_path / "b.csv").write_bytes((tmp_path / "a.csv").read_bytes())
    found = run(project(tmp_path, "  - '[ab].csv'\n"))
    assert found["gap"]["scored_on"] == ["a.csv"]
    assert any("b.csv is a copy of a.csv" in item for item in found["warnings"])


def designs(length_slope: float, ratio_slope: float) -> tuple[JumpAcrossDesigns, ...]:
    """Nine jumps whose predicted rise is off by these shares a metre and a unit of ratio about 10 %."""
    made = []
    for length in (0.10, 0.12, 0.14):
        for ratio in (75.0, 100.0, 150.0):
            error = 0.1 + length_slope * (length - 0.12) + ratio_slope * (ratio - 108.3)
            rises = dict.fromkeys(("as_designed", "before", "after"), 0.1 * (1.0 + error))
            made.append(JumpAcrossDesigns(f"{length}-{ratio}", "m", length, ratio, 0.1, 0.0, rises))
    return tuple(made)


@pytest.mark.parametrize(("length_slope", "ratio_slope"), [(5.0, 0.0), (0.0, -0.002), (2.0, 0.001)])
def test_trends_across_designs_are_distinguished(length_slope: float, ratio_slope: float) -> None:
    made = designs(length_slope, ratio_slope)
    rng = np.random.default_rng(1)
    errors = np.array([d.error("as_designed") for d in made]) + rng.normal(0.0, 0.004, len(made))
    columns = {"length": np.array([d.length for d in made]), "gear_ratio": np.array([d.gear_ratio for d in made])}
    found = _slopes(columns, errors)
    assert found["length"].value == pytest.approx(length_slope, abs=0.3)
    assert found["gear_ratio"].value == pytest.approx(ratio_slope, abs=1.5e-4)
    for by, true in (("length", length_slope), ("gear_ratio", ratio_slope)):
        low, high = found[by].low, found[by].high
        assert low is not None
        assert high is not None
        assert low < true < high
        assert (low > 0.0 or high < 0.0) == (true != 0.0)


def test_the_sentence_states_whether_the_error_grows() -> None:
    made = designs(5.0, 0.0)
    rng = np.random.default_rng(2)
    noisy = np.array([d.error("after") for d in made]) + rng.normal(0.0, 0.003, len(made))
    columns = {"length": np.array([d.length for d in made]), "gear_ratio": np.array([d.gear_ratio for d in made])}
    slopes = _slopes(columns, noisy)
    said = DesignTrends(made, {by: dict.fromkeys(("as_designed", "before", "after"), slopes[by]) for by in slopes})
    first, second = said.sentences()
    assert "grows (+2" in first
    assert "no significant trend" in second


def test_collinear_columns_get_no_slopes() -> None:
    length = np.array([0.1, 0.12, 0.14, 0.16])
    assert _slopes({"length": length, "gear_ratio": 1000 * length}, np.array([0.1, 0.2, 0.3, 0.4])) == {}


def test_tolerances_change_their_own_quantity() -> None:
    """One deviation of each changes its column by its share; the rest stays."""
    from hopper.recorded import changed
    from synth.diagnosis.plants.jumping_leg.jump_tolerances import MOTOR_TOLERANCES, SHARED_TOLERANCES, JumpTolerances
    from synth.files.hopper_gap_project import JumpTolerance

    tolerances = JumpTolerances(JumpTolerance(), 2)
    touched: dict[str, set[str]] = {}
    for name in (*SHARED_TOLERANCES, *MOTOR_TOLERANCES):
        x = np.zeros((tolerances.size, 1))
        x[tolerances.at(name, 1)] = 1.0
        moved, still = changed(0.12, 150, {}), changed(0.12, 150, {})
        tolerances.apply(moved, x, 1)
        touched[name] = {
            key for key, value in vars(still).items()
            if isinstance(value, np.ndarray) and not np.array_equal(value, getattr(moved, key))
        }  # fmt: skip
        other = changed(0.12, 150, {})
        tolerances.apply(other, x, 0)
        alike = all(np.array_equal(getattr(other, key), value) for key, value in vars(still).items())
        assert alike == (name in MOTOR_TOLERANCES or name in ("angle", "force"))
    assert touched["damper"] == {"joint_damping"}
    assert touched["motor"] == {"torque_constant", "back_emf", "stall_torque", "no_load_speed"}
    assert touched["resistance"] == {"resistance", "stall_torque", "stall_current"}
    assert touched["angle"] == touched["force"] == set()
    assert isinstance(changed(0.12, 150, {}), JumpLanes)
    sizes = len(SHARED_TOLERANCES) + 2 * len(MOTOR_TOLERANCES)
    assert JumpPredictor(tolerances, "upper", 5e-6).tolerances.size == sizes
