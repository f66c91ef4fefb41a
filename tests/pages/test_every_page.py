"""Every page in Chromium, wide and narrow, light and dark: no error, overlap, clipping or network access."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest

from pages.browser import SCHEMES, SIZES, Opened, opened

HEAVIEST = 4_000_000  # bytes
PICTURES = os.environ.get("PAGES_PICTURES")  # where ``make pages`` keeps what it saw
PIECE, HIGHEST = 7_800, 31_200  # px: Chromium repeats what lies beyond its largest texture of 8192; kept of a page
PAPER = 718  # px between the margins of A4 that Chromium prints with
HIDDEN = "[...document.querySelectorAll('main h2')].filter((h) => !h.checkVisibility()).map((h) => h.textContent)"
CUT = """[...document.querySelectorAll(".scroll, figure, pre, table")].filter((e) => e.checkVisibility() && (
  e.getBoundingClientRect().right > innerWidth + 2
  || (e.scrollWidth > e.clientWidth + 2 && getComputedStyle(e).overflowX !== "visible")
)).map((e) => [e.tagName, e.className, e.textContent.trim().slice(0, 60), e.scrollWidth, e.clientWidth])"""
PATIENCE = 180_000  # ms: such a picture takes half a minute on a busy machine
PLAIN_UNITS = """[...document.querySelectorAll("p, li, td, th, figcaption, caption, dd")]
  .filter((e) => e.checkVisibility() && !e.closest("#inputs, #inputs-read"))
  .flatMap((e) => [...e.childNodes].filter((n) => n.nodeType === 3).map((n) => n.data))
  .filter((words) => /[A-Za-z]\\*[A-Za-z]|\\d deg\\b|\\d degC\\b/.test(words))"""
SETTLE = 250  # ms, for a page's scripts


def fold_open(page: Any) -> None:
    page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")


def keep(found: Opened, name: str, *, whole: bool = False) -> None:
    if PICTURES:
        Path(PICTURES).mkdir(parents=True, exist_ok=True)
        if not whole:
            found.page.screenshot(path=f"{PICTURES}/{name}.png")
            return
        # Drawn by software, a canvas in a picture of 8 000 lines takes a minute; the first picture has it.
        found.page.add_style_tag(content=".panel3d canvas { display: none !important; }")
        width, height = found.page.evaluate("[innerWidth, document.documentElement.scrollHeight]")
        for top in range(0, min(height, HIGHEST), PIECE):
            piece = {"x": 0, "y": top, "width": width, "height": min(PIECE, height - top)}
            path = f"{PICTURES}/{name}-{top // PIECE + 1}.png"
            found.page.screenshot(path=path, full_page=True, clip=piece, timeout=PATIENCE)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("size", SIZES)
def test_every_page_is_complete_and_legible(browser: Any, pages: dict[str, Path], size: str, scheme: str) -> None:
    assert pages
    for name, path in pages.items():
        assert path.stat().st_size <= HEAVIEST, name
        with opened(browser, path, size, scheme) as found:
            found.page.wait_for_timeout(SETTLE)
            keep(found, f"{name}-{size}-{scheme}")
            for _ in range(2):  # as it opens, then with every fold open
                audit = found.audit()
                faults = {key: audit[key] for key in ("overlaps", "pale", "nameless", "cut") if audit[key]}
                assert not faults, (name, size, scheme, faults)
                assert audit["too_wide"] <= 0, (name, size, scheme)
                fold_open(found.page)
            keep(found, f"{name}-{size}-{scheme}-all", whole=True)
            assert not found.said, (name, found.said)
            assert not [url for url in found.asked if not url.startswith(("file:", "data:"))], name


def test_the_first_screen_has_title_verdict_and_next_step(browser: Any, pages: dict[str, Path]) -> None:
    """Title, verdict and what to do next stand in the first window, wide and narrow."""
    for name, path in pages.items():
        for size, (_, height) in SIZES.items():
            with opened(browser, path, size) as found:
                for part in ("h1", ".verdict", ".next"):
                    box = found.page.locator(part).first.bounding_box()
                    assert box["y"] + box["height"] <= height, (name, size, part)


def test_units_are_set_alike_in_numbers_and_sentences(browser: Any, pages: dict[str, Path]) -> None:
    """No ``N*m`` or ``5 deg`` outside code and the project's own settings."""
    for name, path in pages.items():
        with opened(browser, path) as found:
            fold_open(found.page)
            assert found.page.evaluate(PLAIN_UNITS) == [], name


