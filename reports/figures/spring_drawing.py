"""Dimensioned drawing of a torsion spring: along its axis with both arms and the included angle, and from the side."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup

from synth.reports.figures.palette import BLACK, BLUE, GREY, VERMILION
from synth.reports.figures.svg import Point, Svg
from synth.reports.quantities import number

HEIGHT, TOP, LEFT = 400.0, 34.0, 84.0  # px
ROOM = (330.0, 288.0)  # for the coil with its arms along the axis
SIDE_ROOM = 300.0  # for the body's length
ARC = 80.0  # for the included angle's arc and its label beside the coil
GAP, RIGHT = 70.0, 170.0  # px
WIRE = "#dfe6ee"
THIN = f'stroke="{GREY}" stroke-width="0.8"'
CHAIN = f'stroke="{GREY}" stroke-width="0.8" stroke-dasharray="9 3 2 3"'
LABEL = f'font-size="12" fill="{BLACK}"'
MOST_DRAWN = 40  # coils


@dataclass(frozen=True)
class DrawnSpring:
    """Dimensions of the drawing; mm, rad. ``arms``: ``tangent``, ``radial``, ``axial``; ``travel`` closes the coil.

    ``inch`` : write dimensions in inches.
    """

    wire: float
    mean: float
    coils: float
    included_angle: float
    leg_lengths: tuple[float, float]
    body_length: float
    arms: str = "tangent"
    arbor: float | None = None
    hand: str = "right"
    travel: float | None = None
    inch: bool = False

    def length_text(self, length: float) -> str:
        """A length in mm with the unit of the drawing's dimensions."""
        return f"{number(length / 25.4, 4)} in" if self.inch else f"{number(length, 4)} mm"


@dataclass(frozen=True)
class Arm:
    """An arm in the plane across the axis: where the wire leaves the circle, and its end; mm, y upwards."""

    root: Point
    end: Point
    direction: Point


def arms_of(spring: DrawnSpring) -> tuple[Arm, Arm]:
    """Both arms, rotated so that the included angle opens to the right, symmetric about the horizontal.

    The wire of a right-hand coil approaches the viewer counter-clockwise, that of a left-hand coil clockwise. The first
    tangent arm leaves against the winding direction, the second along it, 2 pi N later. The angle between them is then
    180 deg - 360 deg frac(N), which must be the included angle.
    """
    radius, half = spring.mean / 2, spring.included_angle / 2
    if spring.arms == "tangent":
        # With t(a) = (-sin a, cos a) the first arm points along -t and the second along t.
        angles, directions = (half + math.pi / 2, -half - math.pi / 2), (_unit(half), _unit(-half))
    else:
        angles, directions = (-half, half), (_unit(-half), _unit(half))
    found = []
    for angle, direction, length in zip(angles, directions, spring.leg_lengths, strict=True):
        root = (radius * math.cos(angle), radius * math.sin(angle))
        reach = 0.0 if spring.arms == "axial" else length
        end = (root[0] + reach * direction[0], root[1] + reach * direction[1])
        found.append(Arm(root, end, direction) if spring.hand == "right" else _arm_mirrored(root, end, direction))
    return found[0], found[1]


def _arm_mirrored(root: Point, end: Point, direction: Point) -> Arm:
    """The arm in a coil of the other hand."""
    return Arm((root[0], -root[1]), (end[0], -end[1]), (direction[0], -direction[1]))


def spring_drawing(title: str, spring: DrawnSpring) -> Markup:
    """Both views at one scale, with dimensions."""
    arms = arms_of(spring)
    outer = (spring.mean + spring.wire) / 2
    xs = [-outer, outer, *(arm.end[0] for arm in arms)]
    ys = [-outer, outer, *(arm.end[1] for arm in arms)]
    scale = min(ROOM[0] / (max(xs) - min(xs)), ROOM[1] / (max(ys) - min(ys)), SIDE_ROOM / spring.body_length)
    centre = (LEFT - min(xs) * scale, TOP + ROOM[1] / 2 + (max(ys) + min(ys)) / 2 * scale)
    right = max(max(xs) * scale, outer * scale + ARC) + centre[0]
    start = right + GAP
    svg = Svg(start + spring.body_length * scale + RIGHT, HEIGHT, title)
    _along_axis(svg, spring, arms, centre, scale)
    _from_side(svg, spring, arms, (start, centre[1]), scale)
    return svg.markup


