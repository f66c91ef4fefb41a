"""The jumping leg's page in Chromium: the played jump against its file, and the description of every design."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from pages.browser import Opened, opened

UPPER, LOWER, SPACING = 0.1, 0.1, 0.02  # m
MOTORS = (("N20 A 100:1", 100.0), ("N20 A 50:1", 50.0), ("N20 B 75:1", 75.0))
LENGTHS = (0.08, 0.1, 0.12)


def quantity(value: float, unit: str) -> dict[str, Any]:
    return {"value": value, "unit": unit}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, made: ModuleType) -> Path:
    """A study of nine designs, and a jump whose foot stays under the hips until 50 ms and then rises."""
    from synth.reports.hopper_pages import write_hopper_report

    target = tmp_path_factory.mktemp("jump") / "hopper"
    target.mkdir()
    times = [k * 1e-3 for k in range(101)]
    angle = [60.0 - 50.0 * min(1.0, time / 0.05) for time in times]
    foot = [max(0.0, time - 0.05) * 0.8 for time in times]
    hip = [2 * UPPER * math.cos(math.radians(a)) + f for a, f in zip(angle, foot, strict=True)]
    columns = {"time [s]": times, "hip height [m]": hip, "foot height [m]": foot}
    columns |= {f"{name} angle [deg]": angle for name in ("upper link", "upper link end", "lower link")}
    for name, unit in (
        ("ground force", "N"),
        ("gear torque", "N*m"),
        ("current", "A"),
        ("centre of mass speed", "m/s"),
    ):
        columns[f"{name} [{unit}]"] = [1.0 + time for time in times]
    made.write_columns(target / "jump.csv", columns)
    heads = "motor,gear_ratio,leg_length [m],model,clearance [m],clearance_low [m],clearance_high [m],relative_height,"
    heads += "feasible,limit,total_height [m],energy [J],peak_gear_torque [N*m],peak_current [A],takeoff_speed [m/s]"
    rows = [
        f"{motor},{ratio},{length},full,{length / 4},{length / 5},{length / 3},0.25,{'no' if length > 0.11 else 'yes'},"
        f"{'too weak' if length > 0.11 else ''},0.1,1.0,0.2,3.0,1.0"
        for motor, ratio in MOTORS
        for length in LENGTHS
    ]
    (target / "designs.csv").write_text("\n".join([heads, *rows]) + "\n")
    leg = {"hip_spacing": quantity(SPACING * 1e3, "mm"), "upper_link": quantity(UPPER * 1e3, "mm"),
           "lower_link": quantity(LOWER * 1e3, "mm")}  # fmt: skip
    best = {"motor": MOTORS[0][0], "gear_ratio": 100.0, "leg_length": quantity(0.1, "m"), "leg": leg,
            "clearance": {"value": 0.025, "unit": "m", "interval90": [0.02, 0.033]},
            "relative_height": quantity(0.25, "1"), "takeoff_time": quantity(0.05, "s")}  # fmt: skip
    grid = [[length / 4 for length in LENGTHS] for _ in MOTORS[:2]]
    content = {
        "format": "synth/hopper/1", "name": "made leg", "best": best, "warnings": [],
        "counts": {"designs": 9, "jump": 9}, "settings": {"model": "full", "choose": "clearance", "objectives": []},
        "map": {"family": "A", "gear_ratio": [50.0, 100.0], "leg_length_m": list(LENGTHS), "clearance_m": grid},
        "pareto": [{"motor": MOTORS[0][0], "gear_ratio": 100.0, "leg_length": quantity(0.1, "m")}],
    }  # fmt: skip
    (target / "hopper.json").write_text(json.dumps(content))
    return write_hopper_report(target).parent


@pytest.fixture
def page(browser: Any, folder: Path) -> Iterator[Any]:
    with opened(browser, folder / "report.html") as found:
        found.page.locator(".player svg").wait_for()
        yield found.page
        assert not found.said, found.said
        assert_no_faults(found)


def assert_no_faults(found: Opened) -> None:
    audit = found.audit()
    assert not [audit[key] for key in ("overlaps", "pale", "nameless") if audit[key]]


def ends(path: str) -> tuple[float, float]:
    """The last point of a path."""
    x, y = re.findall(r"(-?[\d.]+) (-?[\d.]+)", path)[-1]
    return float(x), float(y)


def test_the_played_foot_follows_the_file(page: Any, folder: Path) -> None:
    with (folder / "jump.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    slider = page.locator(".player input[type=range]")
    heights = []
    for k in (0, 50, 100):
        slider.fill(rows[k]["time [s]"])
        left, right = (page.locator(".player path").nth(i).get_attribute("d") for i in (1, 3))
        assert ends(left)[1] == pytest.approx(ends(right)[1], abs=1e-6)
        heights.append(ends(left)[1])
    ground = float(page.locator(".player line").first.get_attribute("y1"))
    assert heights[0] == pytest.approx(ground, abs=0.5)  # the foot stands
    top = float(rows[100]["foot height [m]"])
    scale = (heights[1] - heights[2]) / (top - float(rows[50]["foot height [m]"]))
    body = float(page.locator(".player rect").get_attribute("y")) + 5
    assert (ground - body) / scale == pytest.approx(float(rows[100]["hip height [m]"]), rel=0.01)
    assert "in flight" in page.locator(".player output").text_content()


def test_the_slider_moves_the_plots_cursor_and_back(page: Any) -> None:
    page.evaluate("document.querySelector('#hopper-jump').open = true")
    page.locator(".player input[type=range]").fill("0.04")
    plot = page.locator("#hopper-jump .plot").first
    assert float(plot.get_attribute("aria-valuenow")) == pytest.approx(0.04, abs=1e-3)
    plot.focus()
    page.keyboard.press("End")
    assert page.locator(".player output").text_content().startswith("100 ms")


def test_pointer_and_keys_describe_every_design(page: Any) -> None:
    summary, chart = page.locator(".designs .summary"), page.locator(".designs svg")
    assert "N20 A 100:1, 100 mm links" in summary.text_content()
    assert "the chosen design" in summary.text_content()
    chart.focus()
    page.keyboard.press("ArrowRight")
    assert "120 mm links: clearance 3.0 cm (90 %: 2.4 to 4.0)" in summary.text_content()
    assert "too weak" in summary.text_content()
    page.keyboard.press("ArrowDown")
    assert "N20 A 50:1" in summary.text_content()
    chart.locator("rect").first.hover()
    assert "80 mm links" in summary.text_content()


def test_the_motor_can_be_selected(page: Any) -> None:
    motor = page.locator(".designs select").first
    assert motor.locator("option").all_text_contents() == ["N20 A", "N20 B"]
    motor.select_option("N20 B")
    assert page.locator(".designs svg text", has_text="75:1").count() == 1
    page.locator(".designs svg rect").first.hover()
    assert "N20 B 75:1" in page.locator(".designs .summary").text_content()


def test_a_study_of_total_heights_opens_on_them_without_a_chosen_design_too(
    browser: Any, folder: Path, tmp_path: Path
) -> None:
    from synth.reports.hopper_pages import write_hopper_report

    shutil.copytree(folder, tmp_path / "out")
    content = json.loads((folder / "hopper.json").read_text())
    content["settings"] |= {"choose": "total_height", "height": "total"}
    content |= {"best": {}, "pareto": [], "none_because": "all exceed the gearbox's limit"}
    content["map"]["total_height_m"] = content["map"]["clearance_m"]
    (tmp_path / "out" / "hopper.json").write_text(json.dumps(content))
    write_hopper_report(tmp_path / "out")
    with opened(browser, tmp_path / "out" / "report.html") as found:
        selected = found.page.evaluate(
            "[...document.querySelectorAll('.designs select')].map((s) => s.selectedOptions[0].textContent)"
        )
        assert selected == ["N20 A", "total height"]
        told = found.page.inner_text(".designs .summary")
    assert "total height 10.0 cm, clearance 2.0 cm" in told
    assert "total height over link length 0.250" in told
