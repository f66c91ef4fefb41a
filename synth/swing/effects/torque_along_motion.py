"""An effect's torque along a motion that is given, measured or simulated: for figures and for linear fits.

The compiled torque of the chain itself is evaluated, sixteen columns at a time, so that what is drawn is what is
simulated. A memory is integrated along the motion (midpoint rule, inputs linear between samples), in steps of at most
``LONGEST_STEP``: half of what the fastest memory, backlash's output side, needs to be stable. Dry friction begins as if
it had slid, and turns over with its bristle, over the presliding, not at once as in the simulation, so that noise in a
joint at rest does not toss it to and fro.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.compiling import code_cache
from synth.swing.chain import compiled_chain
from synth.swing.effects.definition import Effect
from synth.swing.lane_layout import LANES

LONGEST_STEP = 2.5e-4  # s
GIVEN = -1  # in place of the damper curves' switch: the damper's torque is given
_INPUTS = ("rotation", "rate", "rest", "spring_rate", "damper_rate", "damper_torque", "bearing_force")


def torque_along(
    effect: Effect,
    time: Array,
    rotation: Array,
    rate: Array,
    deflection: Array,
    spring_rate: Array | float,
    damper_rate: Array | float,
    damper_torque: Array | float,
    force: Array | float,
    parameters: Array | Sequence[float],
) -> Array:
    """Torque on q (N m) that a torque effect would exert along a motion.

    Parameters
    ----------
    time : (n_time,) s, increasing.
    rotation, rate, deflection : (n_time,) or (n_time, n_column) rad and rad/s; ``deflection`` is the rotation less the
        spring's rest.
    spring_rate, damper_rate, damper_torque, force : scalars or arrays that broadcast with them: N m/rad, N m s/rad,
        N m against positive rates (``damper_rate * rate`` without a curve), N in the bearing.
    parameters : (n_parameter,) or (n_parameter, n_column) in the order of ``effect.parameters``, in the sense of q.

    Returns
    -------
    Array of the shape of ``rotation``.
    """
    if effect.way != "torque":
        raise ValueError(f"{effect.name} is no torque")
    given = (rotation, rate, np.asarray(rotation) - deflection, spring_rate, damper_rate, damper_torque, force)
    shape = np.broadcast_shapes(np.shape(rotation), np.shape(rate), np.shape(deflection))
    columns = [np.broadcast_to(np.asarray(value, dtype=float), shape).reshape(len(time), -1) for value in given]
    n_column = columns[0].shape[1]
    values = np.broadcast_to(
        np.asarray(parameters, dtype=float).reshape(len(effect.parameters), -1).T, (n_column, len(effect.parameters))
    )
    result = np.empty((len(time), n_column))
    for first in range(0, n_column, LANES):
        part = slice(first, first + LANES)
        inputs = np.stack([column[:, part] for column in columns], axis=1)
        width = inputs.shape[2]
        padded = np.pad(inputs, ((0, 0), (0, 0), (0, LANES - width)), mode="edge")
        lanes = np.pad(values[part].T, ((0, 0), (0, LANES - width)), mode="edge")
        result[:, part] = _along(effect, np.ascontiguousarray(time, dtype=float), padded, lanes)[:, :width]
    return result.reshape(shape)


def columns_along(
    effect: Effect,
    time: Array,
    rotation: Array,
    rate: Array,
    deflection: Array,
    spring_rate: Array | float,
    damper_rate: Array | float,
    damper_torque: Array | float,
    force: Array | float,
    parameters: Array | Sequence[float],
) -> dict[str, Array]:
    """Of an effect that is linear in its strengths, each strength's torque a unit of it along a motion.

    Arguments as of ``torque_along``; the strengths' own values in ``parameters`` do not matter, the others' do.

    Returns
    -------
    Strength's name -> array of the shape of ``rotation``, N m a unit of the strength: columns of a linear regression.

    Raises
    ------
    ValueError : the effect is not linear in its strengths.
    """
    if not effect.linear:
        raise ValueError(f"{effect.name} is not linear in {', '.join(effect.strengths)}")
    found = {}
    for strength in effect.strengths:
        unit = np.array(parameters, dtype=float)
        unit[[effect.index(name) for name in effect.strengths]] = 0.0
        unit[effect.index(strength)] = 1.0
        found[strength] = torque_along(
            effect, time, rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, unit
        )
    return found


def _along(effect: Effect, time: Array, inputs: Array, parameters: Array) -> Array:
    """(n_time, 16) torque for inputs (n_time, 7, 16) in the order of ``_INPUTS`` and parameters (n_parameter, 16)."""
    chain = compiled_chain(1)
    layout = chain.layout
    workspace = np.zeros((layout.n_row, LANES))
    for p, values in enumerate(parameters):
        workspace[layout.parameter_rows(effect.name, p)] = values
    active = np.zeros(1 + len(layout.laws), dtype=np.int64)
    active[0] = GIVEN
    active[1 + [law.name for law in layout.laws].index(effect.name)] = 1
    memory, change, steps = -1, -1, np.zeros(len(time), dtype=np.int64)
    if effect.memory:
        memory, change = layout.row(f"{effect.name} memory"), layout.row(f"{effect.name} memory rate")
        steps[1:] = np.ceil(np.diff(time) / LONGEST_STEP)
        workspace[memory] = effect.function("start")(inputs[0, 0] - inputs[0, 2], *parameters)
        if effect.bristle and len(time) > 1:
            workspace[memory] = np.sign(inputs[1, 0] - inputs[0, 0])
    rows = np.array([layout.row(block) for block in _INPUTS])
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
