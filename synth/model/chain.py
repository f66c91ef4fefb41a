"""The compiled chain: leg parameters in, trajectories out, sixteen lanes at a time."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from synth.effects import SPECIFICATIONS
from synth.model import generate
from synth.model.curves import compiled_rows
from synth.model.layout import CURVE_POINTS, LANES, Layout
from synth.model.leg import Array, Leg
from synth.model.mechanics import coefficients

MAX_STEPS = 20_000


@dataclass(frozen=True)
class Conditions:
    """What one trial does to the leg: joints locked where they start, a mass at the tip, the base tilted further."""

    locked: tuple[int, ...] = ()
    tip_mass: float = 0.0  # kg
    tilt: float = 0.0  # rad, added to the leg's own


@dataclass(frozen=True)
class Chain:
    """The compiled functions for one number of links; obtain it from ``compiled_chain``."""

    layout: Layout
    right_hand_side: Any
    extra_torques: Any
    integrate: Any

    def parameters(self, leg: Leg, conditions: Conditions = Conditions()) -> Array:
        """(n_row,) one lane of the workspace for this leg under these conditions, state rows zero."""
        layout = self.layout
        lane = np.zeros(layout.n_row)
        found = coefficients(leg, conditions.tip_mass)
        upper = np.triu_indices(layout.n)
        lane[layout.rows("inertia")] = found.inertia[upper]
        lane[layout.rows("gravity")] = found.gravity
        lane[layout.row("tilt")] = leg.tilt + conditions.tilt
        lane[layout.rows("free")] = [0.0 if i in conditions.locked else 1.0 for i in range(layout.n)]
        for i, joint in enumerate(leg.joints):
            if joint.spring is not None:
                lane[layout.row("spring_rate", i)] = joint.spring.rate
                lane[layout.row("rest", i)] = joint.sign * (joint.spring.free_angle - joint.zero)
            if joint.damper is not None and joint.damper.rate is not None:
                lane[layout.row("damper_rate", i)] = joint.damper.rate
            if joint.damper is not None and joint.damper.curve is not None:
                rows = slice(i * CURVE_POINTS, (i + 1) * CURVE_POINTS)
                speed, slope = compiled_rows(joint.damper.curve)
                lane[layout.rows("curve_speed")][rows] = speed
                lane[layout.rows("curve_slope")][rows] = slope
            for effect in SPECIFICATIONS:
                given = joint.effects.get(effect.name)
                for p, parameter in enumerate(effect.parameters):
                    value = (given or {}).get(parameter.name, parameter.default)
                    off = 0.0 if parameter.default is None else parameter.default
                    lane[layout.row(effect.name, p * layout.n + i)] = off if given is None or value is None else value
        return lane

    def active(self, lanes: Array) -> np.ndarray[Any, np.dtype[np.int64]]:
        """(1 + n_effect,) which extra torques any column of ``lanes`` (n_row, n_lane) switches on."""
        layout = self.layout
        switches = [np.any(lanes[layout.rows("curve_slope")] != 0.0)]
        for effect in SPECIFICATIONS:
            first = layout.row(effect.name)
            switches.append(np.any(lanes[first : first + layout.n] != 0.0))
        return np.array(switches, dtype=np.int64)

    def run(
        self,
        lanes: Array,
        times: Array,
        tolerance: float = 1e-6,
        *,
        rates: bool = False,
        known_torque: tuple[Array, Array] | None = None,
        max_steps: int = MAX_STEPS,
    ) -> Array:
        """Integrate any number of lanes over the same sample times.

        Parameters
        ----------
        lanes : (n_row, n_lane), from ``parameters`` with rows ``rotation`` and ``rate`` holding the initial state.
            Each group of 16 shares its steps: put a nominal lane and its perturbed copies in one group.
        times : (n_time,) s, increasing.
        tolerance : relative and absolute (rad, rad/s) error a step.
        known_torque : times (m,) s and torques on q (m, n) N m, the same for every lane.

        Returns
        -------
        (n_time, n, n_lane) rad, or with ``rates`` (n_time, 2 n, n_lane); nan after the time at which a group gave up
        because it diverged or needed more than ``max_steps``.
        """
        n, n_lane = self.layout.n, lanes.shape[1]
        known = known_torque or (np.zeros(0), np.zeros((0, n)))
        times = np.ascontiguousarray(times, dtype=float)
        both = np.array([tolerance, tolerance])
        result = np.empty((len(times), 2 * n if rates else n, n_lane))
        out = np.empty((len(times), result.shape[1], LANES))
        active = self.active(lanes)
        for first in range(0, n_lane, LANES):
            group = lanes[:, first : first + LANES]
            width = group.shape[1]
            workspace = np.empty((self.layout.n_row, LANES))
            workspace[:, :width] = group
            workspace[:, width:] = group[:, :1]
            self.integrate(
                self.right_hand_side, self.extra_torques, workspace, n, active, known, times, both, 1e-3, max_steps, out
            )
            result[:, :, first : first + width] = out[:, :, :width]
        return result


def _file_of(module: str) -> Path:
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        raise ImportError(f"no source file for {module}")
    return Path(spec.origin)


@lru_cache(maxsize=8)
def compiled_chain(n: int) -> Chain:
    """The compiled chain of ``n`` links. The first call on a machine compiles for some seconds, then it is on disk."""
    layout = Layout(n, tuple((effect.name, len(effect.parameters)) for effect in SPECIFICATIONS))
    imports = {effect.name: effect.module for effect in SPECIFICATIONS}
    dependencies = (_file_of("synth.model.trigonometry"), *(_file_of(module) for module in imports.values()))
    chain = generate.load(f"chain{n}", generate.right_hand_side(layout), dependencies[:1])
    extra = generate.load(f"torques{n}", generate.extra_torques(layout, imports), dependencies)
    integrator = importlib.import_module("synth.model.integrator")
    return Chain(layout, chain.right_hand_side, extra.extra_torques, integrator.integrate)


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
    chain = compiled_chain(len(leg.joints))
    lane = chain.parameters(leg, conditions)
    lane[chain.layout.rows("rotation")] = rotation
    lane[chain.layout.rows("rate")] = np.where(lane[chain.layout.rows("free")] == 0.0, 0.0, rate)
    motion = chain.run(lane[:, None], times, tolerance, rates=rates, known_torque=known_torque)[:, :, 0]
    if not np.all(np.isfinite(motion)):
        raise ArithmeticError(f"the motion of {leg.name!r} diverged or is too stiff to follow")
    return motion
