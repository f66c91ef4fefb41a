"""Chromium without a screen, and the audit of every page that it opens.

Debian: ``apt-get install chromium``; ``pip install playwright`` (the extra ``pages``) drives it. Where either is
missing the tests skip and say so.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome")
# Background services would ask the network; without a graphics card WebGL is drawn by SwiftShader.
FLAGS = [
    "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--disable-quic", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]  # fmt: skip
SIZES = {"wide": (1400, 900), "narrow": (400, 800)}
SCHEMES = ("light", "dark")
AUDIT = (Path(__file__).parent / "audit.js").read_text(encoding="utf-8")


def missing() -> str:
    """What is not here, as a sentence; empty where a browser can be driven."""
    try:
        import playwright  # noqa: F401
    except ImportError:
        return "playwright is not installed (pip install playwright)"
    return "" if executable() else "no Chromium is installed (Debian: apt-get install chromium)"


def executable() -> str | None:
    """The browser's path."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser with a new profile, closed at the end."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


@dataclass
class Opened:
    """An open page, its console errors, and its network requests."""

    page: Any
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def audit(self) -> dict[str, Any]:
        """Words that overlap, words too pale, controls without a name, and by how much the page is too wide."""
        found: dict[str, Any] = self.page.evaluate(AUDIT)
        return found


@contextmanager
def opened(browser: Any, path: Path, size: str = "wide", scheme: str = "light") -> Iterator[Opened]:
    """The file as a user opens it; complaints of the console and requests are collected."""
    width, height = SIZES[size]
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
    context.set_default_timeout(30_000)
    found = Opened(context.new_page())
    found.page.on("console", lambda m: found.said.append(m.text) if m.type in ("error", "warning") else None)
    found.page.on("pageerror", lambda error: found.said.append(str(error)))
    found.page.on("request", lambda request: found.asked.append(request.url))
    try:
        found.page.goto(path.resolve().as_uri())
        yield found
    finally:
        context.close()