def _along_axis(svg: Svg, spring: DrawnSpring, arms: tuple[Arm, Arm], centre: Point, scale: float) -> None:
    def place(point: Point) -> Point:
        return centre[0] + point[0] * scale, centre[1] - point[1] * scale

    wire, radius = spring.wire * scale, spring.mean / 2 * scale
    _rod(svg, place(arms[0].root), place(arms[0].end), wire)
    svg.circle(centre, radius, f'fill="none" stroke="{BLACK}" stroke-width="{wire + 2:.2f}"')
    svg.circle(centre, radius, f'fill="none" stroke="{WIRE}" stroke-width="{max(wire, 0.4):.2f}"')
    _rod(svg, place(arms[1].root), place(arms[1].end), wire)
    below = f'font-size="12" fill="{GREY}"'
    svg.text((8, HEIGHT - 10), f"seen along the axis, {spring.hand}-hand", below)
    if spring.arbor:
        svg.circle(centre, spring.arbor / 2 * scale, f'fill="none" {THIN} stroke-dasharray="4 3"')
        svg.text((8, HEIGHT - 26), f"dashed: arbor Ø {spring.length_text(spring.arbor)}", below)
    _included_angle(svg, spring, centre, scale)
    for index, arm in enumerate(arms):
        upper = (index == 0) == (spring.hand == "right")
        if spring.arms != "axial" and spring.leg_lengths[index] > 0:
            _leg_length(
                svg, place(arm.root), place(arm.end), wire, spring.length_text(spring.leg_lengths[index]), upper=upper
            )


def _included_angle(svg: Svg, spring: DrawnSpring, centre: Point, scale: float) -> None:
    """Lines through the centre parallel to the arms, and the arc between them."""
    if spring.arms == "axial":
        return
    half = spring.included_angle / 2
    reach = (spring.mean / 2 + spring.wire) * scale
    arc = reach + 26.0
    for sign in (1, -1):
        direction = _unit(sign * half)
        end = (centre[0] + direction[0] * (arc + 10), centre[1] - direction[1] * (arc + 10))
        svg.line(centre, end, CHAIN)
    first, last = _unit(half), _unit(-half)
    ends = [(centre[0] + d[0] * arc, centre[1] - d[1] * arc) for d in (first, last)]
    large = 1 if spring.included_angle > math.pi else 0
    if spring.included_angle > 1e-6:
        svg.path(
            f"M{ends[0][0]:.1f} {ends[0][1]:.1f}A{arc:.1f} {arc:.1f} 0 {large} 1 {ends[1][0]:.1f} {ends[1][1]:.1f}",
            f'fill="none" stroke="{BLUE}" stroke-width="1.2"',
        )
        for direction, end, sense in zip((first, last), ends, (1, -1), strict=True):
            # The arc's tangent in drawing coordinates, pointing to its end.
            _head(svg, end, (-direction[1] * sense, -direction[0] * sense), BLUE)
    words = f"{number(math.degrees(spring.included_angle), 4)}°"
    if spring.travel and spring.included_angle > 1e-6:
        _draw_load(svg, spring, centre, arc - 13.0)
    svg.text((centre[0] + arc + 7, centre[1] + 4), words, f'font-size="13" font-weight="600" fill="{BLUE}"')


def _draw_load(svg: Svg, spring: DrawnSpring, centre: Point, radius: float) -> None:
    """The load's direction on the near arm: the winding direction, which closes tangent arms and opens radial ones."""
    assert spring.travel is not None
    sense = 1.0 if spring.hand == "right" else -1.0
    closes = spring.arms == "tangent"
    start = (-sense if closes else sense) * spring.included_angle / 2
    # So that the arrow stays clear of the other arm.
    turned = min(spring.travel, 0.75 * (spring.included_angle if closes else math.tau - spring.included_angle))
    first, last = _unit(start), _unit(start + sense * turned)
    ends = [(centre[0] + d[0] * radius, centre[1] - d[1] * radius) for d in (first, last)]
    large, sweep = int(turned > math.pi), 0 if sense > 0 else 1
    svg.path(
        f"M{ends[0][0]:.1f} {ends[0][1]:.1f}"
        f"A{radius:.1f} {radius:.1f} 0 {large} {sweep} {ends[1][0]:.1f} {ends[1][1]:.1f}",
        f'fill="none" stroke="{VERMILION}" stroke-width="1.4"',
    )
    _head(svg, ends[1], (-last[1] * sense, -last[0] * sense), VERMILION)


