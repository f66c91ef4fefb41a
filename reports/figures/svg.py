"""SVG text: elements with escaped words and coordinates of one decimal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from html import escape

from markupsafe import Markup

Point = tuple[float, float]
NARROW = 480.0  # a wider drawing is not reduced below ``LEGIBLE`` of its width; it is scrolled instead
HEADS = (0.5, 0.7, 0.85, 0.3, 1.0)  # shares of a cut label before its ellipsis that are tried
LEGIBLE = 0.72  # its 11-unit letters are then 8 pixels high


def coordinate(value: float) -> str:
    """A coordinate with one decimal, no trailing zero, no minus zero."""
    text = f"{value:.1f}"
    text = text.removesuffix(".0")
    return "0" if text == "-0" else text


class Svg:
    """A drawing that grows by elements; ``markup`` is its text.

    Parameters
    ----------
    width, height
        of the view box; one unit is about a pixel on a page of the design width.
    title
        the text for screen readers.
    """

    def __init__(self, width: float, height: float, title: str) -> None:
        self.width, self.height = width, height
        least = f";min-width:{coordinate(LEGIBLE * width)}px" if width > NARROW else ""
        self._parts = [
            f'<svg viewBox="0 0 {coordinate(width)} {coordinate(height)}" role="img" '
            f'style="max-width:{coordinate(width)}px{least}"><title>{escape(title)}</title>'
        ]

    @contextmanager
    def group(self, name: str) -> Iterator[None]:
        """Elements of one class, by which the page's script finds them."""
        self._parts.append(f'<g class="{name}">')
        yield
        self._parts.append("</g>")

    @contextmanager
    def named(self, name: str, *, hidden: bool = False) -> Iterator[None]:
        """Elements that belong to the curve of that name, so that it can be switched; ``hidden``: off at first."""
        if name:
            off = ' style="display:none"' if hidden else ""
            self._parts.append(f'<g data-curve="{escape(name)}"{off}>')
        yield
        if name:
            self._parts.append("</g>")

    def line(self, start: Point, end: Point, style: str = "") -> None:
        """A straight line; ``style`` holds SVG attributes, written by us and never by a user."""
        (x1, y1), (x2, y2) = start, end
        ends = f'x1="{coordinate(x1)}" y1="{coordinate(y1)}" x2="{coordinate(x2)}" y2="{coordinate(y2)}"'
        self._parts.append(f"<line {ends} {style}/>")

    def rectangle(self, corner: Point, width: float, height: float, style: str = "") -> None:
        """A rectangle by its upper left corner."""
        place = f'x="{coordinate(corner[0])}" y="{coordinate(corner[1])}"'
        self._parts.append(f'<rect {place} width="{coordinate(width)}" height="{coordinate(height)}" {style}/>')

    def circle(self, centre: Point, radius: float, style: str = "") -> None:
        """A circle."""
        place = f'cx="{coordinate(centre[0])}" cy="{coordinate(centre[1])}"'
        self._parts.append(f'<circle {place} r="{coordinate(radius)}" {style}/>')

    def polyline(self, points: Iterable[Point], style: str = "") -> None:
        """Joined points; a point with nan breaks the line."""
        path = polyline_path(points)
        if path:
            self._parts.append(f'<path d="{path}" fill="none" {style}/>')

    def dots(self, points: Iterable[Point], diameter: float, colour: str) -> None:
        """Points as round dots, in one element."""
        path = "".join(f"M{coordinate(x)} {coordinate(y)}h0" for x, y in points if math.isfinite(y))
        if path:
            style = f'stroke="{colour}" stroke-width="{diameter}" stroke-linecap="round"'
            self._parts.append(f'<path d="{path}" {style}/>')

    def path(self, data: str, style: str = "") -> None:
        """A path whose data we wrote."""
        self._parts.append(f'<path d="{data}" {style}/>')

    def text(
        self, place: Point, words: str, style: str = "", most: int | None = None, short: str | None = None
    ) -> None:
        """Text; longer than ``most`` characters it is cut, or as ``short``, with the whole text as tooltip."""
        shown = short if short is not None else words if most is None else shorten(words, most)
        tip = "" if shown == words else f"<title>{escape(words)}</title>"
        position = f'x="{coordinate(place[0])}" y="{coordinate(place[1])}"'
        self._parts.append(f"<text {position} {style}>{escape(shown)}{tip}</text>")

    @property
    def markup(self) -> Markup:
        """The drawing, safe to put into a page: every word in it was escaped."""
        return Markup("".join(self._parts) + "</svg>")


def shorten(words: str, most: int, head: float = 0.5) -> str:
    """Text of at most ``most`` characters; if it is cut an ellipsis stands in it, ``head`` of what is left before."""
    if len(words) <= most:
        return words
    first = max(1, round(head * (most - 1)))
    last = max(0, most - 1 - first)
    return f"{words[:first]}…{words[-last:] if last else ''}"


def shorten_apart(labels: Sequence[str], most: int) -> list[str]:
    """Every label of at most ``most`` characters, cut where as many as possible stay different."""
    made = [[shorten(words, most, head) for words in labels] for head in HEADS]
    return max(made, key=lambda short: len(set(short)))  # the first of those with most


def polyline_path(points: Iterable[Point]) -> str:
    """Path data of joined points; nan breaks the line, and repeated points are left out."""
    pieces: list[list[str]] = [[]]
    for x, y in points:
        if not (math.isfinite(x) and math.isfinite(y)):
            pieces.append([])
            continue
        here = f"{coordinate(x)} {coordinate(y)}"
        if not pieces[-1] or pieces[-1][-1] != here:
            pieces[-1].append(here)
    return "".join(f"M{piece[0]}L{' '.join(piece[1:] or piece)}" for piece in pieces if piece)


def thin_curve(times: Sequence[float], values: Sequence[float], buckets: int) -> list[Point]:
    """At most two points per bucket of equal count, the lowest and the highest, so that spikes remain visible."""
    n = len(times)
    if n <= 2 * buckets:
        return list(zip(times, values, strict=True))
    kept: list[Point] = []
    for bucket in range(buckets):
        first, last = bucket * n // buckets, (bucket + 1) * n // buckets
        part = values[first:last]
        known: Sequence[int]
        if math.isfinite(sum(part)):
            known, ends = range(first, last), {first + part.index(min(part)), first + part.index(max(part))}
        else:
            known = [i for i in range(first, last) if math.isfinite(values[i])]
            if not known:
                kept.append((times[first], math.nan))
                continue
            ends = {min(known, key=values.__getitem__), max(known, key=values.__getitem__)}
        if bucket == 0:
            ends.add(known[0])
        if bucket == buckets - 1:
            ends.add(known[-1])
        kept += [(times[i], values[i]) for i in sorted(ends)]
    return kept
