"""A study as files: designs.csv, hopper.json, the jump of the chosen design."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import synth
from synth.arrays import Array
from synth.files.output import write_csv
from synth.files.run_manifest import sha256_file
from synth.files.text_forms import csv_text
from synth.hopper.study import Study
from synth.hopper.study_warnings import warnings_of
from synth.jump.hopper_leg import Motor
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS
from synth.jump.outcomes import LANDED_AGAIN, JumpOutcome
from synth.remarks import remarks_json
from synth.units import quantity

FORMAT = "synth/hopper/1"
LIBRARIES = ("numpy", "numba")
HEADER = (
    "motor,gear_ratio,leg_length [m],model,clearance [m],clearance_low [m],clearance_high [m],relative_height,feasible,"
    "limit,total_height [m],energy [J],peak_gear_torque [N*m],peak_current [A],takeoff_speed [m/s],"
    "peak_gear_torque_low [N*m],peak_gear_torque_high [N*m]"
)
FURTHER = ("relative_height", "total_height", "energy", "peak_gear_torque", "peak_current", "takeoff_speed")
MOST_ROWS = 100_000  # of a block that is written at once


def write_designs(found: Study, path: Path) -> None:
    """A row a design, motor by motor, lengths rising; empty intervals where none was asked for."""
    names = [(csv_text(motor.name), f"{motor.gear_ratio:.10g}") for motor in found.sweep.problem.motors]
    with path.open("w", encoding="utf-8", newline="") as stream:
        stream.write(HEADER + "\n")
        for first in range(0, len(found.sweep.motor), MOST_ROWS):
            stream.write("".join(_rows(found, names, first)))


def _rows(found: Study, names: Sequence[tuple[str, str]], first: int) -> Iterator[str]:
    """Lines of a block of designs."""
    sweep = found.sweep
    block = slice(first, first + MOST_ROWS)
    model = sweep.problem.model.name
    limited = (sweep.over_limit() | (sweep.status != LANDED_AGAIN))[block]
    numbers = (sweep.length, sweep.values["clearance"], found.low, found.high, *(sweep.values[n] for n in FURTHER),
               *found.torque_ends)  # fmt: skip
    columns = [column[block].tolist() for column in (sweep.motor, sweep.feasible(found.project.gearbox), *numbers)]
    for i, (m, yes, length, clear, low, high, relative, *rest) in enumerate(zip(*columns, strict=True)):
        motor, ratio = names[m]
        ends = "," if low != low else f"{low:.6f},{high:.6f}"
        limit = csv_text(sweep.limit_text(first + i)) if limited[i] else ""
        total, energy, torque, amps, speed, least, most = rest
        torques = "," if least != least else f"{least:.5f},{most:.5f}"
        yield (
            f"{motor},{ratio},{length:.9g},{model},{clear:.6f},{ends},{relative:.5f},{'yes' if yes else 'no'},{limit},"
            f"{total:.6f},{energy:.5f},{torque:.5f},{amps:.4f},{speed:.5f},{torques}\n"
        )


def write_jump(found: Study, path: Path) -> None:
    """The chosen design's jump: poses, forces, torque and current at every thousandth of a second.

    And at the integrator's steps in which the gear's torque is largest: blows at the stop are shorter than the rest.
    """
    if found.trace is None:
        return
    layout = LAYOUTS[found.project.leg.bending]
    trace = found.trace
    size = np.abs(trace[:, 1 + layout.row("gear_torque")])
    peaks = 1 + np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]))
    times = np.union1d(np.arange(0.0, trace[-1, 0], 1e-3), trace[peaks, 0])

    def column(name: str, index: int = 0) -> Array:
        return np.asarray(np.interp(times, trace[:, 0], trace[:, 1 + layout.row(name, index)]))

    lower = layout.n - 1
    write_csv(path, {
        "time [s]": times,
        "hip height [m]": column("height"),
        "upper link angle [deg]": np.degrees(column("angle", 0)),
        "upper link end angle [deg]": np.degrees(column("angle", layout.knee - 1)),
        "lower link angle [deg]": -np.degrees(column("angle", lower)),
        "foot height [m]": column("foot"),
        "ground force [N]": column("normal"),
        "gear torque [N*m]": column("gear_torque"),
        "current [A]": column("drawn"),
        "centre of mass speed [m/s]": column("com_speed"),
    })  # fmt: skip


def hopper_json(found: Study, files: Sequence[Path], folder: Path, notes: Sequence[str] = ()) -> dict[str, Any]:
    """The content of hopper.json; ``notes`` of its parts, which are warnings too."""
    project, sweep = found.project, found.sweep
    statuses = {"designs": len(sweep.motor), "jump": int((sweep.status == LANDED_AGAIN).sum()),
                "beyond the gearbox": int((sweep.over_limit() & (sweep.status == LANDED_AGAIN)).sum()),
                "beyond the gearbox at the torque's 90 % end": int(found.over_limit_at_end.sum()),
                "without a known gearbox limit": int(sweep.without_limit().sum()),
                "feasible": int(sweep.feasible(found.project.gearbox).sum())}  # fmt: skip
    return {
        "format": FORMAT,
        "name": project.name,
        "versions": {"synth": synth.__version__, **{n: importlib.metadata.version(n) for n in LIBRARIES}},
        "inputs": [{"file": item.name, "sha256": item.sha256} for item in project.inputs],
        "defaults": [{"key": d.key, "value": d.value, "why": d.reason} for d in project.defaults],
        "settings": {
            "model": project.model,
            "objectives": list(project.objectives),
            "choose": project.choose,
            "height": project.height,
            "gearbox": project.gearbox,
            "lengths": f"{len(project.lengths)}, {project.lengths[0] * 1e3:g} to {project.lengths[-1] * 1e3:g} mm",
            "motors": f"{len(sweep.problem.motors)}",
        },
        "counts": statuses,
        **remarks_json([*warnings_of(found), *notes]),
        "best": {} if found.best is None else _best(found, found.best),
        **({"none_because": found.none_because} if found.none_because else {}),
        "pareto": [_design(found, index) for index in found.front],
        "models": _ladder(found),
        "neighbours": [
            {"change": item.change, "motor": item.motor.name, "gear_ratio": item.motor.gear_ratio,
             "leg_length": quantity(item.length, "m"), **outcome_json(item.outcome, item.length, found.project.height)}
            for item in found.neighbours
        ],
        "tolerances": [
            {"quantity": name, "lower_end": quantity(low, "m"), "upper_end": quantity(high, "m")}
            for name, (low, high) in found.contributions.items()
        ],
        "planar": [
            {"lean": quantity(item.pitch, "deg"),
             "final_pitch": quantity(item.final_pitch, "deg") if item.outcome.known else None,
             "slip": quantity(item.slip, "m") if item.outcome.known else None,
             **outcome_json(item.outcome, float(found.best_leg.length), found.project.height)}
            for item in found.leaning
        ],
        "map": _map(found),
        "files": [{"path": path.relative_to(folder).as_posix(), "sha256": sha256_file(path)} for path in files],
    }  # fmt: skip


def outcome_json(outcome: JumpOutcome, length: float, height: str) -> dict[str, Any]:
    """One jump's numbers with units; ``height`` : clearance or total, what the relative one is made of.

    None for a number of a jump that is too stiff to simulate, which is not known.
    """
    tall = outcome.rise if height == "total" else outcome.clearance
    numbers = {
        "clearance": quantity(outcome.clearance, "m"),
        "relative_height": quantity(tall / length, "1"),
        "total_height": quantity(outcome.rise, "m"),
        "takeoff_speed": quantity(outcome.takeoff_speed, "m/s"),
        "takeoff_time": quantity(outcome.takeoff_time, "s"),
        "energy": quantity(outcome.energy, "J"),
        "peak_gear_torque": quantity(outcome.peak_gear_torque, "N*m"),
        "peak_current": quantity(outcome.peak_current, "A"),
    }
    return {**(numbers if outcome.known else dict.fromkeys(numbers)), "limit": outcome.limit}


def motor_json(motor: Motor) -> dict[str, Any]:
    """The motor's constants as used."""
    limit = {} if motor.torque_limit is None else {"torque_limit": quantity(motor.torque_limit, "N*m")}
    return {
        "voltage": quantity(motor.voltage, "V"),
        "stall_torque": quantity(motor.stall_torque, "N*m"),
        "no_load_speed": quantity(motor.no_load_speed, "rad/s"),
        "resistance": quantity(motor.resistance, "ohm"),
        "inductance": quantity(motor.inductance, "mH"),
        "back_emf_constant": quantity(motor.back_emf_constant, "V/(rad/s)"),
        "torque_constant_through_the_gear": quantity(motor.torque_constant, "N*m/A"),
        "gear_efficiency": quantity(motor.driving_efficiency, "1"),
        "gear_efficiency_backwards": quantity(motor.back_efficiency, "1"),
        "rotor_inertia": quantity(motor.rotor_inertia, "kg*m^2"),
        "reflected_inertia": quantity(motor.reflected_inertia, "kg*m^2"),
        "friction_of_the_rotor": quantity(motor.friction, "N*m"),
        **({"viscous_of_the_rotor": quantity(motor.viscous, "N*m*s/rad")} if motor.viscous else {}),
        "mass": quantity(motor.mass, "g"),
        **limit,
    }


