"""Quantities: published conversion factors, angle as a dimension, and text that nobody means well by."""

from __future__ import annotations

import ast
import contextlib
import math
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth import units
from synth.errors import UserError
from synth.units_spelling import plain_unit


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        # NIST SP 811 (2008) appendix B.8 and exact definitions
        ("200 mm", "m", 0.2),
        ("200 fps", "Hz", 200.0),
        ("1.25 in", "m", 0.03175),
        ("31 ozf*in", "N*m", 31 * 7.061552e-3),
        ("1 lbf", "N", 4.448222),
        ("1 lb", "kg", 0.45359237),
        ("1 kgf*cm", "N*m", 0.0980665),
        ("1 psi", "Pa", 6894.757),
        ("5 ksi", "Pa", 5 * 6.894757e6),
        ("30 Msi", "Pa", 30 * 6.894757e9),
        ("50 rpm", "rad/s", 50 * 2 * math.pi / 60),
        ("0.39 N*m/deg", "N*m/rad", 0.39 * 180 / math.pi),
        ("1 rev", "rad", 2 * math.pi),
        ("5 %", "1", 0.05),
        ("3.5e-3 kg*m^2", "kg*m^2", 3.5e-3),
        ("35 kg cm²", "kg*m^2", 35e-4),
        ("740g", "kg", 0.74),
        ("−20 °", "rad", -math.radians(20)),
        ("9.81 m/s**2", "m/s^2", 9.81),
        ("1 N/(rad/s)", "N*s/rad", 1.0),
        ("5 mN·m", "N*m", 5e-3),
        (2, "1", 2.0),
        (0.5, "1", 0.5),
        ("90 deg", "deg", 90.0),
        # as people and vendors write them; 1 lbf in = 0.112 984 829 N m, 1 ozf in = 7.061 552 mN m (SP 811)
        ("1.7 Nm/rad", "N*m/rad", 1.7),
        ("5 N-m", "N*m", 5.0),
        ("3 mNm", "N*m", 3e-3),
        ("3 Nms/rad", "N*m*s/rad", 3.0),
        ("5 Ns/m", "N*s/m", 5.0),
        ("1 Nm/°", "N*m/rad", 180 / math.pi),
        ("15 in-lb/rad", "N*m/rad", 15 * 0.1129848),
        ("15 lb-in", "N*m", 15 * 0.1129848),
        ("15 lbf-in", "N*m", 15 * 0.1129848),
        ("2 lb-in-s/rad", "N*m*s/rad", 2 * 0.1129848),
        ("31 oz-in", "N*m", 31 * 7.061552e-3),
        ("31 in.oz", "N*m", 31 * 7.061552e-3),
        ("5 ft-lbs", "N*m", 5 * 1.355818),
        ("2 kg-cm", "N*m", 2 * 0.0980665),
        ("2 lb-in^2", "kg*m^2", 2 * 2.926397e-4),
        ("2 kg-m²", "kg*m^2", 2.0),
        ("1/2 in", "m", 0.0127),
        ('1/2"', "m", 0.0127),
        ("1 1/4 in", "m", 0.03175),
        ("1-1/4 in", "m", 0.03175),
        ("-1 ½ in", "m", -0.0381),
        ("5 1/s", "Hz", 5.0),
        ("0.5 in.", "m", 0.0127),
        ("2 in.-lb", "N*m", 2 * 0.1129848),
        ("2 inlb/rad", "N*m/rad", 2 * 0.1129848),
        ("2 inch-pounds", "N*m", 2 * 0.1129848),
        ("2 ounce-inches", "N*m", 2 * 7.061552e-3),
        ("10 kgcm", "N*m", 0.980665),
        ("12 gcm²", "kg*m^2", 12e-7),
        ("1.2 kgm^2", "kg*m^2", 1.2),
    ],
)
def test_reads_quantities(text: object, unit: str, value: float) -> None:
    assert units.parse(text, unit) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        (200, "m", ["200 has no unit", "200 mm", "length"]),
        ("200", "m", ['"200" has no unit', "200 mm"]),
        (0, "rad", ["0 has no unit"]),
        ("5 kg", "m", ["mass", "length"]),
        ("38 N*m", "N*m/rad", ["a torque", "torsional spring rate", "N*m/rad"]),
        ("5 Hz", "rad/s", ["a frequency", "an angular speed"]),
        ("31 oz*in", "N*m", ["did you mean ozf*in"]),
        ("2 in lb", "N*m/rad", ["did you mean in*lbf/rad?"]),
        ("5 kg cm", "N*m", ["did you mean kgf*cm?"]),
        ("5 kg·cm/rad", "N*m/rad", ["did you mean kgf*cm/rad?"]),
        ("15 lb in per rad", "N*m/rad", ["did you mean lbf*in/rad?"]),
        ("1.7 Nm", "N*m/rad", ["did you mean N*m/rad?"]),
        ("20 MM", "m", ['"MM"', "did you mean mm"]),
        ("5 Ns/m", "N/m", ["a damping", "a stiffness is needed"]),
        ("2 degg", "rad", ["did you mean deg"]),
        ("5 KSI", "Pa", ["did you mean ksi?"]),
        ("0,39 m", "m", ["point, not a comma: write 0.39 m"]),
        ("1,250 mm", "m", ["1250 mm", "1.250 mm"]),
        ("1,250,000 mm", "m", ["leave the commas out: 1250000 mm"]),
        ("1,5 Nm", "N*m", ["write 1.5 Nm"]),
        ("1.234,5 mm", "m", ["write 1234.5 mm"]),
        ("5 lbs", "N", ["did you mean lbf"]),
        ("1/0 in", "m", ["not a number"]),
        ("1 1 in", "m", ["cannot be read as a unit"]),
        ("nan m", "m", ["not a number"]),
        (math.nan, "1", ["not a number"]),
        (math.inf, "1", ["not a number"]),
        ("inf m", "m", ["not a number"]),
        ("1e999 m", "m", ["too large"]),
        ("1e308 km", "m", ["too large"]),
        (True, "1", ["not a quantity"]),
        (None, "m", ["no value", "200 mm"]),
        ("mm", "m", ["not a number"]),
        ("5 m*", "m", ["cannot be read as a unit"]),
        ("90 Grad", "rad", ['"Grad" in "Grad" is not accepted', "write deg for degrees; a gradian is 0.9 deg"]),
        ("0.4 N*m/Grad", "N*m/rad", ['"Grad" in "N*m/Grad" is not accepted', "write deg"]),
        ("100 grad", "rad", ['"grad" in "grad" is not accepted', "a gradian is 0.9 deg"]),
        ("1.2.3 m", "m", ["not a number"]),
    ],
)
def test_refuses_with_how_to_write_it(text: object, unit: str, words: list[str]) -> None:
    with pytest.raises(UserError) as caught:
        units.parse(text, unit)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9 m",
        "1 m**9**9",
        "1 m^99999999",
        "1 (m^9)^9",
        "1 m" + "*m" * 500_000,
        "1" * 1_000_000 + " m",
        "x" * 1_000_000,
        "1 __import__('os').system('true')",
        "1 m if 1 else m",
        "1 [m for m in (1,)]",
        "1 m\x00",
        "1 " + "x" * 50 + "?",
        "1 " + "m*" * 40 + "?",
        "1 " + "m0" * 40 + "!",
        "1 m**m",
        "1 11 m",
        "1 " + "(" * 90,
    ],
)
def test_hostile_text_is_refused_quickly(text: str) -> None:
    units.parse("1 mm", "m")  # pint's import is not what is timed
    start = time.process_time()
    with pytest.raises(UserError) as caught:
        units.parse(text, "m")
    assert time.process_time() - start < 1.0
    assert len(str(caught.value)) < 300


