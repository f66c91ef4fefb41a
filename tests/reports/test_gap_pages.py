"""The gap's page and its files: opening, resources, every verdict, names with markup."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from diagnosis.made_result import FRICTION, made_result
from page_reader import check_words, drawings, page_of
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
from synth.diagnosis.plants.swinging_chain.chain_write import write_gap
from synth.estimation.intervals import Estimate
from synth.files.gap_project import GapProject, Tolerance
from synth.files.leg_file import read_leg
from synth.reports import quantities, write_gap_report
from synth.reports.figures import missing_torque
from synth.reports.figures.missing_torque import Cloud, bins_of, missing_torque_figure, quantile
from synth.reports.figures.named_laws import law_of
from synth.reports.reading import ResultTable
from synth.reports.sections.gap_next import entry_text
from synth.reports.sections.gap_where import error_over_time

Folder = Callable[[GapResult], Path]


@pytest.fixture
def written(tmp_path: Path) -> Folder:
    """A maker of result folders, each with its page."""

    def made(result: GapResult) -> Path:
        folder = tmp_path / "out"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        result = replace(result, inputs={"gap.yaml": "ab" * 32})
        project = GapProject(Path("gap.yaml"), "robot", result.leg, (), Tolerance(), 0, (), ())
        write_gap(result, project, folder)
        write_gap_report(folder)
        return folder

    return made


@pytest.fixture(scope="module")
def effect() -> GapResult:
    return made_result()


def check_all(html: str) -> None:
    for drawing in drawings(html):
        check_words(drawing)


def columns_of(path: Path) -> dict[str, list[float]]:
    with path.open() as stream:
        header, *rows = csv.reader(stream)
    return {name: [float(cell or "nan") for cell in cells] for name, *cells in zip(header, *rows, strict=True)}


def test_predictions_have_the_public_form_for_the_scored_trials_alone(written: Folder, effect: GapResult) -> None:
    folder = written(effect)
    assert sorted(path.name for path in (folder / "predicted").iterdir()) == ["check_6.csv", "check_7.csv"]
    columns = columns_of(folder / "predicted" / "check_7.csv")
    assert list(columns) == [
        "time [s]",
        *(f"{joint} {kind} [deg]" for joint in effect.leg.joint_names for kind in ("measured", "before", "after")),
    ]
    trial = effect.trials[-1]
    np.testing.assert_allclose(columns["knee before [deg]"], np.degrees(trial.before[:, 1]), rtol=1e-9)
    np.testing.assert_allclose(columns["knee measured [deg]"], np.degrees(trial.measured[:, 1]), rtol=1e-9)


def test_every_trial_says_where_torque_is_missing(written: Folder, effect: GapResult) -> None:
    folder = written(effect)
    assert len(list((folder / "where").iterdir())) == len(effect.trials)
    columns = columns_of(folder / "where" / "free_1.csv")
    torques, speeds = columns["knee missing torque [N*m]"], columns["knee speed [deg/s]"]
    against = [-torque * np.sign(speed) for torque, speed in zip(torques, speeds, strict=True) if abs(speed) > 20]
    assert len(against) > 10
    assert np.median(against) == pytest.approx(FRICTION, rel=0.1)


def test_gap_json_has_the_public_keys_and_units(written: Folder, effect: GapResult) -> None:
    gap = json.loads((written(effect) / "gap.json").read_text())
    assert gap["format"] == "synth/gap/1"
    assert gap["verdict"] == "effect"
    assert gap["explanation"][0] == gap["explanation"][0] | {"effect": "coulomb_friction", "joint": "knee"}
    assert gap["explanation"][0]["parameters"]["torque"]["unit"] == "N*m"
    assert set(gap["ranked"][0]) >= {"effect", "joint", "probability", "parameters", "shrink"}
    total = sum(entry["probability"] for entry in gap["ranked"])
    assert total + gap["probability_none"] + gap["probability_unknown"] == pytest.approx(1.0)
    assert set(gap["gap"]) >= {"as_designed", "before", "after", "noise_floor", "scored_on"}
    assert gap["gap"]["scored_on"] == ["trials/check_6.csv", "trials/check_7.csv"]
    assert gap["settings"]["tolerance.spring"] == {"value": 3.0, "unit": "percent", "how": "one standard deviation"}
    assert set(gap["versions"]) >= {"synth", "numpy", "numba"}
    for trial in gap["trials"]:
        assert (trial["predicted"] is not None) == trial["scored"]
    before, after = (gap["gap"]["joints"]["knee"][key]["value"] for key in ("before", "after"))
    errors = [np.degrees(trial.before - trial.measured)[:, 1] for trial in effect.trials if trial.scored]
    assert before == pytest.approx(float(np.sqrt(np.mean(np.concatenate(errors) ** 2))), rel=1e-9)
    assert after < before / 5


def test_the_diagnosed_leg_can_be_read_back(written: Folder, effect: GapResult) -> None:
    folder = written(effect)
    leg = read_leg(folder / "diagnosed.leg.yaml")
    assert (
        "<code>diagnosed.leg.yaml</code> is the nominal leg with this effect." in (folder / "report.html").read_text()
    )
    assert leg.joints[1].effects == {"coulomb_friction": {"torque": 0.048}}
    assert leg.joints[0].spring == effect.leg.joints[0].spring


def test_a_locked_joint_and_lost_samples_are_empty_cells_and_no_panel(written: Folder, effect: GapResult) -> None:
    trial = effect.trials[-1]
    measured = trial.measured.copy()
    measured[:, 0] = np.nan
    measured[3:6, 1] = np.nan
    changed = replace(trial, measured=measured)
    folder = written(replace(effect, trials=(*effect.trials[:-1], changed)))
    columns = columns_of(folder / "predicted" / "check_7.csv")
    assert all(math.isnan(value) for value in columns["hip measured [deg]"])
    gap = json.loads((folder / "gap.json").read_text())
    assert set(gap["trials"][-1]["rms"]) == {"knee", "ankle"}
    html, _ = page_of(folder / "report.html")
    found = re.findall("check_7.csv: measured.*?</svg>", html.split("<main>")[1])
    assert [drawing.count("angle [°]") for drawing in found] == [1, 1]


def test_a_servo_s_command_stands_beside_its_angle(written: Folder, effect: GapResult) -> None:
    """In the figure of each scored trial and in the first one, in the legend, and in the file; at no other joint."""
    told = [replace(trial, command={"knee": trial.measured[:, 1] + 0.1}) for trial in effect.trials]
    folder = written(replace(effect, trials=tuple(told)))
    columns = columns_of(folder / "predicted" / "check_7.csv")
    np.testing.assert_allclose(columns["knee command [deg]"], np.degrees(told[-1].command["knee"]), rtol=1e-9)
    assert "hip command [deg]" not in columns
    html, _ = page_of(folder / "report.html")
    drawings = re.findall("check_7.csv: measured.*?</svg>", html.split("<main>")[1])
    assert [drawing.count('data-curve="command"') for drawing in drawings] == [
        int(joint == "knee") for joint in effect.leg.joint_names
    ]
    assert html.count('<span data-curve="command">') == 2


def with_single_causes(effect: GapResult) -> GapResult:
    """Dry friction alone does what the explanation does, latency alone makes twice the error."""
    found = []
    for trial in effect.trials:
        alone = {"coulomb_friction @ knee": trial.after, "latency @ hip": 2 * trial.before - trial.measured}
        found.append(replace(trial, alone=alone if trial.scored else {}))
    return replace(effect, trials=tuple(found))


def test_the_evidence_of_a_cause_is_what_it_leaves_and_which_trials_speak_for_it(
    written: Folder, effect: GapResult
) -> None:
    html, _ = page_of(written(with_single_causes(effect)) / "report.html")
    section = html.split('id="evidence"')[1].split("</details>")[0]
    friction, latency = re.findall(r"<tr><th>(.*?)</tr>", section.split("<tbody>")[1])
    before, after = (
        np.degrees(np.sqrt(np.nanmean(np.concatenate([(getattr(t, kind) - t.measured)[:, 1] ** 2 for t in scored]))))
        for scored in [[t for t in effect.trials if t.scored]]
        for kind in ("before", "after")
    )
    cells = re.findall(r"<td[^>]*>(.*?)</td>", friction)
    assert [float(word) for word in cells[1].split(" → ")] == pytest.approx([before, after], rel=0.06)
    assert cells[3:5] == ["2 of 2", "0"]
    assert re.fullmatch(r"trials/check_[67].csv: −\d+\xa0%", unescape(cells[5]))
    assert re.findall(r"<td[^>]*>(.*?)</td>", latency)[3:6] == ["0 of 2", "2", "–"]
    assert re.findall(r"<td[^>]*>(.*?)</td>", latency)[6].endswith("+100\xa0%")


def test_the_page_opens_with_the_sentence_and_keeps_the_order(written: Folder, effect: GapResult) -> None:
    folder = written(with_single_causes(effect))
    html, page = page_of(folder / "report.html")
    opening = re.search(r"<h1>robot</h1>\n<p class=\"verdict good\">(.*?)</p>", html)
    assert opening
    assert unescape(opening.group(1)).replace("\u00a0%", " %") == effect.sentence
    assert page.ids == ["warnings", "which", "evidence", "how-far", "where", "next", "terms", "inputs"]
    assert "Left out" not in page.text
    assert "equations of the last section" not in page.text


def test_the_page_needs_nothing_outside_itself_and_its_words_fit(written: Folder, effect: GapResult) -> None:
    folder = written(effect)
    html, page = page_of(folder / "report.html")
    assert all(link.startswith("#") and link[1:] in page.ids for link in page.links)
    assert not page.sources
    assert not re.search(r"url\(|@import|https?://", re.sub(r"<script>.*?</script>", "", html, flags=re.S))
    found = drawings(html)
    joints = len(effect.leg.joints)
    drawn = joints + joints + joints * 4  # torque a joint, error over time, two trials with their errors
    # six shares, candidates, errors, menu, ten swatches and four of poses; on top the worst joint, its error, the leg
    assert len(found) == drawn + 6 + 1 + 1 + 1 + 14 + 3
    check_all(html)


def test_the_same_result_gives_the_same_bytes(written: Folder, effect: GapResult) -> None:
    folder = written(effect)
    first = (folder / "report.html").read_bytes()
    assert write_gap_report(folder).read_bytes() == first


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("effect", "the trials identify the cause"),
        ("none", "no effect is missing"),
        ("tie", "These trials cannot distinguish"),
        ("unknown", "is not sure enough to be named"),
    ],
)
def test_every_verdict_has_its_page(written: Folder, verdict: str, words: str) -> None:
    _, page = page_of(written(made_result(verdict)) / "report.html")
    assert words in page.text
    assert ("No explanation was accepted" in page.text) == (verdict in ("none", "unknown"))
    assert ("The most probable of the tied explanations" in page.text) == (verdict == "tie")
    assert ("nearest explanation, not accepted" in page.text) == (verdict == "unknown")
    assert "none: no effect is missing" in page.text
    assert "unknown: not in the library" in page.text


@pytest.mark.parametrize(
    ("takes", "words", "not_said"),
    [
        (0.74, "the nearest explanation, which takes 74 % of the gap, is not sure enough", "no effect in the library"),
        (0.04, "no effect in the library explains the trials", "not sure enough to be named"),
    ],
)
def test_an_unknown_cause_is_told_as_by_the_headline(written: Folder, takes: float, words: str, not_said: str) -> None:
    """Of a nearest cause that left 2.6 of 9.9 deg the lines below the headline said that nothing explains it."""
    result = replace(made_result("unknown"), sentence="", shrink=Estimate(takes, "1", takes - 0.1, takes + 0.1))
    _, page = page_of(written(result) / "report.html")
    told = page.text.replace("\u00a0", " ").lower()
    assert told.count(words) == 2  # below the headline and at the verdict
    assert not_said not in told
    _, page = page_of(written(replace(result, next_experiment=None)) / "report.html")
    assert ("would make the nearest explanation surer" in page.text) == (takes > 0.5)


def test_an_unknown_cause_of_which_no_explanation_helps_names_no_nearest_one(written: Folder) -> None:
    made = made_result("unknown")
    left = replace(made.remainder, share=1.0)
    result = replace(made, sentence="", explanation=(), after=made.before, shrink=Estimate(0.0, "1"), remainder=left)
    _, page = page_of(written(result) / "report.html")
    assert "none is probable enough to be shown" in page.text
    assert "the same: no explanation was accepted" in page.text
    assert "100 % of the gap" in page.text.replace("\u00a0", " ")
    assert "nearest" not in page.text.lower()


def test_the_opening_lists_every_cause_that_the_sentence_names(written: Folder) -> None:
    made = made_result("tie")
    last = made.ranked[-1].cause
    for tied, listed in ((made.tied, False), ((*made.tied[:1], (last,)), True)):
        html = (written(replace(made, tied=tied)) / "report.html").read_text()
        opening = html[html.index('class="verdict') : html.index("<main>")]
        assert ("load friction, ankle" in opening) == listed


def test_a_gap_within_the_accuracy_is_not_told_as_no_missing_effect(written: Folder) -> None:
    _, page = page_of(written(replace(made_result("none"), within_accuracy=True)) / "report.html")
    assert "the gap is below the required accuracy; causes were not judged" in page.text.lower()
    assert "no effect is missing" not in page.text
    assert "no missing effect" not in page.text
    assert "show no effect" not in page.text


def test_causes_that_were_not_accepted_are_not_in_the_diagnosed_leg(written: Folder, effect: GapResult) -> None:
    _, page = page_of(written(replace(effect, verdict="unknown")) / "report.html")
    assert "Nearest, not accepted" in page.text
    assert "is the nominal leg fitted within its tolerances, without this effect." in page.text
    assert "is the nominal leg with this effect." not in page.text
    _, page = page_of(written(effect) / "report.html")
    assert "is the nominal leg with this effect." in page.text


def test_an_explanation_that_predicts_worse_removes_nothing(written: Folder, effect: GapResult) -> None:
    _, page = page_of(written(replace(effect, shrink=Estimate(-0.08, "1", -0.2, 0.05))) / "report.html")
    assert re.search(r"With the explanation the gap above the noise rises by\s+8\s%", page.text)
    assert "removes −8" not in page.text
    assert "largest reduction" not in page.text


def test_the_page_says_how_the_trials_were_predicted(written: Folder, effect: GapResult) -> None:
    for how, words, note in (
        ("held_out", "left out of the diagnosis", "error on unseen trials"),
        ("fitted", ", the one that was fitted", "error on the trial that was fitted"),
        ("in_turn", ", each in turn predicted from the others", "error on each trial, predicted from the others"),
        ("pieces_in_turn", ", each piece in turn predicted", "error on each piece of the recording, predicted from"),
    ):
        trials = tuple(replace(trial, held_out=trial.scored and how == "held_out") for trial in effect.trials)
        _, page = page_of(written(replace(effect, scored_by=how, trials=trials)) / "report.html")
        assert words in page.text
        assert note in page.text


def test_a_cause_that_is_not_sure_is_favoured_and_not_identified(written: Folder, effect: GapResult) -> None:
    first = replace(effect.ranked[0], probability=0.55)
    _, page = page_of(written(replace(effect, ranked=(first,), probability_unknown=0.42)) / "report.html")
    assert "favour this cause; the probability that it is not in the library is 42 %" in page.text
    assert "the trials identify the cause" not in page.text


def test_nothing_ranked_and_nothing_to_record(written: Folder, effect: GapResult) -> None:
    bare = replace(
        effect, verdict="none", explanation=(), ranked=(), probability_none=1.0, probability_unknown=0.0,
        next_experiment=None, warnings=(), diagnosed=effect.leg, remainder=made_result("none").remainder,
    )  # fmt: skip
    html, page = page_of(written(bare) / "report.html")
    assert "no trial of the list would change the diagnosis" in page.text
    assert "warning" not in html.split("<nav")[0].split("<body>")[1]
    check_all(html)


def test_many_candidates_are_summed_beyond_the_first(written: Folder, effect: GapResult) -> None:
    ranked = [replace(effect.ranked[0], probability=0.05 - 0.002 * k) for k in range(18)]
    result = replace(effect, ranked=tuple(ranked), probability_unknown=0.396)  # in all 1
    html, page = page_of(written(result) / "report.html")
    assert "8 others together" in page.text
    assert f" {round(100 * sum(0.05 - 0.002 * k for k in range(10, 18)))} %" in page.text
    check_all(html)


def test_names_with_markup_stay_text(written: Folder) -> None:
    wicked = "<img src=x onerror=alert(1)>\"'&{{7*7}}"
    result = made_result(names=(wicked, "knee with a rather long name indeed", "a"))
    result = replace(result, sentence=wicked, warnings=(wicked,), trials=tuple(
        replace(trial, name=f"{wicked}{k}.csv") for k, trial in enumerate(result.trials)
    ))  # fmt: skip
    folder = written(result)
    html, page = page_of(folder / "report.html")
    assert not page.events
    assert "<img src=x" not in html
    assert all(wicked not in text for text in re.findall(r"<script.*?</script>", html, re.S))
    assert unescape(page.text).count(wicked) > 8
    check_all(html)


def test_a_damaged_table_of_the_gap_s_place_is_left_out_and_reported(written: Folder, effect: GapResult) -> None:
    folder = written(effect)
    content: dict[str, Any] = json.loads((folder / "gap.json").read_text())
    for key in ("where", "gap", "next_experiment", "ranked", "settings", "noise", "effects", "versions", "trials"):
        (folder / "gap.json").write_text(json.dumps({k: v for k, v in content.items() if k != key}))
        _, page = page_of(write_gap_report(folder))
        assert effect.sentence in page.text
    (folder / "gap.json").write_text(json.dumps({k: v for k, v in content.items() if k != "where"}))
    _, page = page_of(write_gap_report(folder))
    assert "does not say where the gap lies" in page.text


@settings(deadline=None)
@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=40), st.floats(0, 1))
def test_quantiles_are_numpy_s(values: list[float], share: float) -> None:
    assert quantile(sorted(values), share) == pytest.approx(float(np.quantile(values, share)), abs=1e-9)


def test_bins_show_a_step_of_dry_friction() -> None:
    points = [(x / 10, -0.05 * np.sign(x)) for x in range(-500, 501)]
    bins = bins_of(points)
    assert 15 <= len(bins) <= 21
    assert all(one.low <= one.median <= one.high for one in bins)
    assert {one.median for one in bins if one.place < -5} == {0.05}
    assert {one.median for one in bins if one.place > 5} == {-0.05}
    assert bins_of(points[:5]) == []
    assert bins_of([(1.0, 0.1)] * 50) == []


def test_few_fast_samples_among_many_at_rest_have_bins_of_their_own() -> None:
    rest = [(0.0, 0.04 * (-1) ** k) for k in range(200)]
    fast = [(20.0 + 8 * k, -0.05) for k in range(10)]
    *_, last = bins_of(rest + fast)
    assert last.place > 30.0
    assert last.median == -0.05


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.integers(0, 30), st.floats(1.0, 1e4))
def test_nothing_is_drawn_outside_the_axes(seed: int, outliers: int, far: float) -> None:
    """However far out a few samples lie: dots, medians and band stay within the frame."""
    generator = np.random.default_rng(seed)
    points = generator.normal(0.0, 1.0, (300, 2))
    points[:outliers] *= far
    cloud = Cloud("knee", "speed", [(float(x), float(y)) for x, y in points])
    svg = str(missing_torque_figure("knee", [cloud]))
    drawn = re.findall(r'<path d="([^"]+)"', svg)
    assert len(drawn) == 3  # dots, band, medians
    places = [[float(number) for number in pair] for d in drawn for pair in re.findall(r"(-?[\d.]+)[ ,](-?[\d.]+)", d)]
    places += [[float(x), float(y)] for x, y in re.findall(r'cx="(-?[\d.]+)" cy="(-?[\d.]+)"', svg)]
    x, y = np.array(places).T
    assert x.min() >= missing_torque.LEFT - 0.1
    assert x.max() <= missing_torque.WIDTH - missing_torque.RIGHT + 0.1
    assert y.min() >= missing_torque.TOP - 0.1
    assert y.max() <= missing_torque.HEIGHT - missing_torque.BOTTOM + 0.1


def test_single_causes_stand_beside_the_trial_switched_off(written: Folder, effect: GapResult) -> None:
    trials = [
        replace(t, alone={"coulomb_friction @ knee": t.after, "backlash @ hip": t.before}) if t.scored else t
        for t in effect.trials
    ]
    folder = written(replace(effect, trials=tuple(trials)))
    columns = columns_of(folder / "alone" / "check_7.csv")
    np.testing.assert_allclose(
        columns["knee with coulomb_friction @ knee [deg]"], np.degrees(effect.trials[-1].after[:, 1]), rtol=1e-9
    )
    assert sorted(path.name for path in (folder / "alone").iterdir()) == ["check_6.csv", "check_7.csv"]
    html, page = page_of(folder / "report.html")
    assert 'data-curve="backlash @ hip" style="display:none"' in html
    assert "coulomb friction, knee alone (" in page.text
    check_all(html)


@pytest.mark.parametrize(
    ("effect_name", "parameters", "column", "at", "torque"),
    [
        ("coulomb_friction", {"torque": 0.05, "presliding": 0.01}, "speed", -3.0, 0.05),
        ("stribeck_friction", {"torque": 0.1, "fall": 0.6, "speed": 1.0}, "speed", 1e-6, -0.1),  # breakaway
        ("stribeck_friction", {"torque": 0.1, "fall": 0.6, "speed": 1.0}, "speed", 50.0, -0.04),
        ("quadratic_damping", {"coefficient": 0.2, "exponent": 2.0, "speed": 1.0}, "speed", -3.0, 1.8),
        (
            "hardening_spring",
            {"stiffening": 0.4, "exponent": 3.0, "reach": 1.0, "onset": 0.0},
            "deflection",
            0.5,
            -0.05,
        ),
    ],
)
def test_a_named_law_is_its_effect_s_formula(
    effect_name: str, parameters: dict[str, float], column: str, at: float, torque: float
) -> None:
    law = law_of(effect_name, parameters, column)
    assert law is not None
    assert law(at) == pytest.approx(torque, rel=1e-9)


def test_an_effect_that_is_no_law_of_speed_has_no_curve() -> None:
    assert law_of("coulomb_friction", {"torque": 0.05}, "deflection") is None
    assert law_of("backlash", {"gap": 0.05}, "speed") is None
    assert law_of("stribeck_friction", {"torque": 0.1}, "speed") is None  # a number is missing


def test_the_named_law_lies_on_the_missing_torque(written: Folder, effect: GapResult) -> None:
    html, page = page_of(written(effect) / "report.html")
    assert "law of the named effect" in page.text
    knee = re.search(r"<title>knee: torque that the nominal leg lacks.*?</svg>", html)
    assert knee
    assert knee.group(0).count('stroke-dasharray="7 3"') == 1  # against speed; friction is no law of deflection


def test_error_over_time_is_a_root_mean_square_over_trials() -> None:
    times = [k / 100 for k in range(101)]
    tables = [ResultTable({"time": times, "e": [size] * 101}, {}) for size in (3.0, 4.0)]
    middles, values = error_over_time(tables, "e")
    assert values == pytest.approx([math.sqrt(12.5)] * len(values))
    assert middles[0] > 0.0
    assert error_over_time(tables, "none") == ([], [])
    assert error_over_time([], "e") == ([], [])


@pytest.mark.parametrize(
    ("trial", "text"),
    [
        ({"tip_mass": "50 g"}, "- {file: trials/next.csv, tip_mass: 50 g}"),
        ({"locked": ["hip", "knee"]}, "- {file: trials/next.csv, locked: [hip, knee]}"),
        ({"tilt": {"value": -20.0, "unit": "deg"}}, "- {file: trials/next.csv, tilt: -20 deg}"),
        ({"held_out": True, "file": "a.csv"}, "- {file: a.csv, held_out: true}"),
        ({}, "- {file: trials/next.csv}"),
    ],
)
def test_the_next_trial_is_an_entry_that_a_project_takes(trial: dict[str, Any], text: str) -> None:
    assert entry_text(trial) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.834, "83\u00a0%"), (0.0, "under 1\u00a0%"), (0.004, "under 1\u00a0%"), (0.997, "over 99\u00a0%"),
     (1.0, "100\u00a0%"), (-0.12, "−12\u00a0%"), (-0.001, "0\u00a0%"), (None, "–"), (math.nan, "–")],
)  # fmt: skip
def test_shares_as_per_cent(value: float | None, text: str) -> None:
    assert quantities.share_text(value) == text
    assert quantities.share_text({"value": value, "unit": "1"}) == text


@pytest.mark.parametrize(
    ("verdict", "words"),
    [
        ("tie", "No usual trial separates the tied explanations"),
        ("unknown", "No usual trial would make the nearest explanation surer"),
    ],
)
def test_without_a_trial_to_record_a_tie_is_not_told_as_settled(
    written: Folder, effect: GapResult, verdict: Any, words: str
) -> None:
    open_ended = replace(made_result(verdict), next_experiment=None)
    _, page = page_of(written(open_ended) / "report.html")
    assert page.text.count(words) == 2  # in the opening and in its section
    assert "would change the diagnosis" not in page.text
    assert "No further recording needed" not in page.text
    assert "names the trial that would" not in page.text
    assert "has what would" not in page.text  # nothing points to a trial
    assert ("; no usual trial would." in page.text) is (verdict == "tie")


@pytest.mark.parametrize(
    ("verdict", "changes", "words"),
    [
        ("none", {"probability_none": 0.77}, "None of the usual trials would show whether an effect is missing"),
        (
            "none",
            {"probability_none": 0.93, "remainder": 87.0},
            "No usual trial shows more of what remains unexplained",
        ),
        ("effect", {"ranked": 0.6}, "No usual trial would make this cause surer"),
        ("none", {"probability_none": 0.93}, "no trial of the list would change the diagnosis"),
        ("effect", {}, "no trial of the list would change the diagnosis"),
        ("none", {"probability_none": 1.0, "remainder": 87.0, "within_accuracy": True}, "no trial of the list would"),
    ],
)
def test_nothing_is_left_to_record_only_where_nothing_is_open(
    written: Folder, effect: GapResult, verdict: Any, changes: dict[str, Any], words: str
) -> None:
    """Of "the trials cannot show whether an effect is missing (77 %)" it was told that no recording is needed."""
    changes = {"next_experiment": None, **changes}
    if "remainder" in changes:
        changes["remainder"] = replace(effect.remainder, times_noise=changes["remainder"])
    if "ranked" in changes:
        changes["ranked"] = (replace(effect.ranked[0], probability=changes["ranked"]),)
    _, page = page_of(written(replace(made_result(verdict), **changes)) / "report.html")
    assert page.text.count(words) == 2  # in the opening and in its section
    assert ("No further recording needed" in page.text) is words.startswith("no trial of the list would")


@pytest.mark.parametrize("probability", [0.46, 0.91])
def test_no_missing_effect_is_told_and_green_only_where_it_is_probable(
    written: Folder, effect: GapResult, probability: float
) -> None:
    ranked = tuple(replace(entry, probability=0.05) for entry in effect.ranked)
    result = replace(
        made_result("none"),
        ranked=ranked,
        probability_none=probability,
        probability_unknown=0.0,
    )
    html, page = page_of(written(result) / "report.html")
    sure = probability > 0.8
    assert ('class="verdict good"' in html) is sure
    assert ("no effect is missing: the designed leg" in page.text.lower()) is sure
    told = "these trials cannot show whether an effect is missing; the probability that none is missing is 46 %"
    assert (told in page.text) is not sure
    assert ("the same: no effect was accepted" in page.text) is not sure  # in the table of errors


def test_an_error_far_above_the_noise_is_not_told_as_no_missing_effect(written: Folder, effect: GapResult) -> None:
    """A real double pendulum at 87 noise floors: "no effect is missing: the designed leg explains the trials"."""
    result = replace(made_result("none"), probability_none=0.93, remainder=effect.remainder)
    html, page = page_of(written(result) / "report.html")
    told = "othing in the library improves the prediction of the designed leg; 0.310°, 3.1 times the noise, remains"
    assert page.text.count(told) == 1  # beside the verdict; in the opening the sentence says it
    assert "none: the design as it is" in page.text
    assert "the same: no effect of the library improves it" in page.text
    for claim in ("no effect is missing", "explains the trials", "no missing effect", "that the design does not have"):
        assert claim not in page.text.lower()
    assert 'class="verdict good"' not in html


def test_probabilities_add_up_with_those_that_are_not_listed(written: Folder, effect: GapResult) -> None:
    """Eight of many candidates are listed: their bars, none and unknown summed to 89 %, "all 8 candidates"."""
    ranked = tuple(replace(effect.ranked[0], probability=p) for p in (0.1, 0.1, 0.09, 0.08, 0.05))
    result = replace(made_result("none"), ranked=ranked, probability_none=0.46, probability_unknown=0.0)
    html, page = page_of(written(result) / "report.html")
    opening, section = page.text.split("Which effect causes it", 1)[0], page.text.split("Which effect causes it", 1)[-1]
    assert "all others together 25 %" in opening.replace("\u00a0", " ")  # 1 - 0.46 - 0.29
    assert "all others together" in section
    assert "The 5 most probable candidates" in page.text
    assert "Less probable candidates are not listed; together they have 12 %" in page.text.replace("\u00a0", " ")
    check_all(html)
    html, page = page_of(written(replace(result, probability_none=0.58)) / "report.html")
    assert "are not listed" not in page.text
