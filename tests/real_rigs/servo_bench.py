"""Position servos on a bench, ``../shared/rigs/servo_bench``: projects of their logs, and the owners' own models.

The owners' simulation is written here anew from their paper (Duclusaud et al., BAM, arXiv 2410.08650, section III),
with their integrator (semi-implicit Euler, friction as the torque that would stop the joint, cut off). So their
identified numbers are scored as they score them: mean absolute angle error of a log simulated from its first sample on.
"""

from __future__ import annotations

import argparse
import csv
import json
import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project

SHARED = Path(__file__).resolve().parents[3] / "shared"
BENCH = SHARED / "rigs" / "servo_bench"
MODELS = ("m1", "m2", "m3", "m4", "m5", "m6")
COPPER = 0.0039  # growth of copper's resistance a kelvin, at 20 C (IEC 60028)
RISING = 1.2  # s, within the first rise of sin(t^2), which ends at sqrt(pi / 2)
SUBSTEPS = 4  # of a log's sample; one, as the owners take, makes their errors larger by 2 %, eight smaller by .4 %
# Duty a radian and unit of the firmware's gain as in the owners' code. Nominal motors: torque a current and winding
# near what the data sheets' stall torque, stall current and free speed give; inertia of rotor and gear by the owners.
SERVOS = {
    "xl330": {"gain": 0.0028773775, "constant": 0.36, "resistance": 3.4, "armature": 1.8e-3, "supply": 7.4},
    "feetech": {"gain": 0.166, "constant": 1.2, "resistance": 2.0, "armature": 0.02, "supply": 12.0},
}
LEG = """kind: leg
name: {name} at gain {kp:g}
joints:
  - name: arm
    zero: 0 deg
    sign: +1
    armature: {armature} kg*m^2
    link: {{length: {length} m, mass: {mass} kg, com: {length} m, inertia: {inertia:.3g} kg*m^2}}
    drive:
      kind: servo
      gain: {gain:.6g} 1/rad
      supply: {supply} V
      motor: {{torque_constant: {constant} N*m/A, resistance: {resistance} ohm}}
"""


@dataclass(frozen=True)
class Log:
    """One log: what was done, and its columns."""

    name: str
    trajectory: str
    kp: float
    mass: float
    length: float
    columns: NDArray[np.void]

    @property
    def position(self) -> NDArray[np.float64]:
        """(m,) rad."""
        return np.asarray(self.columns["position"])


def logs(servo: str) -> list[Log]:
    """All logs of a servo, in the order of its index."""
    with (BENCH / f"{servo}_index.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    return [
        Log(
            f"{row['trajectory']}_{row['kp']}",
            row["trajectory"],
            float(row["kp"]),
            float(row["mass"]),
            float(row["length"]),
            np.genfromtxt(BENCH / row["file"], delimiter=",", names=True),
        )
        for row in rows
    ]


@dataclass(frozen=True)
class Change:
    """What should not matter to an answer: commands ``earlier`` by s, the last ``cut`` samples of each log left out,
    readings changed by ``jitter`` rad RMS; or what once was done: commands as lines, ``lines``, half a sample late.
    """

    earlier: float = 0.0
    cut: int = 0
    jitter: float = 0.0
    lines: bool = False


def _rows(log: Log, change: Change) -> list[str]:
    """Lines of the trial's CSV; commands at other times have rows of their own."""
    at, rng = log.columns[: len(log.columns) - change.cut], np.random.default_rng(1)
    time, told = at["timestamp"], at["goal_position"]
    read = at["position"] + change.jitter * rng.standard_normal(len(at))
    sent = time - change.earlier + (0.5 * float(np.median(np.diff(time))) if change.lines else 0.0)
    rest = [f"{volts:.9g},{on:.9g}" for volts, on in zip(at["input_volts"], at["torque_enable"], strict=True)]
    if not np.any(sent != time):
        return [f"{t:.9g},{q:.9g},{c:.9g},{more}" for t, q, c, more in zip(time, read, told, rest, strict=True)]
    rows = [(t, f"{t:.9g},{q:.9g},,{more}") for t, q, more in zip(time, read, rest, strict=True)]
    # A nanosecond aside: stamps have five digits, and two rows must not fall together.
    rows += [(t + 1e-9, f"{t + 1e-9:.12g},,{c:.9g},{more}") for t, c, more in zip(sent, told, rest, strict=True)]
    return [row for _, row in sorted(rows)]


