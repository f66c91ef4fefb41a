"""The compiled chain: leg parameters in, trajectories out, sixteen lanes at a time."""

from __future__ import annotations

import importlib.util
import sys
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numba.core.types import WrapperAddressProtocol

from synth.arrays import Array
from synth.compiling import code_cache
from synth.swing import chain_source
from synth.swing.effects import Effect, effect_named, registered
from synth.swing.known_torque import KnownTorque, delayed, for_integrator
from synth.swing.lane_layout import DRIVE, LANES, MOST_MEMORIES, WORKING, LaneLaw, Layout
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg, Tip
from synth.swing.time_unit import time_exponent

MAX_STEPS = 20_000  # of one trajectory; beyond this it is nan. Three links take about 140 a second
FIRST_STEP = 1e-3  # s
PLAIN = ("chain", "plain")  # the modules that springs, linear dampers and gravity need
# Modules that the compiled integrator inlines: a change of one compiles it anew.
CALLED = ("synth.swing.lane_layout", "synth.swing.turning_events", "synth.swing.effects.inlined")
# Power of time in the unit of what is not an effect's; all else has none.
IN_TIME = {
    "rate": -1, "spring_rate": -2, "damper_rate": -1, "gravity": -2, "weight": -2, "curve_speed": -1,
    "curve_slope": -1, "torque_offset": -2, "torque_delay": 1,
}  # fmt: skip
BEND_TOLERANCE = 1e3  # a bristle's bend, of one at most, may be wrong by a thousand times as much as an angle


@dataclass(frozen=True)
class Conditions:
    """What one trial does to the leg: joints locked where they start, a mass at the tip, the base tilted further."""

    locked: tuple[int, ...] = ()
    tip_mass: float = 0.0  # kg
    tilt: float = 0.0  # rad, added to the leg's own
    tip_inertia: float = 0.0  # kg m^2, of what is added about its own centre
    tip_at: float | None = None  # m from the last joint along its link; None: at the link's end

    @property
    def tip(self) -> Tip:
        """What is added to the last link."""
        return Tip(self.tip_mass, self.tip_inertia, self.tip_at)


class Compiled(WrapperAddressProtocol):
    """A compiled function as an argument of another; numba would look a plain one's address up at every call."""

    def __init__(self, function: Any) -> None:
        self._function = function  # keeps the code alive
        self._signature = function.nopython_signatures[0]
        compiled = function.get_compile_result(self._signature)
        self._address = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_cfunc_wrapper_name)

    def __wrapper_address__(self) -> int:
        """Where the code lies."""
        return int(self._address)

    def signature(self) -> Any:
        """What it takes and gives."""
        return self._signature


