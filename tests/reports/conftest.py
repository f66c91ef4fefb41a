"""Result folders made by code: decaying swings with noise, in the form of ``design.json`` and ``fit.json``."""

from __future__ import annotations

import csv
import json
import math
import random
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Json = dict[str, Any]
DEG = "deg"


def quantity(value: float, unit: str, half: float | None = None) -> Json:
    """A quantity, with a symmetric interval where a half width is given."""
    found: Json = {"value": value, "unit": unit}
    return found if half is None else {**found, "interval90": [value - half, value + half]}


def swing(time: float, rest: float, amplitude: float, ratio: float, frequency: float) -> float:
    """Free decay from rest + amplitude, at speed zero."""
    damped = frequency * math.sqrt(1 - ratio**2)
    lag = ratio / math.sqrt(1 - ratio**2)
    decay = math.exp(-ratio * frequency * time)
    return rest + amplitude * decay * (math.cos(damped * time) + lag * math.sin(damped * time))


def write_columns(path: Path, columns: dict[str, list[float]]) -> None:
    """A CSV file; nan as an empty cell."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        for row in zip(*columns.values(), strict=True):
            writer.writerow(["" if math.isnan(cell) else f"{cell:.8g}" for cell in row])


def png(width: int = 8, height: int = 6) -> bytes:
    """A small grey picture."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\x00" + b"\xb0" * width for _ in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def joint_parameters(joints: list[str]) -> dict[str, tuple[float, float, float, float, float]]:
    """Name -> rest (deg), amplitude (deg), damping ratio, frequency (rad/s), spring rate."""
    return {
        name: (95.0 + 18.0 * i, 22.0 - 3.0 * i, 0.22 + 0.05 * i, 22.0 + 6.0 * i, 20.0 / 2**i)
        for i, name in enumerate(joints)
    }


def fit(joints: list[str], trials: list[str], scale: float = 1.0, dampers: bool = True) -> Json:
    """One stage in the form of ``fit.json``."""
    parameters = joint_parameters(joints)
    found: Json = {}
    for name, (rest, _, _, _, rate) in parameters.items():
        k = rate * scale
        found[name] = {
            "spring_rate": {**quantity(k, "N*m/rad"), "interval90": [k * 0.93, k * 1.08]},
            "free_angle": quantity(rest + 4.0, DEG, 0.42),
            "free_angle_spread": {**quantity(1.3, DEG), "interval90": [0.8, 2.6]},
        }
        if dampers:
            found[name]["damper_rate"] = {**quantity(k / 20, "N*m*s/rad"), "interval90": [k / 21, k / 19]}
        else:
            found[name]["damper"] = {"law": "curve"}
    rates = {name: joint["spring_rate"] for name, joint in found.items()}
    softer = {
        name: {"value": q["value"] * 0.42, "unit": q["unit"], "interval90": [q["value"] * 0.2, q["value"] * 0.8]}
        for name, q in rates.items()
    }
    b = {name: joint["damper_rate"] for name, joint in found.items() if "damper_rate" in joint}
    variants = [
        {
            "free_angle": name,
            "spring_rate": k,
            "damper_rate": b,
            "rms": {joint: quantity(rms, DEG) for joint in joints},
            "free_angle_spread": {joint: quantity(spread, DEG) for joint in joints},
        }
        for name, k, rms, spread in (("common", softer, 1.6, 0.0), ("per_trial", rates, 0.5, 1.3))
    ]
    return {
        "format": "synth/fit/1",
        "joints": found,
        "rms": {name: quantity(0.31 + 0.1 * i, DEG) for i, name in enumerate(joints)},
        "free_angle": {
            "mode": "per_trial",
            "why": "the trials' free angles differ by more than their noise (p below 0.0001)",
            "variants": variants,
        },
        "noise": {name: quantity(0.1, DEG) for name in joints},
        "not_separable": ["not separable: mass scale, from free swings alone."],
        "families": [
            {
                "joint": joints[0],
                "members": [
                    {
                        "spring_rate": quantity(rates[joints[0]]["value"] * factor, "N*m/rad"),
                        "damper_rate": quantity(rates[joints[0]]["value"] * factor / 20, "N*m*s/rad"),
                        "free_angle": quantity(100.0, DEG),
                        "rms": quantity(0.31, DEG),
                        "difference": quantity(0.02 * abs(factor - 1.0), DEG),
                    }
                    for factor in (0.5, 1.0, 2.0)
                ],
                "open_end": False,
                "text": f"{joints[0]}: a family",
            }
        ],
        "warnings": [f"{joints[0]}: the fit leaves 1.2 deg where the samples scatter by only 0.1 deg"],
        "method": "least_squares",
        "iterations": 14,
        "reason": "the step is small",
        "lost_samples": 3,
        "trials": [trial(name, joints, index) for index, name in enumerate(trials)],
        "inputs": {name: f"{index:064x}" for index, name in enumerate(trials)},
    }


