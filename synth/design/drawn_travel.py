"""The travel for which a joint is drawn, its hard stops, and the seat of its spring that holds them before yield."""

from __future__ import annotations

from dataclasses import replace
from math import degrees

import numpy as np

from synth.design.choose_springs import SpringOption
from synth.design.leg_design import LegDesign
from synth.design.stop_places import ASKED_STOP, STOP, Ends, moved_range, needed_range
from synth.remarks import decisive

YIELD_SPARE = 2.0  # deg, from a stop to the spring's yield: an impact bends the printed stop horns by about one


def drawn_range(design: LegDesign, j: int, rest: float) -> Ends:
    """The leg file's range as it stands, else that of the wanted and the built leg's motion with a margin; deg.

    ``rest``: the joint's rest angle, deg. What a stated range leaves out is told by ``stated_range``.
    """
    joint = design.project.target.joints[j]  # the built leg's range is that of an earlier drawing's stops
    if joint.range is not None:
        low, high = (degrees(angle) for angle in joint.range)
        return low, high
    motions = [*design.wanted.motions, *design.built_motions]
    angles = np.degrees(np.concatenate([design.built.to_measured(motion)[:, j] for motion in motions]))
    return moved_range(min(angles.min(), rest), max(angles.max(), rest))


def yields_of(design: LegDesign, j: int, closes: int | None = None) -> Ends | None:
    """Measured angles (deg) at which the joint's spring yields; None if its strength is unknown.

    ``closes``: of another seat than that of the design (``SpringOption.closes``).
    """
    option, joint = design.springs.chosen[j], design.built.joints[j]
    known = option.design if option.design is not None else option.check
    if known is None:
        return None
    assert joint.spring is not None
    free, winds, opens = (degrees(a) for a in (joint.spring.free_angle, known.free_travel, known.free_opening_travel))
    return (free - winds, free + opens) if (closes or option.closes) < 0 else (free - opens, free + winds)


def stops_of(design: LegDesign, j: int, travel: Ends, yields: Ends | None, notes: list[str]) -> tuple[Ends, Ends]:
    """Travel and stops (deg): stops beyond the travel and before yield, if the spring allows both.

    If it does not, a travel that the leg file does not state is reduced to the travel of the motion. If that is not
    enough, the stops stay beyond the travel, a note names the spring's yield as the binding limit, and the drawn joint
    fails the check of its stops.
    """
    joint, asked = design.built.joints[j], is_asked(design, j)
    beyond = ASKED_STOP if asked else STOP
    stops = (travel[0] - beyond, travel[1] + beyond)
    if yields is None:
        return travel, stops
    first, last = yields[0] + YIELD_SPARE, yields[1] - YIELD_SPARE
    if first <= stops[0] and stops[1] <= last:
        return travel, stops
    needed = needed_range(travel, asked=asked)
    if _holds(yields, needed):
        stops = (max(stops[0], first), min(stops[1], last))
        return (max(travel[0], stops[0] + ASKED_STOP), min(travel[1], stops[1] - ASKED_STOP)), stops
    text = (
        f"{joint.name}: the spring yields at {yields[0]:.1f} and {yields[1]:.1f} deg. The wanted travel of "
        f"{needed[0]:.1f} to {needed[1]:.1f} deg and stops {YIELD_SPARE:g} deg before yield are not possible together, "
        "nor with the spring seated the other way round. With stops beyond the travel, at "
        f"{stops[0]:.1f} and {stops[1]:.1f} deg, the joint could turn its spring too far. A spring of thicker wire, or "
        "a smaller range of the joint, would allow both"
    )
    notes.append(decisive(text))
    return travel, stops


def well_seated(design: LegDesign) -> LegDesign:
    """The design with each spring turned round that holds its joint's travel only in the other seat."""
    pose, chosen = np.degrees(design.built.to_measured(design.rest_pose)), []
    for j, option in enumerate(design.springs.chosen):
        needed = needed_range(drawn_range(design, j, float(pose[j])), asked=is_asked(design, j))
        here, there = (yields_of(design, j, closes) for closes in (option.closes, -option.closes))
        if here is not None and there is not None and _holds(there, needed) and not _holds(here, needed):
            option = _turned_round(option)
        chosen.append(option)
    if all(one is other for one, other in zip(chosen, design.springs.chosen, strict=True)):
        return design
    turned = {id(before): after for before, after in zip(design.springs.chosen, chosen, strict=True)}
    ranked = tuple(tuple(turned.get(id(option), option) for option in each) for each in design.springs.ranked)
    return replace(design, springs=replace(design.springs, chosen=tuple(chosen), ranked=ranked))


def _turned_round(option: SpringOption) -> SpringOption:
    """The spring in the other seat: what wound it opens it. Its stresses follow when its drawn arms are known."""
    made, check = (
        None if known is None else replace(known, travel=known.opening_travel, opening_travel=known.travel)
        for known in (option.design, option.check)
    )
    turned = not option.turned_to_hold
    return replace(option, design=made, check=check, closes=-option.closes, turned_to_hold=turned)


def turned_sentences(design: LegDesign, j: int) -> list[str]:
    """A sentence if the joint's spring is turned round because the usual seat does not hold its travel."""
    option = design.springs.chosen[j]
    other = yields_of(design, j, -option.closes)
    if not option.turned_to_hold or other is None:
        return []
    larger = "larger" if option.closes > 0 else "smaller"
    return [
        f"{design.built.joint_names[j]}: its spring is seated so that {larger} measured angles close its arms, and its "
        f"arm offset is the free angle {'plus' if option.closes > 0 else 'less'} the included angle: the other way "
        f"round it would yield at {other[0]:.1f} and {other[1]:.1f} deg, which its stops leave no room for"
    ]


def is_asked(design: LegDesign, j: int) -> bool:
    """Whether the leg file states the joint's range."""
    return design.project.target.joints[j].range is not None


def _holds(yields: Ends, needed: Ends) -> bool:
    """Whether stops beyond this travel lie before yield (deg)."""
    first, last = yields[0] + YIELD_SPARE, yields[1] - YIELD_SPARE
    return first <= needed[0] - ASKED_STOP and needed[1] + ASKED_STOP <= last