def _from_side(svg: Svg, spring: DrawnSpring, arms: tuple[Arm, Arm], start: Point, scale: float) -> None:
    """The view from the right: the axis lies across, heights are those of the view along the axis."""
    wire, radius = spring.wire * scale, spring.mean / 2 * scale
    left, middle = start
    length = spring.body_length * scale
    coils = min(math.ceil(spring.coils), MOST_DRAWN)
    pitch = (length - wire) / max(coils, 1)
    first, last = left + wire / 2, left + length - wire / 2
    _rod(svg, (last, middle - arms[1].root[1] * scale), (last, middle - arms[1].end[1] * scale), wire)
    for index in range(coils):
        x = first + index * pitch
        _rod(svg, (x, middle + radius), (min(x + pitch / 2, last), middle - radius), wire)
    if coils:
        _rod(svg, (last, middle + radius), (last, middle - radius), wire)
    _rod(svg, (first, middle - arms[0].root[1] * scale), (first, middle - arms[0].end[1] * scale), wire)
    svg.line((left - 14, middle), (left + length + 14, middle), CHAIN)
    base = middle + radius + wire / 2
    low = max(base, *(middle - arm.end[1] * scale for arm in arms)) + 22
    _draw_dimension(svg, (left, base), (left + length, base), low, f"body {spring.length_text(spring.body_length)}")
    tip = min(middle - y * scale for arm in arms for y in (arm.root[1], arm.end[1])) - wire / 2
    svg.text((left, tip - 7), f"wire Ø {spring.length_text(spring.wire)}", LABEL)
    _upright(svg, (left + length, middle - radius - wire / 2), (left + length, base), left + length + 26,
             f"outside Ø {spring.length_text(spring.mean + spring.wire)}")  # fmt: skip
    svg.text((left, HEIGHT - 10), "from the side", f'font-size="12" fill="{GREY}"')


def _rod(svg: Svg, start: Point, end: Point, width: float) -> None:
    """A round wire from start to end."""
    svg.line(start, end, f'stroke="{BLACK}" stroke-width="{width + 2:.2f}" stroke-linecap="round"')
    svg.line(start, end, f'stroke="{WIRE}" stroke-width="{max(width, 0.4):.2f}" stroke-linecap="round"')


def _leg_length(svg: Svg, root: Point, end: Point, wire: float, words: str, *, upper: bool) -> None:
    """A dimension line beside an arm, on its outer side."""
    dx, dy = end[0] - root[0], end[1] - root[1]
    length = math.hypot(dx, dy)
    normal = (-dy / length, dx / length)
    if (normal[1] > 0) == upper:
        normal = (-normal[0], -normal[1])
    off = wire / 2 + 14
    a = (root[0] + normal[0] * off, root[1] + normal[1] * off)
    b = (end[0] + normal[0] * off, end[1] + normal[1] * off)
    svg.line(a, b, THIN)
    direction = (dx / length, dy / length)
    _head(svg, b, direction, GREY)
    _head(svg, a, (-direction[0], -direction[1]), GREY)
    middle = ((a[0] + b[0]) / 2 + normal[0] * 14, (a[1] + b[1]) / 2 + normal[1] * 14 + 4)
    anchor = "start" if normal[0] > 0.3 else ("end" if normal[0] < -0.3 else "middle")
    svg.text(middle, words, f'{LABEL} text-anchor="{anchor}"')


def _draw_dimension(svg: Svg, left: Point, right: Point, height: float, words: str) -> None:
    """A horizontal dimension below two points."""
    for point in (left, right):
        svg.line((point[0], point[1] + 3), (point[0], height + 4), THIN)
    svg.line((left[0], height), (right[0], height), THIN)
    _head(svg, (left[0], height), (-1, 0), GREY)
    _head(svg, (right[0], height), (1, 0), GREY)
    svg.text(((left[0] + right[0]) / 2, height + 15), words, f'{LABEL} text-anchor="middle"')


def _upright(svg: Svg, top: Point, bottom: Point, x: float, words: str) -> None:
    """A vertical dimension right of two points."""
    for point in (top, bottom):
        svg.line((point[0] + 3, point[1]), (x + 4, point[1]), THIN)
    svg.line((x, top[1]), (x, bottom[1]), THIN)
    _head(svg, (x, top[1]), (0, -1), GREY)
    _head(svg, (x, bottom[1]), (0, 1), GREY)
    svg.text((x + 8, (top[1] + bottom[1]) / 2 - 6), words, LABEL)


def _head(svg: Svg, tip: Point, direction: Point, colour: str) -> None:
    """An arrow head at ``tip`` along a unit direction in drawing coordinates."""
    (x, y), (dx, dy) = tip, direction
    a = (x - 8 * dx - 2.6 * dy, y - 8 * dy + 2.6 * dx)
    b = (x - 8 * dx + 2.6 * dy, y - 8 * dy - 2.6 * dx)
    svg.path(f"M{x:.1f} {y:.1f}L{a[0]:.1f} {a[1]:.1f} {b[0]:.1f} {b[1]:.1f}Z", f'fill="{colour}"')


def _unit(angle: float) -> Point:
    return math.cos(angle), math.sin(angle)