def trial(name: str, joints: list[str], index: int) -> Json:
    """One trial's entry."""
    found: Json = {"file": name, "held_out": index == 1}
    found["rms"] = {joint: quantity(0.3 + 0.05 * ((index * 7) % 11), DEG) for joint in joints}
    found["free_angle"] = {joint: quantity(100.0 + i, DEG) for i, joint in enumerate(joints)}
    found["initial_rate"] = {joint: quantity(-12.0, "deg/s") for joint in joints}
    found["rise_time"] = {joint: quantity(0.061, "s") for joint in joints}
    found["damping_ratio"] = {joint: quantity(0.22, "1") for joint in joints[1:]}
    found["damped_frequency"] = {joint: quantity(21.4, "rad/s") for joint in joints[1:]}
    found["overshoot"] = {joint: quantity(0.48, "1") for joint in joints}
    found["settling_time"] = {joint: quantity(0.44, "s") for joint in joints}
    found["damping_ratio_validity"] = dict.fromkeys(joints, "valid") | {joints[0]: "fewer than two swings past rest"}
    return found


def write_responses(folder: Path, joints: list[str], trials: list[str], design: bool) -> None:
    """``responses/source`` and, for a design, ``responses/target``."""
    random_numbers = random.Random(5)
    for index, name in enumerate(trials):
        stem = Path(name).stem
        time = [i * 0.002 for i in range(401)]
        source: dict[str, list[float]] = {"time [s]": time}
        target: dict[str, list[float]] = {"time [s]": [2 * t for t in time]}
        for joint, (rest, amplitude, ratio, frequency, _) in joint_parameters(joints).items():
            shift = random_numbers.gauss(0, 1.2)
            fitted = [swing(t, rest + shift, amplitude * (1 - 0.04 * index % 3), ratio, frequency) for t in time]
            measured = [value + random_numbers.gauss(0, 0.15) for value in fitted]
            if index == 0:
                measured[100:120] = [math.nan] * 20
            source[f"{joint} measured [deg]"], source[f"{joint} fitted [deg]"] = measured, fitted
            target[f"{joint} animal [deg]"], target[f"{joint} wanted [deg]"] = measured, fitted
            target[f"{joint} built [deg]"] = [
                swing(t, rest + shift + 0.6, amplitude, ratio * 1.1, frequency) for t in time
            ]
        write_columns(folder / "responses" / "source" / f"{stem}.csv", source)
        if design:
            write_columns(folder / "responses" / "target" / f"{stem}.csv", target)


