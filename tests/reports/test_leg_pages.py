"""The leg's page: steps in order, what is measured already, costs beside their errors; poses beside plots."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from page_reader import page_of
from synth.commands.leg import _page_warnings
from synth.commands.leg_parts import _substitute_lines
from synth.reports import write_fit_report, write_leg_report
from synth.reports.figures import palette
from synth.reports.many_pages import write_legs_report

Json = dict[str, Any]
LegFolder = Callable[..., tuple[Path, Json]]
FitFolder = Callable[[list[str], int], tuple[Path, Json]]


def _opening(folder: Path, design: Json) -> str:
    (folder / "design.json").write_text(json.dumps(design))
    html, _ = page_of(write_leg_report(folder))
    return html.split("<nav")[0].split("<body>")[1].replace("\xa0", " ")


def _buildable(design: Json) -> Json:
    design["joints"]["hip"]["spring"] = design["joints"]["ankle"]["spring"]
    for key, chance in (("forecast", 0.06), ("forecast_free_angles_measured", 1.0)):
        design["response"][key]["chance"]["value"] = chance
    return design


def test_the_steps_of_a_leg_are_in_an_order_that_can_be_done(leg_folder: LegFolder) -> None:
    """Dampers' hubs before printing, free angles in the assembled joints, seats and dampers last."""
    folder, design = leg_folder()
    design = _buildable(design)
    text = _opening(folder, design)
    assert "The leg can be built" in text
    order = ["Order the parts", "the dampers off", "In each assembled joint (hip, knee and ankle)", "from 6 % to 100 %"]
    places = [text.index(words) for words in (*order, "set the seats and put the dampers on")]
    assert places == sorted(places)
    assert "it is not the loose spring" in text
    for joint in ("hip", "knee"):
        design["joints"][joint]["damper"] |= {"slips": True, "assumed_sizes": ["their number (cad.dampers.hip.bolts)"]}
    text = _opening(folder, design)
    assert "Not ready to build: as drawn, the dampers of hip and knee would slip on the shafts" in text
    assert text.index("Get the dampers first and measure what turns them") < text.index("Order the other parts")


def test_a_stated_range_that_leaves_the_wanted_motion_out_is_the_verdict(leg_folder: LegFolder) -> None:
    """A leg that cannot take its wanted poses was said to be ready, with the response of one that can."""
    folder, design = leg_folder()
    design = _buildable(design)
    deg = [[{"value": value, "unit": "deg"} for value in ends] for ends in ((105, 160), (103.5, 161.5), (83.3, 150.6))]
    known = dict(zip(("stated", "stops", "wanted"), deg, strict=True))
    design["joints"]["knee"]["range"] = {**known, "rest": {"value": 121.1, "unit": "deg"}, "outside": []}
    assert "The leg can be built" in _opening(folder, design)
    design["joints"]["knee"]["range"]["outside"] = ["wanted motion"]
    text = _opening(folder, design)
    assert "Not ready to build: the ranges that the target states leave out the wanted motion of the knee" in text
    design["joints"]["hip"]["damper"]["slips"] = True
    text = _opening(folder, design)
    assert "the damper of hip would slip on the shaft; the ranges that the target states leave out" in text
    step = "Widen the range of knee (stated 105.0 to 160.0°, wanted 83.3 to 150.6°, rest 121.1°)"
    assert text.index(step) < text.index("Order the other parts")


def test_a_free_angle_beyond_a_stop_is_not_to_be_read_at_rest(leg_folder: LegFolder) -> None:
    """The joint would rest on its stop: its reading, entered, turned the seat of a right spring."""
    folder, design = leg_folder()
    design = _buildable(design)
    for name, joint in design["joints"].items():
        free = joint["spring"]["free_angle"]["value"]
        low = free + 7.7 if name == "knee" else free - 20.0
        joint["stops"] = [{"value": angle, "unit": "deg"} for angle in (low, free + 40.0)]
    text = _opening(folder, design)
    assert "In each assembled joint (hip and ankle)" in text
    assert "The free angle of knee lies beyond a stop" in text
    assert "measured: {spring: {knee: {free_angle: … deg, free_angle_by: torque}}}" in text


def test_measured_free_angles_are_not_asked_for_again(leg_folder: LegFolder) -> None:
    folder, design = leg_folder()
    design = _buildable(design)
    design["response"]["free_angles_measured"] = ["hip"]
    design["joints"]["hip"]["seat"] = {"setting": {"turn": {"value": -1.4, "unit": "deg"}}}
    text = _opening(folder, design)
    assert "With the free angle measured at hip, and other parts within their tolerances, 6 %" in text
    assert text.index("Turn the seats on their scales: hip −1.4°.") < text.index("joint (knee and ankle)")
    design["response"]["free_angles_measured"] = ["hip", "knee", "ankle"]
    design["response"]["forecast"] = design["response"]["forecast_free_angles_measured"]
    text = _opening(folder, design)
    assert "100 % of such legs" in text
    assert "hip −1.4°, tighten them, and put the dampers on." in text
    assert "In each assembled joint" not in text
    setting = design["joints"]["hip"]["seat"]["setting"]
    page = " ".join(page_of(write_leg_report(folder))[1].text.split())
    assert "Measure the springs first." not in page
    assert "The chosen set is with the measured free angle of hip, knee and ankle" in page
    setting["left"] = {"value": -13.4, "unit": "deg"}
    text = _opening(folder, design)
    assert "travel at hip by 13.4°. Check that it is the angle of the assembled joint" in text
    assert "put the dampers on" not in text


