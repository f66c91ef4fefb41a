"""The compiled chain: leg parameters in, trajectories out, sixteen lanes at a time."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.compiling import code_cache
from synth.compiling.numba_internals import as_argument, entry_point
from synth.drives.servo import ServoSignals
from synth.swing.active_effects import ActiveEffects
from synth.swing.chain_modules import PLAIN, ModuleText, chain_modules
from synth.swing.effects import Effect, registered
from synth.swing.known_torque import KnownTorque, delayed, for_integrator
from synth.swing.lane_groups import LaneGroups, Switches, write_group
from synth.swing.lane_layout import DRIVE, FIRST_LAW, LANES, WORKING, LaneLaw, Layout
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg, Tip
from synth.swing.stage_rows import SINGLE_ROOM
from synth.swing.time_unit import time_exponent
from synth.units import quantity

MAX_STEPS = 20_000  # of one trajectory, which is nan beyond this; three links need about 140 per second
FIRST_STEP = 1e-3  # s, a thousandth of a period of a limb; the error control corrects it at once
# Power of time in the unit of each block of rows outside the effects; 0 for all other blocks.
IN_TIME = {
    "rate": -1, "spring_rate": -2, "damper_rate": -1, "gravity": -2, "weight": -2, "curve_speed": -1,
    "curve_slope": -1, "torque_offset": -2, "torque_delay": 1, "servo_damping_gain": 1, "servo_strength": -2,
    "servo_back_emf": -1, "servo_torque_limit": -2, "servo_delay": 1, "servo_period": 1, "servo_phase": 1,
    "servo_command_rate": -1, "slew_short": 1, "slew_slope": -1,
    "drive_torque": -2, "unlimited_drive": -2,
}  # fmt: skip


@dataclass(frozen=True)
class Conditions:
    """Conditions of one trial: joints locked at their initial angle, a mass at the tip, an additional base tilt."""

    locked: tuple[int, ...] = ()
    tip_mass: float = 0.0  # kg
    tilt: float = 0.0  # rad, added to the leg's own
    tip_inertia: float = 0.0  # kg m^2, of the added mass about its own centre
    tip_at: float | None = None  # m from the last joint along its link; None: at the link's end

    @property
    def tip(self) -> Tip:
        """The mass added to the last link."""
        return Tip(self.tip_mass, self.tip_inertia, self.tip_at)

    def as_json(self, joints: Sequence[str]) -> dict[str, Any]:
        """The conditions that differ from the leg file's, as part of a result; empty if none do."""
        found: dict[str, Any] = {"locked": [joints[j] for j in self.locked]} if self.locked else {}
        if self.tip_mass:
            found["tip_mass"] = {"mass": quantity(self.tip_mass, "g"), "inertia": quantity(self.tip_inertia, "kg*m^2")}
            if self.tip_at is not None:
                found["tip_mass"]["at"] = quantity(self.tip_at, "mm")
        if self.tilt:
            found["tilt"] = quantity(self.tilt, "deg")
        return found


