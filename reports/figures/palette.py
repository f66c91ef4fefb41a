"""Colours and line styles. The colours of Okabe and Ito (2008) are distinguishable with any colour vision; in grey,
dash patterns and markers distinguish the curves.
"""

from __future__ import annotations

from dataclasses import dataclass

BLACK, GREY, RULE = "#222", "#666", "#d4d8dd"
BLUE, ORANGE, GREEN, VERMILION, PURPLE, SKY = "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"


@dataclass(frozen=True)
class Line:
    """How a curve is drawn; ``dots``: as separate points."""

    colour: str
    width: float = 1.6
    dash: str = ""
    dots: bool = False

    @property
    def style(self) -> str:
        """SVG attributes."""
        dash = f' stroke-dasharray="{self.dash}"' if self.dash else ""
        return f'stroke="{self.colour}" stroke-width="{self.width}"{dash} stroke-linejoin="round"'


RECORDED = Line("#a4abb3", 3.2, dots=True)
FITTED = Line(BLUE, 1.3)
WANTED = Line(BLUE, 1.4)
BUILT = Line(VERMILION, 1.6, "6 3")
BEFORE = Line(VERMILION, 1.6, "6 3")
AFTER = Line(BLUE, 1.5)
COMMAND = Line(BLACK, 1.1, "7 2.5 1.5 2.5")
FLOOR = Line(GREY, 1.2, "1.5 2.5")
USED_LAW = Line(BLUE, 2.6)
OTHER_LAWS = (Line(GREEN, 1.5, "8 3"), Line(PURPLE, 1.5, "2 2.5"), Line(ORANGE, 1.6, "8 3 2 3"), Line(SKY, 1.5, "1 4"))
SECANT = Line(VERMILION, 1.5, "5 4")
# Sides of a comparison, in their order: recordings as dots, simulated legs as lines, each with its own dash pattern.
RECORDED_SIDES = (RECORDED, Line(BLACK, 2.6, dots=True), Line(ORANGE, 2.6, dots=True), Line(SKY, 2.6, dots=True))
MODEL_SIDES = (
    Line(BLUE, 1.6), Line(VERMILION, 1.7, "7 3"), Line(GREEN, 1.8, "2 2.5"), Line(PURPLE, 1.8, "9 3 2 3"),
    Line(ORANGE, 1.9, "12 3"), Line(SKY, 1.9, "4 2"), Line(BLACK, 1.4, "1 3"), Line(GREY, 1.8, "9 3 2 3 2 3"),
)  # fmt: skip
