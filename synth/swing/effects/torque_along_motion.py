"""Torque of an effect along a given motion, measured or simulated, for figures and linear fits.

The chain's own compiled torque is evaluated for sixteen columns at a time, so figures show exactly what is simulated.
A memory is integrated along the motion (midpoint rule, inputs linear between samples) in steps of at most
``LONGEST_STEP``, half of the stability limit of the fastest memory, the output side of a backlash. Dry friction starts
as sliding. At a reversal its bristle reverses over the presliding, not at once as in the simulation, so that noise in a
joint at rest does not flip its sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.compiling import code_cache
from synth.swing.chain import compiled_chain
from synth.swing.chain_source import forces_of
from synth.swing.effects.definition import Effect
from synth.swing.lane_layout import FIRST_LAW, LANES

LONGEST_STEP = 2.5e-4  # s: memories of effects follow their motion between samples
GIVEN = -1  # value of the damper curves' switch: the damper's torque is given
_INPUTS = ("rotation", "rate", "rest", "spring_rate", "damper_rate", "damper_torque")  # then the force


@dataclass(frozen=True, eq=False)
class AlongMotion:
    """A motion of a joint with the other inputs of a torque effect.

    ``time`` (n_time,) s, increasing. ``rotation``, ``rate``, ``deflection`` (n_time,) or (n_time, n_column) rad and
    rad/s; ``deflection`` is the rotation minus the spring's rest. Scalars or arrays that broadcast with them:
    ``spring_rate`` N m/rad; ``damper_rate`` N m s/rad; ``damper_torque`` N m, which resists positive rates
    (``damper_rate * rate`` without a curve); ``force`` N of the bearing, or N m of the drive on q for an effect that
    ``uses_drive``.
    """

    time: Array
    rotation: Array
    rate: Array
    deflection: Array
    spring_rate: Array | float
    damper_rate: Array | float
    damper_torque: Array | float
    force: Array | float

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the torque along the motion."""
        return np.broadcast_shapes(np.shape(self.rotation), np.shape(self.rate), np.shape(self.deflection))

    def columns(self) -> list[Array]:
        """Each of ``_INPUTS`` and the force as (n_time, n_column)."""
        given = (
            self.rotation, self.rate, np.asarray(self.rotation) - self.deflection, self.spring_rate, self.damper_rate,
            self.damper_torque, self.force,
        )  # fmt: skip
        flat = (np.broadcast_to(np.asarray(value, dtype=float), self.shape) for value in given)
        return [each.reshape(len(self.time), -1) for each in flat]


def torque_along(effect: Effect, motion: AlongMotion, parameters: Array | Sequence[float]) -> Array:
    """Torque on q, N m, of a torque effect along the motion, in the motion's shape.

    ``parameters`` : (n_parameter,) or (n_parameter, n_column) in the order of ``effect.parameters``, in the sense of q.

    Raises
    ------
    ValueError : the effect is not a torque.
    """
    if effect.way != "torque":
        raise ValueError(f"{effect.name} is not a torque effect")
    columns = motion.columns()
    n_column = columns[0].shape[1]
    values = np.broadcast_to(
        np.asarray(parameters, dtype=float).reshape(len(effect.parameters), -1).T, (n_column, len(effect.parameters))
    )
    result = np.empty((len(motion.time), n_column))
    for first in range(0, n_column, LANES):
        part = slice(first, first + LANES)
        inputs = np.stack([column[:, part] for column in columns], axis=1)
        width = inputs.shape[2]
        padded = np.pad(inputs, ((0, 0), (0, 0), (0, LANES - width)), mode="edge")
        lanes = np.pad(values[part].T, ((0, 0), (0, LANES - width)), mode="edge")
        result[:, part] = _along(effect, np.ascontiguousarray(motion.time, dtype=float), padded, lanes)[:, :width]
    return result.reshape(motion.shape)


def _along(effect: Effect, time: Array, inputs: Array, parameters: Array) -> Array:
    """Torque (n_time, 16) for inputs (n_time, 7, 16) in the order of ``_INPUTS`` and parameters (n_parameter, 16)."""
    chain = compiled_chain(1)
    layout = chain.layout
    workspace = np.zeros((layout.n_row, LANES))
    for p, values in enumerate(parameters):
        workspace[layout.parameter_rows(effect.name, p)] = values
    active = np.zeros(FIRST_LAW + len(layout.laws), dtype=np.int64)
    active[0] = GIVEN
    active[FIRST_LAW + [law.name for law in layout.laws].index(effect.name)] = 1
    memory, change, steps = -1, -1, np.zeros(len(time), dtype=np.int64)
    if effect.memory:
        memory, change = layout.row(f"{effect.name} memory"), layout.row(f"{effect.name} memory rate")
        steps[1:] = np.ceil(np.diff(time) / LONGEST_STEP)
        workspace[memory] = effect.function("start")(inputs[0, 0] - inputs[0, 2], *parameters)
        if effect.bristle and len(time) > 1:
            workspace[memory] = np.sign(inputs[1, 0] - inputs[0, 0])
    force = forces_of(next(law for law in layout.laws if law.name == effect.name))[1]
    rows = np.array([layout.row(block) for block in (*_INPUTS, force)])
    torque = np.empty((len(time), LANES))
    bound = 1.0 if effect.bristle else 1e300
    gap = layout.parameter_rows(effect.name, effect.index(effect.play)).start if effect.play else -1
    _loop()(
        chain.extra_torques, workspace, workspace.reshape(-1), active, rows, layout.row("extra_torque"),
        memory, change, bound, gap, np.ascontiguousarray(time), np.ascontiguousarray(inputs), steps, torque,
    )  # fmt: skip
    return torque


def _loop() -> Any:
    source = Path(__file__).with_name("torque_along_motion_loop.py")
    return code_cache.load("along", source.read_text(encoding="utf-8")).along
