"""Take pictures of result pages for the documentation (docs/pictures), from the results of `make pages`.

    make pages                           # results of every command in build/pages/results
    python tools/docs_pictures.py        # needs playwright, pillow, and Chromium; --from FOLDER, --only NAME

A picture shows part of a page at a width of 1180 px, with 160 colours and at most 120 kB.
"""

from __future__ import annotations

import argparse
import io
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
WIDTH, COLOURS, MOST = 1180, 160, 120_000  # px, 1, bytes
# Opens a section and returns its position.
OPEN = """id => {
  const at = document.getElementById(id);
  for (let e = at; e; e = e.parentElement) if (e.tagName === "DETAILS") e.open = true;
  at.querySelectorAll(":scope > details").forEach(e => e.open = true);
  return at.getBoundingClientRect().top + scrollY;
}"""
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


@dataclass(frozen=True)
class Picture:
    """A picture of a result's page, ``height`` px high, from the start of ``section`` or of the page."""

    result: str
    height: int
    section: str = ""
    page: str = "report.html"


SHOWN = {
    "leg": Picture("leg", 890),
    "fit": Picture("fit", 680),
    "gap": Picture("gap", 860),
    "gap-where": Picture("gap", 900, "where"),
    "gap-which": Picture("gap", 520, "which"),
    "check": Picture("gap-check", 640),
    "check-apart": Picture("gap-check", 900, "apart"),
    "import": Picture("import", 640),
    "compare": Picture("compare", 830),
    "hopper": Picture("hopper", 640),
    "jump-gap": Picture("jump-gap", 600),
    "model-check": Picture("check", 520),
    "winding": Picture("spring", 640, page="winding_sheet.html"),
}
# Pictures that are files of the results.
COPIED = {"knee-apart": Path("leg/parts/knee_exploded.png")}


def taken(browser: Any, page: Path, picture: Picture) -> bytes:
    """The picture as PNG."""
    opened = browser.new_page(viewport={"width": WIDTH, "height": 900}, device_scale_factor=1)
    try:
        opened.goto(page.resolve().as_uri())
        opened.wait_for_timeout(2500)  # the leg is drawn after the page has loaded
        top = 0.0
        if picture.section:
            top = opened.evaluate(OPEN, picture.section)
            opened.wait_for_timeout(500)
        clip = {"x": 0, "y": max(top - 8, 0), "width": WIDTH, "height": picture.height}
        return bytes(opened.screenshot(clip=clip, full_page=True))
    finally:
        opened.close()


def small(png: bytes) -> bytes:
    """The picture with a palette of ``COLOURS``.

    Raises
    ------
    ValueError : larger than ``MOST`` bytes.
    """
    from PIL import Image

    out = io.BytesIO()
    picture = Image.open(io.BytesIO(png)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
    picture.save(out, "PNG", optimize=True)
    if out.tell() > MOST:
        raise ValueError(f"{out.tell()} bytes")
    return out.getvalue()


def main() -> int:
    """Take the pictures of all existing results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--from", dest="results", type=Path, default=ROOT / "build" / "pages" / "results")
    parser.add_argument("--only", nargs="*", default=list(SHOWN), metavar="NAME")
    arguments = parser.parse_args()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for name in arguments.only:
            page = arguments.results / SHOWN[name].result / SHOWN[name].page
            if not page.is_file():
                print(f"{name}: no {page}")
                continue
            picture = small(taken(browser, page, SHOWN[name]))
            (PICTURES / f"{name}.png").write_bytes(picture)
            print(f"{name}.png: {len(picture) / 1000:.0f} kB")
        browser.close()
    for name, path in COPIED.items():
        if (arguments.results / path).is_file():
            shutil.copyfile(arguments.results / path, PICTURES / f"{name}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
