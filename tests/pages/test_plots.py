"""Cursor, zoom, legend and downloads of the plots in Chromium, against the plotted files."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from pages.browser import opened


def numbers(text: str) -> dict[str, float]:
    """``0.123 s · measured 12.3° · fitted 12.1°`` by name; the time under ``time``."""
    time, *curves = text.split(" · ")
    found = {"time": float(time.split()[0])}
    for curve in curves:
        name, value = curve.rsplit(" ", 1)
        if value != "–":
            found[name] = float(re.sub(r"[^\d.−-]", "", value).replace("−", "-"))
    return found


def table_of(folder: Path, trial: str) -> dict[str, list[float]]:
    (path,) = folder.glob(f"*/**/{trial}.csv") if not (folder / "responses").exists() else [
        folder / "responses" / "source" / f"{trial}.csv"
    ]  # fmt: skip
    with path.open() as stream:
        head, *rows = csv.reader(stream)
    return {name: [float(row[i] or "nan") for row in rows] for i, name in enumerate(head)}


def first_plot(page: Any) -> Any:
    return page.locator("main details.section[open] .panels").first


@pytest.fixture
def fit_page(browser: Any, pages: dict[str, Path]) -> Any:
    with opened(browser, pages["fit"]) as found:
        yield found
        assert not found.said, found.said


def test_the_cursor_reads_the_files_values_in_all_plots(fit_page: Any, pages: dict[str, Path]) -> None:
    page = fit_page.page
    panels = first_plot(page)
    panels.scroll_into_view_if_needed()
    plots = panels.locator(".plot")
    box = plots.first.locator("svg").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    trial = panels.get_attribute("data-trial")
    table = table_of(pages["fit"].parent, trial)
    read = []
    for i in range(plots.count()):
        joint = page.evaluate("(s) => JSON.parse(s).joint", plots.nth(i).locator("script").text_content())
        found = numbers(plots.nth(i).locator(".values").text_content())
        row = min(range(len(table["time [s]"])), key=lambda k: abs(table["time [s]"][k] - found["time"]))
        for name in ("measured", "fitted"):
            if name in found:
                assert found[name] == pytest.approx(table[f"{joint} {name} [deg]"][row], abs=0.06)
        read.append(found["time"])
    assert len(set(read)) == 1
    assert len(read) >= 2


def test_keys_move_the_cursor_and_zoom(fit_page: Any) -> None:
    page = fit_page.page
    plot = first_plot(page).locator(".plot").first
    plot.focus()
    page.keyboard.press("Home")
    start = float(plot.get_attribute("aria-valuenow"))
    for _ in range(10):
        page.keyboard.press("Shift+ArrowRight")
    assert float(plot.get_attribute("aria-valuenow")) > start
    assert "s, " in plot.get_attribute("aria-valuetext")
    ticks = plot.locator(".x-ticks text")
    before = ticks.all_text_contents()
    page.keyboard.press("Home")
    page.keyboard.press("+")
    assert ticks.all_text_contents() != before
    page.keyboard.press("Escape")
    assert [float(t) for t in ticks.all_text_contents()] == [float(t) for t in before]


def test_a_drag_zooms_and_a_button_resets(fit_page: Any) -> None:
    page = fit_page.page
    panels = first_plot(page)
    panels.scroll_into_view_if_needed()
    svg = panels.locator(".plot svg").first
    box = svg.bounding_box()
    path = svg.locator("g[data-curve=fitted] path")
    whole = path.get_attribute("d")
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.4 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"], steps=4)
    page.mouse.up()
    xs = [float(x) for x, _ in re.findall(r"[ML]?(-?[\d.]+) (-?[\d.]+)", path.get_attribute("d"))]
    assert path.get_attribute("d") != whole
    assert max(xs) - min(xs) > 200  # what was a fifth of the drawing now fills it
    panels.locator("xpath=following-sibling::div[1]").get_by_text("Whole time").click()
    xs = [float(x) for x, _ in re.findall(r"[ML]?(-?[\d.]+) (-?[\d.]+)", path.get_attribute("d"))]
    assert max(xs) - min(xs) > 200


def test_the_legend_hides_and_shows_curves(fit_page: Any) -> None:
    page = fit_page.page
    section = page.locator("main details.section[open]").first
    switch = section.locator(".legend button").nth(1)
    curve = section.locator("g[data-curve=fitted]").first
    assert curve.is_visible()
    switch.click()
    assert switch.get_attribute("aria-pressed") == "false"
    assert not curve.is_visible()
    switch.click()
    assert curve.is_visible()


def test_a_figure_is_saved_as_csv_and_as_svg(fit_page: Any, pages: dict[str, Path], tmp_path: Path) -> None:
    page = fit_page.page
    panels = first_plot(page)
    trial = panels.get_attribute("data-trial")
    tools = panels.locator("xpath=following-sibling::div[1]")
    with page.expect_download() as waited:
        tools.get_by_text("CSV", exact=True).click()
    waited.value.save_as(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open() as stream:
        head, *rows = csv.reader(stream)
    table = table_of(pages["fit"].parent, trial)
    column = head.index("hip fitted [deg]")
    every = -(-len(table["time [s]"]) // 600)
    assert [float(row[column]) for row in rows] == pytest.approx(table["hip fitted [deg]"][::every], rel=1e-3)
    with page.expect_download() as waited:
        tools.get_by_text("SVG", exact=True).click()
    waited.value.save_as(tmp_path / "a.svg")
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert len(root.findall("{http://www.w3.org/2000/svg}svg")) == panels.locator(".plot").count()


def test_the_stick_figure_follows_the_cursor(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["gap"]) as found:
        page = found.page
        page.locator("header .plot").first.focus()
        pose = page.locator("header [data-stick] path.cursor")
        page.keyboard.press("Home")
        first = [float(x) for x in re.findall(r"-?[\d.]+", pose.get_attribute("d"))]
        page.keyboard.press("End")
        last = [float(x) for x in re.findall(r"-?[\d.]+", pose.get_attribute("d"))]
        assert first[:2] == last[:2]  # it hangs from the same place
        assert max(abs(a - b) for a, b in zip(first, last, strict=True)) > 5.0
        assert not found.said, found.said
