"""The identification experiments' results as JSON, and for people."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from typing import Any

import synth
from synth.files.named_files import InputFile
from synth.hopper.identify_damping import DampingEstimate
from synth.hopper.identify_motor import IdentifiedConstant, MotorEstimate
from synth.hopper.steady_motor import SteadyMotor
from synth.hopper.validate_jumps import Validation
from synth.units import quantity


def head(kind: str, name: str, inputs: Sequence[InputFile]) -> dict[str, Any]:
    """What every result begins with."""
    return {
        "format": f"synth/{kind}/1",
        "name": name,
        "versions": {"synth": synth.__version__, "numpy": importlib.metadata.version("numpy")},
        "inputs": [{"file": item.name, "sha256": item.sha256} for item in inputs],
    }


def _estimate(found: IdentifiedConstant, unit: str) -> dict[str, Any]:
    return quantity(found.value, unit, found.interval90)


def motor_json(found: MotorEstimate) -> dict[str, Any]:
    """Constants at the rotor with intervals."""
    zero, lag = found.current_zero, found.speed_lag
    notes = [text for text in (zero.sentence, lag.sentence) if text]
    return {
        "motor": {
            "resistance": _estimate(found.resistance, "ohm"),
            "inductance": _estimate(found.inductance, "mH"),
            "back_emf_constant": _estimate(found.back_emf, "V/(rad/s)"),
            "friction": _estimate(found.friction, "N*m"),
            "viscous": _estimate(found.viscous, "N*m*s/rad"),
            "rotor_inertia": _estimate(found.rotor_inertia, "kg*m^2"),
        },
        "windows": found.windows,
        **({"current_zero": quantity(zero.value, "A", zero.interval90)} if zero.value else {}),
        **({"speed_lag": quantity(lag.seconds, "ms")} if lag.seconds else {}),
        **({"notes": notes} if notes else {}),
        **({"not_determined": list(found.not_determined)} if found.not_determined else {}),
    }


def steady_json(found: SteadyMotor) -> dict[str, Any]:
    """Constants from stall and free-speed tests, and what these leave open."""
    units = {"resistance": "ohm", "back_emf": "V/(rad/s)", "friction": "N*m", "viscous": "N*m*s/rad",
             "torque_constant": "N*m/A", "torque_per_current_at_stall": "N*m/A"}  # fmt: skip
    names = {"back_emf": "back_emf_constant"}
    constants = {names.get(key, key): _estimate(value, units[key]) for key, value in found.constants.items()}
    return {"steady": {"motor": constants, "points": found.points, "not_determined": list(found.not_determined)}}


def damping_json(found: DampingEstimate) -> dict[str, Any]:
    """The one damping, each length's beside it."""
    return {
        "method": found.method,
        "joint_damping": _estimate(found.damping, "N*m*s/rad"),
        "by_length": [
            {"length": quantity(length, "m"), "joint_damping": _estimate(value, "N*m*s/rad")}
            for length, value in found.by_length.items()
        ],
        "angle_error": quantity(found.angle_error, "deg"),
        "windows": found.windows,
        "windows_at_stop": found.windows_at_stop,
    }


def validation_json(found: Validation) -> dict[str, Any]:
    """Measured jumps and every model's prediction."""
    measured = _ends(found.mean_rise, found.rise_reach)
    return {
        "measured": [
            {
                "file": jump.name,
                "switched_on": quantity(begun.time, "s"),
                "takeoff_time": quantity(jump.takeoff_time, "s"),
                "takeoff_speed": quantity(jump.takeoff_speed, "m/s"),
                "rise": quantity(jump.rise, "m", _ends(jump.rise, jump.rise_reach)),
                "rise_after_takeoff": quantity(jump.rise_after_takeoff, "m"),
                "flight_rise": None if jump.flight_rise is None else quantity(jump.flight_rise, "m"),
                "peak_force": quantity(jump.peak_force, "N"),
                "start_angle": quantity(jump.start_angle, "deg"),
            }
            for jump, begun in zip(found.jumps, found.switched_on, strict=True)
        ],
        "notes": [
            text
            for jump, begun, zero in zip(found.jumps, found.switched_on, found.plate_zeros, strict=True)
            for text in (begun.sentence(jump.name), zero.sentence(jump.name), jump.sentence())
            if text
        ],
        "mean_rise": quantity(found.mean_rise, "m", measured),
        "models": {
            item.model: {
                "rise": quantity(item.outcome.rise, "m"),
                "over_measured": item.outcome.rise / found.mean_rise - 1.0,
                "over_measured_interval90": [
                    None if end <= 0.0 else item.outcome.rise / end - 1.0 for end in reversed(measured)
                ],
                "takeoff_time": quantity(item.outcome.takeoff_time, "s"),
                "takeoff_speed": quantity(item.outcome.takeoff_speed, "m/s"),
                "peak_force": quantity(item.outcome.peak_normal, "N"),
                "force_error": quantity(item.force_error, "N"),
                "angle_error": quantity(item.angle_error, "deg"),
            }
            for item in found.comparisons
        },
    }


def _ends(value: float, reach: float) -> tuple[float, float]:
    """Ends of a height's interval, never below 0."""
    return max(0.0, value - reach), value + reach


def lines(result: dict[str, Any]) -> list[str]:
    """The numbers for the screen."""
    if "motor" in result or "steady" in result:
        shown = [_line(name, value) for name, value in result.get("motor", {}).items()]
        steady = result.get("steady", {})
        shown += [_line(f"steady {name}", value) for name, value in steady.get("motor", {}).items()]
        left_open = [*result.get("not_determined", []), *steady.get("not_determined", [])]
        shown += [f"not determined: {text}" for text in left_open]
        shown += [f"note: {text}" for text in result.get("notes", [])]
        return [*shown, *(f"in a design: {text}" for text in result.get("design", []))]
    if "joint_damping" in result:
        each = [_line(f"  {item['length']['value'] * 100:g} cm", item["joint_damping"]) for item in result["by_length"]]
        stopped = result["windows_at_stop"]
        text = (
            f"note: {stopped} of {stopped + result['windows']} windows, in which the leg is on its stop, are left out"
        )
        return [_line("joint_damping", result["joint_damping"]), *each, *([text] if stopped else [])]
    if "measured" not in result:
        return seen_lines(result["seen"])
    rise = result["mean_rise"]
    between = " to ".join(f"{end * 100:.2f}" for end in rise["interval90"])
    shown = [f"measured: rise {rise['value'] * 100:.2f} cm ({between}, 90 %) over {len(result['measured'])} jumps"]
    for name, item in result["models"].items():
        least, most = ("any" if end is None else f"{end:+.0%}" for end in item["over_measured_interval90"])
        over = f"{item['over_measured']:+.0%} of measured ({least} to {most})"
        shown.append(f"{name}: rise {item['rise']['value'] * 100:.2f} cm, {over}")
    return [*shown, *seen_lines(result.get("seen", {})), *(f"note: {text}" for text in result["notes"])]


def seen_lines(seen: dict[str, Any]) -> list[str]:
    """What video and meter show, and each model's beside it."""
    found = []
    for key, item in seen.items():
        value = item["mean"]
        models = ", ".join(f"{name} {each['over_measured']:+.0%}" for name, each in item["models"].items())
        count = len(item["measured"])
        found.append(f"{key.replace('_', ' ')}: {value['value']:.4g} {value['unit']} over {count} jumps; {models}")
    return found


def _line(name: str, value: dict[str, Any]) -> str:
    low, high = value["interval90"]
    return f"{name}: {value['value']:.5g} {value['unit']} ({low:.5g} to {high:.5g})"
