"""A leg design as files: design.json, the leg file and robot descriptions, responses, torque-speed curves."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import synth
from synth.arrays import Array
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.fit_responses import write_fit_responses as write_fit_responses
from synth.design.leg_design import LegDesign, joint_swings
from synth.design.measured_forecast import measured_free_angles, tolerance_json
from synth.design.spring_entry import spring_entry
from synth.files.curve import write_curve
from synth.files.input_hashes import input_hashes
from synth.files.leg_file import write_leg
from synth.files.output import place, stems, write_csv
from synth.files.run_manifest import sha256_file
from synth.fit.fit_result import TrialFit
from synth.remarks import remark_json
from synth.swing.mechanics import FROUDE
from synth.units import quantity

FORMAT = "synth/leg-design/1"
LIBRARIES = ("numpy", "scipy", "numba", "cadquery")


def write_files(design: LegDesign, folder: Path) -> None:
    """Write all files except design.json, solids and pages."""
    write_leg(design.built, folder / "built.leg.yaml")
    write_leg(design.target.leg, folder / "wanted.leg.yaml")
    curves = folder / "dampers"
    curves.mkdir()
    for joint in design.built.joints:
        if joint.damper is not None and joint.damper.curve is not None:
            write_curve(joint.damper.curve, place(curves, f"{joint.name}.csv"))
    for name, law in design.laws.items():
        write_curve(law.used.curve, place(curves, f"{name}_measured.csv"))
        for fit in law.fits:
            write_curve(fit.curve, place(curves, f"{name}_{fit.law.name}.csv"))
    write_fit_responses(design.source, folder / "responses" / "source")
    _write_target_responses(design, folder / "responses" / "target")


def _write_target_responses(design: LegDesign, folder: Path) -> None:
    """Write the animal's motion in the robot's time and those of the wanted and the built leg, in degrees."""
    folder.mkdir(parents=True)
    leg = design.built
    fitted = [trial for trial in design.target.trials if not trial.held_out]
    for trial, wanted, built, stem in zip(
        fitted, design.wanted.motions, design.built_motions, stems([t.name for t in fitted]), strict=True
    ):
        shift = trial.free_angle - np.array([j.free_angle.value for j in design.target.joints.values()])
        columns: dict[str, Array] = {"time [s]": trial.time}
        for j, name in enumerate(leg.joint_names):
            columns[f"{name} animal [deg]"] = np.degrees(trial.measured[:, j] - shift[j])
            columns[f"{name} wanted [deg]"] = np.degrees(leg.to_measured(wanted)[:, j])
            columns[f"{name} built [deg]"] = np.degrees(leg.to_measured(built)[:, j])
        write_csv(place(folder, f"{stem}.csv"), columns)


def design_json(design: LegDesign, files: Sequence[Path], folder: Path, extra: dict[str, Any]) -> dict[str, Any]:
    """The content of ``design.json``; ``files`` in ``folder`` are listed with their hashes, ``extra`` is added."""
    project = design.project
    names = design.built.joint_names
    parts = {part["part"]: part for part in extra.get("solids", {}).get("parts", [])}
    how = FROUDE if project.dynamic_similarity else "a factor"
    return {
        "format": FORMAT,
        "name": project.name,
        "versions": {"synth": synth.__version__, **{n: importlib.metadata.version(n) for n in LIBRARIES}},
        "inputs": _inputs(design),
        "defaults": [{"key": d.key, "value": d.value, "why": d.reason} for d in project.defaults],
        "settings": {
            "time_scale": {**quantity(project.time_scale, "1"), "how": how},
            "free_angle": project.free_angle,
            "method": project.fit.method,
            "cost": project.fit.cost,
            "weight": project.fit.weight,
            "seed": project.fit.seed,
        },
        "target_effects": [effect.as_json() for effect in design.target_effects],
        "stages": {
            "source": design.source.as_json(),
            "target": design.target.as_json(),
            "refit": design.refit.as_json(),
        },
        "held_out": _held_out(design.held_out, names),
        "damper_laws": {
            joint: {"part": project.dampers[joint].part, **law.as_json(), "curve": f"dampers/{joint}_measured.csv"}
            for joint, law in design.laws.items()
        },
        "joints": {
            name: {**_joint(design, j), **extra.get("solids", {}).get("joints", {}).get(name, {})}
            for j, name in enumerate(names)
        },
        "links": {link.joint: link.as_json(design.built.gravity) for link in design.links},
        "mass_rounds": None if design.rounds is None else asdict(design.rounds),
        "response": {
            "wanted_to_built": {
                "rms": quantity(float(np.sqrt(np.mean(design.errors**2))), "deg"),
                "joints": {n: quantity(float(e), "deg") for n, e in zip(names, design.errors, strict=True)},
            },
            "animal_to_wanted": _animal_to_wanted(design),
            "forecast": design.sets.chosen.forecast.as_json(),
            "forecast_free_angles_measured": design.sets.measured.as_json(),
            "free_angles_measured": list(measured_free_angles(design)),
            **({"fit_uncertainty": design.robustness.as_json()} if design.robustness is not None else {}),
            "alternatives": [item.as_json(names, design.sets.chosen) for item in design.sets.sets[1:]],
            "search": _search(design),
        },
        "warnings": [{"joint": joint, **remark_json(text)} for joint, text in design.warnings],
        **extra,
        "files": [_file(path, folder, parts) for path in files],
    }


def _animal_to_wanted(design: LegDesign) -> dict[str, Any]:
    """How far the wanted motion is from the animal's in the robot's time, and where it is another one."""
    return {
        "joints": {name: quantity(off, "deg") for name, off in design.target.rms.items()},
        "another_motion": list(design.another_motion),
    }


def _file(path: Path, folder: Path, parts: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """A file with its hash; for a part's solid also its joint and the body that it is fixed to."""
    written: dict[str, Any] = {"path": path.relative_to(folder).as_posix(), "sha256": sha256_file(path)}
    part = parts.get(path.stem) if path.suffix in (".step", ".stl", ".glb") else None
    return written if part is None else {**written, "joint": part["joint"], "moves_with": part["moves_with"]}


