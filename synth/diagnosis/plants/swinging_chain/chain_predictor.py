"""Encoder readings of hypothetical legs, from tolerances, effects and initial states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.effect_shape import unknown_slices
from synth.diagnosis.lanes import Block, Hypothesis, PredictorCache
from synth.diagnosis.plants.swinging_chain import lane_packing
from synth.diagnosis.plants.swinging_chain.block_states import (
    departures,
    started_integral_sums,
    starting_links,
    states_of,
)
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.diagnosis.plants.swinging_chain.lane_packing import chain_candidates
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.swing.chain import Chain, compiled_chain
from synth.swing.effects import effect_named
from synth.swing.effects.definition import Effect, Way
from synth.swing.integral_starts import usual_departures
from synth.swing.lane_groups import LaneGroups
from synth.swing.lane_layout import LANES
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg
from synth.swing.readings import control_readings, joint_as_read
from synth.swing.stated_effects import COUNTS, Place, StatedEffect, in_order_of_action, stated_effects
from synth.swing.tolerances import Tolerances

Places = NDArray[np.intp]
_LaneCandidate = tuple[Candidate, Array, Places]  # with its unknowns, or their values, in these lanes
_LaneEffect = tuple[Candidate | StatedEffect, Array, Places]  # with its values in these lanes
TOLERANCE = 1e-6  # of the integrator, rad: a 16-bit encoder resolves 1e-4
MOST_STEPS = 12_000  # of one trajectory before it is aborted


class _AddedLinks(NamedTuple):
    """Links that a structure adds: its ``place``, the legs with them, and the new ``links``."""

    place: Place
    effect: Effect
    legs: LegLanes
    links: range


class _CommonLegs(NamedTuple):
    """Blocks without their states, as all trials of one leg under the same conditions have them.

    ``added`` : links of structures; ``legs``, ``workspace`` (n_row, n_lane) and its ``groups`` include them.
    ``readings`` : errors of the encoders.
    """

    legs: LegLanes
    added: tuple[_AddedLinks, ...]
    readings: tuple[_LaneEffect, ...]
    chain: Chain
    groups: LaneGroups


@dataclass(frozen=True)
class Predictor:
    """Predicts readings of one leg's trials."""

    leg: Leg
    tolerances: Tolerances
    tolerance: float = TOLERANCE
    trial_legs: TrialLegs | None = None  # None: all trials are of ``leg``
    n_lane: ClassVar[int] = LANES

    @property
    def n_tolerance(self) -> int:
        """Number of tolerance unknowns."""
        return self.tolerances.size

    @property
    def open_tolerances(self) -> list[int]:
        """Indices of the tolerance unknowns that are not fixed."""
        return np.flatnonzero(self.tolerances.width.reshape(-1) > 0.0).tolist()

    @property
    def stated_links(self) -> int:
        """Number of links of structures that the legs state, in one leg or another."""
        return sum(self._legs.started.values())

    @property
    def stated_memories(self) -> int:
        """Number of servos with an integral."""
        return len(self._integrals)

    @cached_property
    def _integrals(self) -> dict[int, float]:
        """Joint -> the unit of its servo's initial integral, see ``Block``."""
        return usual_departures(self.leg)

    @cached_property
    def _legs(self) -> TrialLegs:
        """The legs of all trials."""
        return self.trial_legs or TrialLegs(self.leg)

    def coarser(self, tolerance: float) -> Predictor:
        """The same, integrated to another relative tolerance."""
        return replace(self, tolerance=tolerance)

    def groups(self, hypotheses: Sequence[Hypothesis], widths: Sequence[int]) -> list[list[int]]:
        """Indices of blocks that step together: of equal structure, at most sixteen lanes."""
        return lane_packing.groups(hypotheses, widths)

    def runs(self, hypotheses: Sequence[Hypothesis], groups: Sequence[Sequence[int]], least: int) -> list[list[int]]:
        """Indices of groups that one call of ``together`` predicts, see ``lane_packing.runs``."""
        return lane_packing.runs(hypotheses, groups, least)

    def predict(
        self, trials: Sequence[AngleTrial], blocks: Sequence[Block], kept: PredictorCache | None = None
    ) -> list[Array]:
        """(m, n, n_lane) rad in the sense of q for each block; nan if the motion diverged.

        ``trials``, ``kept`` : as in ``LanePredictor``.

        Blocks of equal structure step together as far as sixteen lanes allow; if one makes the others fail
        because it diverges or never stops turning, each is simulated alone.
        """
        result: list[Array | None] = [None] * len(blocks)
        hypotheses, widths = [block.hypothesis for block in blocks], [block.unknowns.shape[1] for block in blocks]
        groups = self.groups(hypotheses, widths)
        for number, run in enumerate(self.runs(hypotheses, groups, 1)):
            own = None if kept is None else kept.setdefault(number, {})
            out, first = self.together(trials, [[blocks[i] for i in groups[g]] for g in run], own), 0
            for i in (i for g in run for i in groups[g]):
                result[i] = out[:, :, first : first + widths[i]]
                first += widths[i]
        return [found for found in result if found is not None]

    def together(
        self, trials: Sequence[AngleTrial], groups: Sequence[Sequence[Block]], kept: PredictorCache | None = None
    ) -> Array:
        """Like ``predict``, for the groups of one of the ``runs``; ``kept`` as in ``LanePredictor``."""
        found, first = self._together(trials, groups, {} if kept is None else kept), 0
        ends = np.cumsum([len(trial.time) for trial in trials])
        for group in groups:
            last = first + sum(block.unknowns.shape[1] for block in group)
            if len(group) > 1:
                for number in np.flatnonzero(~np.isfinite(found[ends - 1, :, first:last]).all(axis=(1, 2))).tolist():
                    alone = [[replace(block, state=block.state[number : number + 1])] for block in group]
                    rows = slice(ends[number] - len(trials[number].time), ends[number])
                    found[rows, :, first:last] = self._together(trials[number : number + 1], alone, {})
            first = last
        return found

    def _together(self, trials: Sequence[AngleTrial], groups: Sequence[Sequence[Block]], kept: PredictorCache) -> Array:
        """Readings (m, n, n_lane) of blocks of equal structures; those of a group share their steps."""
        blocks = [block for group in groups for block in group]
        widths = [block.unknowns.shape[1] for block in blocks]
        n, ends = len(self.leg.joints), np.cumsum([0, *widths])
        between = ends[np.cumsum([len(group) for group in groups[:-1]], dtype=int)]
        recording = trials[0].recording
        common = self._common(trials[0], blocks, between, kept)
        states = states_of(blocks, widths, 2 * n)
        for trial, state in zip(trials, states, strict=True):
            self._hold(trial, common.readings, state)
        if common.added:
            own = self._legs.own_places(recording.leg or self.leg)
            starting = [starting_links(block.hypothesis, self._legs.started, own) for block in blocks]
            below = 2 * n + len(self._integrals)
            added = [departures(blocks, starting, i, below) for i in range(len(trials))]
            each, locked = zip(added, states, strict=True), recording.conditions.locked
            states = np.stack([_initial_motion(common.added, departed, state, locked) for departed, state in each])
        legs, chain = common.legs, common.chain
        joints = list(legs.own)
        if self._integrals:
            states = np.concatenate([states, started_integral_sums(blocks, widths, self._integrals, legs)], axis=1)
        known, signals = recording.known_torque, recording.signals
        if known is not None and legs.n > n:
            wide = np.zeros((len(known[0]), legs.n))
            wide[:, joints] = known[1]
            known = (known[0], wide)
        if signals is not None and legs.n > n:
            signals = signals.widened(legs.n, joints)
        first = np.cumsum([0, *[len(trial.time) for trial in trials]]).tolist()
        out = chain.run(
            common.groups.starting(states, first[:-1]),
            np.concatenate([trial.time + (trial.begin - trials[0].begin) for trial in trials]),
            max([self.tolerance, *(added.effect.tolerance for added in common.added)]),
            rates=bool(common.readings),
            known_torque=known,
            signals=signals,
            max_steps=MOST_STEPS,
            unit=trials[0].time_unit,
        )
        found = legs.as_read(out[:, : legs.n])
        if common.readings:
            turning = legs.as_read(out[:, legs.n :])
            for trial, begin, end in zip(trials, first[:-1], first[1:], strict=True):
                for j in sorted({effect.joint for effect, _, _ in common.readings}):
                    now = turning[begin:end, j]
                    found[begin:end, j] = self._as_read(common.readings, j, trial.time, found[begin:end, j], now)
        return found

    def _common(self, trial: AngleTrial, blocks: Sequence[Block], between: Places, kept: PredictorCache) -> _CommonLegs:
        """What trials of one leg under the same conditions have in common; it is looked up in ``kept``.

        Two threads may both make it: they make the same.
        """
        key = id(trial.recording.leg), trial.recording.conditions
        if key not in kept:
            legs = self._designed_of(trial.recording.leg or self.leg).repeated(sum(b.unknowns.shape[1] for b in blocks))
            self.tolerances.apply(legs, np.concatenate([b.unknowns[: self.tolerances.size] for b in blocks], axis=1))
            pending: list[_LaneEffect] = []
            readings: list[_LaneEffect] = []
            stated = trial.recording.leg or self.leg
            own = self._legs.own_places(stated)
            acting = [item for item in self._gathered(blocks) if own.isdisjoint(item[0].places)]
            for candidate, x, lanes in acting:
                way = candidate.effect.way
                if way == "torque":
                    _switch_effect_on(legs, candidate, candidate.in_rotation(x), lanes)
                elif way in ("leg", "drive"):
                    _change_numbers(legs, candidate, candidate.values(x), lanes)
                elif way == "reading":
                    readings.append((candidate, candidate.values(x), lanes))
                elif not candidate.is_absent:
                    pending.append((candidate, candidate.values(x), lanes))
            pending += _stated_beside(stated, "structure", acting, legs.n_lane)
            readings += _stated_beside(stated, "reading", acting, legs.n_lane)
            readings.sort(key=lambda item: in_order_of_action(item[0].effect))
            control_readings(legs.controlled, stated, readings)
            added = _extend_chain(legs, pending)
            legs = added[-1].legs if added else legs
            chain = compiled_chain(legs.n)
            groups = chain.acting.groups(chain.lanes(legs, trial.recording.conditions), between)
            kept[key] = _CommonLegs(legs, added, tuple(readings), chain, groups)
        found: _CommonLegs = kept[key]
        return found

    def _hold(self, trial: AngleTrial, readings: Sequence[_LaneEffect], state: Array) -> None:
        """Set the joints that were locked at the trial's reading in ``state`` (2 n, n_lane)."""
        n = len(state) // 2
        for j in trial.recording.conditions.locked:
            read = trial.recording.rotation[0, j]
            held = np.full(state.shape[1], read)
            still, time = np.zeros((2, len(held))), np.array([0.0, 1.0])  # s, any two: a held joint is read alike
            for _ in range(3 if any(effect.joint == j for effect, _, _ in readings) else 0):
                held += read - self._as_read(readings, j, time, np.tile(held, (2, 1)), still)[0]
            state[j], state[n + j] = held, 0.0

    @cached_property
    def _designed(self) -> dict[int, tuple[Leg, LegLanes]]:
        """The cached result of ``_designed_of``."""
        return {}

    def _designed_of(self, leg: Leg) -> LegLanes:
        """The designed leg without the structures and errors of readings that it states."""
        if id(leg) not in self._designed:
            self._designed[id(leg)] = leg, LegLanes.of(leg)
        return self._designed[id(leg)][1]

    def _gathered(self, blocks: Sequence[Block]) -> list[_LaneCandidate]:
        """Each candidate once, with its unknowns (size, n_lane) in all of its lanes.

        Once for each of its positions in a hypothesis, in that order: a reading is shifted, then scaled.
        """
        found: dict[tuple[int, int], tuple[Candidate, list[Array], list[Places]]] = {}
        first = 0
        for block in blocks:
            lanes = np.arange(first, first + block.unknowns.shape[1])
            first += len(lanes)
            for place, (candidate, x) in enumerate(_candidate_unknowns(block, self.tolerances.size)):
                _, unknowns, places = found.setdefault((place, id(candidate)), (candidate, [], []))
                unknowns.append(x)
                places.append(lanes)
        ordered = [found[key] for key in sorted(found, key=lambda key: key[0])]
        return [(c, np.concatenate(x, axis=1), np.concatenate(lanes)) for c, x, lanes in ordered]

    def _as_read(
        self,
        readings: Sequence[_LaneEffect],
        joint: int,
        time: Array,
        rotation: Array,
        rate: Array,
    ) -> Array:
        """One joint's rotation (m, n_lane) at ``time`` (m,) s as read by its encoder."""
        return joint_as_read(readings, joint, self.leg.joints[joint], time, rotation, rate)


