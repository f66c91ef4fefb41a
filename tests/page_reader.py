"""A report's page read back: tags in balance, links, text and drawings."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

_VOID = {"meta", "br", "img", "link", "input", "hr", "line", "rect", "circle", "path"}


class Page(HTMLParser):
    """Tags in balance, attributes and text of a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.sources: list[str] = []
        self.tags: set[str] = set()
        self.events: list[str] = []
        self.words: list[str] = []
        self.codes: list[str] = []
        self.feed(html)
        self.close()
        assert not self.open, self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            if name == "href":
                self.links.append(value or "")
            if name in ("src", "srcset", "data", "xlink:href"):
                self.sources.append(value or "")
            if name.startswith("on"):
                self.events.append(name)
        if tag not in _VOID:
            self.open.append(tag)
        if tag == "code":
            self.codes.append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in _VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, tag
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] not in ("style", "script"):
            self.words.append(data)
        if self.open and self.open[-1] == "code":
            self.codes[-1] += data

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))


def drawings(html: str) -> list[ElementTree.Element]:
    """Every SVG of the page, read as XML."""
    return [ElementTree.fromstring(found.replace("&nbsp;", " ")) for found in re.findall(r"<svg.*?</svg>", html, re.S)]


def page_of(path: Path) -> tuple[str, Page]:
    html = path.read_text(encoding="utf-8")
    return html, Page(html)


def check_words(drawing: ElementTree.Element) -> None:
    """Words, 0.6 of their height wide a letter, lie inside the view box (turned ones aside)."""
    width, height = (float(x) for x in drawing.attrib["viewBox"].split()[2:])
    for text in drawing.iter("text"):
        if "transform" in text.attrib:
            continue
        length = 0.6 * float(text.attrib["font-size"]) * len(text.text or "")
        share = {"end": 1.0, "middle": 0.5}.get(text.attrib.get("text-anchor", ""), 0.0)
        left = float(text.attrib["x"]) - share * length
        assert left >= -2.0, (text.text, left)
        assert left + length <= width + 2.0, (text.text, left + length, width)
        assert 6.0 <= float(text.attrib["y"]) <= height
