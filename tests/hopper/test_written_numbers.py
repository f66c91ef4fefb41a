"""The numbers of hopper.json and designs.csv against the columns of jump.csv, kinematics and energy."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from math import asin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hopper.hoppers import catalogue, motor
from synth.arrays import Array
from synth.cli import main
from synth.hopper.hopper_tolerances import QUANTITIES, copies
from synth.hopper.motors import motor_of
from synth.jump.hopper_leg import HopperLeg, HopperTolerances
from synth.jump.outcomes import OUTCOMES
from synth.jump.point_mass import point_mass_outcomes

UPPER, LOWER, HALF_SPACING = 0.08, 0.1, 0.015  # m
SUPPLY = 6.0  # V
PROJECT = """\
kind: hopper-design
motors: {catalogs: [mine.csv], use: ["N20 HP 6V 75:1", weak], gearbox: stop}
lengths: {least: 80 mm, most: 80 mm, step: 10 mm}
leg: {lower_ratio: 1.25}
laminate: {reference_length: 120 mm, link_mass: 3 g}
"""
# Too weak to lift the leg, and at rest already above what its gearbox bears.
WEAK = """\
part,vendor,gear_ratio [1],voltage [V],no_load_speed [rpm],stall_torque [N*mm],stall_current [mA],\
no_load_current [mA],mass [g],torque_limit [N*mm],source
weak,me,5,6,2500,7,360,20,10,1,my bench
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("written")
    (made / "mine.csv").write_text(WEAK)
    (made / "a.yaml").write_text(PROJECT)
    assert main(["-q", "hopper", str(made / "a.yaml"), "--no-cad", "--out", str(made / "out")]) == 0
    return made / "out"


@pytest.fixture(scope="module")
def found(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "hopper.json").read_text())
    return content