def _inputs(design: LegDesign) -> list[dict[str, str]]:
    """Every input file of the design: project, legs, catalogues and curves, then the recordings."""
    return [{"file": name, "sha256": digest} for name, digest in input_hashes(design.project).items()]


def _held_out(trials: Sequence[TrialFit], names: Sequence[str]) -> dict[str, Any] | None:
    """RMS error of the fitted leg on the held-out trials."""
    if not trials:
        return None
    off = np.concatenate([trial.measured - trial.fitted for trial in trials])
    counted = [column[np.isfinite(column)] for column in off.T]
    rms = [float(np.sqrt(np.mean(column**2))) if len(column) else float("nan") for column in counted]
    return {
        "rms": {name: quantity(value, "deg") for name, value in zip(names, rms, strict=True) if value == value},
        "trials": [
            {
                "file": trial.name,
                "rms": {n: quantity(float(v), "deg") for n, v in zip(names, trial.rms, strict=True) if v == v},
            }
            for trial in trials
        ],
    }


def _has_measured_rate(design: LegDesign, name: str) -> bool:
    measured = design.project.measured_springs.get(name)
    return measured is not None and measured.rate is not None


def _joint(design: LegDesign, j: int) -> dict[str, Any]:
    name = design.built.joint_names[j]
    wanted, refit = design.target.joints[name], design.refit.joints[name]
    spring, damper = design.springs.chosen[j], design.dampers.chosen[j]
    built = design.built.joints[j].spring
    assert built is not None
    assert wanted.damper_rate is not None
    written: dict[str, Any] = {
        "wanted": {
            "spring_rate": wanted.spring_rate.as_json(),
            "damper_rate": wanted.damper_rate.as_json(),
            "free_angle": wanted.free_angle.as_json(),
        },
        "refit": {"spring_rate": refit.spring_rate.as_json(), "free_angle": refit.free_angle.as_json()},
        "damper": {**_damper(damper, name), **_damper_as_drawn(design, j)},
        "spring": {
            **spring_entry(spring),
            **({"measured_rate": quantity(built.rate, "N*m/rad")} if _has_measured_rate(design, name) else {}),
            "free_angle": quantity(built.free_angle, "deg"),
        },
        "arm_offset": quantity(design.arm_offset(j), "deg"),
        "spring_alternatives": [
            _ranked_spring(option, spring) for option in design.springs.ranked[j] if option is not spring
        ],
        "damper_alternatives": [
            _ranked_damper(option, damper) for option in design.dampers.ranked[j] if option is not damper
        ],
        "alternatives_basis": (
            "response_error: RMS over all joints and releases of the difference from the wanted motion, with only this "
            "joint's part changed. Another damper has its best spring (with_spring, if that is not the chosen one). "
            "nominal_cost: response_error minus that of the chosen set. expected_error: with tolerances, free angles "
            "measured and seats adjusted. cost: expected_error minus that of the chosen set; the choice and the order "
            "of the list are by it"
        ),
        "tolerance": tolerance_json(design, j),
        "left_out": {"springs": dict(design.springs.left_out[j]), "dampers": dict(design.dampers.left_out[j])},
        "motion": joint_swings(design)[j].as_json(),
        "warnings": [str(text) for joint, text in design.warnings if joint == name],
    }
    stated = next((item for item in design.ranges if item.joint == name), None)
    return written if stated is None else {**written, "range": stated.as_json()}