def test_header() -> None:
    assert units.header("hip velocity [deg/s]") == ("hip velocity", "deg/s")
    assert units.header(' "x" [ N*m ] ') == ('"x"', "N*m")
    for text in ("hip", "hip (deg)", "hip []", "[deg]", "a [b] [c]", "", "x" * 10_000 + "[m]"):
        with pytest.raises(UserError, match=r"\[deg\]"):
            units.header(text)


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(139.6, 2, "140"), (99.6, 2, "100"), (-1234.0, 3, "-1230"), (1.44, 2, "1.4"), (0.0139, 2, "0.014"), (0.0, 2, "0"),
     (999_400.0, 3, "999000"), (1.5e6, 2, "1.5e+06"), (math.inf, 2, "inf"), (math.nan, 2, "nan")],
)  # fmt: skip
def test_significant_digits_without_a_power_of_ten(value: float, digits: int, text: str) -> None:
    assert units.significant(value, digits) == text


def test_factor() -> None:
    assert units.factor("rpm", "rad/s") == pytest.approx(math.pi / 30)
    assert units.factor("ms", "s") == pytest.approx(1e-3)
    with pytest.raises(UserError, match="angle"):
        units.factor("deg", "m")
    with pytest.raises(UserError, match="did you mean deg"):
        units.factor("degr", "rad")


