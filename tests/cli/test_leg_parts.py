"""The options of ``synth leg`` that restrict the parts, and its report of the choice."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from synth.cli import main

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "leg"


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example with two releases, a wish, tolerances, two in parallel and a belt at the ankle."""
    folder = tmp_path_factory.mktemp("parts") / "leg"
    shutil.copytree(EXAMPLE, folder)
    path = folder / "leg-design.yaml"
    text = path.read_text().replace("select:\n", "select:\n  within: 4 deg\n  tolerance: {free_angle: 2 deg}\n", 1)
    ankle = "ankle: {spring: {rate_tolerance: 25 %, parallel: 2}, damper: {parallel: 2, ratios: [1, 2]}}"
    text = text.replace("release_*.csv", "release_[12].csv", 1)
    lines = [f"    {ankle}" if line.strip().startswith("ankle:") else line for line in text.splitlines()]
    kept = [line for line in lines if not line.startswith(("dampers:", "  knee: {part"))]  # no drops of a damper
    path.write_text("\n".join(kept) + "\n")
    return path


def test_excluded_parts_are_left_out_and_reported(
    project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    words = ["leg", str(project), "--out", str(out), "--no-cad", "--without", "6597k8", "--vendor", "Lee Spring"]
    assert main([*words, "--vendor", "McMaster-Carr", "--system", "inch"]) == 0
    said = capsys.readouterr().out
    design = json.loads((out / "design.json").read_text())
    search = design["response"]["search"]
    assert search["filters"] == {
        "vendors": ["Lee Spring", "McMaster-Carr"], "without": ["6597k8"], "system": "inch"
    }  # fmt: skip
    parts = {item["part"] for joint in design["joints"].values() for item in joint["damper_alternatives"]}
    assert {item["count"] for joint in design["joints"].values() for item in joint["damper_alternatives"]} == {1, 2}
    assert not any("6597K8" in part for part in parts)
    forecast = design["response"]["forecast"]
    assert forecast["within"]["value"] == pytest.approx(4.0)
    low, high = forecast["expected"]["interval90"]
    assert low < forecast["expected"]["value"] < high
    assert design["joints"]["hip"]["tolerance"]["free_angle"]["value"] == pytest.approx(2.0)
    assert sum(cause["share"]["value"] for cause in forecast["causes"]) == pytest.approx(1.0)
    for joint in design["joints"].values():
        for item in (*joint["spring_alternatives"], *joint["damper_alternatives"]):
            assert item["cost"]["unit"] == "deg"
        # Of one damper, as it is ordered, however many there are: the maker's 312, 31 and 7 in-oz.
        published = {"6597K21": 312.0, "6597K19": 31.0, "6597K8": 7.0}
        for item in joint["damper_alternatives"]:
            (part,) = [name for name in published if name in item["part"]]
            assert item["torque_inch"] == {"value": pytest.approx(published[part], rel=1e-4), "unit": "ozf*in"}
        costs = [item["cost"]["value"] for item in joint["spring_alternatives"]]
        assert costs == sorted(costs)
    assert f"{forecast['expected']['value']:.2f} deg (90 %: {low:.2f} to {high:.2f})" in said
    assert "Sets of parts under tolerance" in (out / "report.html").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--vendor", "Lee Sprng"], '--vendor: "Lee Sprng" is no vendor in the catalogues; did you mean Lee Spring?'),
        (["--without", "6597K99"], '--without: "6597K99" is no part in the catalogues; did you mean 6597K'),
        (["--system", "imperial"], "not one of inch, metric"),
    ],
)
def test_unknown_part_and_vendor_names_are_refused(
    project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert main(["leg", str(project), "--out", str(tmp_path / "out"), *words]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("within: 4 deg", "within: 0 deg", "must be more than 0 deg"),
        ("within: 4 deg", "vendors: [Lee Sprng]", 'leg-design.yaml:12: select.vendors[1]: "Lee Sprng" is no vendor'),
        ("within: 4 deg", "without: [Lee Spring]", 'select.without[1]: "Lee Spring" is no part in the catalogues'),
        (
            "rate_tolerance: 25 %, parallel: 2",
            "part: 6597K21",
            'leg-design.yaml:17: select.joints.ankle.spring.part: no spring "6597K21" in the catalogues',
        ),
        (
            "rate_tolerance: 25 %, parallel: 2",
            "part: LTR135HH",
            'select.joints.ankle.spring.part: no spring "LTR135HH" in the catalogues; did you mean LTR135H',
        ),
        (
            "rate_tolerance: 25 %, parallel: 2",
            "wire: musik",
            'ankle.spring.wire: no wire material "musik"; did you mean',
        ),
        ("parallel: 2, ratios: [1, 2]", "part: 6597K211", 'ankle.damper.part: no damper "6597K211"'),
        ("free_angle: 2 deg", "free_angel: 2 deg", "free_angle"),
        ("free_angle: 2 deg", "temperature: -5 K", "at least 0"),
        ("parallel: 2, ratios", "parallel: 9, ratios", "parallel"),
        ("ratios: [1, 2]", "ratios: [0]", "ratios"),
        ("ratios: [1, 2]", "ratios: []", "ratios"),
        (
            "rate_tolerance: 25 %, parallel: 2",
            "part: 9271K621",
            "select.joints.ankle.spring.part: 9271K621 is requested",
        ),
    ],
)
def test_invalid_part_options_are_refused(
    project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    copy = tmp_path / "project"
    shutil.copytree(project.parent, copy)
    path = copy / "leg-design.yaml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    assert main(["leg", str(path), "--out", str(tmp_path / "out"), "--dry-run", "--without", "9271K621"]) == 2
    assert message in capsys.readouterr().err
