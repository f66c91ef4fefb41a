"""Which legs share their integration steps, and which calls predict them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from synth.diagnosis.lanes import Hypothesis
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.swing.lane_layout import LANES

MOST_GROUPS = 16  # in one call: the readings of 500 samples and 3 joints then take 3 MB


def groups(hypotheses: Sequence[Hypothesis], widths: Sequence[int]) -> list[list[int]]:
    """Indices of blocks that step together: of equal structure, at most sixteen lanes."""
    kinds: dict[tuple[tuple[str, int], ...], list[int]] = {}
    for index, hypothesis in enumerate(hypotheses):
        kinds.setdefault(_structure_and_memory(hypothesis), []).append(index)
    made = []
    for indices in kinds.values():
        indices.sort(key=lambda i: _packing_order(hypotheses[i]))
        made += [[indices[k] for k in group] for group in _pack_lanes([widths[i] for i in indices])]
    return made


def runs(hypotheses: Sequence[Hypothesis], packed: Sequence[Sequence[int]], least: int) -> list[list[int]]:
    """Indices of ``groups`` that one call predicts: of equal structures, at most ``MOST_GROUPS``.

    In at least ``least`` calls where there are so many groups. A call has a fixed cost, of the order of the
    integration of one group, because the lanes are written by many short array operations.
    """
    kinds: dict[tuple[tuple[str, int], ...], list[int]] = {}
    for index, group in enumerate(packed):
        kinds.setdefault(_structures(hypotheses[group[0]]), []).append(index)
    made = []
    for indices in kinds.values():
        parts = max(-(-len(indices) // MOST_GROUPS), round(least * len(indices) / max(len(packed), 1)), 1)
        parts = min(parts, len(indices))
        made += [indices[part::parts] for part in range(parts)]
    return made


def chain_candidates(hypothesis: Hypothesis) -> tuple[Candidate, ...]:
    """The candidates of a hypothesis about this plant."""
    return cast(tuple[Candidate, ...], hypothesis)


def _structure_and_memory(hypothesis: Hypothesis) -> tuple[tuple[str, int], ...]:
    """The properties that legs stepping together must share: structures, and memories joint by joint."""
    memories = {
        (candidate.effect.kin or candidate.effect.name, candidate.joint)
        for candidate in chain_candidates(hypothesis)
        if candidate.effect.way != "structure" and candidate.effect.memory
    }
    return (*_structures(hypothesis), *sorted(memories))


def _structures(hypothesis: Hypothesis) -> tuple[tuple[str, int], ...]:
    """The part of the kind that changes the number of links."""
    found = {
        (f"{candidate.effect.name} {candidate.shape.free} {candidate.shape.held}", candidate.joint)
        for candidate in chain_candidates(hypothesis)
        if candidate.effect.way == "structure"
    }
    return tuple(sorted(found))


def _packing_order(hypothesis: Hypothesis) -> tuple[bool, list[str]]:
    """Sort key of blocks: lanes of a group should need the same effects, because each is computed for all.

    The bearing force costs most, then each further effect.
    """
    load = any(_needs_bearing_force(candidate) for candidate in chain_candidates(hypothesis))
    return load, sorted(candidate.effect.name for candidate in hypothesis)


def _needs_bearing_force(candidate: Candidate) -> bool:
    """Whether it needs the bearing force in this shape."""
    effect, shape = candidate.effect, candidate.shape
    return effect.uses_load and any(name in shape.free or name in shape.held for name in effect.by_load or shape.free)


def _pack_lanes(widths: Sequence[int]) -> list[list[int]]:
    """Blocks in groups of at most sixteen lanes, first fit in order."""
    groups: list[list[int]] = []
    room: list[int] = []
    for index, width in enumerate(widths):
        if width > LANES:
            raise ValueError(f"a block of {width} lanes does not fit into {LANES}")
        for g, left in enumerate(room):
            if width <= left:
                groups[g].append(index)
                room[g] -= width
                break
        else:
            groups.append([index])
            room.append(LANES - width)
    return groups
