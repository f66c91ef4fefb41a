"""``synth fit`` end to end on the built-in example."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from page_reader import Page
from synth.cli import main

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"
CASES = Path(__file__).resolve().parents[3] / "shared" / "cases" / "fit"


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fit")
    shutil.copytree(EXAMPLES / "fit", folder / "project")
    assert main(["--quiet", "fit", str(folder / "project" / "fit.yaml"), "--out", str(folder / "out")]) == 0
    return folder / "out"


def test_fit_json_has_the_public_form(result: Path) -> None:
    fit = json.loads((result / "fit.json").read_text())
    assert fit["format"] == "synth/fit/1"
    for joint in fit["joints"].values():
        for key, unit in (("spring_rate", "N*m/rad"), ("damper_rate", "N*m*s/rad"), ("free_angle", "deg")):
            estimate = joint[key]
            assert estimate["unit"] == unit
            low, high = estimate["interval90"]
            assert low <= estimate["value"] <= high
        assert joint["free_angle_spread"]["unit"] == "deg"
    for trial in fit["trials"]:
        assert trial["file"].endswith(".csv")
        assert set(trial) >= {"rms", "free_angle", "rise_time", "damping_ratio", "damped_frequency"}
    assert (result / "report.html").is_file()
    assert (result / "fitted.leg.yaml").is_file()


TESTED = """kind: leg
name: two links, the ankle tested
gravity: 9.81 m/s^2
joints:
- {name: knee, zero: 180 deg, sign: 1, link: {length: 0.2 m, mass: 0.4 kg, com: 0.1 m, inertia: 1.5e-3 kg*m^2}KEPT}
- {name: ankle, zero: 180 deg, sign: -1, link: {length: 0.16 m, mass: 0.09 kg, com: 0.05 m, inertia: 4e-4 kg*m^2}}
"""
KEPT = {
    "both": ", spring: {rate: 2.2 N*m/rad, free_angle: 111 deg}, damper: {rate: 0.07 N*m*s/rad}",
    "spring": ", spring: {rate: 2.2 N*m/rad, free_angle: 111 deg}",
    "none": "",
}


def fit_of_a_joint_test(folder: Path, kept: str, *, more: str = "") -> tuple[dict[str, Any], str]:
    """``fit.json`` and ``fitted.leg.yaml`` of two releases of the ankle, the knee clamped at 120 deg."""
    folder.mkdir()
    (folder / "leg.leg.yaml").write_text(TESTED.replace("KEPT", kept))
    time, generator = np.arange(0.0, 1.0, 0.004), np.random.default_rng(1)
    for trial, size in (("a", 0.5), ("b", -0.4)):
        swing = 150.0 + np.degrees(size * np.exp(-4.0 * time) * np.cos(14.0 * time))
        swing += generator.normal(0.0, 0.1, len(time))
        rows = "".join(f"{t:.3f},120,{angle:.3f}\n" for t, angle in zip(time, swing, strict=True))
        (folder / f"{trial}.csv").write_text(f"time [s],knee [deg],ankle [deg]\n{rows}")
    trials = "".join(f"- {{file: {name}.csv, locked: [knee]}}\n" for name in "ab")
    (folder / "fit.yaml").write_text(
        f"kind: fit\nleg: leg.leg.yaml\nlaws: linear\nrelease: recorded\n{more}trials:\n{trials}"
    )
    assert main(["fit", str(folder / "fit.yaml"), "--out", str(folder / "out")]) == 0
    return json.loads((folder / "out" / "fit.json").read_text()), (folder / "out" / "fitted.leg.yaml").read_text()


def test_a_joint_locked_in_every_trial_keeps_what_the_leg_file_gives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It was refused, although its torques do not act; the ankle's estimates do not depend on what is given."""
    found = {name: fit_of_a_joint_test(tmp_path / name, kept) for name, kept in KEPT.items()}
    screen = capsys.readouterr().out
    assert "knee: locked in every trial: nothing is estimated here; spring and damper stay as the leg file" in screen
    ankles = [fit["joints"]["ankle"] for fit, _ in found.values()]
    assert ankles[0] == ankles[1] == ankles[2]
    low, high = ankles[0]["spring_rate"]["interval90"]
    assert low < ankles[0]["spring_rate"]["value"] < high
    both, spring, none = (fit for fit, _ in found.values())
    knee = both["joints"]["knee"]
    assert (knee["spring_rate"], knee["estimated"]) == ({"value": 2.2, "unit": "N*m/rad"}, False)
    assert knee["damper_rate"] == {"value": 0.07, "unit": "N*m*s/rad"}
    assert knee["free_angle"] == {"value": pytest.approx(111.0), "unit": "deg"}
    assert spring["joints"]["knee"]["damper"] == {"law": "none"}
    assert set(none["joints"]) == {"ankle"}
    for fit, leg in found.values():
        assert set(fit["rms"]) == {"ankle"}
        assert not [text for text in fit["not_separable"] if text.startswith("knee")]
        assert leg.count("spring:") == 1 + ("knee" in fit["joints"])
    assert "spring: {rate: 2.2 N*m/rad, free_angle: 111 deg}\n  damper: {rate: 0.07 N*m*s/rad}" in found["both"][1]


