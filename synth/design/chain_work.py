"""Whether parts of a leg's different joints meet, from solids that several processes have built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from synth.shared_calls import SideCall
from synth.side_processes import carried_out, unpacked

if TYPE_CHECKING:
    from synth.cad import BuiltLeg, CheckResult, LegDimensions
    from synth.cad.chain_checks import Meeting, Shadow

Packed = tuple[bytes, bytes]  # a joint and its link, to send them to any process
Built = Sequence[Packed]


@lru_cache(maxsize=1)  # its files are written, and it is drawn, in several calls
def leg_of_copies(dimensions: LegDimensions, built: tuple[Packed, ...]) -> BuiltLeg:
    """The leg of copies."""
    from synth.cad.leg_joints import BuiltWhenUsed, build_leg

    joints = BuiltWhenUsed(len(built), lambda index: unpacked(built[index][0]))
    links = BuiltWhenUsed(len(built), lambda index: unpacked(built[index][1]))
    return replace(build_leg(dimensions), joints=joints, links=links)


def check_chain_of(
    dimensions: LegDimensions, built: Built, shadows: Sequence[Sequence[Shadow]]
) -> tuple[list[CheckResult], list[str]]:
    """Checks of parts on different links, joint by joint, and sentences on poses of several joints to keep out of.

    ``shadows`` : of each joint's parts. The solids are used only where shadows overlap, which is rare.
    """
    from synth.cad.chain_checks import chain_notes, chain_results, near_meetings

    near = near_meetings(dimensions, [each for part in shadows for each in part])
    meetings: list[Meeting] = []
    if near:
        [meetings] = carried_out([SideCall(_confirmed, (dimensions, built, near))])
    return chain_results(dimensions, meetings), chain_notes(meetings)


def _confirmed(dimensions: LegDimensions, built: Built, near: Any) -> list[Meeting]:
    from synth.cad.chain_checks import confirmed

    return confirmed(leg_of_copies(dimensions, tuple(built)), near)