@dataclass(frozen=True)
class Chain:
    """The compiled functions for one number of links; obtain it from ``compiled_chain``.

    Each function is loaded or compiled at its first use; a leg without effects needs only two of them.
    """

    layout: Layout
    effects: tuple[Effect, ...]  # those with a torque, in the order of ``layout.laws``
    sources: Mapping[str, ModuleText]

    @cached_property
    def right_hand_side(self) -> Any:
        """Joint accelerations."""
        return self.sources["chain"].load().right_hand_side

    @cached_property
    def extra_torques(self) -> Any:
        """Torques of damper curves and effects."""
        return self.sources["torques"].load().extra_torques

    @cached_property
    def bearing_forces(self) -> Any:
        """Joint accelerations, and the bearing forces of the hinges."""
        return self.sources["bearing"].load().bearing_forces

    @cached_property
    def again(self) -> Any:
        """Joint accelerations for other extra torques at the state of the last ``bearing_forces``."""
        return self.sources["bearing"].load().again

    @cached_property
    def integrate(self) -> Any:
        """The integrator with effects and known torques."""
        return self.sources["integrator"].load().integrate

    @cached_property
    def integrate_plain(self) -> Any:
        """The integrator for springs, linear dampers and gravity only."""
        return self.sources["plain"].load().integrate

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle a chain without its machine code, which is loaded again when the chain is unpickled."""
        return compiled_chain, (self.layout.n,)

    def parameters(self, leg: Leg, conditions: Conditions = Conditions()) -> Array:
        """(n_row,) one lane of the workspace for this leg under these conditions, state rows zero."""
        return self.lanes(LegLanes.of(leg), conditions)[:, 0]

    def lanes(self, legs: LegLanes, conditions: Conditions = Conditions()) -> Array:
        """(n_row, n_lane) lanes for columns of legs; ``conditions.locked`` are indices of the leg's own joints."""
        locked = tuple(legs.own[j] for j in conditions.locked)
        return legs.write(self.layout, locked, conditions.tip, conditions.tilt, self._off)

    def load(self, *, plain: bool = False) -> None:
        """Load or compile everything now; with ``plain`` only what a leg without effects needs.

        If several modules must be compiled, a separate process compiles the integrator, which is half of the work.
        """
        wanted = [self.sources[name] for name in (PLAIN if plain else self.sources)]
        missing = [source for source in wanted if not source.on_disk]
        aside = self.sources["integrator"]
        helper = code_cache.compile_aside(*aside.parts) if aside in missing and len(missing) > 1 else None
        for source in wanted:
            if source is aside and helper is not None:
                helper.wait()  # if it fails, the integrator is compiled here
            source.load()

    @cached_property
    def _whole(self) -> tuple[Any, ...]:
        called = (self.right_hand_side, self.extra_torques, self.bearing_forces, self.again)
        return entry_point(self.integrate), *(as_argument(function) for function in called)

    @cached_property
    def _plain(self) -> tuple[Any, ...]:
        return entry_point(self.integrate_plain), as_argument(self.right_hand_side), 0, 0, 0

    @cached_property
    def _rubbing(self) -> tuple[Any, ...]:
        integrate = self.sources["friction"].load().integrate_rubbing
        return entry_point(integrate), *self._whole[1:]

    @cached_property
    def _curves(self) -> tuple[Any, ...]:
        stages = self.sources["stages"].load()
        called = (as_argument(made) for made in (stages.begin, stages.iterate, stages.filter_error))
        rows = self.layout.row("curve_speed"), self.layout.row("curve_slope")
        return entry_point(self.sources["curves"].load().integrate_curves), rows, *called

    def _step_implicitly(
        self,
        flat: Array,
        times: Array,
        tolerance: float,
        steps: int,
        out: Array,
        where: tuple[int, int, int, int],
        room: Array,
    ) -> None:
        """Integrate the lanes in the workspace ``flat`` by ``curve_integrator``."""
        integrate, *functions = self._curves
        single, limits = np.empty(SINGLE_ROOM, dtype=np.float32), (tolerance, tolerance)
        integrate(*functions, flat, self.layout.n, times, limits, steps, out, where, room, single)

    @cached_property
    def _off(self) -> Array:
        """(n_row,) a lane in which every effect is off and everything else zero."""
        column = np.zeros(self.layout.n_row)
        for effect in self.effects:
            for p, parameter in enumerate(effect.parameters):
                column[self.layout.parameter_rows(effect.name, p)] = parameter.off
        return column

    @cached_property
    def acting(self) -> ActiveEffects:
        """Finds the effects that act in given lanes."""
        return ActiveEffects(self.layout, self.effects)

    @cached_property
    def _time_exponents(self) -> Array:
        """(n_row,) power of time in the unit of each row's quantity."""
        found, layout = np.zeros(self.layout.n_row), self.layout
        for block, exponent in IN_TIME.items():
            first, count = layout.blocks[block]
            found[first : first + count] = exponent
        for effect in self.effects:
            for p, parameter in enumerate(effect.parameters):
                found[layout.parameter_rows(effect.name, p)] = time_exponent(parameter.unit)
        return found

    def _in_unit(self, unit: float) -> Array:
        """(n_row * 16,) factors that convert lanes to a unit of time, s; cached, because trials share few units."""
        if unit not in self._factors:
            self._factors[unit] = np.repeat(unit**-self._time_exponents, LANES)
        return self._factors[unit]

    @cached_property
    def _factors(self) -> dict[float, Array]:
        """The results of ``_in_unit``."""
        return {}

    def _delays(self, lanes: Array, held: Sequence[int]) -> int:
        """Largest number of different delays of the held commands in a group of lanes."""
        late = lanes[self.layout.rows("servo_delay")][list(held)]
        return int(sum(min(len(np.unique(row)), LANES) for row in late))

    @cached_property
    def _users_own(self) -> list[int]:
        """Indices of the effects from outside this package among the switches."""
        return [FIRST_LAW + i for i, effect in enumerate(self.effects) if not effect.module.startswith("synth.")]

    def _own_effect(self, switched: Sequence[Switches]) -> bool:
        """Whether an effect from outside this package acts in some lane."""
        return bool(self._users_own) and any(active[1, self._users_own].any() for active in switched)

    @cached_property
    def _drive_rows(self) -> list[int]:
        """Rows of a known torque's errors: gain, offset, delay."""
        rows = range(self.layout.n_row)
        return [row for block in DRIVE for row in rows[self.layout.rows(block)]]

    def _late(self, known: KnownTorque, idle: NDArray[np.bool_], workspace: Array) -> KnownTorque:
        """The known torque with the first lane's delay; the lanes' delay rows become differences from the first.

        ``idle`` (n,) : joints without torque, which are not driven.
        """
        offset, delay = (workspace[self.layout.rows(block)] for block in DRIVE[1:])
        offset[idle] = 0.0  # in place: these are rows of the workspace
        first = delay[:, 0].copy()
        delay -= first[:, None]
        return delayed(known, first) if np.any(first) else known

    def _groups_of(self, lanes: Array) -> LaneGroups:
        """Groups of sixteen lanes each, the last with the rest, with the effects that act in any of them."""
        split = [lanes[:, first : first + LANES] for first in range(0, lanes.shape[1], LANES)]
        return self.acting.together(split, [self.acting.active(lanes)] * len(split))

    def run(
        self,
        lanes: Array | LaneGroups,
        times: Array,
        tolerance: float = 1e-6,
        *,
        rates: bool = False,
        known_torque: tuple[Array, Array] | None = None,
        signals: ServoSignals | None = None,
        max_steps: int = MAX_STEPS,
        unit: float = 1.0,
    ) -> Array:
        """Integrate any number of lanes over the same sample times.

        Parameters
        ----------
        lanes : (n_row, n_lane), from ``parameters`` with rows ``rotation`` and ``rate`` holding the initial state.
            Each group of 16 shares its steps: put a nominal lane and its perturbed copies in one group. Or such groups
            themselves, of which each needs only its own effects.
        times : (n_time,) s, increasing.
        tolerance : relative and absolute (rad, rad/s) error a step.
        known_torque : times (m,) s and torques on q (m, n) N m; each lane's drive rows change their gain, offset and
            delay. The offset applies only to joints whose torque is not zero throughout; the others are not driven.
        signals : servo commands, supplies and switches of ``n`` joints; None if no joint has a servo.
        unit : s, unit of time inside the integrator, see ``time_unit``; 1 if a user's own effect acts, because its
            torque may contain constants in seconds.

        Returns
        -------
        (n_time, n, n_lane) rad, or with ``rates`` (n_time, 2 n, n_lane) rad and rad/s; nan from the time at which a
        group diverges or exceeds ``max_steps``.
        """
        if not isinstance(lanes, LaneGroups):
            lanes = self._groups_of(lanes)
        n, n_lane = self.layout.n, sum(lanes.widths)
        if unit != 1.0 and not self._own_effect(lanes.switched):
            factors = self._in_unit(unit)
            times = times / unit
            known_torque = None if known_torque is None else (known_torque[0] / unit, known_torque[1] * unit**2)
            signals = None if signals is None else replace(signals, time=signals.time / unit)
        else:
            unit, factors = 1.0, None
        wrong = known_torque is not None and any(np.any(group[self._drive_rows]) for group in lanes.lanes)
        samples, changes, held = 0.0, 0, []
        times = np.ascontiguousarray(times, dtype=float)
        if signals is not None:
            periods = np.max([group[self.layout.rows("servo_period")].max(axis=1) for group in lanes.lanes], axis=0)
            held = np.flatnonzero(periods).tolist()
            samples = sum(float(times[-1] - times[0]) * unit / periods[j] for j in held)
        as_given = known, told = for_integrator(known_torque, n, signals, held)
        idle = np.zeros(n, dtype=bool) if known_torque is None else ~np.any(known_torque[1] != 0.0, axis=0)
        if signals is not None:
            changes = len(told[0]) * max(self._delays(group, signals.held) for group in lanes.lanes)
        # Steps may end at knots and do end at control steps.
        limits, steps = (tolerance, tolerance, FIRST_STEP), max_steps + 2 * (len(known[0]) + ceil(samples) + changes)
        shown = 2 * n if rates else n
        result = np.empty((len(times), shown, n_lane))
        room = np.empty(WORKING + self.layout.n_row * LANES)
        flat, out, first = room[WORKING:], result.reshape(-1), 0
        workspace = flat.reshape(self.layout.n_row, LANES)
        each = zip(lanes.lanes, lanes.widths, lanes.switched, lanes.bent, lanes.memories, strict=True)
        for group, width, active, bent, memories in each:
            where, last = (shown, n_lane, first, width), first + width
            write_group(self.layout, flat, group, None if lanes.state is None else lanes.state[:, first:last], factors)
            first = last
            if bent and not len(known[0]) and "curves" in self.sources:
                self._step_implicitly(flat, times, tolerance, steps, out, where, room)
                continue
            states, rest = self.acting.states(active, workspace, memories), (times, limits, steps, out, where)
            if not len(known[0]) and self.acting.rubs(active):
                self._rubbing[0](*self._rubbing[1:], room, n, states, active, *rest)
                continue
            integrate, *functions = self._whole if active.any() or len(known[0]) else self._plain
            if wrong and known_torque is not None:
                late = self._late(known_torque, idle, workspace)
                known, told = as_given if late is known_torque else for_integrator(late, n, signals, held)
            integrate(*functions, room, n, states, active, known, told, *rest)
        if rates and unit != 1.0:
            result[:, n:] /= unit
        return result


