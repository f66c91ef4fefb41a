"""MuJoCo's own system identification on the same trials: ``python tests/bench/peer_sysid.py PROBLEM.npz``.

Run by a Python that has ``mujoco[sysid]``; imports nothing of the project. Prints JSON: processor seconds, spring and
damper rates found, version.
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import json
import sys
import time

import mujoco
import numpy as np
from mujoco import sysid

WIDE = 30.0  # times smaller and larger than at the start may a rate become


def main() -> None:
    problem = np.load(sys.argv[1])
    names = [str(name) for name in problem["names"]]
    start, times, releases, angles = (problem[key] for key in ("start", "times", "releases", "angles"))
    spec = mujoco.MjSpec.from_string(str(problem["mjcf"]))
    model = spec.compile()
    mapping, _, _, _ = sysid.TimeSeries.compute_all_state_mappings(model)

    states, controls, measured = [], [], []
    for release, trial in zip(releases, angles, strict=True):
        states.append(sysid.create_initial_state(model, release, np.zeros(len(names))))
        controls.append(sysid.TimeSeries(times, np.zeros((len(times), model.nu))))
        measured.append(sysid.TimeSeries(times, trial, mapping))
    turns = [f"{i}" for i in range(len(angles))]
    sequences = sysid.ModelSequences("leg", spec, turns, states, controls, measured, allow_missing_sensors=True)
    observed = [(name, kind) for name, (kind, _) in mapping.items()]
    residual = sysid.build_residual_fn(models_sequences=[sequences], enabled_observations=observed, n_threads=1)

    begun = time.process_time()
    with contextlib.redirect_stdout(sys.stderr):
        found, _ = sysid.optimize(parameters(names, start), residual, optimizer="mujoco", verbose=False)
    spent = time.process_time() - begun
    values = found.as_vector().tolist()
    version = importlib.metadata.version("mujoco")
    sys.stdout.write(json.dumps({"seconds": spent, "values": values, "version": version}) + "\n")


def parameters(names: list[str], start: np.ndarray) -> sysid.ParameterDict:
    """Spring rates, damper rates and free angles, in this order, at the start's values."""
    made, n = sysid.ParameterDict(), len(names)
    for place, field in enumerate(("stiffness", "damping", "springref")):
        for j, name in enumerate(names):
            value = float(start[place * n + j])
            low, high = (-1.5, 1.5) if field == "springref" else (value / WIDE, value * WIDE)
            made.add(sysid.Parameter(f"{field} {name}", value, low, high, modifier=setter(name, field)))
    return made


def setter(name: str, field: str):  # type: ignore[no-untyped-def]
    """What writes a parameter into the model; stiffness and damping are polynomials there, whose first term this is."""

    def write(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
        joint = spec.joint(name)
        if np.ndim(getattr(joint, field)):
            getattr(joint, field)[0] = parameter.value[0]
        else:
            setattr(joint, field, float(parameter.value[0]))

    return write


if __name__ == "__main__":
    main()