def _design(found: Study, index: int) -> dict[str, Any]:
    sweep = found.sweep
    motor = sweep.problem.motors[sweep.motor[index]]
    low, high = found.low[index], found.high[index]
    interval = None if np.isnan(low) else (float(low), float(high))
    least, most = found.torque_ends[:, index]
    torques = None if np.isnan(least) else (float(least), float(most))
    values = {name: float(value[index]) for name, value in sweep.values.items()}
    return {
        "motor": motor.name,
        "gear_ratio": motor.gear_ratio,
        "leg_length": quantity(float(sweep.length[index]), "m"),
        "clearance": quantity(values["clearance"], "m", interval),
        "relative_height": quantity(values["relative_height"], "1"),
        "total_height": quantity(values["total_height"], "m"),
        "energy": quantity(values["energy"], "J"),
        "peak_gear_torque": quantity(values["peak_gear_torque"], "N*m", torques),
        "peak_current": quantity(values["peak_current"], "A"),
        "takeoff_speed": quantity(values["takeoff_speed"], "m/s"),
        "takeoff_time": quantity(values["takeoff_time"], "s"),
        "limit": sweep.limit_text(index),
    }


def _best(found: Study, index: int) -> dict[str, Any]:
    leg, motor, after = found.best_leg, found.best_motor, found.torque_after_takeoff
    upper, lower = leg.link_mass
    return {
        **_design(found, index),
        "total_height": quantity(float(found.sweep.values["total_height"][index]), "m", found.total_ends),
        **({} if after is None else {"gear_torque_after_takeoff": quantity(after, "N*m")}),
        "motor_constants": motor_json(motor),
        "leg": {
            "upper_link": quantity(leg.length, "mm"),
            "lower_link": quantity(leg.lower_length, "mm"),
            "hip_spacing": quantity(leg.hip_spacing, "mm"),
            "upper_link_mass": quantity(upper, "g"),
            "lower_link_mass": quantity(lower, "g"),
            "total_mass": quantity(leg.total_mass(motor), "g"),
            "beam_rate": quantity(leg.laminate.beam_rate(leg.length), "N*m/rad"),
            "flexure_rate": quantity(leg.flexures.rate, "N*m/rad"),
            "crouch": quantity(leg.start, "deg"),
            "crouch_lower_link": quantity(leg.lower_angle(leg.start), "deg"),
            "extended": quantity(leg.extended, "deg"),
        },
    }


