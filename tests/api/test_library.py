"""``import synth`` as a library: its functions and results, which are those of the commands."""

from __future__ import annotations

import ast
import json
import pickle
import runpy
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import FrozenInstanceError, replace
from importlib.util import find_spec
from math import radians
from pathlib import Path

import numpy as np
import pytest

import synth
from synth.api.report import Report, stage_by_stage
from synth.cli import main
from synth.units import parse

ROOT = Path(synth.__file__).parent
EXAMPLES = ROOT / "examples"
FIT, GAP = EXAMPLES / "fit", EXAMPLES / "gap"


@pytest.fixture(scope="module")
def fitted() -> synth.Fit:
    return synth.fit(FIT / "fit.yaml")


@pytest.fixture(scope="module")
def wound() -> synth.SpringAnswer:
    return synth.spring("1.7 Nm/rad", "40 deg")


def test_import_loads_nothing() -> None:
    code = "import sys, synth; print(sorted({'numpy','pydantic','numba','yaml','pint'} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there_typed_and_documented() -> None:
    assert set(synth.__all__) == {"__version__", *synth._PUBLIC}
    assert set(synth.__all__) <= set(dir(synth))
    for name in synth._PUBLIC:
        assert getattr(synth, name).__doc__, name
    with pytest.raises(AttributeError, match="nothing"):
        synth.nothing  # noqa: B018
    assert (ROOT / "py.typed").exists()


def test_functions_win_over_packages_of_the_same_name() -> None:
    code = "import synth, synth.fit.methods, synth.spring.design, synth.hopper.study, synth.design.bom\n"
    code += "assert all(callable(getattr(synth, n)) for n in ('fit', 'spring', 'hopper', 'design'))\n"
    code += "from synth.fit.methods import fit_by; from synth.fit import methods; assert methods.fit_by is fit_by"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