def test_a_clamped_base_joint_is_a_tilted_base(tmp_path: Path) -> None:
    """The ankle's estimates and intervals are those of a leg of the ankle alone, on a base tilted by -60 deg."""
    folder = tmp_path / "fit"
    two, _ = fit_of_a_joint_test(folder, "")
    lines = TESTED.replace("joints:", "tilt: -60 deg\njoints:").splitlines()
    (folder / "leg.leg.yaml").write_text("\n".join(line for line in lines if "knee" not in line))
    for name in "ab":
        rows = [line.split(",") for line in (folder / f"{name}.csv").read_text().splitlines()]
        (folder / f"{name}.csv").write_text("".join(f"{row[0]},{row[2]}\n" for row in rows))
    project = (folder / "fit.yaml").read_text().replace(", locked: [knee]", "")
    (folder / "fit.yaml").write_text(project)
    assert main(["--quiet", "fit", str(folder / "fit.yaml"), "--out", str(folder / "one")]) == 0
    one = json.loads((folder / "one" / "fit.json").read_text())
    for key in ("spring_rate", "damper_rate", "free_angle"):
        expected, found = (fit["joints"]["ankle"][key] for fit in (one, two))
        assert found["value"] == pytest.approx(expected["value"], rel=1e-5)
        assert found["interval90"] == pytest.approx(expected["interval90"], rel=1e-3)
    assert two["free_angle"]["mode"] == one["free_angle"]["mode"]


def test_intervals_by_bootstrap_beside_a_joint_that_is_locked_in_every_trial(tmp_path: Path) -> None:
    """Its free angle, which nothing determines, made the refits' matrix singular."""
    fit, _ = fit_of_a_joint_test(tmp_path / "fit", "", more="fit: {intervals: bootstrap}\n")
    assert fit["intervals"]["by"] == "bootstrap"
    assert fit["joints"]["ankle"]["spring_rate"]["interval90"]


def test_rms_in_json_and_page_equals_that_of_the_written_samples(result: Path) -> None:
    fit = json.loads((result / "fit.json").read_text())
    words = re.sub(r"\s+", " ", "".join(Page((result / "report.html").read_text()).words))
    pooled: dict[str, list[np.ndarray]] = {name: [] for name in fit["joints"]}
    for trial in fit["trials"]:
        table = np.genfromtxt(
            result / "responses" / "source" / Path(trial["file"]).name, delimiter=",", names=True, deletechars=""
        )
        for name, rms in trial["rms"].items():
            off = table[f"{name}_measured_[deg]"] - table[f"{name}_fitted_[deg]"]
            off = off[np.isfinite(off)]
            assert rms["value"] == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-4)
            assert f"{rms['value']:.3g}" in words
            if not trial["held_out"]:
                pooled[name].append(off)
    for name, parts in pooled.items():
        plain = fit["rms"][name]["value"]
        assert plain == pytest.approx(np.sqrt(np.mean(np.concatenate(parts) ** 2)), rel=1e-4)
        assert f"{plain:.3g}" in words
        assert fit["clipped_rms"][name]["value"] <= plain * (1 + 1e-9)


def test_link_tolerances_are_listed_in_json_and_page(result: Path, tmp_path: Path) -> None:
    fit = json.loads((result / "fit.json").read_text())
    assert fit["tolerance"]["knee"]["mass"] == {"value": 1.0, "unit": "%"}
    listed = {default["key"]: default["value"] for default in fit["defaults"]}
    assert listed["tolerance.inertia"] == "2 %"
    assert "tolerance.spring" not in listed  # sought, not assumed
    assert "Sources of the intervals" in (result / "report.html").read_text()
    shutil.copytree(EXAMPLES / "fit", tmp_path / "project")
    file = tmp_path / "project" / "fit.yaml"
    exact = "tolerance: {length: 0 %, mass: 0 %, com: 0 %, inertia: 0 %, knee: {mass: 5 %}}\n"
    file.write_text(file.read_text() + exact)
    assert main(["--quiet", "fit", str(file), "--out", str(tmp_path / "out")]) == 0
    other = json.loads((tmp_path / "out" / "fit.json").read_text())
    knee = next(s for s in other["interval_sources"] if (s["joint"], s["quantity"]) == ("knee", "spring_rate"))
    assert set(knee["shares"]) == {"trials", "mass of the knee's link"}
    assert not any(default["key"].startswith("tolerance") for default in other["defaults"])


def test_initial_rates_are_in_the_sense_of_the_measured_angle(result: Path) -> None:
    """Against the difference of the first samples, with which a clockwise joint's own rotation would have its sign."""
    fit = json.loads((result / "fit.json").read_text())
    for trial in fit["trials"]:
        for name, rate in trial["initial_rate"].items():
            recorded = trial["recorded_initial_rate"][name]
            low, high = recorded["interval90"]
            assert low - 2 * (high - low) < rate["value"] < high + 2 * (high - low)
            assert trial["initial_angle"][name]["value"] == pytest.approx(
                trial["recorded_initial_angle"][name]["value"], abs=1.0
            )


