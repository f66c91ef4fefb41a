"""The next size of each cause to plant: a bisection between sizes that were missed and sizes that were found."""

from __future__ import annotations

from collections.abc import Sequence

from synth.rehearsal.outcome import CANNOT, FAILED, CaseOutcome
from synth.rehearsal.plants import RUNGS, PlantingTask


def next_rung(outcomes: Sequence[CaseOutcome]) -> tuple[int, int]:
    """Rung and draw of the next case of one cause, given its earlier cases in order.

    Bisection for the lowest rung at which it is found; then again with the next draw of leg
    and forms, starting from the second rung.
    """
    draw, low, high = 0, -1, len(RUNGS)
    for outcome in outcomes:
        if outcome.task.draw != draw:
            draw, low, high = outcome.task.draw, -1, len(RUNGS)
        if outcome.verdict == FAILED:  # it says nothing about this size
            draw, low, high = draw + 1, -1, len(RUNGS)
            continue
        if outcome.verdict == CANNOT or outcome.right:
            high = min(high, outcome.task.rung)
        else:
            low = max(low, outcome.task.rung)
        if high - low <= 1:
            draw, low, high = draw + 1, -1, len(RUNGS)
    return (low + high) // 2, draw


def visible_from(outcomes: Sequence[CaseOutcome]) -> int | None:
    """The lowest rung from which a cause is found in at least half of its cases; None if there is none.

    Shares are made monotonic in the rung by the pool-adjacent-violators algorithm (Ayer
    et al., Ann. Math. Stat. 26 (1955) 641), so that one lucky small case does not count as a detectable size.
    """
    counted = [o for o in outcomes if o.counts]
    blocks: list[list[float]] = []  # named, cases, first rung
    for rung in sorted({o.task.rung for o in counted}):
        here = [o.right for o in counted if o.task.rung == rung]
        blocks.append([float(sum(here)), float(len(here)), float(rung)])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] > blocks[-1][0] / blocks[-1][1]:
            last = blocks.pop()
            blocks[-1] = [blocks[-1][0] + last[0], blocks[-1][1] + last[1], blocks[-1][2]]
    return next((int(first) for named, cases, first in blocks if named >= 0.5 * cases and named > 0), None)


def round_of(
    wanted: Sequence[tuple[str, int]], done: dict[tuple[str, int], list[CaseOutcome]], room: int
) -> list[PlantingTask]:
    """The next case of each cause, at most ``room``, causes with the fewest cases first."""
    order = sorted(wanted, key=lambda key: len(done.get(key, ())))
    made = []
    for effect, joint in order[:room]:
        rung, draw = next_rung(done.get((effect, joint), ()))
        made.append(PlantingTask(effect, joint, rung, draw))
    return made
