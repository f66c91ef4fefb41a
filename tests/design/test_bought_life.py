"""Bought springs that break early: no candidates where full turns are required, told of where none are."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from pathlib import Path

import pytest

from synth.cad import JointDimensions, SpringDimensions
from synth.design.choose_springs import SpringSource, WantedTravel, other_springs, spring_options
from synth.design.drawn_springs import _with_free_arms
from synth.design.spring_warnings import spring_warnings
from synth.files.project_options import CadOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.remarks import severity_of
from synth.spring.bought_spring import breaks_early, check_bought

WINDING, OPENING = radians(28.84), radians(27.5)
HEAD = (
    "part,vendor,material,included_angle [deg],rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],body_coils [1]\n"
)
# WEAK yields at 46 deg; LASTS is a coil of thicker wire with nearly its rate; UNTOLD has no fatigue data.
ROWS = {
    "WEAK": "music wire,120,1.6,2.1,13.8852,3.1667",
    "LASTS": "music wire,120,1.5,3.0,24.0,7.1667",
    "UNTOLD": "hard drawn,120,1.5,3.0,24.0,7.1667",
}


def source(folder: Path, *parts: str, **asked: object) -> SpringSource:
    path = folder / "mine.csv"
    path.write_text(HEAD + "".join(f"{part},Mine,{ROWS[part]}\n" for part in parts))
    whole = Catalogue.load([path])
    only = replace(
        whole,
        springs=tuple(row for row in whole.springs if row.file == str(path)),
        materials=tuple(
            replace(row, repeated_bending_limit_1e6=None) if row.material == "hard drawn" else row
            for row in whole.materials
        ),
    )
    choice = SpringChoice(**{"rate_tolerance": 0.6, **asked})  # type: ignore[arg-type]
    return SpringSource("knee", choice, WantedTravel(WINDING, OPENING), only, CadOptions())


def gerber(sut: float, share: float, amplitude: float, mean: float) -> float:
    """Strength over stress: the largest n for which n Sa/Se + (n Sm/Sut)^2 <= 1, by bisection."""
    half = share * sut / 2.0
    endurance = half / (1.0 - (half / sut) ** 2)
    low, high = 0.0, 100.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        bears = middle * amplitude / endurance + (middle * mean / sut) ** 2 <= 1.0
        low, high = (middle, high) if bears else (low, middle)
    return low


def test_the_life_of_a_bought_spring_is_that_of_the_textbook(tmp_path: Path) -> None:
    """Shigley, tables 10-4 and 10-10, eqs 10-44, 10-58, 10-59, with the strength of music wire by its law."""
    where = source(tmp_path, "WEAK")
    check = check_bought(where.catalogue.find_spring("WEAK"), where.catalogue, WINDING, OPENING)
    assert check is not None
    assert check.life is not None
    wire, mean_diameter = 2.1, 11.7852
    index = mean_diameter / wire
    inner = (4 * index**2 - index - 1) / (4 * index * (index - 1))
    wound, opened = (inner * 32 * 1.6e3 * angle / (pi * wire**3) for angle in (WINDING, OPENING))
    strength = 2211.0 / wire**0.145
    for share, found in ((0.53, check.life.factor_1e5), (0.50, check.life.factor_1e6)):
        assert found == pytest.approx(gerber(strength, share, (wound + opened) / 2, (wound - opened) / 2), rel=0.03)
    assert check.life.factor_1e5 < 0.7
    other = check_bought(where.catalogue.find_spring("WEAK"), where.catalogue, OPENING, WINDING)
    assert other is not None  # in the other seat, in which it may be drawn
    assert other.life is not None
    assert other.life.factor_1e6 == pytest.approx(check.life.factor_1e6, rel=0.01)


def test_a_spring_that_does_not_last_the_required_turns_is_left_out_and_counted(tmp_path: Path) -> None:
    where = source(tmp_path, "WEAK", "LASTS", make=False, cycles=1e6)
    options, left_out, _ = spring_options(where, 1.6)
    assert [each.part for each in options] == ["LASTS"]
    assert left_out == {"may break before 1000000 full turns": 1}
    assert [each.part for each in other_springs(where, 1.6, [])] == ["LASTS"]
    free = source(tmp_path, "WEAK", "LASTS", make=False)
    both = spring_options(free, 1.6)[0]  # as sold WEAK is the nearer one, in the joint its four coils are softer
    assert [each.part for each in both] == ["LASTS", "WEAK"]
    assert abs(both[0].rate / 1.6 - 1.0) < abs(both[1].rate / 1.6 - 1.0)


def test_where_none_lasts_one_is_wound_that_does(tmp_path: Path) -> None:
    (option,), _, (said,) = spring_options(source(tmp_path, "WEAK", cycles=1e6), 1.6)
    assert option.design is not None
    assert option.design.life is not None
    assert option.design.life.factor_1e6 >= 1.0
    assert "1 may break before 1000000 full turns" in said


@pytest.mark.parametrize("asked", [{"part": "WEAK"}, {"make": False}])
def test_a_named_part_or_the_only_one_that_breaks_early_is_told(tmp_path: Path, asked: dict[str, object]) -> None:
    where = source(tmp_path, "WEAK", cycles=1e5, **asked)
    (option,), _, _ = spring_options(where, 1.6)
    (said,) = spring_warnings("knee", option, where.choice)
    assert said.startswith("knee: WEAK may break before 100000 full turns: strength over stress for 1e+05 cycles 0.")
    assert ", required 1 (Gerber)" in said
    assert severity_of(said) == "decide"


def test_without_required_turns_the_same_is_told_as_of_a_wound_spring(tmp_path: Path) -> None:
    where = source(tmp_path, "WEAK", make=False)
    (option,), _, _ = spring_options(where, 1.6)
    assert option.passed == ()
    assert option.check is not None
    (said,) = spring_warnings("knee", option, where.choice)
    (of_wound,) = (text for text in option.check.warnings if "100 000" in text)
    assert said == f"knee: WEAK {of_wound.removeprefix('it ')}"
    assert severity_of(said) == severity_of(of_wound) == "decide"
    lasting = source(tmp_path, "LASTS", make=False)
    assert spring_warnings("knee", spring_options(lasting, 1.6)[0][0], lasting.choice) == []


def test_a_life_that_the_catalogue_does_not_tell_is_no_life_that_is_known(tmp_path: Path) -> None:
    """As of a given spring: required turns must be known to be reached; none required, it is a note."""
    required = source(tmp_path, "UNTOLD", "LASTS", make=False, cycles=1e5)
    options, left_out, _ = spring_options(required, 1.5)
    assert [each.part for each in options] == ["LASTS"]
    assert left_out == {"life unknown, 100000 full turns required": 1}
    free = source(tmp_path, "UNTOLD", make=False)
    (said,) = spring_warnings("knee", spring_options(free, 1.5)[0][0], free.choice)
    assert said == "knee: it is not known how long UNTOLD lasts: no fatigue data are known for hard drawn wire"
    assert severity_of(said) == "note"
    bare = replace(free.catalogue.find_spring("UNTOLD"), material="")
    assert check_bought(bare, free.catalogue, WINDING) is None
    early = breaks_early(None, 1e5, "the catalogue has too few data of it")
    assert early is not None
    assert early.text == "may not last 100000 full turns: the catalogue has too few data of it"
    assert breaks_early(None, None) is None


def test_one_that_lasts_only_until_its_joint_is_drawn_is_told_then(tmp_path: Path) -> None:
    """Shorter drawn arms load the coil's ends more: the required turns are judged again."""
    where = source(tmp_path, "LASTS", make=False, cycles=1e6)
    (option,), _, _ = spring_options(where, 1.5)
    assert option.row is not None
    spring = SpringDimensions(3.0, 21.0, 7 + 60 / 360, 120.0)
    drawn = _with_free_arms(option, JointDimensions("knee", spring, 120.0, 120.0), 20.0, where.catalogue)
    assert spring_warnings("knee", drawn, where.choice) == []
    assert drawn.check is not None
    turned = check_bought(option.row, where.catalogue, 4 * WINDING, OPENING)
    assert turned is not None
    (said,) = spring_warnings("knee", replace(drawn, check=turned), where.choice)
    assert "LASTS may break before 1000000 full turns" in said