def project(
    folder: Path, servo: str, held_out: set[str], change: Change = Change(), gains: set[float] | None = None
) -> Path:
    """A gap project of a servo's logs, those of the firmware's ``gains`` (all), of which ``held_out`` only score."""
    found, numbers = [log for log in logs(servo) if gains is None or log.kp in gains], SERVOS[servo]
    entries = []
    for log in found:
        leg = f"{servo}_{log.kp:g}.leg.yaml"
        motor = {**numbers, "gain": numbers["gain"] * log.kp}
        text = LEG.format(name=servo, kp=log.kp, mass=log.mass, length=log.length, inertia=4e-4 * log.mass, **motor)
        (folder / leg).write_text(text + ("      commands: linear\n" if change.lines else ""))
        header = "time [s],arm [rad],arm command [rad],supply [V],arm enabled [1]"
        (folder / f"{log.name}.csv").write_text("\n".join([header, *_rows(log, change)]) + "\n")
        entries.append(f"  - {{file: {log.name}.csv, leg: {leg}, held_out: {str(log.name in held_out).lower()}}}")
    lines = ["kind: gap", f"leg: {servo}_{found[0].kp:g}.leg.yaml", "tolerance: {com: 2 %}", "trials:", *entries]
    path = folder / "gap.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


def published(servo: str, model: str) -> dict[str, float]:
    """The owners' identified parameters; those that their simpler models share apply to both directions."""
    found = json.loads((BENCH / "authors_params" / f"{servo}__{model}.json").read_text())
    for name in ("load_friction", "load_friction_stribeck"):
        common = found.get(name.replace("friction", "friction_base") if name == "load_friction" else name)
        if common is not None:
            tail = name.removeprefix("load_friction")
            found[f"load_friction_motor{tail}"] = found[f"load_friction_external{tail}"] = common
    return {key: value for key, value in found.items() if isinstance(value, float)}


def owners_error(log: Log, numbers: Mapping[str, float], gain: float, limit: float = 1.0) -> float:
    """Mean absolute angle error, rad, of the owners' model with these numbers on one log."""
    return float(np.mean(np.abs(_simulated(log, numbers, gain * log.kp, limit) - log.position)))


def _simulated(log: Log, numbers: Mapping[str, float], gain: float, limit: float) -> NDArray[np.float64]:
    """(m,) rad, with the supply as it was logged."""
    at = log.columns
    q, rate = float(at["position"][0]), float(at["speed"][0])
    constant, resistance = numbers["kt"], numbers["R"]
    weight, inertia = log.mass * 9.81 * log.length, log.mass * log.length**2 + numbers["armature"]
    angles = np.empty(len(at))
    angles[0] = q
    for k in range(len(at) - 1):
        step = float(at["timestamp"][k + 1] - at["timestamp"][k]) / SUBSTEPS
        command, supply, on = float(at["goal_position"][k]), float(at["input_volts"][k]), at["torque_enable"][k] > 0
        for _ in range(SUBSTEPS):
            duty = max(-limit, min(limit, gain * (command - q)))
            motor = constant * (supply * duty - constant * rate) / resistance if on else 0.0
            load = -weight * math.sin(q + numbers.get("q_offset", 0.0))
            most = _friction(motor, load, rate, numbers) + numbers["friction_viscous"] * abs(rate)
            stopping = inertia / step * rate + motor + load
            acting = motor + load - math.copysign(min(abs(stopping), most), stopping)
            rate += acting / inertia * step
            q += rate * step
        angles[k + 1] = q
    return angles


def _friction(motor: float, load: float, rate: float, numbers: Mapping[str, float]) -> float:
    """N m, the owners' friction budget without its viscous part; terms that a model lacks are 0."""
    get = numbers.get
    stopped = math.exp(-(abs(rate / get("dtheta_stribeck", 1.0)) ** get("alpha", 1.0)))
    found = get("friction_base", 0.0) + stopped * get("friction_stribeck", 0.0)
    for tail, share in (("", 1.0), ("_stribeck", stopped)):
        outside, inside = get(f"load_friction_external{tail}", 0.0), get(f"load_friction_motor{tail}", 0.0)
        found += share * abs(load * outside - motor * inside)
    if motor * load < 0.0:
        name = "load_friction_external_quad" if abs(load) < abs(motor) else "load_friction_motor_quad"
        found += stopped * get(name, 0.0) * min(abs(load), abs(motor)) ** 2
    return found


