"""A leg design as files: design.json, bom.csv, the leg, its MJCF, responses and torque-speed curves."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import synth
from synth.design.dampers import DamperOption
from synth.design.leg_design import LegDesign, fastest_rates
from synth.design.springs import SpringOption
from synth.files.curve import write_curve
from synth.files.leg import write_leg
from synth.files.mjcf import write_mjcf
from synth.files.output import sha256_file, stems, write_csv
from synth.fit.result import FitResult, TrialFit
from synth.model.leg import Array
from synth.units import quantity

FORMAT = "synth/leg-design/1"
ALTERNATIVES = 8
LIBRARIES = ("numpy", "scipy", "numba", "cadquery")


def write_files(design: LegDesign, folder: Path) -> None:
    """Everything but design.json, solids and pages."""
    write_leg(design.built, folder / "built.leg.yaml")
    write_leg(design.target.leg, folder / "wanted.leg.yaml")
    times = [release.time for release in design.wanted.releases]
    write_mjcf(design.built, fastest_rates(design.built_motions, times), folder / "leg.mjcf.xml")
    curves = folder / "dampers"
    curves.mkdir()
    for joint in design.built.joints:
        if joint.damper is not None and joint.damper.curve is not None:
            write_curve(joint.damper.curve, curves / f"{joint.name}.csv")
    for name, law in design.laws.items():
        write_curve(law.used.curve, curves / f"{name}_measured.csv")
        for fit in law.fits:
            write_curve(fit.curve, curves / f"{name}_{fit.law.name}.csv")
    write_fit_responses(design.source, folder / "responses" / "source")
    _write_target_responses(design, folder / "responses" / "target")
    _write_bom(design, folder / "bom.csv")


def write_fit_responses(result: FitResult, folder: Path) -> None:
    """Each trial's measured and fitted angles, ``NAME.csv`` in degrees."""
    folder.mkdir(parents=True)
    names = result.leg.joint_names
    for trial, stem in zip(result.trials, stems([t.name for t in result.trials]), strict=True):
        columns: dict[str, Array] = {"time [s]": trial.time}
        for j, name in enumerate(names):
            columns[f"{name} measured [deg]"] = np.degrees(trial.measured[:, j])
            columns[f"{name} fitted [deg]"] = np.degrees(trial.fitted[:, j])
        write_csv(folder / f"{stem}.csv", columns)


def _write_target_responses(design: LegDesign, folder: Path) -> None:
    """The animal's motion in the robot's time, the wanted leg's and the built leg's, in degrees."""
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
        write_csv(folder / f"{stem}.csv", columns)


def design_json(design: LegDesign, files: Sequence[Path], folder: Path, extra: dict[str, Any]) -> dict[str, Any]:
    """The content of ``design.json``; ``files`` in ``folder`` are listed with their hashes, ``extra`` is added."""
    project = design.project
    names = design.built.joint_names
    how = "square root of the ratio of leg lengths" if project.dynamic_similarity else "a factor"
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
        "joints": {name: _joint(design, j) for j, name in enumerate(names)},
        "response": {
            "wanted_to_built": {
                "rms": quantity(float(np.sqrt(np.mean(design.errors**2))), "deg"),
                "joints": {n: quantity(float(e), "deg") for n, e in zip(names, design.errors, strict=True)},
            },
            "alternatives": _alternatives(design),
        },
        "warnings": [{"joint": joint, "text": text} for joint, text in design.warnings],
        **extra,
        "files": [{"path": path.relative_to(folder).as_posix(), "sha256": sha256_file(path)} for path in files],
    }


def _inputs(design: LegDesign) -> list[dict[str, str]]:
    """Every file that the design rests on: project, legs, catalogues and curves, then the recordings."""
    project = design.project
    trials = [*project.trials, *(trial for damper in project.dampers.values() for trial in damper.trials)]
    found = {item.name: item.sha256 for item in project.inputs} | {trial.name: trial.sha256 for trial in trials}
    return [{"file": name, "sha256": digest} for name, digest in found.items()]


def _held_out(trials: Sequence[TrialFit], names: Sequence[str]) -> dict[str, Any] | None:
    """How far the fitted leg is off on trials that took no part."""
    if not trials:
        return None
    square = np.array([trial.rms**2 for trial in trials])
    rms = [float(np.sqrt(np.mean(column[np.isfinite(column)]))) for column in square.T]
    return {
        "rms": {name: quantity(value, "deg") for name, value in zip(names, rms, strict=True)},
        "trials": [
            {
                "file": trial.name,
                "rms": {n: quantity(float(v), "deg") for n, v in zip(names, trial.rms, strict=True) if v == v},
            }
            for trial in trials
        ],
    }


