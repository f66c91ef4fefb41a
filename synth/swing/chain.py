"""The compiled chain: leg parameters in, trajectories out, sixteen lanes at a time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.cache import cache_folder
from synth.compiling import code_cache
from synth.compiling.announced import announced
from synth.compiling.numba_internals import as_argument, entry_point
from synth.drives.servo import ServoSignals
from synth.swing.active_effects import ActiveEffects
from synth.swing.chain_modules import LARGEST, LAWS, PLAIN, ModuleText, chain_modules, how_often
from synth.swing.driving_inputs import DrivingInputs
from synth.swing.effects import Effect, registered
from synth.swing.known_torque import HeldCommands, Linear
from synth.swing.lane_groups import LaneGroups
from synth.swing.lane_layout import LANES, WORKING, LaneLaw, Layout
from synth.swing.lane_units import LaneUnits
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg, Tip
from synth.swing.stage_rows import SINGLE_ROOM
from synth.units import quantity

MAX_STEPS = 20_000  # of one trajectory, which is nan beyond this; three links need about 120 per second
# Lanes whose samples are written to an array of their own before they are copied: those of a group lie apart by a row
# of all lanes, and each would be written to another page of memory.
TOGETHER = 64
FIRST_STEP = 1e-3  # s, a thousandth of a period of a limb; the error control corrects it at once


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
    def integrate_smooth(self) -> Any:
        """The integrator for extra torques without memory, known torque or servo."""
        return self.sources["smooth"].load().integrate

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
        """Load or compile everything now; with ``plain`` only what a leg without effects needs."""
        self._load(PLAIN if plain else tuple(self.sources))

    def load_laws(self) -> None:
        """Load what friction, drag and hardening at a joint need; where it must be compiled, that is announced."""
        if all(self.sources[name].on_disk for name in LAWS):
            return
        # Idle, nothing on disk, two links: 31 s of processor; with servos' integrator in place of ``smooth`` 48 s.
        text = "compiling the equations of motion with friction, drag and hardening, which the residuals ask for"
        with announced(f"{text} ({how_often(self.effects)}, 10 to 40 s; stored in {cache_folder()})"):
            self._load(LAWS)

    def _load(self, names: Sequence[str]) -> None:
        """Load or compile these modules.

        If several modules must be compiled, a separate process compiles the largest, which is nearly half of the work.
        """
        wanted = [self.sources[name] for name in names]
        missing = [source for source in wanted if not source.on_disk]
        aside = next((self.sources[name] for name in LARGEST if self.sources[name] in missing), None)
        helper = code_cache.compile_aside(*aside.parts) if aside is not None and len(missing) > 1 else None
        for source in wanted:
            if source is aside and helper is not None:
                helper.wait()  # if it fails, the integrator is compiled here
            source.load()

    @cached_property
    def _called(self) -> tuple[Any, ...]:
        called = (self.right_hand_side, self.extra_torques, self.bearing_forces, self.again)
        return tuple(as_argument(function) for function in called)

    @cached_property
    def _whole(self) -> tuple[Any, ...]:
        return entry_point(self.integrate), *self._called

    @cached_property
    def _smooth(self) -> tuple[Any, ...]:
        called = as_argument(self.right_hand_side), as_argument(self.extra_torques)
        return entry_point(self.integrate_smooth), *called, 0, 0

    @cached_property
    def _plain(self) -> tuple[Any, ...]:
        return entry_point(self.integrate_plain), as_argument(self.right_hand_side), 0, 0, 0

    @cached_property
    def _rubbing(self) -> tuple[Any, ...]:
        integrate = self.sources["friction"].load().integrate_rubbing
        return entry_point(integrate), *self._called  # without the other integrator, the largest to compile

    @cached_property
    def _curves(self) -> tuple[Any, ...]:
        stages = self.sources["stages"].load()
        called = (as_argument(made) for made in (stages.begin, stages.iterate, stages.filter_error))
        rows = self.layout.row("curve_speed"), self.layout.row("curve_slope")
        return entry_point(self.sources["curves"].load().integrate_curves), rows, *called

    def _step_implicitly(
        self,
        room: Array,
        times: Array,
        limits: tuple[float, float, float],
        steps: int,
        out: Array,
        where: tuple[int, int, int, int],
    ) -> None:
        """Integrate the lanes in the workspace by ``curve_integrator``."""
        integrate, *functions = self._curves
        single = np.empty(SINGLE_ROOM, dtype=np.float32)
        integrate(*functions, room[WORKING:], self.layout.n, times, limits[:2], steps, out, where, room, single)

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
    def units(self) -> LaneUnits:
        """Converts lanes to another unit of time."""
        return LaneUnits(self.layout, self.effects)

    def _groups_of(self, lanes: Array) -> LaneGroups:
        """Groups of sixteen lanes each, the last with the rest, with the effects that act in any of them."""
        active = self.acting.active(lanes)
        used = lanes if active.any() else lanes[: self.layout.n_plain]
        full = lanes.shape[1] // LANES
        # Copied at once: a group's rows lie apart by a row of all lanes, so the next group is in the same cache lines.
        split = list(np.ascontiguousarray(used[:, : full * LANES].reshape(len(used), full, LANES).swapaxes(0, 1)))
        split += [used[:, full * LANES :]] if lanes.shape[1] % LANES else []
        return self.acting.together(split, [active] * len(split))

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
        times : (n_time,) s, increasing; those of the motions of ``LaneGroups.starting`` one after the other.
        tolerance : relative and absolute (rad, rad/s) error a step.
        known_torque : times (m,) s and torques on q (m, n) N m; each lane's drive rows change their gain, offset and
            delay. The offset applies only to joints whose torque is not zero throughout; the others are not driven.
            At least two samples; linear between them, constant before the first and after the last.
        signals : servo commands, supplies and switches of ``n`` joints, likewise; None if no joint has a servo.
        unit : s, unit of time inside the integrator, see ``time_unit``; 1 if a user's own effect acts, because its
            torque may contain constants in seconds.

        Returns
        -------
        (n_time, n, n_lane) rad, or with ``rates`` (n_time, 2 n, n_lane) rad and rad/s; nan from the time at which a
        group diverges or exceeds ``max_steps`` to the end of the motion.

        Raises
        ------
        ValueError : fewer than two samples of ``known_torque`` or ``signals``.
        """
        groups = lanes if isinstance(lanes, LaneGroups) else self._groups_of(lanes)
        n, n_lane, length = self.layout.n, sum(groups.widths), float(np.ptp(times))
        factors, times = None, np.ascontiguousarray(times, dtype=float)
        if unit != 1.0 and not self.units.seconds(groups.switched):
            factors, times = self.units.factors(unit), times / unit
            known_torque = None if known_torque is None else (known_torque[0] / unit, known_torque[1] * unit**2)
            signals = None if signals is None else replace(signals, time=signals.time / unit)
        inputs = DrivingInputs.of(self.layout, groups, known_torque, signals, length)
        shown = 2 * n if rates else n
        result = np.empty((len(times), shown, n_lane))
        room = np.empty(WORKING + self.layout.n_row * LANES)
        flat, first = room[WORKING:], 0
        part = result if n_lane <= TOGETHER else np.empty((len(times), shown, TOGETHER))
        out, wide, placed = part.reshape(-1), part.shape[2], 0
        row = shown * wide
        spans = list(zip(groups.begins, [*groups.begins[1:], len(times)], strict=True))
        limits, steps = (tolerance, tolerance, FIRST_STEP), max_steps + inputs.steps
        for index, width in enumerate(groups.widths):
            groups.write(index, flat, factors)
            given = inputs.on(flat.reshape(-1, LANES))
            step = self._stepper(groups, index, given, n)
            own = flat[: groups.lanes[index].size]
            unchanged = own.copy() if len(spans) > 1 else own
            last = first + width
            if last - placed > wide:
                result[:, :, placed:first], placed = part[:, :, : first - placed], first
            where = (shown, wide, first - placed, width)
            for motion, (begin, end) in enumerate(spans):
                if motion:
                    own[:] = unchanged
                groups.start(index, slice(first, last), motion, self.layout, flat, factors)
                step(room, times[begin:end], limits, steps, out[begin * row : end * row], where)
            first = last
        if part is not result:
            result[:, :, placed:] = part[:, :, : n_lane - placed]
        if rates and factors is not None:
            result[:, n:] /= unit
        return result

    def _stepper(
        self, groups: LaneGroups, index: int, given: tuple[Linear, HeldCommands], n: int
    ) -> Callable[..., None]:
        """Integrates a group's lanes, which are in the workspace: the integrator that suits what acts on them."""
        active, memories = groups.switched[index], groups.memories[index]
        known, commands_held = given
        if groups.bent[index] and not len(known[0]) and "curves" in self.sources:
            return self._step_implicitly
        driven = len(known[0]) > 0
        rubbing = not driven and self.acting.rubs(active)
        if rubbing:
            integrate, *called = self._rubbing
        elif driven or memories or self.acting.needs_whole(active):
            integrate, *called = self._whole
        else:
            integrate, *called = self._smooth if active.any() else self._plain
        inputs = () if rubbing else (known, commands_held)

        def step(room: Array, times: Array, *rest: Any) -> None:
            states = self.acting.states(active, room[WORKING:].reshape(-1, LANES), memories, known, times[0])
            integrate(*called, room, n, states, active, *inputs, times, *rest)

        return step


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
    layout = Layout(n, tuple(map(_law_of, effects)))
    return Chain(layout, effects, chain_modules(layout, effects))


