"""Whether the joints of a set of parts fit the links between them, before they are drawn.

A link must be at least as long as the halves of its two hinges. Their lengths are estimated by the layout of each joint
with its spring and damper and the wanted travel; the drawn joint, which has the built travel and tubes and screws that
its loads ask for, may be a few per cent longer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from math import degrees
from typing import TYPE_CHECKING

from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption, SpringSource
from synth.design.damper_sizes import drawn_damper, known_sizes
from synth.design.stop_places import DRAWN_STOP
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.cad import DamperDimensions, JointDimensions, SpringDimensions

ROUNDING = 1e-6  # mm, of a converted length
MARGIN = 1.0  # deg, by which the built leg may move farther than the wanted one, beside its stops


class LinkRoom:
    """The links of a leg, and what the parts at their joints need of them.

    Parameters
    ----------
    sources
        of each joint's springs; where the first is not drawn, nothing needs room.
    leg
        its links.
    """

    def __init__(self, sources: Sequence[SpringSource], leg: Leg) -> None:
        self._sources = sources
        self._links = [joint.link.length * 1e3 for joint in leg.joints]

    def fits(self, parts: Sequence[tuple[SpringOption, DamperOption]]) -> bool:
        """Whether every link is long enough for the joints of one spring and damper each."""
        if not self._sources[0].drawn:
            return True
        halves = [_halves(_joint(source, *each)) for source, each in zip(self._sources, parts, strict=True)]
        uppers = [*(upper for upper, _ in halves[1:]), 0.0]
        needed = [lower + upper for (_, lower), upper in zip(halves, uppers, strict=True)]
        return all(length >= least - ROUNDING for length, least in zip(self._links, needed, strict=True))


@lru_cache(maxsize=2048)
def _halves(joint: JointDimensions | None) -> tuple[float, float]:
    """Upper and lower half of a joint, mm; 0 of one whose sizes are unknown or cannot be drawn for other reasons."""
    from synth.cad.least_joint import least_halves

    return (0.0, 0.0) if joint is None else least_halves(joint)


def _joint(source: SpringSource, spring: SpringOption, damper: DamperOption) -> JointDimensions | None:
    """The joint with these parts, its free angle at zero; None: sizes are unknown, or out of the drawing's range."""
    from synth.cad import LoadDimensions
    from synth.cad.least_joint import least_joint

    coil, body, cad = _coil(spring), _body(source, damper), source.cad
    if coil is None or coil.problems() or body.problems():
        return None
    tube = (cad.link_width * 1e3, cad.tube_wall * 1e3)
    joint = least_joint(cad.shaft_diameter * 1e3, cad.clearance * 1e3, cad.wall * 1e3, tube, body)
    beyond = DRAWN_STOP + MARGIN
    travel = (-degrees(source.turned.winding), degrees(source.turned.opening))
    return replace(
        joint,
        spring=coil,
        springs=min(spring.number, 2),
        free_angle=0.0,
        rest_angle=0.0,
        range=travel,
        stops=(travel[0] - beyond, travel[1] + beyond),
        loads=LoadDimensions(spring_rate=spring.rate),
    )


def _coil(spring: SpringOption) -> SpringDimensions | None:
    from synth.cad import SpringDimensions
    from synth.design.drawable_springs import drawn_pitch

    row, made = spring.row, spring.design
    angle = degrees(spring.included_angle)
    if made is not None:
        return SpringDimensions(made.wire_diameter * 1e3, made.mean_diameter * 1e3, made.body_coils, angle)
    if row is None or row.wire_diameter is None or row.mean_diameter is None or row.body_coils is None:
        return None
    return SpringDimensions(
        row.wire_diameter * 1e3, row.mean_diameter * 1e3, row.body_coils, angle, pitch=drawn_pitch(row)
    )


def _body(source: SpringSource, damper: DamperOption) -> DamperDimensions:
    known = known_sizes(damper.row, source.joint, source.cad)
    return drawn_damper(known, source.cad.shaft_diameter * 1e3, f"cad.dampers.{source.joint}")