def test_the_leg_that_follows_the_cursor_is_beside_its_plots(browser: Any, pages: dict[str, Path]) -> None:
    for name in ("fit", "gap"):
        with opened(browser, pages[name]) as found:
            drawn = found.page.locator("header [data-stick] svg")
            if not drawn.count():
                pytest.skip(f"the {name} was made without its leg; make pages has one")
            plot = found.page.locator("header .plot").first.bounding_box()
            leg = drawn.bounding_box()
            assert leg["x"] > plot["x"] + plot["width"], name
            assert leg["y"] + leg["height"] < SIZES["wide"][1], name


def test_a_link_opens_its_section(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["leg"]) as found:
        links = found.page.locator("nav a")
        name = links.last.get_attribute("href")
        assert not found.page.locator(f"details{name}").evaluate("(each) => each.open")
        links.last.click()
        found.page.wait_for_timeout(SETTLE)
        assert found.page.locator(f"details{name}").evaluate("(each) => each.open")


def test_nothing_is_cut_on_paper(browser: Any, pages: dict[str, Path]) -> None:
    """With print's rules, at paper's width, folds open: every section is there and no table, figure or line is cut."""
    for name, path in pages.items():
        with opened(browser, path) as found:
            fold_open(found.page)
            found.page.set_viewport_size({"width": PAPER, "height": 1000})
            found.page.emulate_media(media="print")
            assert found.page.evaluate(HIDDEN) == [], name
            assert found.page.evaluate(CUT) == [], name


def test_the_keyboard_reaches_every_control(browser: Any, pages: dict[str, Path]) -> None:
    """Tab reaches each control of the first window that stands open, seen by an outline; arrows and Enter move it."""
    for name, path in pages.items():
        with opened(browser, path) as found:
            page = found.page
            page.wait_for_timeout(SETTLE)
            wanted = page.evaluate(
                """[...document.querySelectorAll('button, input, select, a[href], summary')]
                .filter((e) => e.checkVisibility() && e.getBoundingClientRect().bottom < innerHeight)
                .map((e, i) => { e.dataset.wanted = i; return i; }).length"""
            )
            reached, outlined = set(), 0
            for _ in range(wanted + 20):
                page.keyboard.press("Tab")
                at, outline = page.evaluate(
                    "[document.activeElement.dataset.wanted, getComputedStyle(document.activeElement).outlineStyle]"
                )
                if at is not None and at not in reached:
                    reached.add(at)
                    outlined += outline != "none"
            assert len(reached) == outlined == wanted, name
            fold = page.locator("details.section > summary").first
            if fold.count():
                before = fold.evaluate("(s) => s.parentElement.open")
                fold.focus()
                page.keyboard.press("Enter")
                assert fold.evaluate("(s) => s.parentElement.open") is not before, name


def test_a_page_prints_completely(browser: Any, pages: dict[str, Path]) -> None:
    """Chromium's own print: every section's heading and the last equation are in the file, on several pages."""
    with opened(browser, pages["leg"]) as found:
        data = found.page.pdf(format="A4")
        assert data.startswith(b"%PDF")
        count = len(re.findall(rb"/Type\s*/Page[^s]", data))
        closed = found.page.evaluate("[...document.querySelectorAll('main details')].filter((d) => !d.open).length")
        assert closed == 0  # beforeprint opened them
        assert count >= 4