def scored(servo: str) -> set[str]:
    """Names of the held-out logs: one gain of the servo with several, else one trajectory."""
    found = logs(servo)
    several = len({log.kp for log in found}) > 1
    return {log.name for log in found if (log.kp == 400.0 if several else log.trajectory == "sin_sin")}


def warming(servo: str) -> dict[str, float]:
    """K by which a log warms at most, and C of the coldest and the warmest, by the servo's own thermometer.

    Of each log the medians of its first and its last tenth: single readings of the STS3250 are tens of kelvins off.
    """
    tenths = [np.array_split(log.columns["temp"], 10) for log in logs(servo)]
    ends = np.array([[np.median(each[0]), np.median(each[-1])] for each in tenths])
    rise = float((ends[:, 1] - ends[:, 0]).max())
    found = {"most_in_a_log": rise, "resistance_share": COPPER * rise}
    return {**found, "coldest": float(ends.min()), "warmest": float(ends.max())}


def command_lead(servo: str) -> float:
    """Seconds by which a command left before the stamp of its log's row, from the logs of sin(t^2).

    The owners' recorder computes the command, sends it, reads the servo, and stamps the row with the middle of the
    reading. On its first rise sin(t^2) tells the time at which each command was computed.
    """
    found = []
    for log in logs(servo):
        if log.trajectory == "sin_time_square":
            stamp, command = log.columns["timestamp"], log.columns["goal_position"]
            rising = stamp < RISING
            found.append(float(np.median(stamp[rising] - np.sqrt(np.arcsin(command[rising])))))
    return float(np.median(found))


def line(servo: str, folder: Path, change: Change = Change()) -> dict[str, object]:
    """The result of ``synth gap`` on a servo's logs, and mean absolute errors, mrad, on the held-out ones."""
    found = read_gap_project(project(folder, servo, scored(servo), change))
    result = diagnose(found.leg, found.trials, found.tolerance, seed=found.seed)
    document = result.as_json()
    trials = [trial for trial in result.trials if trial.scored]

    def error(stage: str) -> float:
        return float(1e3 * np.mean([np.nanmean(np.abs(getattr(trial, stage) - trial.measured)) for trial in trials]))

    owners = {}
    for model in MODELS:
        if (BENCH / "authors_params" / f"{servo}__{model}.json").is_file():
            numbers, gain = published(servo, model), SERVOS[servo]["gain"]
            kept = [log for log in logs(servo) if log.name in scored(servo)]
            owners[model] = float(1e3 * np.mean([owners_error(log, numbers, gain) for log in kept]))
    first = document["ranked"][0]
    return {
        "servo": servo,
        "verdict": document["verdict"],
        "sentence": document["sentence"],
        "first": f"{first['effect']} ({first['joint']})",
        "parameters": {name: value["value"] for name, value in first["parameters"].items()},
        "probability": first["probability"],
        "as_designed": error("as_designed"),
        "within_tolerances": error("before"),
        "explained": error("after"),
        "remainder": document["remainder"],
        "owners": owners,
        "warming": warming(servo),
        "command_lead": command_lead(servo),
    }


def main() -> None:
    """Print the table: ``PYTHONPATH=tests python -m real_rigs.servo_bench``; with options what a change does to it."""
    parser = argparse.ArgumentParser(prog="real_rigs.servo_bench", description=main.__doc__)
    parser.add_argument("servos", nargs="*", metavar="SERVO", help="xl330, feetech (default: both)")
    parser.add_argument("--earlier", type=float, default=0.0, help="ms by which commands are earlier")
    parser.add_argument("--cut", type=int, default=0, help="samples left out at each log's end")
    parser.add_argument("--jitter", type=float, default=0.0, help="rad RMS by which readings are changed")
    parser.add_argument("--lines", action="store_true", help="commands as lines, half a sample late")
    asked = parser.parse_args()
    change = Change(1e-3 * asked.earlier, asked.cut, asked.jitter, asked.lines)
    for servo in asked.servos or SERVOS:
        with tempfile.TemporaryDirectory() as folder:
            print(json.dumps(line(servo, Path(folder), change), indent=1))  # noqa: T201


if __name__ == "__main__":
    main()
