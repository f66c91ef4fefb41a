"""Every page in Chromium, wide and narrow, light and dark: nothing complains, overlaps, is cut, or asks the network."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest

from pages.browser import SCHEMES, SIZES, Opened, opened

HEAVIEST = 4_000_000  # bytes
PICTURES = os.environ.get("PAGES_PICTURES")  # where ``make pages`` keeps what it saw
SETTLE = 250  # ms, for a page's scripts


def fold_open(page: Any) -> None:
    page.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")


def keep(found: Opened, name: str, *, whole: bool = False) -> None:
    if PICTURES:
        Path(PICTURES).mkdir(parents=True, exist_ok=True)
        if whole:  # drawn by software, a canvas in a picture of 13 000 lines takes a minute; the first picture has it
            found.page.add_style_tag(content=".panel3d canvas { display: none !important; }")
        found.page.screenshot(path=f"{PICTURES}/{name}.png", full_page=whole)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("size", SIZES)
def test_every_page_is_whole_and_legible(browser: Any, pages: dict[str, Path], size: str, scheme: str) -> None:
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


def test_the_first_screen_answers(browser: Any, pages: dict[str, Path]) -> None:
    """Title, verdict and what to do next stand in the first window, wide and narrow."""
    for name, path in pages.items():
        for size, (_, height) in SIZES.items():
            with opened(browser, path, size) as found:
                for part in ("h1", ".verdict", ".next"):
                    place = found.page.locator(part).first
                    if place.count():
                        box = place.bounding_box()
                        assert box["y"] + box["height"] <= height, (name, size, part)


def test_a_link_opens_the_fold_that_it_leads_into(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["leg"]) as found:
        links = found.page.locator("nav a")
        name = links.last.get_attribute("href")
        assert not found.page.locator(f"details{name}").evaluate("(each) => each.open")
        links.last.click()
        found.page.wait_for_timeout(SETTLE)
        assert found.page.locator(f"details{name}").evaluate("(each) => each.open")


def test_a_page_prints_whole(browser: Any, pages: dict[str, Path]) -> None:
    """Chromium's own print: every section's heading and the last equation are in the file, on several pages."""
    with opened(browser, pages["leg"]) as found:
        data = found.page.pdf(format="A4")
        assert data.startswith(b"%PDF")
        count = len(re.findall(rb"/Type\s*/Page[^s]", data))
        closed = found.page.evaluate("[...document.querySelectorAll('main details')].filter((d) => !d.open).length")
        assert closed == 0  # beforeprint opened them
        assert count >= 4