def spring_to_make(rate: float = 19.9, **other: Any) -> Json:
    """The entry ``make``: 6.1667 coils have tangent arms at 120 deg."""
    return {
        "material": "music wire", "count": 1, "leg_convention": "tangent",
        "leg_lengths": [quantity(38.0, "mm"), quantity(38.0, "mm")],
        "wire_diameter": quantity(5.0, "mm"), "mean_diameter": quantity(31.0, "mm"),
        "outer_diameter": quantity(36.0, "mm"), "body_coils": quantity(6.0 + 1 / 6, "1"),
        "active_coils": quantity(6.427, "1"), "included_angle": quantity(120.0, DEG),
        "rate": quantity(rate, "N*m/rad"), "rate_bending_form": quantity(rate, "N*m/rad"),
        "rate_friction_form": quantity(rate / 1.0603, "N*m/rad"), "stress": quantity(1180.0, "MPa"),
        "allowed_stress": quantity(1230.0, "MPa"), "tensile_strength": quantity(1740.0, "MPa"),
        "free_travel": quantity(31.0, DEG), "travel": quantity(25.0, DEG), "body_length": quantity(35.83, "mm"),
        "index": quantity(6.2, "1"), "wire_length": quantity(677.0, "mm"),
        "cut_length": quantity(737.0, "mm"), "mass": quantity(104.0, "g"),
        "arbor_diameter": quantity(8.0, "mm"), "arbor_clearance": quantity(17.0, "mm"),
        "elastic_modulus": quantity(203.4, "GPa"), "violations": [], "warnings": [],
        "strength_source": "maker's table, 5 mm", **other,
    }  # fmt: skip


def damper_law(joint: str) -> Json:
    """``damper_laws`` of one joint: a power law used, a linear one beside it, a table without its curve."""
    laws = [
        ("linear", "T = b w", {"rate": quantity(0.09, "N*m*s/rad")}, False),
        ("power", "T = T1 (w / w1)^p, w1 = 1 rad/s",
         {"torque_at_1_rad_per_s": quantity(0.1, "N*m"), "exponent": quantity(0.46, "1")}, True),
        ("coulomb_viscous", "T = Tc + b w",
         {"friction": quantity(0.03, "N*m"), "rate": quantity(0.06, "N*m*s/rad")}, False),
        ("table", "monotone", {"slope_1": quantity(0.3, "N*m*s/rad")}, False),
    ]  # fmt: skip
    return {
        "part": "6597K19",
        "speed_range": [quantity(0.06, "rad/s"), quantity(3.4, "rad/s")],
        "trials": [{"file": f"drops/{joint}_{i}.csv", "held_out": False} for i in range(4)],
        "how_held_out": "every second drop in turn",
        "laws": [
            {"law": law, "formula": formula, "parameters": numbers, "used": used,
             "rms_fitted": quantity(0.8, DEG), "rms_held_out": quantity(0.9, DEG)}
            for law, formula, numbers, used in laws
        ],
        "curve": f"dampers/{joint}.csv",
        "warnings": [f"{joint}: the damper was measured between 0.06 and 3.4 rad/s"],
    }  # fmt: skip


def design_link(mass: float) -> Json:
    """One link of ``design.json``: twice as heavy as assumed, its damper's mass not known."""
    figures = {"com": quantity(80.0, "mm"), "inertia": quantity(1e-3, "kg*m^2")}
    return {
        "includes": "joint",
        "assumed": {"mass": quantity(mass, "g"), **figures},
        "drawn": {"mass": quantity(2 * mass, "g"), **figures},
        "built": {"mass": quantity(2 * mass, "g"), **figures, "com_across": quantity(0.5, "mm")},
        "offset_torque": quantity(2e-3, "N*m"),
        "parts": [{"part": "a_damper", "mass": quantity(54.0, "g"), "basis": "assumed: of the drawn envelope"}],
    }