def _joint(design: LegDesign, j: int) -> dict[str, Any]:
    name = design.built.joint_names[j]
    wanted, refit = design.target.joints[name], design.refit.joints[name]
    spring, damper = design.springs.chosen[j], design.dampers.chosen[j]
    built = design.built.joints[j].spring
    assert built is not None
    assert wanted.damper_rate is not None
    written = {
        "wanted": {
            "spring_rate": wanted.spring_rate.as_json(),
            "damper_rate": wanted.damper_rate.as_json(),
            "free_angle": wanted.free_angle.as_json(),
        },
        "refit": {"spring_rate": refit.spring_rate.as_json(), "free_angle": refit.free_angle.as_json()},
        "damper": _damper(damper, name),
        "spring": {**spring.as_json(), "free_angle": quantity(built.free_angle, "deg")},
        "arm_offset": quantity(design.arm_offset(j), "deg"),
        "spring_alternatives": [_ranked_spring(option) for option in design.springs.ranked[j] if option is not spring],
        "damper_alternatives": [
            _ranked_damper(option) for option in design.dampers.ranked[j] if option.part != damper.part
        ],
        "alternatives_basis": (
            "response_error: RMS over all joints and releases against the wanted motion with only this joint's part "
            "changed; a damper is judged with the spring that suits it, a spring with the chosen dampers"
        ),
        "left_out": {"springs": dict(design.springs.left_out[j]), "dampers": dict(design.dampers.left_out[j])},
        "warnings": [text for joint, text in design.warnings if joint == name],
    }
    return written


def _damper(option: DamperOption, joint: str) -> dict[str, Any]:
    row = option.row
    written: dict[str, Any] = {
        "part": option.part,
        "vendor": row.vendor if row is not None else None,
        "law": option.law,
        "law_why": option.why,
    }
    if option.damper.curve is not None:
        written["curve"] = f"dampers/{joint}.csv"
    if row is not None:
        written["source"] = row.source
        if row.max_torque is not None and row.speed is not None:
            point = {"torque": quantity(row.max_torque, "N*m"), "speed": quantity(row.speed, "rpm")}
            written["vendor_point"] = point
            written["secant_rate"] = quantity(row.max_torque / row.speed, "N*m*s/rad")
    return written


def _ranked_spring(option: SpringOption) -> dict[str, Any]:
    row = option.row
    return {
        "part": option.part,
        "vendor": row.vendor if row is not None else None,
        "rate": quantity(option.rate, "N*m/rad"),
        "response_error": quantity(option.error, "deg"),
        "source": row.source if row is not None else "to wind",
    }


def _ranked_damper(option: DamperOption) -> dict[str, Any]:
    row = option.row
    return {
        "part": option.part,
        "vendor": row.vendor if row is not None else None,
        "law": option.law,
        "response_error": quantity(option.error, "deg"),
        "source": row.source if row is not None else option.why,
    }


def _alternatives(design: LegDesign) -> list[dict[str, Any]]:
    """The next best sets: other springs with the chosen dampers, and other dampers with springs that suit them."""
    names = design.built.joint_names
    found = []
    for springs, error in design.springs.sets[1:]:
        parts = {
            name: {"spring": s.part, "damper": d.part}
            for name, s, d in zip(names, springs, design.dampers.chosen, strict=True)
        }
        found.append((error, {"parts": parts, "rms": quantity(error, "deg")}))
    for other in design.dampers.sets[1:]:
        parts = {}
        for joint, option in zip(other.leg.joints, other.options, strict=True):
            assert joint.spring is not None
            parts[joint.name] = {"spring": f"one of {joint.spring.rate:.3g} N*m/rad", "damper": option.part}
        found.append((other.error, {"parts": parts, "rms": quantity(other.error, "deg")}))
    found.sort(key=lambda item: item[0])
    return [item for _, item in found[:ALTERNATIVES]]


def _write_bom(design: LegDesign, path: Path) -> None:
    """One line a thing to order or make; cells that a spreadsheet would take for a formula are defused."""
    rows: list[dict[str, str]] = []
    for joint, spring, damper in zip(design.built.joints, design.springs.chosen, design.dampers.chosen, strict=True):
        rows.append(_spring_line(joint.name, spring))
        row = damper.row
        vendor, source = (row.vendor, row.source) if row is not None else ("", damper.why)
        what = "rotary damper"
        if row is not None and row.max_torque is not None and row.speed is not None:
            what += f", {row.max_torque:.4g} N*m at {row.speed * 30 / np.pi:.4g} rpm"
        rows.append(_line(joint.name, what, vendor, damper.part, "1", source))
    header = ("joint", "item", "vendor", "part", "quantity", "source")
    write_csv(path, {name: [_defused(row[name]) for row in rows] for name in header})


def _spring_line(joint: str, option: SpringOption) -> dict[str, str]:
    if option.row is not None:
        row = option.row
        return _line(joint, f"torsion spring, {option.rate:.4g} N*m/rad", row.vendor, row.part, "1", row.source)
    design = option.design
    assert design is not None
    what = (
        f"{design.material} wire, {design.wire_diameter * 1e3:.4g} mm, {design.wire_length * 1e3:.0f} mm a spring: "
        f"wind {design.body_coils:.4g} coils on {design.mean_diameter * 1e3:.4g} mm mean diameter"
    )
    return _line(joint, what, "to wind", "", str(design.count), design.strength_source)


def _line(joint: str, item: str, vendor: str, part: str, count: str, source: str) -> dict[str, str]:
    return {"joint": joint, "item": item, "vendor": vendor, "part": part, "quantity": count, "source": source}


def _defused(cell: str) -> str:
    """A cell that starts like a formula gets an apostrophe, which spreadsheets show as text."""
    return f"'{cell}" if cell[:1] in tuple("=+-@\t\r") else cell