def _candidate_unknowns(block: Block, first: int) -> list[tuple[Candidate, Array]]:
    """Each candidate with its unknowns (size, n_lane)."""
    places = unknown_slices(block.hypothesis, first)
    return [(c, block.unknowns[place]) for c, place in zip(chain_candidates(block.hypothesis), places, strict=True)]


def _switch_effect_on(legs: LegLanes, candidate: Candidate, values: Array, lanes: Places) -> None:
    """Switch a torque effect on in some of the lanes, and off the stated ones of which it takes the place."""
    name = candidate.effect.name
    if name not in legs.torques:
        off = np.array([parameter.off for parameter in candidate.effect.parameters])
        legs.torques[name] = np.tile(off[:, None, None], (1, legs.n, legs.n_lane))
    legs.torques[name][:, candidate.joint, lanes] = values
    for other in candidate.replaced:
        off = np.array([parameter.off for parameter in effect_named(other).parameters])
        if other in legs.torques:
            legs.torques[other][:, candidate.joint, lanes] = off[:, None]


def _change_numbers(legs: LegLanes, candidate: Candidate, values: Array, lanes: Places) -> None:
    """Change the leg's numbers in some of the lanes only."""
    wide = np.zeros((len(values), legs.n_lane))
    wide[:, lanes] = values
    candidate.effect.function()(legs, candidate.joint, candidate.leg.joints[candidate.joint].sign, *wide)


