"""``synth fit`` end to end on the built-in example."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

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
