"""A measured motor as a catalogue row: a design takes it, with the constants that were measured."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hopper.hoppers import catalogue
from hopper.test_steady_and_seen import EFFICIENCY, EMF, FRICTION, RATIO, RESISTANCE, VISCOUS, motor_tests
from synth.cli import main
from synth.errors import UserError
from synth.files.hopper_project import read_hopper_project
from synth.hopper.identify_motor import IdentifiedConstant, MotorEstimate
from synth.hopper.measured_row import measured_row
from synth.hopper.study import sweep_problem
from synth.parts.catalogs import Catalogue, check_catalogue

TESTS = "stall: [stall.csv]\nfree_speed: [free.csv]\n"


def ran(folder: Path, keys: str, ratio: float = RATIO) -> int:
    (folder / "motor.yaml").write_text(f"kind: hopper-motor\ngear_ratio: {ratio:g}\n{keys}")
    return main(["-q", "hopper", str(folder / "motor.yaml"), "--out", str(folder / "motor")])


def test_a_design_takes_the_measured_motor_with_its_constants(tmp_path: Path) -> None:
    """Its constants were to be turned into a row by hand."""
    motor_tests(tmp_path)
    assert ran(tmp_path, f'motor: "N20 HP 6V 210:1"\n{TESTS}') == 0
    written = tmp_path / "motor" / "motor.csv"
    assert check_catalogue([written]) == []
    said = json.loads((tmp_path / "motor" / "motor.json").read_text())["design"]
    lines = "\n".join(said).replace("[motor.csv]", "[motor/motor.csv]")
    (tmp_path / "hopper.yaml").write_text(f"kind: hopper-design\n{lines}\n")
    project = read_hopper_project(tmp_path / "hopper.yaml")
    problem, (row,) = sweep_problem(project, Catalogue.load(project.catalogs))
    (made,), (tolerances,) = problem.motors, problem.tolerances
    true = {"resistance": RESISTANCE, "back_emf_constant": EMF, "friction": FRICTION, "viscous": VISCOUS,
            "torque_constant": EFFICIENCY * EMF}  # fmt: skip
    for name, value in true.items():
        assert getattr(made, name) == pytest.approx(value, rel=1e-4), name
    assert "the stall test" in row.basis
    assert row.mass == catalogue().find_motor("N20 HP 6V 210:1").mass
    steady = json.loads((tmp_path / "motor" / "motor.json").read_text())["steady"]["motor"]
    for name, share in (("back_emf_constant", tolerances.speed), ("torque_constant", tolerances.torque)):
        low, high = steady[name]["interval90"]
        assert share == pytest.approx(0.5 * (high - low) / steady[name]["value"], rel=0.01), name


def test_run_ups_give_inertia_and_inductance_and_the_catalogue_its_efficiency() -> None:
    row = catalogue().find_motor("N20 HP 6V 75:1")

    def known(value: float, low: float = 0.98) -> IdentifiedConstant:
        return IdentifiedConstant(value, 0.01 * value, (low * value, 1.02 * value))

    runs = MotorEstimate(
        known(3.75), known(9e-4), known(1.73e-3), known(1.7e-4), known(2e-9), known(1.2e-8), windows=100
    )
    found = measured_row(row, 75.81, runs, None)
    assert (found.row.inductance, found.row.rotor_inertia) == (9e-4, 1.2e-8)
    assert found.row.torque_gain == pytest.approx(row.torque_gain, rel=0.01)
    assert "the catalogue's efficiency" in found.row.basis
    assert found.tolerances == {"torque": 0.1, "rotor_inertia": pytest.approx(0.02)}
    unknown = MotorEstimate(
        known(3.75), known(9e-4, 0.0), known(1.73e-3), known(1.7e-4), known(2e-9), known(1.2e-8), windows=100
    )
    assert measured_row(row, 75.81, unknown, None).row.inductance is None
    with pytest.raises(UserError, match=r"gear ratio of 75\.81; gear_ratio is 1"):
        measured_row(row, 1.0, runs, None)


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        (f'motor: "N20 HP 6V 211:1"\n{TESTS}', "no gear motor"),
        (f'motor: "N20 HP 6V 150:1"\n{TESTS}', "gear ratio of 150"),
        ('motor: "N20 HP 6V 210:1"\nstall: [stall.csv]\n', "leave back emf, friction open"),
    ],
)
def test_a_motor_of_which_no_row_can_be_made_is_refused(
    keys: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    motor_tests(tmp_path)
    assert ran(tmp_path, keys) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "motor").exists()