def test_a_leg_that_is_not_drawn_is_not_to_be_ordered(leg_folder: LegFolder, tmp_path: Path) -> None:
    folder, design = leg_folder()
    design = _buildable(design)
    design["solids"]["drawn"] = False
    text = _opening(folder, design)
    assert "not final" in text
    assert "Run without <code>--no-cad</code> before you order" in text
    assert "Order the" not in text.replace("before you order", "")
    assert "In each assembled joint" not in text
    leg = {"name": "a", "report": "legs/a/report.html", "joints": {}, "rms": {"value": 1.0, "unit": "deg"},
           "joint_rms": {}, "failed_checks": [], "warnings": [], "drawn": False}  # fmt: skip
    content = {"format": "synth/legs/1", "versions": {}, "legs": [leg], "failed": []}
    (tmp_path / "legs.json").write_text(json.dumps(content))
    text = " ".join(page_of(write_legs_report(tmp_path))[1].text.split())
    assert "Run a without --no-cad before you order" in text
    assert "every drawn joint passes its checks" not in text


def test_the_cost_of_a_set_is_the_difference_of_a_column_that_the_table_has(leg_folder: LegFolder) -> None:
    """Sets are ranked with measured free angles; their cost stood beside another expected error."""
    folder, design = leg_folder()
    other = design["response"]["alternatives"][0]
    other["free_angles_measured"] = {"expected": {"value": 1.8, "unit": "deg", "interval90": [1.5, 2.0]}}
    other["chance"]["value"] = 0.001
    (folder / "design.json").write_text(json.dumps(design))
    html, _ = page_of(write_leg_report(folder))
    table = html[html.index("Expected, angles measured</th>") :].split("</table>")[0].replace("\xa0", " ")
    rows = [re.findall(r'<td class="num">([^<]*)', row) for row in table.split("<tr")[1:]]
    assert [row[-2:] for row in rows] == [["1.30°", "–"], ["1.80°", "+0.50°"]]
    assert "under 1 %" in table


def test_only_a_bought_spring_is_compared_with_the_fitted_rate(leg_folder: LegFolder) -> None:
    """A spring to wind has the rate of the least expected error, which the fitted one has not."""
    folder, design = leg_folder()
    text = _opening(folder, _buildable(design))
    assert "20.6 N·m/rad, +5.1 %" in text
    assert text.count("%</span>") == 1


def test_the_leg_beside_plots_has_no_colour_of_their_curves(fit_folder: FitFolder) -> None:
    """Blue and orange are fitted, before and after in the legend beside it; the figure's are poses of one motion."""
    folder, _ = fit_folder(["knee"], 2)
    leg = {"tilt": {"value": 0.0}, "joints": [{"name": "knee", "zero": 0.0, "sign": 1, "length": 100.0}]}
    (folder / "page.json").write_text(json.dumps({"leg": leg}))
    html, _ = page_of(write_fit_report(folder))
    beside = html[html.index('class="stick-small"') :]
    beside = beside[: beside.index("not two models.")]
    for colour in (palette.BLUE, palette.VERMILION, palette.GREEN):
        assert colour not in beside
    assert "first pose" in beside


def test_a_chance_that_rests_on_assumed_laws_says_so(leg_folder: LegFolder) -> None:
    """The chance, from 6 % to 100 %, stood beside the warning that the dampers may be off by a factor of two."""
    folder, design = leg_folder()
    design = _buildable(design)
    assert "assumed damper law" not in _opening(folder, design)
    laws = {"joints": ["hip", "ankle"], "factor": {"value": 2.0, "unit": "1"}}
    laws |= {key: {"value": value, "unit": "deg"} for key, value in (("least", 1.9), ("most", 3.21))}
    for key in ("forecast", "forecast_free_angles_measured"):
        design["response"][key]["assumed_laws"] = laws
    text = re.sub(r"\s+", " ", _opening(folder, design))
    assert "from 6 % to 100 % if the assumed damper laws hold." in text
    assert (
        "This holds if the assumed damper laws of hip and ankle are right; off by a factor of 2 at low speed, nominal "
        "parts give 1.90° to 3.21°, more than allowed."
    ) in text
    _, page = page_of(folder / "report.html")
    assert page.text.count("off by a factor of 2 at low speed") >= 2  # also beside the figure of the forecast


def test_screen_and_page_count_the_same_warnings(leg_folder: LegFolder) -> None:
    """The screen said 5 and 26 more, the page 35: it has the fits' warnings too."""
    folder, _ = leg_folder()
    _, page = page_of(write_leg_report(folder))
    counted = re.search(r"All (\d+) warnings", page.text)
    assert counted
    assert len(set(_page_warnings(folder))) == int(counted[1])


def test_substitutes_stand_in_the_order_of_the_cost_that_is_shown(leg_folder: LegFolder) -> None:
    folder, design = leg_folder()
    first = design["joints"]["hip"]["spring_alternatives"][0]
    costs = (0.79, 0.77, 1.15)
    design["joints"]["hip"]["spring_alternatives"] = [
        {**first, "part": f"part {k}", "cost": {"value": cost, "unit": "deg"}} for k, cost in enumerate(costs)
    ]
    (folder / "design.json").write_text(json.dumps(design))
    _, page = page_of(write_leg_report(folder))
    places = [page.text.index(f"part {k}") for k in (1, 0, 2)]
    assert places == sorted(places)
    lines = [row[2] for row in _substitute_lines(design["joints"]["hip"]["spring_alternatives"])]
    assert lines[:2] == ["part 1", "part 0"]
