"""The moving leg of a page: its integrator against the engine, and every control in a real browser."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from pages.browser import Opened, opened
from pages.live_leg import CURVED, LEG, RELEASES, RUBBING, engine_angles, responses, swapped, write_leg_folder

NEAR = 0.1  # deg, the page against the engine
MOVE = """(legs) => {
  const page = JSON.parse(document.getElementById("leg-data").textContent);
  return legs.map((acting) => page.replay.releases.map((release) => {
    const motion = synthLeg.motion(release, acting);
    return motion && motion.map((one, j) => Array.from(one, (q) => synthLeg.measured(page.leg.joints[j], q)));
  }));
}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, made: ModuleType) -> Path:
    return write_leg_folder(tmp_path_factory.mktemp("live") / "leg", made).parent


@pytest.fixture
def live(browser: Any, folder: Path) -> Iterator[Opened]:
    with opened(browser, folder / "report.html") as found:
        found.page.locator(".panel3d canvas").wait_for()
        found.page.locator("#swap-parts[data-error]").wait_for(state="attached")
        found.page.evaluate("document.getElementById('swap-parts').closest('details').open = true")
        yield found
        assert not found.said, found.said


def as_acting(leg: Any) -> list[dict[str, Any]]:
    from synth.design.page_data import damper_json, effects_json

    return [
        {
            "rate": each.spring.rate,
            "rotation": each.rest,
            "damper": damper_json(each.damper),
            "effects": effects_json(leg, j),
        }
        for j, each in enumerate(leg.joints)
    ]


def number_after(text: str, before: str) -> float:
    """The number that follows these words."""
    found = re.search(re.escape(before) + r"\s*([−-]?[\d.]+)", text)
    assert found, (before, text)
    return float(found.group(1).replace("−", "-"))


def test_the_pages_integrator_agrees_with_the_engine(live: Opened) -> None:
    """Linear and curved dampers, friction that slides and sticks, a locked joint, a mass at the tip, a tilted base."""
    wanted, built = responses()
    other, _ = swapped(wanted, built)
    legs = [LEG, CURVED, other, RUBBING]
    moved = live.page.evaluate(MOVE, [as_acting(leg) for leg in legs])
    for leg, motions in zip(legs, moved, strict=True):
        for release, ours, theirs in zip(RELEASES, motions, engine_angles(wanted, leg), strict=True):
            apart = np.abs(np.array(ours).T - theirs)
            assert apart.max() < NEAR, (release.name, apart.max())
            assert np.ptp(theirs) > 5.0  # there was something to follow


def test_a_swapped_spring_shows_the_engines_error_and_a_project_line(live: Opened) -> None:
    page = live.page
    wanted, built = responses()
    before = float(np.degrees(wanted.overall([built])[0]))
    _, after = swapped(wanted, built)
    home = page.locator("#swap-parts")
    assert float(home.get_attribute("data-error")) == pytest.approx(before, abs=NEAR)
    curve = page.locator("details#swap .plot").nth(1).locator("g[data-curve=tried] path")
    drawn = curve.get_attribute("d")
    home.locator("fieldset").nth(1).locator("select").first.select_option("1")
    assert float(home.get_attribute("data-error")) == pytest.approx(after, abs=NEAR)
    assert abs(after - before) > 2 * NEAR  # it makes a difference that is seen
    assert curve.get_attribute("d") != drawn
    assert "knee: {spring: {part: B 12}}" in home.locator("pre").text_content()
    home.get_by_text("As chosen").click()
    assert float(home.get_attribute("data-error")) == pytest.approx(before, abs=NEAR)


def test_a_damper_that_no_line_names_is_said(live: Opened) -> None:
    """Without a word the lines were those of the chosen one."""
    home = live.page.locator("#swap-parts")
    home.locator("fieldset").nth(1).locator("select").nth(1).select_option("1")
    said = home.locator("pre").text_content()
    assert said == "# knee: no line names the damper E at 0.2 N*m: ordered by torque"


def test_a_slider_changes_the_response_and_shows_the_interval(live: Opened) -> None:
    page, home = live.page, live.page.locator("#swap-parts")
    box = home.locator("fieldset").nth(1)
    assert box.locator(".band").count() == 2
    assert "90 %" in box.locator(".band").first.get_attribute("aria-label")
    before = home.get_attribute("data-error")
    box.locator("input[type=range]").nth(1).fill("0.5")
    page.wait_for_function("(b) => document.getElementById('swap-parts').dataset.error !== b", arg=before)
    assert "damper torque times 2" in home.locator("pre").text_content()


