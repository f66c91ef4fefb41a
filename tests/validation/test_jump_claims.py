"""The jumping leg's claims: the calibration, its consequences, and closed forms of the figures in the sentences."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from synth.cli import main
from synth.commands.reproduce import reproduced_text
from synth.jump.outcomes import PEAK_GEAR_TORQUE
from synth.validation.jump_claims import (
    GEAR_LIMIT,
    LENGTH,
    MEASURED,
    MOST_OVER,
    PREDICTED,
    RATIO,
    ROTOR_DENSITY,
    ROTOR_INERTIA,
    ROTOR_LENGTH,
    Configuration,
    calibrate_crouch,
    deepest_crouch,
    inertia_for,
    printed_work_share,
    rotor_diameter,
)

TWO_CELLS = Configuration(supply=7.4, damping=0.0005)


def test_the_stall_torque_is_the_one_in_the_laboratorys_code() -> None:
    """Its code: 0.00016 * 5.7 / 4.3586, in kgf m, is one motor's stall torque."""
    motor = Configuration().motor(1.0)
    assert motor.stall_torque == pytest.approx(0.00016 * 5.7 / 4.3586 * 9.80665)
    assert motor.driving_efficiency == 1.0
    assert Configuration().motor(RATIO).stall_torque == pytest.approx(RATIO * motor.stall_torque)


def test_the_printed_work_share_against_a_sum() -> None:
    theta = np.linspace(radians(30.0), radians(80.0), 20_001)
    summed = np.trapezoid(np.cos(theta) ** 2, theta) / (theta[-1] - theta[0])
    assert printed_work_share(radians(60.0), radians(10.0)) == pytest.approx(float(summed), rel=1e-6)
    assert printed_work_share(pi / 2, 0.0) == pytest.approx(0.5)


def test_a_calibrated_crouch_gives_the_published_prediction_as_clearance() -> None:
    found = calibrate_crouch(TWO_CELLS)
    assert found is not None
    assert found.height("D") == pytest.approx(PREDICTED, rel=1e-3)
    assert radians(30.0) < found.crouch < deepest_crouch()
    best = found.best("D", 0.14)
    assert 180.0 <= best.ratio <= 240.0
    assert 0.11 <= best.length <= 0.15
    assert found.height("full") < min(found.height("B"), found.height("D"))


def test_the_laboratorys_supply_does_not_reach_the_prediction() -> None:
    assert calibrate_crouch(Configuration()) is None
    assert replace(Configuration(), crouch=deepest_crouch()).height("D") == pytest.approx(0.2, abs=0.02)


def test_the_measured_height_needs_a_lighter_rotor() -> None:
    found = calibrate_crouch(TWO_CELLS)
    assert found is not None
    inertia = inertia_for(found)
    assert inertia is not None
    assert inertia < 0.5 * ROTOR_INERTIA
    assert replace(found, inertia=inertia).height("full") == pytest.approx(MEASURED, rel=0.01)
    nominal, low, high = found.interval("full")
    assert low < nominal < high < MEASURED
    assert found.by_length("D", RATIO, np.array([LENGTH, 0.02]))[1] == 0.0  # the crouch is out of its reach


def test_the_rotor_of_an_inertia_by_thin_discs() -> None:
    """J is the sum of m r^2 / 2 over discs of iron and copper; the estimate's rotor fits the motor's can of 10 mm."""
    diameter = rotor_diameter(ROTOR_INERTIA)
    mass = ROTOR_DENSITY * pi * diameter**2 / 4.0 * ROTOR_LENGTH
    assert mass * diameter**2 / 8.0 == pytest.approx(ROTOR_INERTIA)
    assert 0.006 < diameter < 0.009


def test_a_high_stop_clears_more_and_breaks_the_gear() -> None:
    stopped = calibrate_crouch(Configuration(supply=11.1, extended=radians(40.0)))
    stretched = calibrate_crouch(Configuration(supply=7.4))
    assert stopped is not None
    assert stretched is not None
    assert stopped.height("full") > MEASURED > 1.5 * stretched.height("full")
    assert stopped.height("full", row=PEAK_GEAR_TORQUE) > 10.0 * GEAR_LIMIT
    assert stretched.height("full", row=PEAK_GEAR_TORQUE) < MOST_OVER * GEAR_LIMIT


def test_the_command_writes_four_tables(tmp_path: Path) -> None:
    assert main(["--quiet", "reproduce", "jump", "--out", str(tmp_path / "out")]) == 0
    found = json.loads((tmp_path / "out" / "reproduction.json").read_text())
    assert [table["name"] for table in found["tables"]] == ["Claims", "Heights", "Configurations", "Stops"]
    assert all(table["differences"] for table in found["tables"])
    stops = found["tables"][-1]["differences"]
    assert "times the 0.196 N*m that its maker allows" in stops[0]
    assert "unless the rotor is that light" in stops[1]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "clearance over leg length, measured" in page
    # The headline answers; what ours is calibrated to is not counted.
    judged = {row["label"]: row["holds"] for row in found["tables"][0]["rows"] if "holds" in row}
    assert "predicted clearance (D), 12 cm, 210:1" not in judged
    assert judged["a point mass jumps higher than A"] is False
    assert judged["8 cm with 150:1 jumps higher over its length than 12 cm with 210:1"] is True
    assert f"{sum(judged.values())} of {len(judged)} published claims hold; not: measured clearance" in page
    assert re.search(rf"Claims +11 +{sum(judged.values())} of {len(judged)} ", reproduced_text(found))
    # A row that does not reach 22 cm says so.
    for row in found["tables"][2]["rows"]:
        assert ("22 cm is out of reach" in row["label"]) == (row["cells"][3]["value"] < 21.9)