def test_quantity_shows_si_in_another_unit() -> None:
    shown = units.quantity(0.1, "deg", (0.09, math.inf))
    assert shown["value"] == pytest.approx(5.7296, abs=1e-4)
    assert shown["unit"] == "deg"
    assert shown["interval90"] == [pytest.approx(5.15662, abs=1e-5), None]
    assert "interval90" not in units.quantity(1.0, "m")
    with pytest.raises(ValueError, match="nan"):
        units.quantity(math.nan, "m")
    with pytest.raises(ValueError, match="interval"):
        units.quantity(1.0, "m", (math.nan, 2.0))


@given(
    st.floats(-1e12, 1e12, allow_nan=False),
    st.sampled_from(["mm", "deg", "kg*m^2", "N*m/rad", "N*m*s/rad", "rpm", "ozf*in", "%"]),
)
def test_written_quantity_reads_back(value: float, unit: str) -> None:
    canonical = {"mm": "m", "deg": "rad", "rpm": "rad/s", "ozf*in": "N*m", "%": "1"}.get(unit, unit)
    assert units.parse(units.write(value, unit), canonical) == pytest.approx(value, rel=1e-13, abs=1e-300)


@given(st.text(max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(UserError):
        assert math.isfinite(units.parse(text, "m"))


def test_import_alone_brings_no_pint() -> None:
    code = "import sys, synth.units; assert 'pint' not in sys.modules and 'numpy' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_units_of_results_need_no_pint() -> None:
    """``synth leg`` loaded it at the end for the inch units of two columns."""
    written = {
        plain_unit(arguments[1].value)
        for path in Path(units.__file__).parent.rglob("*.py")
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "quantity"
        if len(arguments := call.args) > 1 and isinstance(arguments[1], ast.Constant) and "commands" not in path.parts
    }
    assert {"deg", "lbf*in/deg"} < written
    assert written - set(units.OFTEN) == {"1"}


@pytest.mark.parametrize("unit", units.OFTEN)
def test_units_met_often_are_those_of_pint(unit: str) -> None:
    found, known = units._by_pint(unit, unit), units._unit(unit)
    assert found.factor == pytest.approx(known.factor, rel=1e-15)
    assert found.dimension == known.dimension


def test_no_unit_is_suggested_that_differs_in_its_prefix() -> None:
    """``ksi`` was unknown, and psi suggested for it: a strength of a thousandth."""
    with pytest.raises(UserError) as caught:
        units.parse("5 tsi", "Pa")
    assert "did you mean" not in str(caught.value)
