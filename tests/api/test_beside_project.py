"""Arguments of the library beside a project: they apply, or are refused; none is ignored."""

from __future__ import annotations

from pathlib import Path

import pytest

import synth
from synth.api.beside_project import not_overridden
from synth.api.gaps import read_gap
from synth.files.schema import Default

EXAMPLES = Path(synth.__file__).parent / "examples"
FIT, GAP = EXAMPLES / "fit", EXAMPLES / "gap"
LOOSE = synth.Tolerance(mass=0.3, inertia=0.3)


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project of one short trial with settings of its own."""
    folder = tmp_path_factory.mktemp("project")
    (folder / "robot.leg.yaml").write_text((FIT / "robot.leg.yaml").read_text())
    (folder / "one.csv").write_text((FIT / "trials" / "free_1.csv").read_text())
    text = "kind: fit\nleg: robot.leg.yaml\ntrials: [one.csv]\nfree_angle: common\nlaws: linear\nfit: {seed: 5}\n"
    (folder / "fit.yaml").write_text(f"{text}tolerance: {{mass: 2 %}}\n")
    return folder / "fit.yaml"


def test_only_given_settings_override_a_projects(project: Path) -> None:
    own = synth.fit(project).project
    assert (own.free_angle, own.laws, own.fit.seed, own.tolerance.mass) == ("common", "linear", 5, 0.02)
    bare = synth.fit(project, settings=synth.FitSettings()).project
    for name in ("free_angle", "laws", "release", "fit", "tolerance", "prior", "defaults"):
        assert getattr(bare, name) == getattr(own, name), name
    loose = synth.fit(project, settings=synth.FitSettings(tolerance=LOOSE))
    assert (loose.project.free_angle, loose.project.fit.seed) == ("common", 5)
    assert loose.result.as_json()["tolerance"]["knee"]["mass"]["value"] == pytest.approx(30.0)
    assert "tolerance" in {default.key.partition(".")[0] for default in own.defaults}
    assert "tolerance" not in {default.key.partition(".")[0] for default in loose.project.defaults}


def test_a_mapping_of_options_changes_what_it_names(project: Path) -> None:
    own = synth.fit(project).project
    one = synth.fit(project, settings=synth.FitSettings(options={"weight": "equal"})).project
    assert (one.fit.seed, one.fit.weight) == (5, "equal")
    listed = {default.key for default in one.defaults}
    assert listed == {default.key for default in own.defaults} - {"fit.weight"}
    assert "fit.weight" in {default.key for default in own.defaults}
    whole = synth.fit(project, settings=synth.FitSettings(options=synth.FitOptions(weight="equal"))).project
    assert whole.fit == synth.FitOptions(weight="equal")
    for options, said in (
        ({"wieght": "equal"}, '"wieght" is not allowed; did you mean weight'),
        ({"seed": -1}, "seed"),
    ):
        with pytest.raises(synth.UserError, match=said):
            synth.fit(project, settings=synth.FitSettings(options=options))


def test_tolerance_and_prior_beside_a_project_act_as_beside_a_leg(project: Path) -> None:
    leg = synth.read_leg(project.parent / "robot.leg.yaml")
    trials = synth.read_trials("one.csv", leg, folder=project.parent)
    wide = synth.FitSettings(free_angle="common", laws="linear", tolerance=LOOSE)
    by_leg, by_project = synth.fit(leg, trials, wide), synth.fit(project, settings=wide)
    plain = synth.fit(project)
    for name, joint in by_project.joints.items():
        rate, same, narrow = joint.spring_rate, by_leg.joints[name].spring_rate, plain.joints[name].spring_rate
        assert rate is not None
        assert same is not None
        assert narrow is not None
        assert (rate.low, rate.high) == pytest.approx((same.low, same.high), rel=1e-6)
        assert rate.high - rate.low > 1.2 * (narrow.high - narrow.low)
    springs = leg.with_joints(**{name: {"spring": synth.Spring(1.0, 2.0)} for name in leg.joint_names})
    synth.write_leg(springs, project.parent / "springs.leg.yaml")
    other = project.parent / "springs.yaml"
    other.write_text(project.read_text().replace("robot.leg", "springs.leg"))
    pulled = synth.fit(other, settings=synth.FitSettings(prior=synth.RatePrior(spring=0.001))).joints
    for joint in pulled.values():
        assert joint.spring_rate is not None
        assert joint.spring_rate.value == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (synth.FitSettings(tolerance=synth.Tolerance(joints={"kne": {"mass": 0.1}})), "no joint of .*mean knee"),
        (synth.FitSettings(tolerance=synth.Tolerance(joints={"knee": {"mas": 0.1}})), '"mas" has no .*mean mass'),
        (synth.FitSettings(prior=synth.RatePrior(damper=0.1)), r"prior\.damper: no joint of .* has a damper rate"),
    ],
)
def test_settings_of_what_the_leg_does_not_have_are_refused(
    project: Path, settings: synth.FitSettings, said: str
) -> None:
    leg = synth.read_leg(project.parent / "robot.leg.yaml")
    trials = synth.read_trials("one.csv", leg, folder=project.parent)
    with pytest.raises(synth.UserError, match=said):
        synth.fit(leg, trials, settings)
    with pytest.raises(synth.UserError, match=rf"fit\.yaml: .*{said.removeprefix('prior')}"):
        synth.fit(project, settings=settings)


def test_trials_beside_a_project_are_refused(project: Path) -> None:
    trials = synth.fit(project).project.trials
    with pytest.raises(synth.UserError, match=r"fit\.yaml: the project has its own trials, and 1 more .*fit\(leg"):
        synth.fit(project, trials)
    with pytest.raises(synth.UserError, match=r"gap\.yaml: the project has its own trials, and 1 more .*gap\(leg"):
        synth.gap(GAP / "gap.yaml", trials)


def test_tolerance_and_seed_beside_a_gap_project_apply(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the diagnosis is given; it stops there."""
    asked: list[tuple[object, int]] = []

    def diagnose(leg: object, trials: object, tolerance: object, *, seed: int, **_: object) -> object:
        asked.append((tolerance, seed))
        raise KeyboardInterrupt

    monkeypatch.setattr("synth.api.gaps.diagnose", diagnose)
    own = read_gap(GAP / "gap.yaml")
    for given in ({}, {"tolerance": LOOSE}, {"seed": 7}):
        with pytest.raises(KeyboardInterrupt):
            synth.gap(GAP / "gap.yaml", **given)  # type: ignore[arg-type]
    assert asked == [(own.tolerance, own.seed), (LOOSE, own.seed), (own.tolerance, 7)]
    with pytest.raises(synth.UserError, match='"hp" is no joint'):
        synth.gap(GAP / "gap.yaml", tolerance=synth.Tolerance(joints={"hp": {"mass": 0.1}}))


def test_a_leg_for_recordings_without_recordings_is_refused() -> None:
    leg = synth.read_leg(GAP / "nominal.leg.yaml")
    with pytest.raises(synth.UserError, match="no argument is a recording without a leg"):
        synth.compare(f"a={GAP / 'nominal.leg.yaml'}", f"b={GAP / 'nominal.leg.yaml'}", leg=leg)


def test_defaults_of_an_overridden_section_are_not_listed() -> None:
    listed = [Default("fit.seed", "0", ""), Default("tolerance.mass", "1 %", ""), Default("laws", "auto", "")]
    assert [item.key for item in not_overridden(listed, {"tolerance": 1, "laws": 2})] == ["fit.seed"]