def _ladder(found: Study) -> dict[str, Any]:
    if found.best is None:
        return {}
    length = float(found.best_leg.length)
    shown = {}
    for rung in found.ladder:
        what = MODELS[rung.model].what + (", on MuJoCo's own contact" if rung.own_contact else "")
        shown[rung.name] = {"what": what, **outcome_json(rung.outcome, length, found.project.height)}
    return shown


def _map(found: Study) -> dict[str, Any]:
    """Heights over ratio and length of one motor's family, thinned to at most 60 lengths, for the figure.

    The family is that of the chosen design; without one, of the highest jump, beyond its limits. Empty: nothing jumps.
    """
    sweep = found.sweep
    rows = found.rows
    shown = found.best
    if shown is None:
        if not np.any(sweep.status == LANDED_AGAIN):
            return {}
        heights = sweep.values["total_height" if found.project.height == "total" else "clearance"]
        shown = int(np.argmax(np.where(sweep.status == LANDED_AGAIN, heights, -np.inf)))
    own = rows[sweep.motor[shown]]
    family = [i for i, row in enumerate(rows) if row.same_motor == own.same_motor]
    family.sort(key=lambda i: sweep.problem.motors[i].gear_ratio)
    n = len(sweep.problem.lengths)
    every = max(1, -(-n // 60))
    lengths = list(range(0, n, every))
    feasible = sweep.feasible(found.project.gearbox).reshape(-1, n)
    return {
        "family": " ".join(word for word in own.same_motor if word),
        "gear_ratio": [sweep.problem.motors[i].gear_ratio for i in family],
        "leg_length_m": [sweep.problem.lengths[k] for k in lengths],
        **{
            f"{name}_m": [[float(value) for value in sweep.values[name].reshape(-1, n)[i, lengths]] for i in family]
            for name in ("clearance", "total_height")
        },
        "feasible": [[bool(value) for value in feasible[i, lengths]] for i in family],
    }
