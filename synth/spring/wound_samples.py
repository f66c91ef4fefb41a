"""The table of wound samples, and the file of the calibration that follows from them.

``SAMPLES.csv`` has one row per coil that was wound and measured: ``mandrel [mm],wire [mm],turns [1],coils [1],
outer_diameter [mm],free_angle [deg],rate [N*m/rad],leg_length [mm]``, in any unit of the same dimension; counts need
none (``coils``, ``coils [turns]``). Required are mandrel, wire and coils (of the free body), and either ``turns``
(wound on the mandrel) or ``outer_diameter`` (of the free coil). ``free_angle`` between tangent legs
determines the fraction of the coils. A ``rate`` needs its ``leg_length``: of each leg, from the coil to where the load
acts; 0 where it acts at the coil. Other columns without a unit are the user's own notes.
Semicolons or tabs may separate; decimals may then take a comma.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from synth.errors import Problem, UserError, did_you_mean
from synth.files.csv_rows import csv_rows, pointed, refuse_no_text, separator_of
from synth.files.paths import read_bytes
from synth.parts.coil_angle import coil_fraction
from synth.parts.coil_rate import RATE_FORMS, RATE_FORMULA, RateForm
from synth.parts.headers import COUNTED
from synth.parts.wire import WireMaterial, WireProperties
from synth.remarks import unlike
from synth.spring.calibration import (
    FLOW_RANGE,
    RATE_RANGE,
    Sample,
    WindingCalibration,
    flow_factor,
    mean_calibration,
    rate_factor,
)
from synth.units import factor, header, quantity

FORMAT = "synth/spring/calibration/1"
COLUMNS = {
    "mandrel": "m", "wire": "m", "turns": "1", "coils": "1", "outer_diameter": "m", "free_angle": "rad",
    "rate": "N*m/rad", "leg_length": "m",
}  # fmt: skip
NEEDED = ("mandrel", "wire", "coils")
AT_COIL = "leg_length"  # may be 0: the load acts at the coil
TYPING = 0.8  # likeness of names; that of ``parts.catalog_table``, for the same purpose
LARGEST = 1_000_000  # bytes; upper limit of either file
HALF = 0.5  # coils; the free angle's fraction corrects a counted number of coils by less than this


def read_samples(path: Path) -> tuple[Sample, ...]:
    """Read the table.

    Raises
    ------
    UserError : with every invalid header and cell.
    """
    name = str(path)
    data = read_bytes(path, LARGEST, "one row per wound coil")
    refuse_no_text(data, name)
    separator = separator_of(data.decode("utf-8-sig").lstrip().partition("\n")[0])
    rows = csv_rows(data, name, separator=separator)
    lines = [(line, row) for line, row in rows if any(cell.strip() for cell in row)]
    if len(lines) < 2:
        raise UserError(Problem("has no sample; the first line must have the headers, name [unit]", name))
    columns = _columns(lines[0][1], name)
    samples, problems = [], []
    for number, cells in lines[1:]:
        if any(cell.strip() for cell in cells[len(lines[0][1]) :]):
            text = f"has {len(cells)} cells under {len(lines[0][1])} headers"
            text += "; write decimals with a point, or separate cells by semicolons" if separator == "," else ""
            problems.append(Problem(text, name, line=number))
            continue
        try:
            written = [pointed(cell, separator) for cell in cells]
            samples.append(replace(_sample(_values(written, columns)), line=number))
        except ValueError as error:
            problems.append(Problem(str(error), name, line=number))
    if problems:
        raise UserError(problems)
    return tuple(samples)


def _columns(titles: Sequence[str], name: str) -> dict[str, tuple[int, float]]:
    """Index and factor to SI of each known column; an unknown one without a unit is a note, if no typing mistake."""
    columns: dict[str, tuple[int, float]] = {}
    problems, seen = [], set()
    for index, title in enumerate(titles):
        bare, _, unit = title.partition("[")
        bare = bare.strip().casefold().replace(" ", "_")
        if bare not in COLUMNS:
            meant = did_you_mean(bare, COLUMNS, cutoff=TYPING)
            if unit or meant:
                text = f'column "{title.strip()}" is not one of wound samples'
                problems.append(Problem(f"{text}{meant or _offered_columns()}", name, line=1))
            continue
        if bare in seen:
            problems.append(Problem("the column is given twice", name, line=1, key=bare))
            continue
        seen.add(bare)
        if COLUMNS[bare] == "1" and unit.strip(" ]").casefold() in COUNTED:
            columns[bare] = index, 1.0
            continue
        if "[" not in title:
            problems.append(Problem(f'column "{title}" has no unit: write it like {bare} [mm]', name, line=1))
            continue
        try:
            columns[bare] = index, factor(header(title)[1], COLUMNS[bare])
        except UserError as error:
            problems.append(Problem(str(error), name, line=1, key=bare))
    for needed in NEEDED:
        if needed not in columns and not any(problem.key == needed for problem in problems):
            problems.append(Problem(f"there is no column {needed}{_offered_columns()}", name, line=1))
    if problems:
        raise UserError(problems)
    return columns


def _offered_columns() -> str:
    return f"; the columns are {', '.join(COLUMNS)}"


def _values(cells: Sequence[str], columns: Mapping[str, tuple[int, float]]) -> dict[str, float]:
    found = {}
    for column, (index, scale) in columns.items():
        text = cells[index].strip() if index < len(cells) else ""
        if not text:
            continue
        try:
            value = float(text) * scale
        except ValueError:
            raise ValueError(f'{column}: "{text}" is not a number; the unit belongs in the header') from None
        if not (
            math.isfinite(value) and (column == "free_angle" or value > 0.0 or (column == AT_COIL and value == 0.0))
        ):
            allowed = {"free_angle": "be finite", AT_COIL: "be 0 or more"}.get(column, "be above 0")
            raise ValueError(f'{column}: "{text}" must {allowed}')
        found[column] = value
    return found


def _sample(values: Mapping[str, float]) -> Sample:
    """One row as a sample; ValueError for a missing or impossible value."""
    for needed in NEEDED:
        if needed not in values:
            raise ValueError(f"no {needed}")
    coils = values["coils"]
    if "free_angle" in values:
        fraction = coil_fraction(values["free_angle"])
        exact = round(coils - fraction) + fraction
        if abs(exact - coils) < HALF and exact > 0.0:
            coils = exact
    mean = None
    if "outer_diameter" in values:
        mean = values["outer_diameter"] - values["wire"]
        inside, mandrel = unlike((mean - values["wire"]) * 1e3, values["mandrel"] * 1e3)
        if mean <= values["mandrel"] + values["wire"]:
            raise ValueError(
                f"outer_diameter gives a free coil of {inside} mm inside, smaller than its mandrel of {mandrel} mm; "
                "a free coil is larger"
            )
    elif "turns" in values:
        if values["turns"] <= coils:
            turns, left = unlike(values["turns"], coils)
            raise ValueError(f"turns: {turns} on the mandrel cannot leave {left} coils; a free coil has fewer")
    else:
        raise ValueError("turns (wound on the mandrel) or outer_diameter (of the free coil) is required")
    if "rate" in values and AT_COIL not in values:
        raise ValueError("rate needs its leg_length: of each leg, from the coil to where the load acts; 0 at the coil")
    leg = values.get(AT_COIL, 0.0)
    return Sample(
        values["mandrel"], values["wire"], coils, values.get("turns"), mean, values.get("rate"), (leg, leg)
    )  # fmt: skip


def calibration_of(
    samples: Sequence[Sample], material: WireMaterial, form: RateForm, name: str | None = None
) -> WindingCalibration:
    """The calibration of a wire from its samples; ``name`` : of their table, in messages.

    Raises
    ------
    UserError : with every sample whose spring-back or rate is impossible.
    """
    flows: list[float] = []
    rates: list[float] = []
    problems: list[Problem] = []
    for sample in samples:
        try:
            wire = material.properties(sample.wire)
            flows.append(_flow(sample, wire))
            if sample.rate is not None:
                rates.append(_rate(sample, sample.rate, wire, form))
        except UserError as error:
            problems += [Problem(one.text, name, sample.line, one.key) for one in error.problems]
    if problems:
        raise UserError(problems)
    return replace(mean_calibration(flows, rates), material=material.name, form=form)


def _flow(sample: Sample, wire: WireProperties) -> float:
    """The sample's flow stress over the wire's strength."""
    found = flow_factor(sample, wire.elastic_modulus, wire.strength.value)
    if found is None:
        low, high = FLOW_RANGE
        back = (sample.free_mean or 0.0) - sample.wire
        raise UserError(
            f"springs back from its mandrel of {sample.mandrel * 1e3:.4g} mm to {back * 1e3:.4g} mm inside, which is "
            f"no yield stress of {low:g} to {high:g} times the wire's strength: check mandrel, wire and the free coil"
        )
    return found


def _rate(sample: Sample, measured: float, wire: WireProperties, form: RateForm) -> float:
    """The sample's rate over the formula's."""
    found = rate_factor(sample, wire.elastic_modulus, form)
    assert found is not None  # its diameter is known, since it has a flow stress
    low, high = RATE_RANGE
    if not low <= found <= high:
        raise UserError(
            Problem(
                f"{measured:.4g} N*m/rad is {found:.3g} times the {measured / found:.4g} N*m/rad of the formula, and "
                f"{low:g} to {high:g} times are possible: check its unit (per rad, deg or turn), wire and coils",
                key="rate",
            )
        )
    return found


def calibration_json(found: WindingCalibration, source: str) -> dict[str, Any]:
    """The content of the calibration file; ``source`` : the table of samples."""
    assert found.form is not None
    return {
        "format": FORMAT,
        "material": found.material,
        "source": source,
        "rate_formula": RATE_FORMULA[found.form],
        "spring_back": {**quantity(found.spring_back, "1"), "samples": found.n_back},
        "rate": {
            **quantity(found.rate, "1"),
            "samples": found.n_rate,
            **({} if found.spread is None else {"spread": quantity(found.spread, "1")}),
        },
    }


def read_calibration(path: Path) -> WindingCalibration:
    """Read a calibration file.

    Raises
    ------
    UserError : the file cannot be read, is not a calibration, or has an impossible factor.
    """
    try:
        content = json.loads(read_bytes(path, LARGEST, "a calibration file has a dozen lines").decode("utf-8"))
        if content["format"] != FORMAT:
            raise KeyError("format")
        back, rate = content["spring_back"], content["rate"]
        values = float(back["value"]), float(rate["value"])
        spread = float(rate["spread"]["value"]) if "spread" in rate else None
        numbers = int(back["samples"]), int(rate["samples"])
        form = RATE_FORMS[content["rate_formula"]]
        found = WindingCalibration(*values, spread, *numbers, material=str(content["material"]), form=form)
    except UserError as error:
        raise UserError([Problem(one.text, one.file, key="--calibration") for one in error.problems]) from None
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        text = f"is not a result of synth spring calibrate ({error})"
        raise UserError(Problem(text, str(path), key="--calibration")) from None
    for what, value, (low, high) in (
        ("spring_back", found.spring_back, FLOW_RANGE),
        ("rate", found.rate, RATE_RANGE),
    ):
        if not low <= value <= high:
            text = f"{what}: the factor {value:.4g} is impossible, {low:g} to {high:g} are allowed; calibrate again"
            raise UserError(Problem(text, str(path), key="--calibration"))
    return found
