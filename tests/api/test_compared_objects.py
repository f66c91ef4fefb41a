"""``synth.compare`` takes results, legs and recordings that are in memory, as it takes their files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import synth
from synth.files.output import output_folder

FIT = Path(synth.__file__).parent / "examples" / "fit"


@pytest.fixture(scope="module")
def fitted() -> synth.Fit:
    leg = synth.read_leg(FIT / "robot.leg.yaml")
    return synth.fit(leg, synth.read_trials("trials/free_1.csv", leg, folder=FIT))


def test_a_fit_and_its_leg_are_compared_as_their_files(fitted: synth.Fit, tmp_path: Path) -> None:
    found = synth.compare({"fit": fitted, "leg": fitted.leg})
    assert [side.name for side in found.result.sides] == ["fit recorded", "fit fitted", "leg"]
    assert found.result.differences[-1].overall < 1e-9
    folder = fitted.save(tmp_path / "saved")
    by_files = synth.compare(f"fit={folder}", f"leg={folder / 'fitted.leg.yaml'}")
    ours, theirs = found.result.as_json(), by_files.result.as_json()
    for key in ("differences", "starts", "reference"):
        assert ours[key] == theirs[key]
    assert [side["characteristics"] for side in ours["sides"]] == [side["characteristics"] for side in theirs["sides"]]
    assert ours["inputs"]["fit/fit.json"] == theirs["inputs"][f"{folder.as_posix()}/fit.json"]
    assert str(tmp_path.parent) not in json.dumps(ours)


def test_a_comparison_is_not_saved_over_what_it_compares(fitted: synth.Fit, tmp_path: Path) -> None:
    """The command refused it; ``save`` replaced the fit by the comparison."""
    folder = fitted.save(tmp_path / "saved")
    for found in (synth.compare(str(folder), fitted.leg), synth.compare(fitted, fitted.leg)):
        with pytest.raises(synth.UserError, match=r"saved: holds what this run reads \(fit\.json, "):
            found.save(folder)
        assert (folder / "fitted.leg.yaml").exists()
        assert found.save(found.save(tmp_path / "compared")).exists()  # its own earlier folder is replaced


def test_a_fit_is_not_saved_over_its_recordings(
    fitted: synth.Fit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They were protected only where the working folder was the one that they are named from."""
    monkeypatch.chdir(tmp_path)
    with output_folder(tmp_path / "found") as made:
        (made / "free_1.csv").write_bytes((FIT / "trials" / "free_1.csv").read_bytes())
    trials = synth.read_trials(tmp_path / "found" / "free_1.csv", fitted.leg)
    found = replace(fitted, project=replace(fitted.project, trials=trials))
    with pytest.raises(synth.UserError, match=r"found: holds what this run reads \(free_1\.csv\)"):
        found.save(tmp_path / "found")


def test_a_fit_is_not_saved_over_the_leg_that_it_was_given(fitted: synth.Fit, tmp_path: Path) -> None:
    """The leg of an earlier result, and the curve of its damper, were replaced without a word."""
    curve = synth.Damper(curve=synth.DamperCurve((1.0, 2.0), (0.1, 0.15)))
    first = fitted.leg.joint_names[0]
    with output_folder(tmp_path / "found") as made:
        synth.write_leg(fitted.leg.with_joints(**{first: {"damper": curve}}), made / "fitted.leg.yaml")
    leg = synth.read_leg(tmp_path / "found" / "fitted.leg.yaml")
    again = replace(fitted, project=replace(fitted.project, leg=leg.with_joints(**{first: {"sign": 1}})))
    with pytest.raises(synth.UserError, match=r"found: holds what this run reads \(fitted\.leg\.yaml, fitted.*\.csv\)"):
        again.save(tmp_path / "found")
    assert again.save(again.save(tmp_path / "elsewhere")).exists()  # its own earlier folder is replaced


def test_names_come_from_the_objects(fitted: synth.Fit) -> None:
    name = fitted.leg.name
    found = synth.compare(fitted, fitted.leg)
    assert [side.name for side in found.result.sides] == [f"{name} recorded", f"{name} fitted", name]
    with pytest.raises(synth.UserError, match=r'two sides are called .* synth\.compare\(\{"new"'):
        synth.compare(fitted.leg, fitted.leg)
    with pytest.raises(synth.UserError, match='the name "a/b" of a side is not allowed'):
        synth.compare({"a/b": fitted.leg}, fitted)


def test_recordings_that_were_read_are_a_side(fitted: synth.Fit) -> None:
    for trials in (fitted.project.trials, fitted.project.trials[0]):
        found = synth.compare(trials, {"model": fitted.leg})
        assert [side.name for side in found.result.sides] == ["recorded", "model"]
        assert found.result.inputs["trials/free_1.csv"] == fitted.project.trials[0].sha256


def test_what_cannot_be_compared_is_told() -> None:
    leg = synth.read_leg(FIT.parent / "gap" / "nominal.leg.yaml")
    trial = synth.read_trials("trials/free_1.csv", leg, folder=FIT.parent / "gap")
    with pytest.raises(synth.UserError, match="NoneType, which cannot be compared"):
        synth.compare(None, leg)  # type: ignore[arg-type]
    with pytest.raises(synth.UserError, match=r"\[\] are no recordings that were read; compare takes a Fit"):
        synth.compare([], trial)
    with pytest.raises(synth.UserError, match="SpringAnswer, which cannot be compared"):
        synth.compare(synth.spring("1.7 N*m/rad", "40 deg"), leg)
    with pytest.raises(synth.UserError, match="are no recordings that were read"):
        synth.compare([leg, leg])  # type: ignore[list-item]
