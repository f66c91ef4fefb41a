"""A free angle that the fit calls unknown is unknown in its files, tables and comparisons."""

from __future__ import annotations

import csv
from math import radians
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from fit.simulated_legs import robot
from synth.api.fitting import Fit
from synth.batch.folder_summary import fit_columns
from synth.commands.compare import compare_text
from synth.comparison.compare_sides import compare, table_columns
from synth.comparison.side import MODEL, Side, joints_of
from synth.estimation.intervals import Estimate
from synth.files.output import write_csv
from synth.files.projects import FitProject
from synth.fit.fit_result import FitResult, JointFit

RATE, SPREAD = Estimate(0.0007, "N*m/rad", 0.0, 0.005), Estimate(0.0, "deg")


def fitted(half: float) -> dict[str, object]:
    """A joint's entry of ``fit.json``; ``half`` deg, half of the free angle's interval."""
    free = Estimate(radians(14.6), "deg", radians(14.6 - half), radians(14.6 + half))
    return JointFit(RATE, free, SPREAD, None).as_json()


@pytest.mark.parametrize(("half", "unknown"), [(731.0, True), (180.0, True), (170.0, False)])
def test_an_interval_of_a_full_turn_makes_it_unknown(half: float, unknown: bool, tmp_path: Path) -> None:
    entry = fitted(half)
    free = entry["free_angle"]
    assert isinstance(free, dict)
    assert free["value"] == pytest.approx(14.6)
    assert free.get("unknown", False) == unknown
    name = robot().joint_names[0]
    leg = robot()
    sides = [Side("A", "A", MODEL, leg, joints_of(leg, {name: entry})), Side("B", "B", MODEL, leg, joints_of(leg))]
    found = compare(sides)
    shown = compare_text(found.as_json())
    assert ("unknown" in shown) == unknown
    assert ("14.6" in shown) != unknown
    write_csv(tmp_path / "compare.csv", table_columns(found))
    with (tmp_path / "compare.csv").open() as stream:
        rows = [row for row in csv.DictReader(stream) if (row["side"], row["joint"]) == ("A", name)]
    row = next(row for row in rows if row["quantity"] == "free_angle")
    assert (row["value"] == "", row["basis"].startswith("unknown")) == (unknown, unknown)
    assert float(row["low"]) == pytest.approx(14.6 - half)
    legs = {"name": "a", "trials": 1, "joints": {name: entry}, "rms": {}, "warnings": [], "not_separable": []}
    (value,) = fit_columns({"legs": [legs], "failed": []})["free_angle [deg]"]
    assert (value is None) == unknown


def test_a_fits_table_has_no_value_for_it() -> None:
    joints = {
        name: JointFit(RATE, Estimate(0.25, "deg", 0.25 - half, 0.25 + half), SPREAD, None)
        for name, half in (("upper", 12.7), ("lower", 0.1))
    }
    result = SimpleNamespace(joints=joints, rms=dict.fromkeys(joints, 0.01))
    table = Fit(cast(FitProject, None), cast(FitResult, result)).columns()
    assert table["free angle [deg]"][0] is None
    assert table["free angle [deg]"][1] == pytest.approx(14.3, abs=0.1)
    assert table["free angle high [deg]"][0] == pytest.approx(742, abs=1)
