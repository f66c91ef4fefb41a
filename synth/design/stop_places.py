"""Where a joint's hard stops lie beside what it moves through, and inside what its damper can turn through; degrees."""

from __future__ import annotations

from math import ceil, floor

Ends = tuple[float, float]
MARGIN = 5.0  # deg, drawn travel beyond the leg's motion if the leg file gives no range
STOP = 3.0  # deg past such a travel, at which the hard stops touch
ASKED_STOP = 1.5  # deg past a range that the leg file states: the tolerance of printed flanks
DRAWN_STOP = 1.0 + MARGIN + STOP  # deg, from a motion to the farthest drawn stops, which lie at whole degrees
CLOCKING = 1.0  # deg, either way, left to set a damper's travel to the stops by hand: a mark on its flange


def moved_range(least: float, most: float) -> Ends:
    """The range that is drawn for a motion between two measured angles, where the leg file states none."""
    return floor(least - MARGIN), ceil(most + MARGIN)


def needed_range(travel: Ends, *, asked: bool) -> Ends:
    """The least travel to draw: a stated one as it stands, else that of the motion and a degree."""
    return travel if asked else (travel[0] + MARGIN - 1.0, travel[1] - MARGIN + 1.0)


def least_stops(travel: Ends, *, asked: bool) -> Ends:
    """The closest stops that a drawn travel allows."""
    low, high = needed_range(travel, asked=asked)
    return low - ASKED_STOP, high + ASKED_STOP


def within_damper(travel: Ends, stops: Ends, least: Ends, turns: float) -> tuple[Ends, Ends]:
    """Travel and stops drawn closer, so that the stops are met before the ends of a damper that ``turns`` so far.

    Where even the ``least`` stops are too far apart, as those of a stated range may be, all stay: a warning tells it.
    """
    asked = least[1] - least[0]
    if stops[1] - stops[0] <= turns - 2.0 * CLOCKING or asked > turns:
        return travel, stops
    room = (max(least[0] - stops[0], 0.0), max(stops[1] - least[1], 0.0))
    spare = max(turns - 2.0 * CLOCKING - asked, 0.0)
    left = 1.0 - min(spare / sum(room), 1.0) if sum(room) > 0.0 else 0.0
    closer = (stops[0] + left * room[0], stops[1] - left * room[1])
    return (max(travel[0], closer[0] + ASKED_STOP), min(travel[1], closer[1] - ASKED_STOP)), closer