@dataclass(frozen=True)
class Chain:
    """The compiled functions for one number of links; obtain it from ``compiled_chain``.

    Each is loaded, or compiled, where it is first asked for: a leg without effects needs but two of them.
    """

    layout: Layout
    effects: tuple[Effect, ...]  # those with a torque, in the order of ``layout.laws``
    sources: Mapping[str, Source]

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
        """Joint accelerations, and forces that the hinges carry."""
        return self.sources["bearing"].load().bearing_forces

    @cached_property
    def again(self) -> Any:
        """Joint accelerations where ``bearing_forces`` has been, for other extra torques."""
        return self.sources["bearing"].load().again

    @cached_property
    def integrate(self) -> Any:
        """The integrator, with all that effects and known torques need."""
        return self.sources["integrator"].load().integrate

    @cached_property
    def integrate_plain(self) -> Any:
        """The integrator for springs, linear dampers and gravity alone."""
        return self.sources["plain"].load().integrate

    def __reduce__(self) -> tuple[Any, ...]:
        """A result that holds a chain is kept without its machine code, which is found again where it is read."""
        return compiled_chain, (self.layout.n,)

    def parameters(self, leg: Leg, conditions: Conditions = Conditions()) -> Array:
        """(n_row,) one lane of the workspace for this leg under these conditions, state rows zero."""
        return self.lanes(LegLanes.of(leg), conditions)[:, 0]

    def lanes(self, legs: LegLanes, conditions: Conditions = Conditions()) -> Array:
        """(n_row, n_lane) lanes for columns of legs; ``conditions.locked`` counts in the leg's own joints."""
        locked = tuple(legs.own[j] for j in conditions.locked)
        return legs.write(self.layout, locked, conditions.tip, conditions.tilt, self._off)

    def load(self, *, plain: bool = False) -> None:
        """Load, or compile, everything now, or all that a leg without effects needs (``plain``).

        Where several modules are to be compiled the integrator, half of the work, is compiled by a process of its own.
        """
        wanted = [self.sources[name] for name in (PLAIN if plain else self.sources)]
        missing = [source for source in wanted if not source.on_disk]
        aside = self.sources["integrator"]
        helper = code_cache.compile_aside(*aside.parts) if aside in missing and len(missing) > 1 else None
        for source in wanted:
            if source is aside and helper is not None:
                helper.wait()  # if it fails, compiled here after all
            source.load()

    @cached_property
    def _whole(self) -> tuple[Any, ...]:
        called = (self.right_hand_side, self.extra_torques, self.bearing_forces, self.again)
        return _entry(self.integrate), *(Compiled(function) for function in called)

    @cached_property
    def _plain(self) -> tuple[Any, ...]:
        return _entry(self.integrate_plain), Compiled(self.right_hand_side), 0, 0, 0

    @cached_property
    def _off(self) -> Array:
        """(n_row,) a lane in which every effect is off and all else zero."""
        column = np.zeros(self.layout.n_row)
        for effect in self.effects:
            for p, parameter in enumerate(effect.parameters):
                column[self.layout.parameter_rows(effect.name, p)] = parameter.off
        return column

    @cached_property
    def _needs_load(self) -> dict[int, np.ndarray[Any, Any]]:
        """Index of each effect that uses the bearing force -> rows that make it do so where they are not zero."""
        layout, found = self.layout, {}
        for index, effect in enumerate(self.effects):
            if effect.uses_load:
                names = effect.by_load or effect.strengths
                blocks = [layout.parameter_rows(effect.name, effect.index(name)) for name in names]
                found[index] = np.concatenate([np.arange(layout.n_row)[block] for block in blocks])
        return found

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

    def _own_effect(self, lanes: Array) -> bool:
        """Whether an effect that is not of this package acts in some lane."""
        switched = self.active(lanes)[1, 1:]
        return any(on and not e.module.startswith("synth.") for e, on in zip(self.effects, switched, strict=True))

    @cached_property
    def _drive_rows(self) -> list[int]:
        """Rows of what is wrong with a known torque."""
        rows = range(self.layout.n_row)
        return [row for block in DRIVE for row in rows[self.layout.rows(block)]]

    def _late(self, known: KnownTorque, workspace: Array) -> KnownTorque:
        """The known torque as the first lane has it; the others' delays are from then on what they differ by."""
        offset, delay = (workspace[self.layout.rows(block)] for block in DRIVE[1:])
        offset[~np.any(known[1] != 0.0, axis=0)] = 0.0  # in place: these are rows of the workspace
        first = delay[:, 0].copy()
        delay -= first[:, None]
        return delayed(known, first) if np.any(first) else known

    @cached_property
    def _switches(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """Rows that switch a torque on when they are not zero, curves' and each effect's, and where each begins."""
        layout = self.layout
        groups = [list(range(layout.n_row)[layout.rows("curve_slope")])]
        for effect in self.effects:
            blocks = [layout.parameter_rows(effect.name, effect.index(name)) for name in effect.strengths]
            groups.append([row for block in blocks for row in range(layout.n_row)[block]])
        starts = np.cumsum([0, *[len(group) for group in groups[:-1]]])
        return np.array([row for group in groups for row in group]), starts

    def active(self, lanes: Array) -> np.ndarray[Any, np.dtype[np.int64]]:
        """(2, 1 + n_law) which extra torques any column of ``lanes`` (n_row, n_lane) switches on, as ``integrate``."""
        rows, starts = self._switches
        switches = np.logical_or.reduceat(np.any(lanes[rows] != 0.0, axis=1), starts)
        both = np.array([switches, switches], dtype=np.int64)
        for index, rows in self._needs_load.items():
            if both[1, 1 + index] and np.any(lanes[rows]):
                both[0, 1 + index] = 0
        return both

    def _states(self, active: np.ndarray[Any, np.dtype[np.int64]], workspace: Array) -> tuple[Any, ...]:
        """Rows of state and derivative, tolerance factors and events; puts memories that are on to their start.

        A memory takes part at those joints alone where its effect is on in some lane: a bristle turning over at a joint
        without friction would cost steps all the same.
        """
        layout, on = self.layout, []
        if not any(switch and effect.memory for effect, switch in zip(self.effects, active[1, 1:], strict=True)):
            return self._rows([])
        for effect, switch in zip(self.effects, active[1, 1:], strict=True):
            if not (switch and effect.memory):
                continue
            deflection = workspace[layout.rows("rotation")] - workspace[layout.rows("rest")]
            values = [workspace[layout.parameter_rows(effect.name, p)] for p in range(len(effect.parameters))]
            workspace[layout.rows(f"{effect.name} memory")] = effect.function("start")(deflection, *values)
            strengths = [values[effect.index(name)] for name in effect.strengths]
            on += [(effect.name, int(j)) for j in np.flatnonzero(np.any(np.array(strengths) != 0.0, axis=(0, 2)))]
        return self._rows(on)

    @cached_property
    def _made(self) -> dict[tuple[tuple[str, int], ...], tuple[Any, ...]]:
        """What ``_rows`` has made: the same few memories are on time and again."""
        return {}

    def _rows(self, on: Sequence[tuple[str, int]]) -> tuple[Any, ...]:
        """What ``_states`` gives, for these memories (effect, joint)."""
        key = tuple(on)
        if key not in self._made:
            self._made[key] = self._newly(on)
        return self._made[key]

    def _newly(self, on: Sequence[tuple[str, int]]) -> tuple[Any, ...]:
        layout = self.layout
        if len(on) > MOST_MEMORIES:
            raise ValueError(f"{len(on)} memories of effects at once; the integrator has room for {MOST_MEMORIES}")
        state, derivative = layout.states(on)
        factors = np.ones(len(state))
        factors[2 * layout.n :] = [BEND_TOLERANCE if effect_named(name).bristle else 1.0 for name, _ in on]
        bends, plays = (np.full((len(state), width), -1, dtype=np.int64) for width in (2, 3))
        for index, (name, joint) in enumerate(on, start=2 * layout.n):
            effect = effect_named(name)
            if effect.bristle:
                give = layout.parameter_rows(name, effect.index(effect.bristle)).start
                bends[index] = layout.n + joint, give + joint
            elif effect.play:
                gap = layout.parameter_rows(name, effect.index(effect.play)).start
                plays[index] = joint, gap + joint, layout.row("rest", joint)
        rows = np.array(state, dtype=np.uint64), np.array(derivative, dtype=np.uint64)
        return *rows, factors, bends, plays

    def run(
        self,
        lanes: Array,
        times: Array,
        tolerance: float = 1e-6,
        *,
        rates: bool = False,
        known_torque: tuple[Array, Array] | None = None,
        max_steps: int = MAX_STEPS,
        unit: float = 1.0,
    ) -> Array:
        """Integrate any number of lanes over the same sample times.

        Parameters
        ----------
        lanes : (n_row, n_lane), from ``parameters`` with rows ``rotation`` and ``rate`` holding the initial state.
            Each group of 16 shares its steps: put a nominal lane and its perturbed copies in one group.
        times : (n_time,) s, increasing.
        tolerance : relative and absolute (rad, rad/s) error a step.
        known_torque : times (m,) s and torques on q (m, n) N m, which each lane's drive rows change: gain, offset, and
            delay. An offset acts where the torque is not zero throughout: else the joint has none.
        unit : s, in which time is counted inside, see ``time_unit``; 1 all the same where a user's own effect acts,
            whose torque may hold numbers with a unit.

        Returns
        -------
        (n_time, n, n_lane) rad, or with ``rates`` (n_time, 2 n, n_lane); nan after the time at which a group gave up
        because it diverged or needed more than ``max_steps``.
        """
        n, n_lane = self.layout.n, lanes.shape[1]
        if unit != 1.0 and not self._own_effect(lanes):
            slow = lanes * unit ** -self._time_exponents[:, None]
            driven = None if known_torque is None else (known_torque[0] / unit, known_torque[1] * unit**2)
            found = self.run(slow, times / unit, tolerance, rates=rates, known_torque=driven, max_steps=max_steps)
            if rates:
                found[:, n:] /= unit
            return found
        wrong = known_torque is not None and bool(np.any(lanes[self._drive_rows]))
        known = for_integrator(known_torque, n)
        times = np.ascontiguousarray(times, dtype=float)
        limits, steps = (tolerance, tolerance, FIRST_STEP), max_steps + 2 * len(known[0])  # it may end at every knot
        shown, width = 2 * n if rates else n, -(-n_lane // LANES) * LANES
        result = np.empty((len(times), shown, width))
        out = result.reshape(-1)
        active = self.active(lanes)
        integrate, *functions = self._whole if active.any() or len(known[0]) else self._plain
        workspace = np.empty((self.layout.n_row, LANES))
        flat, room = workspace.reshape(-1), np.empty(WORKING)
        for first in range(0, n_lane, LANES):
            group = lanes[:, first : first + LANES]
            workspace[:, : group.shape[1]] = group
            workspace[:, group.shape[1] :] = group[:, :1]
            if wrong and known_torque is not None:
                known = for_integrator(self._late(known_torque, workspace), n)
            states = self._states(active, workspace)
            integrate(
                *functions, workspace, flat, n, states, active, known, times, limits, steps, out,
                (shown, width, first), room,
            )  # fmt: skip
        return result[:, :, :n_lane]


@dataclass(frozen=True)
class Source:
    """A module to compile: its name, its text and the files that it depends on."""

    name: str
    text: str
    depends_on: tuple[Path, ...]

    @property
    def parts(self) -> tuple[str, str, tuple[Path, ...]]:
        """Name, text and files, as ``generate`` takes them."""
        return self.name, self.text, self.depends_on

    def load(self) -> ModuleType:
        """Import it, compiled anew only where that is not on disk."""
        return code_cache.load(*self.parts)

    @property
    def on_disk(self) -> bool:
        """Whether it is compiled."""
        return code_cache.on_disk(*self.parts)


def _entry(integrate: Any) -> Any:
    """The one compiled form of an integrator: to ask numba each time which would do costs as much as ten steps.

    It takes what it is given for what it was compiled for: arrays must be contiguous and of the right type.
    """
    return integrate.get_compile_result(integrate.nopython_signatures[0]).entry_point


def _file_of(module: str) -> Path:
    loaded = getattr(sys.modules.get(module), "__file__", None)
    if loaded:
        return Path(loaded)
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        raise ImportError(f"no source file for {module}")
    return Path(spec.origin)


def compiled_chain(n: int) -> Chain:
    """The compiled chain of ``n`` links. What is used for the first time on a machine compiles, then it is on disk."""
    with _loading:
        effects = _torque_effects()
        key = (n, *map(id, effects))  # an effect loaded again from its file is another one; a chain keeps its own alive
        if key not in _chains:
            _chains[key] = _chain_of(n, effects)
        return _chains[key]


_chains: dict[tuple[int, ...], Chain] = {}
_loading = threading.RLock()  # a module that another thread is still running has no functions yet


def is_compiled(n: int, *, plain: bool = False) -> bool:
    """Whether ``compiled_chain(n)`` finds everything on disk, or all that a leg without effects needs (``plain``)."""
    sources = compiled_chain(n).sources
    return all(sources[name].on_disk for name in (PLAIN if plain else sources))


def _torque_effects() -> tuple[Effect, ...]:
    return tuple(effect for effect in registered() if effect.way == "torque")


def _chain_of(n: int, effects: tuple[Effect, ...]) -> Chain:
    """The chain with the text of each module that it may need."""
    layout = Layout(n, tuple(LaneLaw(effect.name, len(effect.parameters), effect.memory) for effect in effects))
    imports = {effect.name: effect.module for effect in effects}
    modules = ("synth.compiling.trigonometry", "synth.swing.effects.inlined", *imports.values())
    files = tuple(_file_of(module) for module in modules)
    integrator = _file_of("synth.swing.chain_integrator").read_text(encoding="utf-8")
    plain = integrator.replace("\nWHOLE = True\n", "\nWHOLE = False\n")
    called = tuple(map(_file_of, CALLED))
    sources = {
        "chain": Source(f"chain{n}", chain_source.right_hand_side(layout), files[:1]),
        "plain": Source("plain", plain, called[:1]),
        "torques": Source("torques", chain_source.extra_torques(layout, imports), files),
        "bearing": Source(f"bearing{n}", chain_source.bearing_forces(layout), files[:1]),
        "integrator": Source("integrator", integrator, called),
    }
    return Chain(layout, effects, sources)


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
    motion = chain.run(lanes, times, tolerance, rates=rates, known_torque=known_torque)[:, :, 0]
    motion = motion[:, [*own, *[legs.n + j for j in own]] if rates else own]
    if not np.all(np.isfinite(motion)):
        raise ArithmeticError(f"the motion of {leg.name!r} diverged or is too stiff to follow")
    return motion