def test_held_out_trials_are_scored_and_marked(result: Path) -> None:
    fit = json.loads((result / "fit.json").read_text())
    held_out = [trial for trial in fit["trials"] if trial["held_out"]]
    assert held_out
    for trial in held_out:
        for name, rms in trial["rms"].items():
            assert rms["value"] < 3 * fit["rms"][name]["value"]


@pytest.mark.skipif(not CASES.is_dir(), reason="the shared example cases are not here")
@pytest.mark.parametrize("case", ["000", "001", "002"])
def test_the_shared_cases_are_recovered(case: str, tmp_path: Path) -> None:
    """Spring and damper rates within 1 %, free angles within 0.2 deg of the true ones."""
    answers = json.loads((CASES / "answers.json").read_text())[case]["joints"]
    assert main(["--quiet", "fit", str(CASES / case / "fit.yaml"), "--out", str(tmp_path / "out")]) == 0
    fit = json.loads((tmp_path / "out" / "fit.json").read_text())
    for name, answer in answers.items():
        found = fit["joints"][name]
        assert found["spring_rate"]["value"] == pytest.approx(answer["spring_rate"], rel=0.01)
        assert found["damper_rate"]["value"] == pytest.approx(answer["damper_rate"], rel=0.01)
        assert found["free_angle"]["value"] == pytest.approx(answer["free_angle"], abs=0.2)


def test_method_and_cost_are_chosen_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(EXAMPLES / "fit", tmp_path / "project")
    file, out = tmp_path / "project" / "fit.yaml", tmp_path / "out"
    assert main(["fit", str(file), "--out", str(out), "--method", "piecewise", "--cost", "transient"]) == 0
    fit = json.loads((out / "fit.json").read_text())
    assert (fit["method"], fit["cost"]) == ("piecewise", "transient")
    assert "piecewise with the cost transient leaves" in capsys.readouterr().out
    assert main(["fit", str(file), "--out", str(tmp_path / "no"), "--cost", "characteristics"]) == 2
    assert "Write method: piecewise or swarm" in capsys.readouterr().err
    assert main(["fit", str(file), "--out", str(tmp_path / "no"), "--method", "swam"]) == 2
    assert "did you mean swarm?" in capsys.readouterr().err
    assert main(["fit", str(tmp_path), "--out", str(tmp_path / "no"), "--method", "swarm"]) == 2
    assert "write it under fit: in each project" in capsys.readouterr().err
    assert not (tmp_path / "no").exists()


def test_a_static_point_and_bootstrap_intervals_are_in_the_result(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES / "fit", tmp_path / "project")
    file = tmp_path / "project" / "fit.yaml"
    point = "static:\n  - {angles: {hip: 140 deg}, torque: {hip: 12 N*m}, supported: true}\n"
    file.write_text(file.read_text() + point)
    assert main(["--quiet", "fit", str(file), "--out", str(tmp_path / "out"), "--intervals", "bootstrap"]) == 0
    fit = json.loads((tmp_path / "out" / "fit.json").read_text())
    (static,) = fit["static"]
    assert (static["point"], static["joint"]) == ("static[1]", "hip")
    assert static["spring_torque"]["measured"] == {"value": 12.0, "unit": "N*m"}
    assert fit["intervals"]["by"] == "bootstrap"
    assert fit["intervals"]["refits"] == 200
    assert not any("mass scale" in text for text in fit["not_separable"])
    page = (tmp_path / "out" / "report.html").read_text()
    assert "static[1]" in page
    assert "200" in page


def test_a_mistake_in_a_static_point_is_named_with_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(EXAMPLES / "fit", tmp_path / "project")
    file = tmp_path / "project" / "fit.yaml"
    lines = file.read_text().rstrip("\n").splitlines()
    file.write_text("\n".join([*lines, "static:", "  - {angles: {hip: 140 deg}, torque: {hip: 12 N*m}}", ""]))
    assert main(["fit", str(file), "--out", str(tmp_path / "no")]) == 2
    said = capsys.readouterr().err
    assert f"fit.yaml:{len(lines) + 2}" in said
    assert "supported: true" in said
    assert not (tmp_path / "no").exists()


def test_the_commented_options_of_the_example_are_valid(tmp_path: Path) -> None:
    """The static points of the example are those of the leg that made its trials: the fit agrees with them."""
    shutil.copytree(EXAMPLES / "fit", tmp_path / "project")
    file = tmp_path / "project" / "fit.yaml"
    lines = file.read_text().splitlines()
    used = [line.removeprefix("# ") if line.startswith(("# static:", "#   - ", "# fit:")) else line for line in lines]
    file.write_text("\n".join(used) + "\n")
    assert main(["--quiet", "fit", str(file), "--out", str(tmp_path / "out")]) == 0
    fit = json.loads((tmp_path / "out" / "fit.json").read_text())
    assert len(fit["static"]) == 1 + 3 + 1
    assert max(abs(point["deviations"]) for point in fit["static"]) < 1.5
    assert not any("static point" in item for item in fit["warnings"])
