"""The same trajectories by other engines: each a function (releases (N, 3), parameters (N, 9), setting) -> (N, 501, 3).

What compiles or builds models is done where the engine is made, not where it is timed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi
import mujoco
import numpy as np
from mujoco import rollout
from numba import njit
from scipy.integrate import solve_ivp

from bench import thesis_leg as thesis
from peers.mujoco_leg import mjcf
from synth.arrays import Array

TOLERANCES = (1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8, 1e-9)
Run = Callable[[], Array]


@dataclass(frozen=True)
class Engine:
    """``prepare(releases, parameters, setting)`` gives what is timed; ``settings`` from coarse to fine."""

    name: str
    prepare: Callable[[Array, Array, float], Run]
    settings: Sequence[float]
    unit: str = "rtol"
    count: int = 14  # trajectories to time


def scipy_engines() -> list[Engine]:
    """``solve_ivp`` with the right-hand side in numpy and compiled by numba; relative and absolute tolerance alike."""
    constants = thesis.CONSTANTS
    scalar = njit(fastmath=True)(_scalar)
    scalar(0.0, np.zeros(6), thesis.NOMINAL, constants)
    compiled = lambda t, x, p: scalar(t, x, p, constants)  # noqa: E731
    made = []
    for words, function in (("numpy", thesis.derivative), ("numba", compiled)):
        for method in ("RK45", "LSODA"):
            made.append(Engine(f"scipy {method}, {words} right-hand side", _solve_ivp(function, method), TOLERANCES))
    return made


def _solve_ivp(function: Any, method: str) -> Callable[[Array, Array, float], Run]:
    def prepare(releases: Array, parameters: Array, tolerance: float) -> Run:
        def run() -> Array:
            found = []
            for release, p in zip(releases, parameters, strict=True):
                solved = solve_ivp(
                    function, (0.0, 1.0), thesis.start(release), method, thesis.TIMES,
                    rtol=tolerance, atol=tolerance, args=(p,),
                )  # fmt: skip
                found.append(thesis.joints(solved.y[:3].T))
            return np.array(found)

        return run

    return prepare


_accelerations = njit(fastmath=True)(thesis.accelerations)


def _scalar(time, x, p, a):  # type: ignore[no-untyped-def]
    e1, e2, e3 = _accelerations(x, p, a)
    return np.array([x[3], x[4], x[5], e1, e2, e3])


def mujoco_engines() -> list[Engine]:
    """``mujoco.rollout`` of one model a trajectory, one thread; Runge-Kutta 4 and the advised integrator."""
    steps = (2e-3, 1e-3, 2e-3 / 3, 5e-4)
    return [
        Engine("MuJoCo rollout, RK4", _mujoco("RK4"), steps, "step s"),
        Engine("MuJoCo rollout, implicitfast", _mujoco("implicitfast"), (2e-3, 1.25e-4), "step s", 7),
    ]


def _mujoco(integrator: str) -> Callable[[Array, Array, float], Run]:
    def prepare(releases: Array, parameters: Array, step: float) -> Run:
        each = round(2e-3 / step)
        texts = [mjcf(thesis.leg(p), np.zeros(3), step=2e-3 / each) for p in parameters]
        models = [mujoco.MjModel.from_xml_string(t.replace('"RK4"', f'"{integrator}"')) for t in texts]
        data = mujoco.MjData(models[0])
        state = np.concatenate([np.zeros((len(releases), 1)), releases, np.zeros((len(releases), 3))], axis=1)

        def run() -> Array:
            states, _ = rollout.rollout(models, data, state, nstep=(len(thesis.TIMES) - 1) * each)
            return np.concatenate([releases[:, None], states[:, each - 1 :: each, 1:4]], axis=1)

        return run

    return prepare


def sundials_engines() -> list[Engine]:
    """SUNDIALS' CVODES through CasADi's virtual machine, by both of its multistep families."""
    return [Engine(f"SUNDIALS cvodes ({way}) by CasADi", _cvodes(way), TOLERANCES) for way in ("bdf", "adams")]


def _cvodes(way: str) -> Callable[[Array, Array, float], Run]:
    x, p = casadi.SX.sym("x", 6), casadi.SX.sym("p", 9)
    change = casadi.vertcat(x[3:], *thesis.accelerations(x, p, thesis.CONSTANTS.tolist(), casadi.sin, casadi.cos))

    def prepare(releases: Array, parameters: Array, tolerance: float) -> Run:
        options = {"reltol": tolerance, "abstol": tolerance, "linear_multistep_method": way, "max_num_steps": 100_000}
        problem = {"x": x, "p": p, "ode": change}
        integrator = casadi.integrator("leg", "cvodes", problem, 0.0, thesis.TIMES[1:].tolist(), options)

        def run() -> Array:
            found = []
            for release, values in zip(releases, parameters, strict=True):
                first = thesis.start(release)
                rest = np.asarray(integrator(x0=first, p=values)["xf"])
                found.append(thesis.joints(np.hstack([first[:, None], rest])[:3].T))
            return np.array(found)

        return run

    return prepare