def design_joint(folder: Path, name: str, index: int) -> Json:
    """One joint of ``design.json``: the first's spring cannot be made, the second's is bought, the third's is made."""
    speeds = [0.05 * 800 ** (i / 11) for i in range(12)]
    write_columns(
        folder / "dampers" / f"{name}.csv",
        {"speed [rpm]": speeds, "torque [N*m]": [0.0346 * s**0.46 for s in speeds]},
    )
    rate = 40.0 / 2**index
    nearest = [
        {
            "kind": "parallel",
            "text": "2 in parallel, each within the limits",
            "make": spring_to_make(rate / 2, count=2),
        },
        {"kind": "smaller_travel", "text": "a smaller travel, 18 deg of 25 deg", "make": spring_to_make(rate)},
    ]
    springs: list[Json] = [
        {"make": None, "binding": ["stress: it has 2100 MPa, allowed are 1230 MPa"], "nearest": nearest},
        {"part": "LTR135H 10 M", "vendor": "Lee Spring", "rate": quantity(rate * 1.03, "N*m/rad"),
         "included_angle": quantity(120.0, DEG),
         "wanted_rate": quantity(rate * 0.98, "N*m/rad"), "rate_as_sold": quantity(rate * 1.03, "N*m/rad"),
         "wire_diameter": quantity(3.43, "mm"), "outer_diameter": quantity(29.5, "mm"),
         "body_coils": quantity(7.17, "1"), "source": "thesis, Table 6"},
        {"make": spring_to_make(rate)},
    ]  # fmt: skip
    return {
        "wanted": {
            "spring_rate": quantity(rate, "N*m/rad", rate * 0.06),
            "damper_rate": quantity(rate / 20, "N*m*s/rad", rate / 300),
            "free_angle": quantity(99.0 + 18 * index, DEG, 0.4),
        },
        "refit": {"spring_rate": quantity(rate * 0.98, "N*m/rad", 0.4), "free_angle": quantity(98.4, DEG, 0.4)},
        "damper": {
            "part": "6597K19", "vendor": "McMaster-Carr", "law": "power", "law_why": "measured drops",
            "curve": f"dampers/{name}.csv", "source": "thesis, Table 5",
            "vendor_point": {"torque": quantity(0.2189, "N*m"), "speed": quantity(50.0, "rpm")},
            "secant_rate": quantity(0.0418, "N*m*s/rad"),
        },
        "spring": {**springs[index % 3], "free_angle": quantity(111.0 + index, DEG)},
        "arm_offset": quantity(-9.0 + 14 * index, DEG),
        "spring_alternatives": [
            {"part": "LTR120", "vendor": "Lee Spring", "rate": quantity(rate * 1.2, "N*m/rad"),
             "rate_inch": quantity(rate * 0.154, "lbf*in/deg"), "within_tolerance": False,
             "response_error": quantity(1.4, DEG), "expected_error": quantity(1.7, DEG),
             "nominal_cost": quantity(0.2, DEG),
             "cost": quantity(0.3, DEG), "source": "catalogue"}
        ],
        "damper_alternatives": [
            {"part": "6597K8", "vendor": "McMaster-Carr", "response_error": quantity(2.2, DEG), "source": "thesis"}
        ],
        "tolerance": {
            "rate": quantity(10.0, "percent"), "free_angle": quantity(10.0, DEG), "torque": quantity(15.0, "percent"),
            "spring_source": "usual", "damper_source": "assumed",
        },
        "left_out": {"springs": {"included angle": 31, "outside diameter": 12}, "dampers": {"one-way": 40}},
        "warnings": [f"the free angle of {name} is known to 0.4 deg only"],
    }  # fmt: skip


def forecast(joints: list[str], expected: float) -> Json:
    """The response under tolerances."""
    causes = [{"joint": joints[0], "cause": "free angle"}, {"joint": "all", "cause": "temperature"}]
    return {
        "nominal": quantity(1.1, DEG),
        "expected": quantity(expected, DEG, 0.9),
        "within": quantity(3.0, DEG),
        "chance": quantity(0.42, "1"),
        "samples": 256,
        "causes": [
            {**cause, "share": quantity(share, "1"), "alone": quantity(share * 3, DEG)}
            for cause, share in zip(causes, (0.9, 0.1), strict=True)
        ],
    }


