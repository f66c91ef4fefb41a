"""The key to a figure's lines, as a drawing beside words."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from synth.reports.figures.palette import Line
from synth.reports.figures.svg import Svg


def swatch(line: Line) -> Markup:
    """A short piece of the line."""
    svg = Svg(34, 10, "line style")
    if line.dots:
        svg.dots([(x, 5) for x in range(4, 33, 5)], line.width + 0.6, line.colour)
    else:
        svg.line((1, 5), (33, 5), line.style)
    return Markup(str(svg.markup).replace("<svg ", '<svg class="swatch" ', 1))


def legend(entries: Sequence[tuple[Line, str]], switched: Sequence[tuple[Line, str, str]] = ()) -> Markup:
    """Lines with their names in a row; ``switched``: line, curve and words of curves that are off at first."""
    items = Markup("").join(
        Markup('<span data-curve="{}">{}&nbsp;{}</span>').format(name.split(":")[0].split(",")[0], swatch(line), name)
        for line, name in entries
    )
    items += Markup("").join(
        Markup('<span data-curve="{}" data-off="1" class="live">{}&nbsp;{}</span>').format(curve, swatch(line), words)
        for line, curve, words in switched
    )
    return Markup('<p class="legend">{}</p>').format(items)
