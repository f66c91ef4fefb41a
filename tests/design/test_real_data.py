"""The lab's own recordings, end to end except solids, compared with the thesis.

Nothing of these data is in the product; where they are absent, these tests say so and skip.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from played_legs import play_errors
from synth.design.leg_design import LegDesign, design_leg
from synth.files.leg_file import read_leg
from synth.files.projects import read_leg_project
from synth.files.trial_list import read_trials
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.later_samples import recordings_from
from synth.fit.recordings import recordings
from synth.fit.still_start import from_release
from synth.model_checks.designed_leg import Predicted
from synth.parts.catalogs import Catalogue

DATA = Path(__file__).resolve().parents[3] / "shared" / "aarl"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the lab's recordings (../shared/aarl) are not here")
SEVEN = ("IP_5", "GS_1", "ST_1", "ST2_1", "VL_1", "BFp_1", "BFa_1")
REPEATS = ("GS_2", "ST_2", "ST2_2", "VL_2", "BFp_2", "BFa_2")

PROJECT = """
kind: leg-design
source:
  leg: rat/rat.leg.yaml
  trials: [{fitted}, {held_out}]
scale: {{time: 2}}
target: dog/dog.leg.yaml
select:
  joints:
    hip: {{spring: {{make: true}}, damper: {{direction: both, travel: 360 deg}}}}
    knee: {{spring: {{included_angle: 120 deg, max_outer_diameter: 1.25 in, max_body_length: 1.25 in}}}}
dampers:
  hip: {{part: 6597K21, leg: dog/dog_dampers.leg.yaml, trials: [dog/damper_drops/hip_*.csv], locked: [knee, ankle]}}
  knee: {{part: 6597K19, leg: dog/dog_dampers.leg.yaml, trials: [dog/damper_drops/knee_*.csv], locked: [hip, ankle]}}
  ankle: {{part: 6597K8, leg: dog/dog_dampers.leg.yaml, trials: [dog/damper_drops/ankle_*.csv], locked: [hip, knee]}}
"""


@pytest.fixture(scope="module")
def design(tmp_path_factory: pytest.TempPathFactory) -> LegDesign:
    folder = tmp_path_factory.mktemp("lab")
    for name in ("rat", "dog"):
        shutil.copytree(DATA / name, folder / name)
    fitted = ", ".join(f"rat/releases/{name}.csv" for name in SEVEN)
    held_out = ", ".join(f"{{file: rat/releases/{name}.csv, held_out: true}}" for name in REPEATS)
    (folder / "project.yaml").write_text(PROJECT.format(fitted=fitted, held_out=held_out))
    return design_leg(read_leg_project(folder / "project.yaml"), Catalogue.load())


def test_the_fit_is_no_worse_than_earlier_results(design: LegDesign) -> None:
    """A plain solver left 1.2/1.5/2.0 deg with one free angle for all, 0.48/0.74/0.78 with one a trial."""
    variants = {variant.free_angle: variant for variant in design.target.variants}
    common = np.degrees(list(variants["common"].rms.values()))
    own = np.degrees(list(variants["per_trial"].rms.values()))
    assert np.all(common < [1.3, 1.6, 2.1])
    assert np.all(own < [0.48, 0.74, 0.78])
    assert design.target.free_angle == "per_trial"


def test_the_fit_with_one_free_angle_agrees_with_the_thesis() -> None:
    """Thesis Table 3, one free angle for all: 23.7, 1.71 and 0.454 N m/rad lie within our intervals.

    From the first samples on, as the thesis had them; what muscles still drive there is left out otherwise.
    """
    published = json.loads((DATA / "published.json").read_text())["thesis_table_3_target"]["k"]
    rat, dog = (read_leg(DATA / name / f"{name}.leg.yaml") for name in ("rat", "dog"))
    trials = read_trials([f"rat/releases/{name}.csv" for name in SEVEN], DATA, rat)
    scaled = [recording.stretched(2.0) for recording in recordings(rat, trials)]
    common = fit_leg(dog, scaled, LegFitOptions(free_angle="common"))
    for joint, value in zip(common.joints.values(), published, strict=True):
        estimate = joint.spring_rate
        assert estimate.low is not None
        assert estimate.high is not None
        assert estimate.low < value < estimate.high


def test_the_overdamped_hip_is_reported_as_not_separable(design: LegDesign) -> None:
    """Once the muscles' share is cut, b/k is open too, so that the rates are named one by one."""
    openings = ("hip: not separable: spring rate and damper rate", "hip: these trials determine the spring rate only")
    assert any(text.startswith(openings) for text in design.target.not_separable)


