"""The laminate's layers one under the other: plates, fold lines, holes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from synth.reports.figures.palette import BLACK, GREY, VERMILION
from synth.reports.figures.svg import Svg

WIDTH, LEFT, GAP = 1000.0, 130.0, 18.0  # px
FILLS = {"rigid": "#c6dbef", "adhesive": "#fdf4d0", "film": "#e6e0ee"}


def layers_figure(layers: Sequence[Mapping[str, Any]]) -> Markup:
    """To scale along and across; a gap that is too small to see is still a gap."""
    end = max(plate[1] for layer in layers for plate in layer["plates_mm"])
    scale = (WIDTH - LEFT - 10) / end
    high = max(layer["width_mm"] for layer in layers) * scale
    svg = Svg(WIDTH, len(layers) * (high + GAP) + 10, "layers of the laminate")
    for i, layer in enumerate(layers):
        top = 8 + i * (high + GAP)
        svg.text((4, top + high / 2 + 4), str(layer["name"]).replace("_", " "), f'font-size="12" fill="{BLACK}"')
        for begin, stop in layer["plates_mm"]:
            style = f'fill="{FILLS.get(str(layer["material"]), "#eee")}" stroke="{GREY}" stroke-width="0.8"'
            svg.rectangle((LEFT + begin * scale, top), (stop - begin) * scale, high, style)
        for x in layer["folds_mm"]:
            place = LEFT + x * scale
            style = f'stroke="{VERMILION}" stroke-width="1" stroke-dasharray="4 3"'
            svg.line((place, top - 4), (place, top + high + 4), style)
        for x, y in layer["holes_mm"]:
            svg.circle((LEFT + x * scale, top + high - y * scale), 1.6, f'fill="#fff" stroke="{GREY}"')
    return svg.markup
