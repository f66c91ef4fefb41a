"""diffrax on the thesis' leg, run by a Python that has it: ``python tests/bench/peer_diffrax.py PROBLEM.npz``.

Imports nothing of the project but the equations of motion, whose text it runs. Prints JSON: setting, error, rate.
"""

from __future__ import annotations

import importlib.metadata
import json
import sys
import time

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)
TOLERANCES = (3e-5, 1e-5, 3e-6, 1e-6, 3e-7)
COUNT = 256  # trajectories in one call


def main() -> None:
    problem = np.load(sys.argv[1])
    space: dict[str, object] = {"cos": jnp.cos, "sin": jnp.sin, "Any": object}
    exec(str(problem["accelerations"]), space)
    accelerations, constants, times = (
        space["accelerations"],
        problem["constants"].tolist(),
        jnp.asarray(problem["times"]),
    )

    def change(t, x, p):  # type: ignore[no-untyped-def]
        return jnp.stack([x[3], x[4], x[5], *accelerations(x, p, constants, jnp.sin, jnp.cos)])

    def one(first, p, tolerance):  # type: ignore[no-untyped-def]
        solved = diffrax.diffeqsolve(
            diffrax.ODETerm(change), diffrax.Dopri5(), 0.0, 1.0, 1e-3, first, args=p,
            saveat=diffrax.SaveAt(ts=times), stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
        )  # fmt: skip
        return solved.ys[:, :3]

    run = jax.jit(jax.vmap(one, (0, 0, None)))
    first, p, reference = problem["first"], problem["parameters"], problem["reference"]
    many = [np.resize(array, (COUNT, array.shape[1])) for array in (problem["many_first"], problem["many_parameters"])]
    for tolerance in TOLERANCES:
        absolute = np.asarray(run(first, p, tolerance))
        error = float(np.abs(np.diff(absolute, axis=-1, prepend=0.0) - reference).max())
        if error <= 1e-6:
            break
    run(*many, tolerance).block_until_ready()
    spent = []
    for _ in range(3):
        start = time.process_time()
        run(*many, tolerance).block_until_ready()
        spent.append(time.process_time() - start)
    rate = COUNT / sorted(spent)[1]
    version = importlib.metadata.version("diffrax")
    sys.stdout.write(json.dumps({"setting": tolerance, "error": error, "rate": rate, "version": version}) + "\n")


if __name__ == "__main__":
    main()