def test_a_leg_made_in_code_equals_the_file(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("speed [rad/s],torque [N*m]\n1,0.5\n4,1.0\n")
    (tmp_path / "a.leg.yaml").write_text("""kind: leg
name: two links
gravity: 9.81 m/s^2
tilt: 10 deg
joints:
  - name: hip
    zero: 90 deg
    sign: -1
    range: [60 deg, 150 deg]
    link: {length: 200 mm, mass: 740 g, com: 91 mm, inertia: 3.5e-3 kg*m^2}
    armature: 2e-5 kg*m^2
    spring: {rate: 15 in-lb/rad, free_angle: 105 deg}
    damper: {rate: 0.2 Nms/rad}
    effects: [{coulomb_friction: {torque: 50 mNm}}]
  - name: knee
    zero: 0 deg
    sign: +1
    link: {length: 1 1/2 in, mass: 0.5 kg, com: 80 mm, inertia: 20 kg-cm^2}
    damper: {curve: curve.csv}
""")
    read = synth.read_leg(tmp_path / "a.leg.yaml")
    friction = {"coulomb_friction": {"torque": 0.05}}
    made = synth.Leg(
        "two links",
        (
            synth.Joint(
                "hip",
                synth.Link(0.2, 0.74, 0.091, 3.5e-3),
                zero=radians(90),
                sign=-1,
                range=(radians(60), radians(150)),
                spring=synth.Spring(read.joints[0].spring.rate, radians(105)),  # type: ignore[union-attr]
                damper=synth.Damper(rate=0.2),
                effects=friction,
                armature=2e-5,
            ),
            synth.Joint(
                "knee",
                synth.Link(0.0381, 0.5, 0.08, 2e-3),
                damper=synth.Damper(curve=synth.DamperCurve((1.0, 4.0), (0.5, 1.0))),
            ),
        ),
        gravity=9.81,
        tilt=radians(10),
    )
    assert read.joints[0].spring is not None
    assert read.joints[0].spring.rate == pytest.approx(15 * 0.1129848290276, rel=1e-10)  # NIST SP 811
    synth.write_leg(made, tmp_path / "b.leg.yaml")
    for other in (read, synth.read_leg(tmp_path / "b.leg.yaml")):
        for a, b in zip(made.joints, other.joints, strict=True):
            same = {name: getattr(b, name) for name in ("zero", "armature", "range", "spring", "damper", "link")}
            assert replace(a, **same) == b  # names, signs, effects to the letter; numbers to rounding:
            numbers = [
                (x.zero, x.armature, *(x.range or ()), x.link.length, x.link.mass, x.link.com, x.link.inertia)
                for x in (a, b)
            ]
            assert numbers[0] == pytest.approx(numbers[1], rel=1e-14)
        assert (other.tilt, other.gravity, other.joint_names) == (made.tilt, made.gravity, made.joint_names)


def test_a_fit_of_a_leg_in_code_is_that_of_the_project(tmp_path: Path, fitted: synth.Fit) -> None:
    project = fitted.project
    again = synth.fit(synth.read_leg(FIT / "robot.leg.yaml"), project.trials)
    for name, joint in fitted.joints.items():
        assert again.joints[name] == joint
    with pytest.raises(FrozenInstanceError):
        again.project = project  # type: ignore[misc]


def test_what_is_saved_is_what_the_command_writes(tmp_path: Path, fitted: synth.Fit) -> None:
    assert main(["fit", str(FIT / "fit.yaml"), "--out", str(tmp_path / "command"), "-q"]) == 0
    assert fitted.save(tmp_path / "saved") == tmp_path / "saved"
    files = {p.relative_to(tmp_path / "saved"): p.read_bytes() for p in (tmp_path / "saved").rglob("*") if p.is_file()}
    assert Path("fit.json") in files
    for name, content in files.items():
        assert (tmp_path / "command" / name).read_bytes() == content


def test_results_are_tables_with_units(fitted: synth.Fit, wound: synth.SpringAnswer) -> None:
    frame = fitted.to_frame().set_index("joint")
    content = fitted.result.as_json()
    for name, joint in content["joints"].items():
        assert frame.loc[name, "spring rate [N*m/rad]"] == pytest.approx(joint["spring_rate"]["value"])
        assert frame.loc[name, "free angle [deg]"] == pytest.approx(joint["free_angle"]["value"])
        found = fitted.joints[name].free_angle
        assert parse(f"{found.value!r} {found.unit}", joint["free_angle"]["unit"]) == pytest.approx(
            joint["free_angle"]["value"]
        )
        low, high = joint["spring_rate"]["interval90"]
        assert frame.loc[name, "spring rate low [N*m/rad]"] == pytest.approx(low)
        assert frame.loc[name, "spring rate high [N*m/rad]"] == pytest.approx(high)
    springs = wound.to_frame()
    assert springs["rate [N*m/rad]"].to_numpy() == pytest.approx(1.7)
    assert bool(springs["feasible"].all())


def test_a_copy_of_a_result_has_its_table(fitted: synth.Fit) -> None:
    copied = pickle.loads(pickle.dumps(fitted))
    assert copied.to_frame().equals(fitted.to_frame())
    assert copied.joints == fitted.joints


def test_results_show_themselves_in_a_notebook(fitted: synth.Fit, wound: synth.SpringAnswer) -> None:
    for result in (fitted, wound):
        page = result._repr_html_()
        assert page.count("<table>") == page.count("<svg") == 1
        assert "<script" not in page
        assert all(head in page for head in result.columns())


@pytest.mark.skipif(find_spec("matplotlib") is None, reason="matplotlib is not installed")
def test_results_are_drawn(fitted: synth.Fit, wound: synth.SpringAnswer, tmp_path: Path) -> None:
    figure = fitted.plot()
    lines = {line.get_label(): line for line in figure.axes[0].get_lines()}
    trial = fitted.result.trials[0]
    name = fitted.leg.joint_names[0]
    np.testing.assert_allclose(lines[f"{name} fitted"].get_ydata(), np.degrees(trial.fitted[:, 0]))
    wound.plot().savefig(tmp_path / "spring.png")
    with pytest.raises(synth.UserError, match="no panel 99"):
        fitted.plot(99)


def test_missing_packages_are_reported(fitted: synth.Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(synth.UserError, match=r"pip install limb-synth\[notebook\]"):
        fitted.to_frame()
    with pytest.raises(synth.UserError, match=r"pip install limb-synth\[notebook\]"):
        fitted.plot()


def test_an_infeasible_spring_is_a_valid_result() -> None:
    from synth.spring.spring_task import SpringLimits

    answer = synth.spring("79 N*m/rad", "45 deg", wish={"limits": SpringLimits(max_outer_diameter=0.03)})
    assert answer.best is None
    assert answer.in_the_way
    assert answer.headline.startswith("No single spring")
    assert isinstance(answer, Report)


def test_a_leg_without_springs_and_dampers_has_no_gap() -> None:
    leg = synth.Leg("bare", (synth.Joint("hip", synth.Link(0.2, 0.5, 0.1, 1e-3)),))
    with pytest.raises(synth.UserError, match="has a spring or a damper"):
        synth.gap(leg, ())


def test_compared_recordings_are_a_table(tmp_path: Path) -> None:
    leg = synth.read_leg(GAP / "nominal.leg.yaml")
    found = synth.compare(str(GAP / "nominal.leg.yaml"), f"built={GAP / 'trials' / 'free_1.csv'}", leg=leg)
    assert {"built"} <= {side.name for side in found.result.sides}
    assert len(found.to_frame()) >= 2
    assert (found.save(tmp_path / "out") / "compare.json").exists()


ENGINEERING = ("batch", "design", "diagnosis", "fit", "hopper", "spring", "swing", "jump", "estimation")
# What the five commands may take beside the library: texts for the screen, and caches between runs.
ALLOWED = {
    "synth.hopper.checkpoint", "synth.batch.cluster", "synth.batch.one_fit", "synth.spring.spring_files",
    "synth.spring.spring_result", "synth.spring.spring_task", "synth.spring.design", "synth.spring.spring_requirements",
    "synth.spring.calibration",
    "synth.spring.wound_samples", "synth.spring.winding", "synth.spring.requirement_ranges",
    "synth.swing.effects.users_own",
}  # fmt: skip


@pytest.mark.parametrize("name", ["fit", "gap", "gap_jumps", "leg", "hopper", "spring", "compare"])
def test_the_command_line_calls_the_library(name: str) -> None:
    tree = ast.parse((ROOT / "commands" / f"{name}.py").read_text(encoding="utf-8"))
    modules = {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert any(module.startswith("synth.api.") for module in modules)
    deeper = {m for m in modules if m.startswith("synth.") and m.split(".")[1] in ENGINEERING}
    assert deeper <= ALLOWED


SCRIPTS = sorted((ROOT.parent / "docs" / "examples").glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_the_scripts_of_the_documentation_run(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(script))
    shown = capsys.readouterr().out
    said = {
        "fit_a_leg": "N*m/rad, 90 % between",
        "why_it_moves_otherwise": next(iter(json.loads((GAP / "truth.json").read_text()))),
        "wind_a_spring": "No single spring",
    }
    assert said[script.stem] in shown


@pytest.mark.parametrize("first", ["", "import synth.fit.methods; "])
def test_modules_of_packages_that_share_a_functions_name_are_imported(first):
    """In a fresh process: what is imported first must not decide what ``synth.fit`` is."""
    program = first + (
        "import synth, synth.fit.methods as methods, synth.spring.spring_search as search, "
        "synth.design.forecast as forecast, synth.hopper.sweep as sweep; from synth.fit import methods as same; "
        "assert methods is same and methods.fit_by and search.candidates and forecast.Forecast and sweep.__name__; "
        "assert synth.fit.__qualname__ == 'fit' and callable(synth.fit) and callable(synth.hopper)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_recordings_are_named_by_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``sorted(folder.glob("*.csv"))`` was refused: "PosixPath(...) is not a trial"."""
    fit = Path(synth.__file__).parent / "examples" / "fit"
    leg = synth.read_leg(fit / "robot.leg.yaml")
    for name in ("b [1].csv", "a.csv", "deep/c.csv"):
        (tmp_path / "t" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "t" / name).write_text((fit / "trials" / "free_1.csv").read_text())
    monkeypatch.chdir(tmp_path)
    for folder in (tmp_path / "t", Path("t")):
        assert [trial.name for trial in synth.read_trials(sorted(folder.glob("*.csv")), leg)] == ["a.csv", "b [1].csv"]
        assert [trial.name for trial in synth.read_trials(sorted(folder.rglob("*.csv")), leg)][-1] == "deep/c.csv"
    for path in (Path("a.csv"), tmp_path / "t" / "a.csv"):
        assert synth.read_trials([path], leg, folder="t")[0].name == "a.csv"
    assert synth.read_trials([Path("t/a.csv"), "t/deep/*.csv"], leg)[1].name == "t/deep/c.csv"
    with pytest.raises(synth.UserError, match=r"gone\.csv"):
        synth.read_trials([Path("t/gone.csv")], leg)


def test_recordings_are_named_by_whole_paths_as_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In code no file names them: a list of texts such as ``glob.glob`` gives was refused as "an absolute path"."""
    fit = Path(synth.__file__).parent / "examples" / "fit"
    leg = synth.read_leg(fit / "robot.leg.yaml")
    for name in ("here/x.csv", "t/b [1].csv", "t/a.csv", "t/deep/c.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text((fit / "trials" / "free_1.csv").read_text())
    monkeypatch.chdir(tmp_path / "here")
    t = str(tmp_path / "t")

    def names(files: object, folder: str | None = None) -> list[str]:
        return [trial.name for trial in synth.read_trials(files, leg, folder=folder)]  # type: ignore[arg-type]

    assert names([f"{t}/a.csv"]) == ["a.csv"]
    assert names([f"{t}/a.csv", f"{t}/b [1].csv"]) == ["a.csv", "b [1].csv"]
    assert names([f"{t}/*.csv", f"{t}/*/c.csv"]) == ["a.csv", "b [1].csv", "deep/c.csv"]
    assert names(f"{t}/*/c.csv") == ["deep/c.csv"]
    assert names(f"{t}/a.csv", folder=t) == ["a.csv"]
    assert names([f"{t}/a.csv"], folder=t) == ["a.csv"]
    assert names([f"{t}/a.csv", "x.csv"]) == ["t/a.csv", "here/x.csv"]
    assert names(["*.csv", {"file": f"{t}/a.csv", "tip_mass": "50 g"}]) == ["here/x.csv", "t/a.csv"]
    assert names([{"file": "x.csv", "tip_mass": "50 g"}, Path(t, "a.csv")]) == ["here/x.csv", "t/a.csv"]
    with pytest.raises(synth.UserError, match=r'"gone\.csv" does not exist'):
        names([f"{t}/gone.csv"])
    with pytest.raises(synth.UserError, match=r"5 is not a trial"):
        names([5, f"{t}/a.csv"])


def test_each_stage_ends_where_the_next_begins_and_an_error_ends_the_last() -> None:
    told: list[str] = []

    @contextmanager
    def stage(text: str) -> Iterator[None]:
        told.append(f"{text} ...")
        try:
            yield
        except ValueError:
            told.append(f"{text} stopped")
            raise
        told.append(f"{text} done")

    def broken() -> None:
        with stage_by_stage(stage) as begin:
            begin("one")
            begin("two")
            raise ValueError("broken")

    with pytest.raises(ValueError, match="broken"):
        broken()
    assert told == ["one ...", "one done", "two ...", "two stopped"]