@pytest.fixture(scope="module")
def jump(folder: Path) -> dict[str, Array]:
    with (folder / "jump.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def designs(folder: Path) -> list[dict[str, str]]:
    with (folder / "designs.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_the_links_of_jump_csv_reach_from_the_hip_to_the_foot(jump: dict[str, Array]) -> None:
    """Down: the foot's height. Sideways: both lower links end in the middle, pointing inward.

    An upper link that bends is two equal stiff halves.
    """
    first, end, lower = (
        np.radians(jump[f"{name} [deg]"]) for name in ("upper link angle", "upper link end angle", "lower link angle")
    )
    down = 0.5 * UPPER * (np.cos(first) + np.cos(end)) + LOWER * np.cos(lower)
    # To a tenth of a millimetre: the table is between steps of the integration.
    np.testing.assert_allclose(jump["hip height [m]"] - down, jump["foot height [m]"], atol=1e-4)
    out = HALF_SPACING + 0.5 * UPPER * (np.sin(first) + np.sin(end)) - LOWER * np.sin(lower)
    np.testing.assert_allclose(out, 0.0, atol=1e-4)
    assert first[0] == end[0] == pytest.approx(np.radians(39.0), abs=1e-3)  # at rest the link is straight


def test_energy_peaks_and_heights_are_those_of_the_jump(
    folder: Path, found: dict[str, Any], jump: dict[str, Array]
) -> None:
    best = found["best"]
    (row,) = [row for row in designs(folder) if row["feasible"] == "yes"]
    time, takeoff = jump["time [s]"], best["takeoff_time"]["value"]
    pushing = time <= takeoff

    def until_takeoff(name: str) -> Array:
        return np.append(jump[name][pushing], np.interp(takeoff, time, jump[name]))

    energy = SUPPLY * np.trapezoid(until_takeoff("current [A]"), np.append(time[pushing], takeoff))
    speed = jump["centre of mass speed [m/s]"]
    rise = np.trapezoid(np.maximum(speed, 0.0), time)
    # Every thousandth of a second: the inrush, of 0.25 ms, is left out, and a peak may lie between two rows.
    wanted = {
        "energy": (energy, "energy [J]", 0.02),
        "peak_gear_torque": (np.abs(until_takeoff("gear torque [N*m]")).max(), "peak_gear_torque [N*m]", 0.08),
        "peak_current": (np.abs(until_takeoff("current [A]")).max(), "peak_current [A]", 0.01),
        "total_height": (rise, "total_height [m]", 0.003),
        "clearance": (jump["foot height [m]"].max(), "clearance [m]", 0.003),
        "takeoff_speed": (until_takeoff("centre of mass speed [m/s]")[-1], "takeoff_speed [m/s]", 0.01),
    }
    (as_chosen,) = [item for item in found["neighbours"] if item["change"] == "as chosen"]
    for name, (value, column, within) in wanted.items():
        for stated in (best[name]["value"], float(row[column]), *(
            item[name]["value"] for item in (as_chosen, found["models"]["full"], found["planar"][0])
        )):  # fmt: skip
            assert stated == pytest.approx(value, rel=within), name


def test_a_leg_that_leans_pitches_on_in_the_direction_of_its_lean(found: dict[str, Any]) -> None:
    """Weight and push act beside the foot: upright nothing turns it, leaning both turn it further, in proportion."""
    upright, *leaning = found["planar"]
    assert upright["lean"]["value"] == 0.0
    assert upright["final_pitch"]["value"] == pytest.approx(0.0, abs=0.01)
    shares = [item["final_pitch"]["value"] / item["lean"]["value"] for item in leaning]
    assert len(shares) >= 2
    assert min(shares) > 1.0
    assert shares[0] == pytest.approx(shares[-1], rel=0.05)


def test_beyond_the_gearbox_counts_jumps_only(folder: Path, found: dict[str, Any]) -> None:
    """With ``gearbox: stop`` each jump is feasible or beyond the gearbox; a design that stays down is neither."""
    (weak,) = [row for row in designs(folder) if row["motor"] == "weak"]
    assert weak["limit"].startswith("too weak")
    assert float(weak["peak_gear_torque [N*m]"]) > 1e-3  # its gearbox's limit, as in ``WEAK``
    counts = found["counts"]
    of_all = {name: counts[name] for name in ("designs", "jump", "beyond the gearbox", "feasible")}
    assert of_all == {"designs": 2, "jump": 1, "beyond the gearbox": 0, "feasible": 1}


def test_each_link_has_the_mass_of_its_own_length(found: dict[str, Any]) -> None:
    """3 g for 120 mm: 2 g for 80 mm and 2.5 g for 100 mm."""
    leg = found["best"]["leg"]
    assert (leg["upper_link_mass"]["value"], leg["lower_link_mass"]["value"]) == pytest.approx((2.0, 2.5))
    motors = 2 * found["best"]["motor_constants"]["mass"]["value"]
    assert leg["total_mass"]["value"] == pytest.approx(17.9 + motors + 2 * (2.0 + 2.5))


def test_a_body_s_mass_tolerance_is_of_the_body_with_its_motors() -> None:
    """Of 17.9 g and twice 9.5 g a tenth is 3.69 g."""
    leg, own = HopperLeg(), motor()
    made = copies(leg, own, HopperTolerances(mass=0.1))
    place = 1 + QUANTITIES.index("body mass")
    masses = [changed.total_mass(drive) for changed, drive in (made[0], made[place], made[place + len(QUANTITIES)])]
    assert masses[0] - masses[1] == pytest.approx(3.69e-3)
    assert masses[2] - masses[0] == pytest.approx(3.69e-3)


def test_a_motor_twice_as_large_in_every_direction_has_32_times_the_rotor_inertia() -> None:
    """Equal density: eight times the mass, at twice the radius."""
    row = catalogue().find_motor("N20 HP 6V 75:1")
    assert row.mass is not None
    small, large = motor_of(row), motor_of(replace(row, mass=8 * row.mass))
    assert large.rotor_inertia == pytest.approx(32 * small.rotor_inertia)


def test_the_point_mass_takes_the_energy_of_both_motors() -> None:
    """Their current falls linearly with speed: its integral is that of the time and of the angle turned."""
    leg, own, length = HopperLeg(), motor(), 0.1
    outcome = dict(zip(OUTCOMES, point_mass_outcomes(leg, own, np.array([length]))[:, 0], strict=True))
    start = length * np.cos(leg.crouch)
    rise = outcome["apex"] - outcome["clearance"]
    turned = asin((start + rise) / length) - asin(start / length)
    charge = own.stall_current * outcome["takeoff_time"]
    charge -= (own.stall_current - own.no_load_current) * turned / own.no_load_speed
    assert outcome["energy"] == pytest.approx(2 * own.voltage * charge, rel=0.01)  # steps of 0.2 ms
