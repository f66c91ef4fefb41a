"""The repository as a whole: lock, examples."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import synth
from synth.files.gap_project import Tolerance, read_gap_project
from synth.files.leg_project import read_leg_project
from synth.files.projects import read_fit_project
from synth.units import factor
from tool_modules import tool

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "synth" / "examples"


def files_in(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)


def test_lock_covers_every_dependency_with_hashes_and_names_no_host() -> None:
    text = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    locked = re.findall(r"^([a-z0-9.-]+)==\S+ \\\n {4}--hash=sha256:[0-9a-f]{64}", text, re.MULTILINE)
    assert len(locked) == len(re.findall(r"^[^\s#]", text, re.MULTILINE))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = project["project"]["dependencies"] + project["project"]["optional-dependencies"]["dev"]
    names = {re.split(r"[^A-Za-z0-9.-]", item)[0].lower() for item in wanted + project["build-system"]["requires"]}
    assert sorted(names - set(locked)) == []
    assert "://" not in text
    assert "--index" not in text
    assert "--find-links" not in text


def test_changelog_begins_with_this_version_dated_or_with_what_comes_after_it() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    first, *others = re.findall(r"^## \[([^]]+)\](?: - (\d{4}-\d{2}-\d{2}))?$", text, re.MULTILINE)
    released = [first, *others] if first[0] != "Unreleased" else others
    assert released[0][0] == synth.__version__
    assert all(date for _, date in released)
    assert re.search(r"^## \[[^]]+\].*\n\n### (Added|Changed|Fixed|Removed)\n- ", text, re.MULTILINE)


@pytest.mark.slow
def test_examples_are_what_their_tools_make(tmp_path: Path) -> None:
    tool("make_example").make(EXAMPLES, tmp_path)
    tool("make_jumps").make(tmp_path / "hopper")
    tool("make_videos").make(tmp_path / "import")
    made = files_in(tmp_path)
    assert [name for name in files_in(EXAMPLES) if name.endswith(".csv") or name.endswith("truth.json")] == made
    for name in made:
        shipped, again = (EXAMPLES / name).read_text(encoding="utf-8"), (tmp_path / name).read_text(encoding="utf-8")
        if name.endswith(".json"):
            assert json.loads(shipped) == json.loads(again)
            continue
        if name.startswith("import/"):  # three lines of header, and words among them
            assert shipped == again
            continue
        assert shipped.splitlines()[0] == again.splitlines()[0]
        values = [np.loadtxt(text.splitlines(), delimiter=",", skiprows=1) for text in (shipped, again)]
        np.testing.assert_allclose(values[0], values[1], rtol=0, atol=1e-6, err_msg=name)


def test_examples_are_small_say_that_they_are_simulated_and_how() -> None:
    assert sum((EXAMPLES / name).stat().st_size for name in files_in(EXAMPLES)) < 300_000
    for folder in ("leg", "fit"):
        text = (EXAMPLES / folder / "README.md").read_text(encoding="utf-8")
        assert "simulated by MuJoCo" in text
        assert "tools/make_example.py" in text
        truth = json.loads((EXAMPLES / folder / "truth.json").read_text(encoding="utf-8"))
        for joint in truth["animal" if folder == "leg" else "robot"].values():
            assert all(repr(joint[key]["value"]).removesuffix(".0") in text for key in joint)


def test_the_gap_example_is_off_within_its_tolerances_and_says_what_it_hides() -> None:
    text = (EXAMPLES / "gap" / "README.md").read_text(encoding="utf-8")
    assert "simulated by MuJoCo" in text
    assert "tools/make_example.py" in text
    project = read_gap_project(EXAMPLES / "gap" / "gap.yaml")
    assert project.tolerance == Tolerance()
    assert [trial.held_out for trial in project.trials] == [False] * 5 + [True] * 2
    truth = json.loads((EXAMPLES / "gap" / "truth.json").read_text(encoding="utf-8"))
    friction = truth["coulomb_friction"]["torque"]["value"]
    assert f"{friction} N·m" in text
    off = []
    for joint in project.leg.joints:
        assert joint.spring is not None
        assert joint.effects == {}
        built = {
            key: item["value"] * factor(item["unit"], UNITS[key]) for key, item in truth["built"][joint.name].items()
        }
        off.append((built["mass"] / joint.link.mass - 1.0) / project.tolerance.mass)
        off.append((built["spring_rate"] / joint.spring.rate - 1.0) / project.tolerance.spring)
        off.append((built["free_angle"] - joint.spring.free_angle) / project.tolerance.free_angle)
    assert all(0.0 < abs(one) < 3.0 for one in off)


UNITS = {"length": "m", "mass": "kg", "com": "m", "inertia": "kg*m^2", "spring_rate": "N*m/rad"}
UNITS |= {"damper_rate": "N*m*s/rad", "free_angle": "rad"}


def test_examples_read_without_a_problem() -> None:
    leg = read_leg_project(EXAMPLES / "leg" / "leg-design.yaml")
    assert [trial.held_out for trial in leg.trials] == [False] * 7 + [True] * 2
    assert leg.time_scale == 2.0
    fit = read_fit_project(EXAMPLES / "fit" / "fit.yaml")
    assert len(fit.trials) == 7


def test_animal_rest_angles_scatter_as_the_readme_says() -> None:
    truth = json.loads((EXAMPLES / "leg" / "truth.json").read_text(encoding="utf-8"))
    common = [truth["animal"][joint]["free_angle"]["value"] for joint in ("hip", "knee", "ankle")]
    shift = np.array(list(truth["free angles of each trial, deg"].values())) - common
    # 27 draws of SD 2 deg: the 99.9 % interval of their root mean square (chi-squared, 27 degrees of freedom)
    assert 1.16 < np.sqrt(np.mean(shift**2)) < 2.93
