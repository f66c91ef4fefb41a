"""``synth leg`` and ``synth fit`` end to end on the built-in examples, and their messages for bad input."""

from __future__ import annotations

import hashlib
import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from played_legs import play_errors
from result_fields import require_explained
from synth.cli import main
from synth.files.run_manifest import MANIFEST

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"
Edit = Callable[[Path], None]


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("example") / "leg"
    shutil.copytree(EXAMPLES / "leg", folder)
    return folder


@pytest.fixture(scope="module")
def result(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("result") / "out"
    assert main(["--quiet", "leg", str(project / "leg-design.yaml"), "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def design(result: Path) -> dict[str, object]:
    return json.loads((result / "design.json").read_text())  # type: ignore[no-any-return]


def test_every_field_has_a_text_in_the_reference(design: dict) -> None:  # type: ignore[type-arg]
    require_explained("design.json", design)


def hashes(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_the_example_gives_a_complete_design(result: Path, design: dict) -> None:  # type: ignore[type-arg]
    assert design["format"] == "synth/leg-design/1"
    for name in ("design.json", "bom.csv", "report.html", "leg.mjcf.xml", "built.leg.yaml", "wanted.leg.yaml"):
        assert (result / name).stat().st_size > 0
    for joint in ("hip", "knee", "ankle"):
        assert (result / "parts" / f"{joint}_upper.step").is_file()
        assert (result / "parts" / f"{joint}_lower.stl").is_file()
        wound = "make" in design["joints"][joint]["spring"]
        assert (result / "parts" / f"{joint}_spring_quotation.dxf").is_file() == wound
    assert list(design["joints"]) == ["hip", "knee", "ankle"]
    assert all(check["passed"] for check in design["solids"]["checks"])


def test_the_page_on_parts_states_what_the_bought_spring_costs(design: dict) -> None:  # type: ignore[type-arg]
    (bought,) = (o for o in design["joints"]["knee"]["spring_alternatives"] if o["part"] == "LTR135H 10 M")
    page = (EXAMPLES.parents[1] / "docs" / "order_parts.md").read_text(encoding="utf-8")
    assert f"LTR135H 10 M, for {bought['cost']['value']:.2f}° more" in page


def test_listed_hashes_match_the_written_files(result: Path, design: dict) -> None:  # type: ignore[type-arg]
    found = hashes(result)
    for item in design["files"]:
        assert found[item["path"]] == item["sha256"]
    unlisted = set(found) - {item["path"] for item in design["files"]}
    assert unlisted == {"design.json", "report.html", ".synth-output"}


def test_the_source_fit_finds_the_published_values(project: Path, design: dict) -> None:  # type: ignore[type-arg]
    """The example's truth lies within five per cent of the estimates, damper rates too."""
    truth = json.loads((project / "truth.json").read_text())
    animal = next(value for key, value in truth.items() if "animal" in key or "source" in key)
    for name, joint in design["stages"]["source"]["joints"].items():
        known = animal["joints"][name] if "joints" in animal else animal[name]
        assert joint["spring_rate"]["value"] == pytest.approx(known["spring_rate"]["value"], rel=0.05)
        assert joint["damper_rate"]["value"] == pytest.approx(known["damper_rate"]["value"], rel=0.05)


def test_the_arm_offset_equals_the_drawn_one(design: dict) -> None:  # type: ignore[type-arg]
    """Free angle less the spring's included angle, less where the upper arm is drawn."""
    for joint in design["joints"].values():
        spring = joint["spring"]
        included = spring.get("make", spring)["included_angle"]["value"]
        offset = spring["free_angle"]["value"] - included - joint["arms"]["upper_arm_angle"]["value"]
        assert math.remainder(joint["arm_offset"]["value"] - offset, 360.0) == pytest.approx(0.0, abs=1e-6)


def test_solids_agree_with_the_design(result: Path, design: dict) -> None:  # type: ignore[type-arg]
    """No play, stops that are the leg's limits in every file, and one wire in design, sheet and solid."""
    for name, joint in design["joints"].items():
        assert joint["play"]["value"] < 0.3
        low, high = (stop["value"] for stop in joint["stops"])
        assert f"range: [{low:g} deg, {high:g} deg]" in (result / "built.leg.yaml").read_text()
        assert joint["arms"]["drawn_rate_over_designed"]["value"] == pytest.approx(1.0, abs=5e-3)
        drawn = next(part for part in design["solids"]["parts"] if part["part"] == f"{name}_spring")
        assert drawn["moves_with"] == "spring"
        made = joint["spring"].get("make")
        if made is not None:
            assert drawn["mass"]["value"] == pytest.approx(made["mass"]["value"], rel=5e-3)
            assert made["leg_lengths"][0]["value"] == pytest.approx(joint["arms"]["whole"]["value"])
    for part in design["solids"]["parts"]:
        assert part["mass"] is None or part["inertia"]["value"] > 0.0
    solids = [item for item in design["files"] if item["path"].startswith("parts/") and "joint" in item]
    assert {item["moves_with"] for item in solids} == {"upper", "lower", "spring"}
    text = (result / "leg.urdf").read_text()
    assert text.count("<limit lower=") == len(design["joints"])


def test_alternative_sets_are_ranked_by_expected_error(design: dict) -> None:  # type: ignore[type-arg]
    sets = design["response"]["alternatives"]
    expected = [item["free_angles_measured"]["expected"]["value"] for item in sets]
    assert expected == sorted(expected)
    assert len(expected) >= 2
    costs = [item["cost"]["value"] for item in sets]
    for cost, value in zip(costs, expected, strict=True):
        assert cost - costs[0] == pytest.approx(value - expected[0], abs=1e-6)
    for item in sets:
        low, high = item["expected"]["interval90"]
        assert low < item["expected"]["value"] < high


def test_a_chosen_part_is_not_its_own_substitute(design: dict) -> None:  # type: ignore[type-arg]
    """The drawn spring differs in its arms from the one that was ranked: it stood below itself, at no cost."""
    for joint in design["joints"].values():
        made = joint["spring"].get("make")
        own = f"wind {made['wire_diameter']['value']:.4g} mm {made['material']}" if made else joint["spring"]["part"]
        assert joint["spring_alternatives"]
        assert own not in [other["part"] for other in joint["spring_alternatives"]]
        assert joint["damper"]["part"] not in [other["part"] for other in joint["damper_alternatives"]]


def test_the_maker_s_point_and_the_units_of_parts(design: dict) -> None:  # type: ignore[type-arg]
    """McMaster-Carr's 312, 31 and 7 in-oz at 50 rpm; an in*lbf is 4.4482 N by 25.4 mm, a sixteenth of it an in*oz."""
    pound = 4.4482216 * 0.0254
    published = {"6597K21": 312.0, "6597K19": 31.0, "6597K8": 7.0}
    for joint in design["joints"].values():
        damper = joint["damper"]
        torque, speed = published[damper["part"]] * pound / 16, 50 * math.tau / 60
        assert damper["secant_rate"] == {"value": pytest.approx(torque / speed, rel=1e-4), "unit": "N*m*s/rad"}
        for other in joint["spring_alternatives"]:
            inch = other["rate"]["value"] / pound * math.pi / 180
            assert other["rate_inch"] == {"value": pytest.approx(inch, rel=1e-4), "unit": "lbf*in/deg"}


def test_the_cost_of_a_part_is_from_the_error_of_the_chosen_set(design: dict) -> None:  # type: ignore[type-arg]
    """Which the response states by itself, and which is the RMS of those of its joints.

    That of the response is of the leg as drawn, whose springs and masses differ a little from those that were ranked.
    """
    response = design["response"]["wanted_to_built"]
    chosen = response["rms"]["value"]
    of_joints = [error["value"] for error in response["joints"].values()]
    assert chosen == pytest.approx(math.sqrt(sum(error**2 for error in of_joints) / len(of_joints)))
    for kind in ("spring", "damper"):
        others = [each for joint in design["joints"].values() for each in joint[f"{kind}_alternatives"]]
        assert others
        for other in others:
            assert other["response_error"]["value"] - other["nominal_cost"]["value"] == pytest.approx(chosen, rel=0.01)
        expected = [other["expected_error"]["value"] - other["cost"]["value"] for other in others]
        assert expected == pytest.approx([expected[0]] * len(others), abs=1e-6)  # of the chosen set, by which it is
        allowed = [other for other in others if other.get("within_tolerance", True)]
        assert allowed or kind == "spring"  # every bought spring of the example is further off than its tolerance
        assert all(other["cost"]["value"] > -0.003 for other in allowed)  # the set is never worse than what it lists


def test_the_held_out_error_is_that_of_all_their_samples(project: Path, design: dict) -> None:  # type: ignore[type-arg]
    """Its square is the mean of those of the trials, each as often as it has samples."""
    trials = design["held_out"]["trials"]
    counts = [len((project / trial["file"]).read_text().splitlines()) - 1 for trial in trials]
    assert len(counts) == 2
    for joint, stated in design["held_out"]["rms"].items():
        squares = [count * trial["rms"][joint]["value"] ** 2 for count, trial in zip(counts, trials, strict=True)]
        assert stated["value"] == pytest.approx(math.sqrt(sum(squares) / sum(counts)), rel=1e-6)


@pytest.mark.slow  # a second design with solids
def test_the_same_input_gives_the_same_bytes(
    project: Path, result: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On one core too, where nothing is done in side processes."""
    monkeypatch.setenv("SYNTH_THREADS", "1")
    again = ["--quiet", "leg", str(project / "leg-design.yaml"), "--no-cache", "--out", str(tmp_path / "again")]
    assert main(again) == 0
    first, second = hashes(result), hashes(tmp_path / "again")
    assert {name for name in first if first[name] != second[name]} == set()
    assert first.keys() == second.keys()


def test_the_built_leg_reads_back_and_the_mjcf_moves_like_it(result: Path) -> None:
    """The exported model, simulated by MuJoCo, follows our trajectory within 0.1 deg at every instant."""
    mujoco = pytest.importorskip("mujoco")
    import numpy as np

    from synth.files.leg_file import read_leg
    from synth.swing.chain import simulate

    leg = read_leg(result / "built.leg.yaml")
    model = mujoco.MjModel.from_xml_path(str(result / "leg.mjcf.xml"))
    data = mujoco.MjData(model)
    start = np.array([0.3, -0.9, 0.6])
    data.qpos[:] = start
    times = np.arange(0, 1.0, model.opt.timestep)
    ours = simulate(leg, start, np.zeros(3), times)
    theirs = np.empty_like(ours)
    for index in range(len(times)):
        theirs[index] = data.qpos
        mujoco.mj_step(model, data)
    assert np.degrees(np.abs(ours - theirs)).max() < 0.1


def test_mujoco_with_drawn_play_stops_and_friction_follows_the_report(result: Path, design: dict) -> None:  # type: ignore[type-arg]
    """``synth check`` of the result: seven releases of three joints, with full inertias and the dampers' curves."""
    pytest.importorskip("mujoco")
    from synth.model_checks.designed_leg import designed_leg_checks

    checks = designed_leg_checks(result)
    assert len(checks.checks) == 21
    assert checks.left_out == ()
    assert not checks.failed
    assert max(abs(check.found - check.expected) for check in checks.checks) < math.radians(0.1)
    assert all(joint["play"]["value"] < 0.01 for joint in design["solids"]["joints"].values())


@pytest.mark.slow  # like ``design/test_real_data``
def test_mujoco_follows_the_leg_with_as_much_play_as_may_be_drawn(result: Path, design: dict) -> None:  # type: ignore[type-arg]
    """A play of 0.3 deg in every joint, behind dampers whose curves bend: within 0.3 deg (0.08 to 0.27)."""
    mujoco = pytest.importorskip("mujoco")
    from synth.files.leg_file import read_leg
    from synth.model_checks.designed_leg import predicted
    from synth.parts.resolver import resolver

    leg = read_leg(result / "built.leg.yaml", resolve_part=resolver())
    releases = predicted(result, design, leg)
    off, effect = play_errors(mujoco, leg, releases[::3])
    assert effect > 0.3
    assert off < 0.3


def test_an_earlier_result_of_the_same_input_is_reused(
    project: Path, result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["leg", str(project / "leg-design.yaml"), "--out", str(tmp_path / "again")]) == 0
    said = capsys.readouterr()
    assert "the input is unchanged" in said.out + said.err
    assert "fitting" not in said.out + said.err
    assert hashes(tmp_path / "again") == hashes(result)


def test_urdf_and_sdf_are_valid_and_their_losses_reported(result: Path, design: dict) -> None:  # type: ignore[type-arg]
    mujoco = pytest.importorskip("mujoco")
    assert mujoco.MjModel.from_xml_path(str(result / "leg.urdf")).nq == 3
    assert "spring_stiffness" in (result / "leg.sdf").read_text()
    lost = [warning["text"] for warning in design["warnings"] if "does not represent all" in warning["text"]]
    assert [text.split()[0] for text in lost] == ["leg.urdf", "leg.sdf"]


def edited(project: Path, tmp_path: Path, edit: Edit) -> Path:
    copy = tmp_path / "project"
    shutil.copytree(project, copy)
    edit(copy)
    return copy / "leg-design.yaml"


def replace_in(name: str, old: str, new: str) -> Edit:
    def edit(folder: Path) -> None:
        path = folder / name
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    return edit


def first_release(folder: Path) -> Path:
    return sorted((folder / "animal" / "releases").glob("release_*.csv"))[0]


def no_unit(folder: Path) -> None:
    path = first_release(folder)
    path.write_text(path.read_text().replace("hip [deg]", "hip", 1))


def backwards(folder: Path) -> None:
    path = first_release(folder)
    lines = path.read_text().splitlines()
    lines[5], lines[6] = lines[6], lines[5]
    path.write_text("\n".join(lines) + "\n")


def too_short(folder: Path) -> None:
    path = first_release(folder)
    path.write_text("\n".join(path.read_text().splitlines()[:10]) + "\n")


def missing_joint(folder: Path) -> None:
    path = first_release(folder)
    path.write_text(path.read_text().replace("ankle [deg]", "ankel [deg]", 1))


def never_moves(folder: Path) -> None:
    for path in (folder / "animal" / "releases").glob("*.csv"):
        lines = path.read_text().splitlines()
        column = lines[0].split(",").index("ankle [deg]")
        rows = [line.split(",") for line in lines]
        for row in rows[1:]:
            row[column] = "139.0"
        path.write_text("\n".join(",".join(row) for row in rows) + "\n")


def link_outside(folder: Path) -> None:
    outside = folder.parent / "outside.csv"
    outside.write_text(first_release(folder).read_text())
    first_release(folder).unlink()
    (folder / "animal" / "releases" / "release_x.csv").symlink_to(outside)


def huge(folder: Path) -> None:
    with first_release(folder).open("ab") as stream:
        stream.truncate(200_000_000)


BAD = {
    "a column without unit": (no_unit, ["hip", "[deg]"]),
    "time backwards": (backwards, ["runs backwards"]),
    "a trial too short": (too_short, ["at least 12 samples"]),
    "a missing joint": (missing_joint, ["ankle [deg]", "ankel"]),
    "a joint that never moves": (never_moves, ["ankle", "never moves"]),
    "a link out of the folder": (link_outside, ["release_x.csv", "leads out of"]),
    "a 200 MB recording": (huge, ["200 MB"]),
    "an unknown key": (replace_in("leg-design.yaml", "scale:", "skale:"), ["skale", "scale"]),
    "a damper's shaft at no joint": (
        replace_in("leg-design.yaml", "cad: {", "cad: {damper_shafts: {hipp: 8 mm}, "),
        ["hipp", "cad.damper_shafts"],
    ),
    "a negative clearance": (replace_in("leg-design.yaml", "clearance: 0.4 mm", "clearance: -0.4 mm"), ["clearance"]),
    "a method that is none": (
        replace_in("leg-design.yaml", "target:", "fit: {method: genetic}\ntarget:"),
        ["genetic", "swarm"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gives_one_message_and_no_output(
    case: str, project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit, words = BAD[case]
    file = edited(project, tmp_path, edit)
    assert main(["--quiet", "leg", str(file), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert all(word in said for word in words), said
    assert "Traceback" not in said
    assert sorted(path.name for path in tmp_path.iterdir() if "out" in path.name and path.name != "outside.csv") == []


def test_constraints_that_exclude_every_part_are_reported(
    project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (project / "leg-design.yaml").read_text()
    assert "ankle:" in text
    edit = replace_in("leg-design.yaml", "ankle:", "ankle: {spring: {make: false, max_outer_diameter: 2 mm}} #")
    file = edited(project, tmp_path, edit)
    assert main(["--quiet", "leg", str(file), "--out", str(tmp_path / "out"), "--no-cad"]) == 1  # cannot be had
    said = capsys.readouterr().err
    assert "ankle: none of the" in said
    assert "make: true" in said


def test_dry_run_writes_nothing(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main(["--quiet", "leg", str(project / "leg-design.yaml"), "--out", str(out), "--dry-run"]) == 0
    assert not out.exists()


def test_a_driven_motion_is_not_scaled(project: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def drive(folder: Path) -> None:
        path = first_release(folder)
        lines = path.read_text().splitlines()
        path.write_text("\n".join([lines[0] + ",hip torque [N*m]", *(line + ",0.001" for line in lines[1:])]) + "\n")

    file = edited(project, tmp_path, drive)
    assert main(["--quiet", "leg", str(file), "--out", str(tmp_path / "out")]) == 2
    assert "torque columns" in capsys.readouterr().err


@pytest.fixture(scope="module")
def elbow(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project of any limb, not the thesis' alone: one joint, measured from straight, clockwise, with its own name."""
    import numpy as np

    from synth.files.leg_file import write_leg
    from synth.swing.chain import simulate
    from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

    folder = tmp_path_factory.mktemp("elbow")
    leg = Leg("arm", (Joint("elbow", Link(0.3, 0.5, 0.15, 4e-3), 0.0, -1, None, Spring(2.0, 0.3), Damper(0.05)),))
    write_leg(leg, folder / "arm.leg.yaml")
    generator, time = np.random.default_rng(1), np.arange(0, 2, 0.01)
    for index, start in enumerate((0.8, -0.6, 1.2)):
        motion = leg.to_measured(simulate(leg, leg.to_rotation(np.array([start])), np.zeros(1), time))[:, 0]
        noisy = np.degrees(motion) + generator.normal(0, 0.1, len(time))
        rows = "".join(f"{t:.3f},{a:.4f}\n" for t, a in zip(time, noisy, strict=True))
        (folder / f"release_{index}.csv").write_text("time [s],elbow [deg]\n" + rows)
    (folder / "leg-design.yaml").write_text(
        "kind: leg-design\nsource: {leg: arm.leg.yaml, trials: [release_*.csv]}\ntarget: arm.leg.yaml\n"
    )
    return folder


def test_a_single_link_through_the_straight_pose_is_designed(elbow: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert main(["--quiet", "leg", str(elbow / "leg-design.yaml"), "--out", str(out), "--no-pictures"]) == 0
    design = json.loads((out / "design.json").read_text())
    # With the drawn parts the link's centre is nearer to the joint than stated, and the spring does what gravity did.
    link = design["links"]["elbow"]
    assert link["built"]["com"]["value"] < 0.95 * link["assumed"]["com"]["value"]
    assert design["stages"]["target"]["joints"]["elbow"]["spring_rate"]["value"] == pytest.approx(2.0, rel=0.03)
    assert (out / "parts" / "elbow_lower.step").is_file()
    assert any("the upper arm cannot lie" in note for note in design["solids"]["notes"])


def test_a_failed_gate_writes_a_report_with_picture_and_no_parts(
    elbow: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A bed too small for some parts: another one leaves the stored design as it is."""
    small = "cad: {bed: [90 mm, 90 mm, 15 mm]}\n"
    path = edited(elbow, tmp_path, lambda folder: _append(folder / "leg-design.yaml", small))
    out = tmp_path / "out"
    (out / "parts").mkdir(parents=True)
    (out / "parts" / "earlier.step").write_text("of another design")
    (out / MANIFEST).write_text("parts/earlier.step\n")
    assert (
        main(["-q", "leg", str(path), "--out", str(out)]) == 1
    )  # nothing is wrong with the input: so it cannot be had
    said = capsys.readouterr().err
    assert "the joints are not exported" in said
    assert f"{out}: now holds this design, without parts; those of the earlier run are removed" in said
    assert "elbow_damper_bracket: print: bed" in said
    design = json.loads((out / "design.json").read_text())
    failed = [check for check in design["solids"]["checks"] if not check["passed"]]
    assert failed
    assert {check["name"] for check in failed} == {"print: bed"}
    assert not (out / "parts").exists()
    assert f"{len(failed)} of {len(design['solids']['checks'])} checks failed" in (out / "report.html").read_text()
    if not any("no pictures" in note for note in design["solids"]["notes"]):
        assert all((out / check["picture"]).stat().st_size > 1000 for check in failed)


def test_an_impossible_dimension_is_named(elbow: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    thick = "cad: {dampers: {elbow: {bolt_circle: 300 mm}}}\n"
    file = edited(elbow, tmp_path, lambda folder: _append(folder / "leg-design.yaml", thick))
    status = main(["--quiet", "leg", str(file), "--out", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert status == 2
    assert "cad.dampers.elbow.bolt_circle: 300 mm: allowed is " in said
    assert "--no-cad" in said
    assert not (tmp_path / "out").exists()


def _append(path: Path, text: str) -> None:
    path.write_text(path.read_text() + text)