def compiled_chain(n: int) -> Chain:
    """The compiled chain of ``n`` links; a function compiles at its first use on a machine and is then on disk."""
    with _loading:
        effects = tuple(effect for effect in registered() if effect.way == "torque")
        key = (n, *map(id, effects))  # a reloaded effect is a new object; a chain keeps its effects alive
        if key not in _chains:
            _chains[key] = _chain_of(n, effects)
        return _chains[key]


_chains: dict[tuple[int, ...], Chain] = {}
_loading = threading.RLock()  # a module that another thread is still executing has no functions yet


def is_compiled(n: int, *, plain: bool = False) -> bool:
    """Whether all functions of ``compiled_chain(n)`` are on disk; ``plain`` : those of a leg without effects."""
    sources = compiled_chain(n).sources
    return all(sources[name].on_disk for name in (PLAIN if plain else sources))


def _chain_of(n: int, effects: tuple[Effect, ...]) -> Chain:
    """The chain with the source text of each of its modules."""
    laws = (LaneLaw(each.name, len(each.parameters), each.memory, each.uses_drive) for each in effects)
    layout = Layout(n, tuple(laws))
    return Chain(layout, effects, chain_modules(layout, effects))


def simulate(
    leg: Leg,
    rotation: Sequence[float] | Array,
    rate: Sequence[float] | Array,
    times: Array,
    conditions: Conditions = Conditions(),
    *,
    tolerance: float = 1e-6,
    rates: bool = False,
    known_torque: tuple[Array, Array] | None = None,
    signals: ServoSignals | None = None,
) -> Array:
    """Motion of one leg from one state: rotations q (n_time, n) rad, or with ``rates`` (n_time, 2 n).

    ``rotation`` (n,) rad and ``rate`` (n,) rad/s at ``times[0]``; locked joints must have zero rate.

    Raises
    ------
    ArithmeticError : the motion diverged or needs more steps than allowed.
    """
    legs, held = LegLanes.held(leg, np.asarray(rotation, dtype=float)[:, None])
    chain = compiled_chain(legs.n)
    lanes = chain.lanes(legs, conditions)
    n, own = len(leg.joints), list(legs.own)
    turning = np.zeros(legs.n)
    turning[own] = [0.0 if j in conditions.locked else value for j, value in enumerate(np.asarray(rate, dtype=float))]
    lanes[chain.layout.rows("rotation")] = held
    lanes[chain.layout.rows("rate")] = turning[:, None]
    if legs.n > n and known_torque is not None:
        wide = np.zeros((len(known_torque[0]), legs.n))
        wide[:, own] = known_torque[1]
        known_torque = (known_torque[0], wide)
    inputs = signals if signals is None or legs.n == n else signals.widened(legs.n, own)
    motion = chain.run(lanes, times, tolerance, rates=rates, known_torque=known_torque, signals=inputs)[:, :, 0]
    motion = motion[:, [*own, *[legs.n + j for j in own]] if rates else own]
    if not np.all(np.isfinite(motion)):
        raise ArithmeticError(f"the motion of {leg.name!r} diverged or is too stiff to follow")
    return motion