def make_design(folder: Path, joints: list[str] | None = None, trials: int = 7, name: str = "test leg") -> Json:
    """Write a whole design folder; returns the content of ``design.json``."""
    joints = joints or ["hip", "knee", "ankle"]
    files = [f"releases/release_{i + 1}.csv" for i in range(trials)]
    folder.mkdir(parents=True, exist_ok=True)
    write_responses(folder, joints, files, design=True)
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "assembly.png").write_bytes(png(320, 200))
    (folder / "parts" / "knee.png").write_bytes(png(160, 120))
    design: Json = {
        "format": "synth/leg-design/1",
        "name": name,
        "versions": {"synth": "0.1.0", "numpy": "2.0"},
        "inputs": [{"file": file, "sha256": f"{i:064x}"} for i, file in enumerate(["leg-design.yaml", *files])],
        "defaults": [{"key": "select.joints.ankle", "value": "any spring", "why": "nothing was asked"}],
        "settings": {
            "time_scale": {"value": 2.0, "unit": "1", "how": "scale.time"},
            "free_angle": "auto", "method": "least_squares", "cost": "trajectory", "weight": "amplitude",
        },
        "stages": {
            "source": fit(joints, files), "target": fit(joints, files, 2.0),
            "refit": fit(joints, files, 1.96, dampers=False),
        },
        "held_out": {
            "rms": {joint: quantity(0.7, DEG) for joint in joints},
            "trials": [{"file": "releases/check_1.csv", "rms": {joint: quantity(0.7, DEG) for joint in joints}}],
        },
        "damper_laws": {joints[-1]: damper_law(joints[-1])},
        "joints": {joint: design_joint(folder, joint, i) for i, joint in enumerate(joints)},
        "links": {joint: design_link(200.0) for joint in joints},
        "mass_rounds": {"count": 2, "settled": True},
        "response": {
            "wanted_to_built": {"rms": quantity(1.1, DEG), "joints": {joint: quantity(1.0, DEG) for joint in joints}},
            "forecast": forecast(joints, 3.1),
            "forecast_free_angles_measured": forecast(joints, 1.3),
            "alternatives": [
                {"parts": {joint: {"spring": "LTR120", "damper": "6597K8"} for joint in joints[:2]},
                 "rms": quantity(1.5, DEG), **forecast(joints, 3.6), "cost": quantity(0.5, DEG)}
            ],
            "search": {"sets": 1200, "simulated": 1200, "exhaustive": True, "none_better_left": True},
        },
        "warnings": [
            {"joint": joints[0], "text": "no single spring can do it", "severity": "decide"},
            {"joint": None, "text": "30 s", "severity": "note"},
        ],
        "solids": {
            "drawn": True, "notes": [],
            "checks": [{"name": "wall", "part": "knee_upper", "passed": True, "text": "wall: 3 mm, at least 1.2 mm",
                        "value": quantity(3.0, "mm"), "limit": quantity(1.2, "mm")}],
        },
        "pictures": [
            {"path": "parts/assembly.png", "caption": "the leg at rest"},
            {"path": "parts/knee.png", "caption": "knee, arm offset -9 deg"},
        ],
        "files": [{"path": "parts/assembly.png", "sha256": "ab" * 32}, {"path": "bom.csv", "sha256": "cd" * 32}],
    }  # fmt: skip
    write_json(folder / "design.json", design)
    return design


def make_fit(folder: Path, joints: list[str], trials: int) -> Json:
    """Write a fit folder; returns the content of ``fit.json``."""
    files = [f"trials/free_{i + 1}.csv" for i in range(trials)]
    folder.mkdir(parents=True, exist_ok=True)
    write_responses(folder, joints, files, design=False)
    content = fit(joints, files)
    write_json(folder / "fit.json", content)
    return content


def write_json(path: Path, content: Json) -> None:
    """Plain JSON."""
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")


@pytest.fixture
def leg_folder(tmp_path: Path) -> Callable[..., tuple[Path, Json]]:
    """A maker of design folders."""

    def made(**options: Any) -> tuple[Path, Json]:
        folder = tmp_path / "out"
        return folder, make_design(folder, **options)

    return made


@pytest.fixture
def fit_folder(tmp_path: Path) -> Callable[[list[str], int], tuple[Path, Json]]:
    """A maker of fit folders."""

    def made(joints: list[str], trials: int) -> tuple[Path, Json]:
        folder = tmp_path / "fit"
        return folder, make_fit(folder, joints, trials)

    return made
