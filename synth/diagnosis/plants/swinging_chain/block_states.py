"""Initial states of the simulated legs, from the rows of a ``Block``'s states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet

import numpy as np

from synth.arrays import Array
from synth.diagnosis.lanes import Block, Hypothesis
from synth.diagnosis.plants.swinging_chain.lane_packing import chain_candidates
from synth.swing.leg_lanes import LegLanes
from synth.swing.stated_effects import Place


def states_of(blocks: Sequence[Block], widths: Sequence[int], count: int) -> Array:
    """The first ``count`` rows of the blocks' states (n_trial, count, n_lane); one column stands for all lanes."""
    if all(block.state.shape[2] == 1 for block in blocks):
        return np.repeat(np.concatenate([block.state[:, :count] for block in blocks], axis=2), widths, axis=2)
    each = [
        np.broadcast_to(block.state[:, :count], (len(block.state), count, width))
        for block, width in zip(blocks, widths, strict=True)
    ]
    return np.concatenate(each, axis=2)


def starting_links(
    hypothesis: Hypothesis, stated: Mapping[Place, int], own: AbstractSet[Place]
) -> list[tuple[Place | None, int]]:
    """Place and number of the links whose initial states a ``Block`` has, in its order; None for a place not used.

    A candidate's replace those of the ``stated`` structure in its place, except at the leg's ``own`` places.
    """
    structures = [(c.place, c.links) for c in chain_candidates(hypothesis) if c.effect.way == "structure"]
    replaced = {place for place, _ in structures} - own
    kept = [(None if place in replaced else place, number) for place, number in stated.items()]
    return [*kept, *((None if place in own else place, number) for place, number in structures)]


def departures(
    blocks: Sequence[Block], starting: Sequence[Sequence[tuple[Place | None, int]]], trial: int, below: int
) -> dict[Place, Array]:
    """For each structure, the displacement of its links from the held position (2 m, n_lane), see ``Block``.

    ``starting`` : of each block, see ``starting_links``; their rows of its states begin at ``below``.
    """
    found: dict[Place, Array] = {}
    first, total = 0, sum(block.unknowns.shape[1] for block in blocks)
    for block, links in zip(blocks, starting, strict=True):
        row, last = below, first + block.unknowns.shape[1]
        for place, number in links:
            given, row = block.state[trial, row : row + 2 * number], row + 2 * number
            if place is not None and len(given):  # without an entry they start as if held
                wide = found.setdefault(place, np.zeros((2 * number, total)))
                wide[: len(given), first:last] = given  # of one column or of all
        first = last
    return found


def started_integral_sums(
    blocks: Sequence[Block], widths: Sequence[int], units: Mapping[int, float], legs: LegLanes
) -> Array:
    """(n_trial, n_link, n_lane) duty, what the servos' integrals begin with beside that which holds their joints.

    ``units`` : the result of ``usual_departures``; their rows follow those of the joints.
    """
    first = 2 * len(legs.own)
    started = np.zeros((len(blocks[0].state), legs.n, sum(widths)))
    if all(block.state.shape[1] > first for block in blocks):
        found = states_of(blocks, widths, first + len(units))[:, first:]
        for k, (joint, unit) in enumerate(units.items()):
            started[:, legs.own[joint]] = unit * found[:, k]
    return started