def _stated_beside(leg: Leg, way: Way, causes: Sequence[_LaneCandidate], n_lane: int) -> list[_LaneEffect]:
    """The effects of one way that a leg states, in the lanes where no candidate replaces them."""
    found: list[_LaneEffect] = []
    for stated in stated_effects(leg, way):
        replaced = [lanes for each, _, lanes in causes if each.place == stated.place]
        lanes = np.setdiff1d(np.arange(n_lane), np.concatenate([*replaced, np.zeros(0, dtype=np.intp)]))
        if len(lanes) and stated.effect.name != COUNTS:
            found.append((stated, np.repeat(np.array(stated.values)[:, None], len(lanes), axis=1), lanes))
    return found


def _extend_chain(legs: LegLanes, pending: Sequence[_LaneEffect]) -> tuple[_AddedLinks, ...]:
    """The chain with the links of one structure after the other, each of them in all lanes."""
    added = []
    effects = {item[0].place: item[0].effect for item in pending}
    for place, effect in sorted(effects.items(), key=lambda item: (in_order_of_action(item[1]), item[0][1])):
        wide = np.empty((len(effect.parameters), legs.n_lane))
        for each, values, lanes in pending:
            if each.place == place:
                wide[:, lanes] = values
        made = effect.function()(legs, legs.own[place[1]], *wide)
        added.append(_AddedLinks(place, effect, made, range(made.newest, made.newest + made.n - legs.n)))
        legs = made
    return tuple(added)


def _initial_motion(
    added: Sequence[_AddedLinks], departures: Mapping[Place, Array], state: Array, locked: tuple[int, ...]
) -> Array:
    """Initial rotations and rates (2 n_link, n_lane) with those of the added links; held without ``departures``."""
    rotation, rates = np.split(state, 2)
    for place, effect, legs, links in added:
        rotation = legs.started(effect, place[1], rotation, locked)
        rates = np.insert(rates, [links.start] * len(links), 0.0, axis=0)
        held, at = rotation.copy(), legs.own[place[1]]
        for k, link in enumerate(links if place in departures else ()):
            far, fast = legs.initial_deviation(effect, link, at, held)
            for motion, most, share in ((rotation, far, 2 * k), (rates, fast, 2 * k + 1)):
                off = most * departures[place][share]
                motion[link] += off
                if link == at + 1:
                    motion[at] -= legs.read_beyond[at] * off  # what the encoder reads stays
    return np.concatenate([rotation, rates])
