"""The score's drawings: confusion matrix, reliability diagram, scores on their levels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from markupsafe import Markup

from blind.chance import BINS, Array, reliability, wilson
from synth.reports.figures.palette import BLACK, BLUE, GREY, RULE
from synth.reports.figures.svg import Svg

CELL, LEFT, TOP = 21.0, 172.0, 150.0
LAST = ("none", "unknown", "failed")


def confusion_matrix(cases: Mapping[tuple[str, str], int]) -> Markup:
    """True effect against named effect; a cell's blue is the share of its row, the number its cases."""
    rows = _ordered({true for true, _ in cases})
    columns = _ordered({true for true, _ in cases} | {named for _, named in cases})
    svg = Svg(LEFT + CELL * len(columns) + 50, TOP + CELL * len(rows) + 10, "confusion matrix")
    for x, named in enumerate(columns):
        at = LEFT + (x + 0.65) * CELL, TOP - 6.0
        turn = f'transform="rotate(-55 {at[0]:.1f} {at[1]:.1f})" font-size="11" fill="{BLACK}"'
        svg.text(at, _plain(named), turn)
    for y, true in enumerate(rows):
        total = sum(n for (t, _), n in cases.items() if t == true)
        base = TOP + (y + 0.7) * CELL
        svg.text((LEFT - 6, base), f"{_plain(true)} ({total})", f'font-size="11" text-anchor="end" fill="{BLACK}"')
        for x, named in enumerate(columns):
            number = cases.get((true, named), 0)
            share = number / total
            fill = f'fill="{BLUE}" fill-opacity="{0.12 + 0.88 * share:.2f}"' if number else 'fill="none"'
            edge = BLACK if true == named else RULE
            corner = LEFT + x * CELL, TOP + y * CELL
            svg.rectangle(corner, CELL - 1, CELL - 1, f'{fill} stroke="{edge}" stroke-width="0.6"')
            if number:
                ink = "#fff" if share > 0.5 else BLACK
                style = f'font-size="11" text-anchor="middle" fill="{ink}"'
                svg.text((corner[0] + CELL / 2, base), str(number), style)
    return svg.markup


def _ordered(names: set[str]) -> list[str]:
    return sorted(names - set(LAST)) + [name for name in LAST if name in names]


def _plain(name: str) -> str:
    return name.replace("_", " ") or "nothing"


def reliability_diagram(methods: Sequence[tuple[str, Array, str]]) -> Markup:
    """Share of right answers over the stated probability, (name, rows (n, 2), colour) per method; bars are 90 %."""
    size, left, top = 300.0, 52.0, 14.0
    svg = Svg(left + size + 190, top + size + 48, "reliability diagram")

    def place(p: float, share: float) -> tuple[float, float]:
        return left + p * size, top + (1 - share) * size

    for k in range(0, BINS + 1, 2):
        p = k / BINS
        svg.line(place(p, 0), place(p, 1), f'stroke="{RULE}" stroke-width="0.7"')
        svg.line(place(0, p), place(1, p), f'stroke="{RULE}" stroke-width="0.7"')
        x, y = place(p, 0)
        svg.text((x, y + 16), f"{p:.0%}", f'font-size="11" text-anchor="middle" fill="{GREY}"')
        x, y = place(0, p)
        svg.text((x - 6, y + 4), f"{p:.0%}", f'font-size="11" text-anchor="end" fill="{GREY}"')
    svg.line(place(0, 0), place(1, 1), f'stroke="{GREY}" stroke-width="1" stroke-dasharray="3 3"')
    for number, (name, rows, colour) in enumerate(methods):
        found = reliability(rows)
        svg.polyline([place(said, was) for _, _, said, was in found], f'stroke="{colour}" stroke-width="1.4"')
        for _, count, said, was in found:
            low, high = wilson(round(was * count), count)
            svg.line(place(said, low), place(said, high), f'stroke="{colour}" stroke-width="1" stroke-opacity="0.6"')
            svg.circle(place(said, was), 2.5 + min(count, 60) ** 0.5 / 2, f'fill="{colour}"')
            x, y = place(said, was)
            svg.text((x + 8, y - 6), str(count), f'font-size="10" fill="{colour}"')
        at = left + size + 16, top + 16.0 + 18 * number
        svg.circle((at[0], at[1] - 4), 4, f'fill="{colour}"')
        svg.text((at[0] + 9, at[1]), name, f'font-size="12" fill="{BLACK}"')
    svg.text((left + size / 2, top + size + 38), "probability of the first-ranked cause", _CENTRED)
    turn = f'transform="rotate(-90 12 {top + size / 2:.1f})" {_CENTRED}'
    svg.text((12, top + size / 2), "share that was right", turn)
    return svg.markup


_CENTRED = f'font-size="12" text-anchor="middle" fill="{BLACK}"'