def test_the_sliders_mark_the_fit_with_the_chosen_damper_s_law(browser: Any, tmp_path: Path, made: ModuleType) -> None:
    """Where the spring was fitted anew with the chosen damper's law, a mark of the linear fit would lead astray."""
    from synth.reports import write_leg_report

    page = write_leg_folder(tmp_path / "leg", made)
    path = page.parent / "design.json"
    design = json.loads(path.read_text())
    anew = {"value": 16.3, "unit": "N*m/rad", "interval90": [15.0, 17.7]}
    design["joints"]["knee"]["refit"] = {"spring_rate": anew}
    design["joints"]["ankle"].pop("refit", None)
    path.write_text(json.dumps(design))
    write_leg_report(page.parent)
    with opened(browser, page) as found:
        home = found.page.locator("#swap-parts[data-error]")
        home.wait_for(state="attached")
        knee, ankle = (home.locator("fieldset").nth(j).locator(".band").first for j in (1, 2))
        assert knee.get_attribute("aria-label") == "fit with the chosen damper's law: 16.3 N·m/rad, 90 % 15 to 17.7"
        assert ankle.get_attribute("aria-label").startswith("fit with a linear damper: ")


def test_a_turned_joint_shows_spring_damper_and_stop(live: Opened) -> None:
    page = live.page
    row = page.locator(".joint3d").nth(1)
    row.locator("input").fill("60")
    text = row.locator(".readout").text_content()
    spring, joint = CURVED.joints[1].spring, CURVED.joints[1]
    assert spring is not None
    torque = -spring.rate * joint.sign * (joint.sign * (np.radians(60.0) - joint.zero) - joint.rest)
    assert number_after(text, "spring") == pytest.approx(torque, abs=2e-3)
    assert number_after(text, "N·m,") == pytest.approx(abs(torque) * 500.0, rel=0.01)
    assert "20.0° to the stop" in text
    row.locator("input").fill("40")
    assert "touches the stop" in row.locator(".readout").text_content()
    assert "touches" in row.locator(".readout").get_attribute("class")


def test_the_cursor_follows_a_played_response(live: Opened) -> None:
    page = live.page
    play = page.locator(".panel3d button").first
    play.click()
    moving = "(s) => document.querySelector(s).getAttribute('aria-valuenow') > 0.05"
    page.wait_for_function(moving, arg="details#built .panels[data-trial=free_1] .plot")
    if play.text_content() != "▶ Play":  # not over yet
        play.click()
    angle = number_after(page.locator(".joint3d .slide span").first.text_content(), "hip")
    motion = engine_angles(*responses())[0][:, 0]
    assert motion.min() - 0.5 <= angle <= motion.max() + 0.5


def test_the_cursor_poses_the_leg(live: Opened) -> None:
    page = live.page
    plot = page.locator("details#built .panels[data-trial=free_2] .plot").first
    plot.focus()
    page.keyboard.press("End")
    motion = engine_angles(*responses())[1]
    for j, name in enumerate(CURVED.joint_names):
        angle = number_after(page.locator(".joint3d .slide span").nth(j).text_content(), name)
        assert angle == pytest.approx(motion[-1, j], abs=0.1)


def test_parts_are_described_and_can_be_hidden(live: Opened) -> None:
    page = live.page
    page.locator(".parts3d summary").click()
    page.get_by_role("button", name="knee lower").click()
    told = page.locator(".picked").text_content().replace("\xa0", " ")
    assert "knee lower" in told
    assert "12.5 g" in told
    assert "parts/knee_lower.step" in told
    canvas = page.locator(".panel3d canvas")
    before = canvas.screenshot()
    page.get_by_label("show hip lower").uncheck()
    page.wait_for_timeout(200)
    assert canvas.screenshot() != before


def test_the_slider_turns_the_solids(live: Opened) -> None:
    canvas = live.page.locator(".panel3d canvas")
    before = canvas.screenshot()
    live.page.locator(".joint3d input").first.fill("70")
    live.page.wait_for_timeout(200)
    assert canvas.screenshot() != before


def test_the_page_shows_the_designs_error(browser: Any, pages: dict[str, Path]) -> None:
    """Of a real design (``make pages``): the page's own error of the chosen parts is the program's."""
    folder = pages["leg"].parent
    if not (folder / "page.json").exists():
        pytest.skip("this leg folder was made without page.json")
    design = json.loads((folder / "design.json").read_text())
    with opened(browser, pages["leg"]) as found:
        home = found.page.locator("#swap-parts[data-chosen]")
        home.wait_for(state="attached")
        rms = design["response"]["wanted_to_built"]["rms"]["value"]
        assert float(home.get_attribute("data-chosen")) == pytest.approx(rms, abs=NEAR)
        for j, (name, joint) in enumerate(design["joints"].items()):
            row = found.page.locator("table.key tbody tr").nth(j)
            assert row.locator("th").text_content().strip() == name
            made = joint["spring"].get("make") or joint["spring"]
            shown = number_after(row.locator("td").first.locator(".interval").text_content(), "")
            assert shown == pytest.approx(made["rate"]["value"], rel=1e-3)