def _law_of(effect: Effect) -> LaneLaw:
    part = "" if effect.memory or effect.belongs_to == "joint" else effect.belongs_to
    play = effect.index(effect.play) if effect.play else -1
    return LaneLaw(effect.name, len(effect.parameters), effect.memory, effect.uses_drive, part, play)


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

    ``rotation`` (n,) rad and ``rate`` (n,) rad/s at ``times[0]``; a locked joint's rate is 0, whatever is given. The
    known torque and the signals need at least two samples, between which they are as in ``Chain.run``, and are
    constant before the first and after the last.

    Raises
    ------
    ValueError : a known torque or signals of fewer than two samples.
    ArithmeticError : the motion diverged or needs more steps than allowed.
    """
    legs, held = LegLanes.held(leg, np.asarray(rotation, dtype=float)[:, None], conditions.locked)
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
    out = chain.run(lanes, times, tolerance, rates=rates, known_torque=known_torque, signals=inputs)[:, :, :1]
    read = [legs.as_read(out[:, : legs.n]), *([legs.as_read(out[:, legs.n :])] if rates else [])]
    motion = np.concatenate(read, axis=1)[:, :, 0]
    if not np.all(np.isfinite(motion)):
        raise ArithmeticError(f"the motion of {leg.name!r} diverged or is too stiff to follow")
    return motion