def test_held_out_repeats_are_predicted_nearly_as_well(design: LegDesign) -> None:
    for j, name in enumerate(design.target.leg.joint_names):
        held = np.sqrt(np.mean([trial.rms[j] ** 2 for trial in design.held_out]))
        assert held < 2.0 * design.target.rms[name]


def test_the_dampers_are_concave_not_linear(design: LegDesign) -> None:
    """Exponents of 0.44 to 0.50 as reckoned from torques before; a linear law is several times worse."""
    for joint, exponent in (("hip", 0.452), ("knee", 0.440), ("ankle", 0.498)):
        fits = {fit.law.name: fit for fit in design.laws[joint].fits}
        assert fits["power"].parameters["exponent"]["value"] == pytest.approx(exponent, abs=0.03)
        assert fits["linear"].rms_held_out > 3 * fits["power"].rms_held_out
        assert design.laws[joint].used.rms_held_out <= fits["power"].rms_held_out * 1.02


def test_the_chosen_dampers_move_the_leg_as_wanted_within_three_degrees(design: LegDesign) -> None:
    assert [option.part for option in design.dampers.chosen][:2] == ["6597K21", "6597K19"]
    assert np.degrees(design.errors).max() < 3.0


@pytest.mark.slow  # like ``cli/test_leg``
def test_mujoco_follows_the_built_leg_with_as_much_play_as_may_be_drawn(design: LegDesign) -> None:
    """0.3 deg of play in every joint, behind the measured curves: within 0.3 deg (0.09 to 0.19 with all seven)."""
    mujoco = pytest.importorskip("mujoco")
    releases = [
        Predicted(r.name, r.time, m, r.rate) for r, m in zip(design.wanted.releases, design.built_motions, strict=True)
    ]
    off, effect = play_errors(mujoco, design.built, releases[::3])
    assert effect > 0.3
    assert off < 0.3


@pytest.mark.slow  # like ``validation/test_unseen_releases``
def test_the_other_releases_agree_with_the_seven(design: LegDesign) -> None:
    """One of the thirty windows (ST2_4) begins before the stimulus: with it the knee came out at half its stiffness."""
    leg = read_leg(DATA / "dog" / "dog.leg.yaml")
    rat = read_leg(DATA / "rat" / "rat.leg.yaml")
    trials = read_trials(["rat/releases/*.csv"], DATA, rat)
    assert len(trials) == 30
    begun = from_release(rat, recordings(rat, trials))
    assert len(begun.recordings) == 29
    assert "ST2_4" in begun.messages[0]
    free = recordings_from(begun.recordings, design.source.cut)
    assert free is not None
    result = fit_leg(leg, [recording.stretched(2.0) for recording in free], LegFitOptions())
    knee, before = result.joints["knee"], design.target.joints["knee"]
    # 15.4 % less; 12.5 % before the bounds of the search followed from the recordings.
    assert knee.spring_rate.value == pytest.approx(before.spring_rate.value, rel=0.18)
    assert knee.damper_rate is not None
    assert before.damper_rate is not None
    assert knee.damper_rate.value == pytest.approx(before.damper_rate.value, rel=0.2)