def _damper(option: DamperOption, joint: str) -> dict[str, Any]:
    row = option.row
    arrangement = option.arrangement
    written: dict[str, Any] = {
        "part": option.part,
        "vendor": row.vendor if row is not None else None,
        "count": arrangement.pieces,
        "pair": arrangement.pair,
        "ratio": quantity(arrangement.ratio, "1"),
        "arrangement": option.label,
        "law": option.law,
        "law_why": option.why,
    }
    if option.damper.curve is not None:
        written["curve"] = f"dampers/{joint}.csv"
    if row is not None:
        written["source"] = row.source
        written["order"] = row.order
        if row.derived:
            written["derived"], written["measure_before_printing"] = list(row.derived), list(row.measure)
        if row.max_torque is not None and row.speed is not None:
            point = {"torque": quantity(row.max_torque, "N*m"), "speed": quantity(row.speed, "rpm")}
            written["vendor_point"] = point
            written["secant_rate"] = quantity(row.max_torque / row.speed, "N*m*s/rad")
    return written


def _damper_as_drawn(design: LegDesign, j: int) -> dict[str, Any]:
    """Whether the shaft slips in the drawn damper, and the keys of its sizes that are assumed; empty if not drawn."""
    if design.drawn is None:
        return {}
    drawn = design.drawn.dimensions.joints[j].damper
    return {"slips": drawn.adapter is None and drawn.bore.slips, "assumed_sizes": list(drawn.unknown)}


def _costs(option: SpringOption | DamperOption, chosen: SpringOption | DamperOption) -> dict[str, Any]:
    """What a substitute costs in response: with tolerances, by which parts are chosen, and with nominal parts."""
    return {
        "nominal_cost": quantity(option.error - chosen.error, "deg"),
        "expected_error": quantity(option.expected, "deg"),
        "cost": quantity(option.expected - chosen.expected, "deg"),
    }


def _ranked_spring(option: SpringOption, chosen: SpringOption) -> dict[str, Any]:
    row, made = option.row, option.design
    wire = row.wire_diameter if row is not None else made.wire_diameter if made is not None else None
    outer = row.outer_diameter if row is not None else made.outer_diameter if made is not None else None
    sizes = {"wire_diameter": wire, "outer_diameter": outer}
    return {
        "part": option.label,
        "vendor": row.vendor if row is not None else None,
        "count": option.number,
        "rate": quantity(option.rate, "N*m/rad"),
        "rate_inch": quantity(option.rate, "lbf*in/deg"),
        "rate_as_sold": quantity(option.as_sold, "N*m/rad"),
        "within_tolerance": not option.outside,
        "response_error": quantity(option.error, "deg"),
        **_costs(option, chosen),
        **{name: quantity(value, "mm") for name, value in sizes.items() if value is not None},
        **{f"{name}_inch": quantity(value, "in") for name, value in sizes.items() if value is not None},
        "source": row.source if row is not None else "to wind",
    }


def _ranked_damper(option: DamperOption, chosen: DamperOption) -> dict[str, Any]:
    row = option.row
    written = {
        "part": option.label,
        "vendor": row.vendor if row is not None else None,
        "count": option.arrangement.pieces,
        "ratio": quantity(option.arrangement.ratio, "1"),
        "law": option.law,
        "response_error": quantity(option.error, "deg"),
        **_costs(option, chosen),
        "source": row.source if row is not None else option.why,
        **({"with_spring": option.partner} if option.partner else {}),
    }
    if row is not None and row.max_torque is not None:
        written["torque"] = quantity(row.max_torque, "N*m")
        written["torque_inch"] = quantity(row.max_torque, "ozf*in")
    return written


def _search(design: LegDesign) -> dict[str, Any]:
    """Record of the search for sets."""
    found, parts = design.sets.found, design.project.parts
    written: dict[str, Any] = {
        "sets": found.n_set,
        "simulated": found.n_simulated,
        "exhaustive": found.exhaustive,
        "none_better_left": found.complete,
        "pairs_left_out": dict(zip(design.built.joint_names, design.sets.cut, strict=True)),
        "filters": {"vendors": list(parts.vendors), "without": list(parts.without), "system": parts.system or "any"},
    }
    if found.mistake is not None:
        written["screen"] = {
            "slope": quantity(found.mistake.slope, "1"),
            "least_ratio": quantity(found.mistake.ratio, "1"),
        }
    return written
