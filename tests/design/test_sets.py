"""Springs and dampers of all joints chosen together: filters, arrangements, and the errors of alternatives."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

import synth.design.part_swaps as part_swaps
from synth.design.choose_dampers import DamperLimits, choose_dampers
from synth.design.choose_springs import SpringSource, spring_to_wind, travels
from synth.design.clamped_arms import softening_by_arms
from synth.design.judged_sets import Judge, Pair
from synth.design.part_sets import SetsMade, choose_sets
from synth.design.part_swaps import JointParts, Swap, Swaps, _other_springs, without_better_swap
from synth.design.spring_entry import spring_entry
from synth.design.spring_warnings import wanted_rate_note
from synth.errors import UserError
from synth.files.project_options import (
    CadOptions,
    DamperChoice,
    JointChoice,
    PartsOptions,
    SpringChoice,
    ToleranceOptions,
)
from synth.parts.catalogs import Catalogue
from synth.parts.part_candidates import ANY
from synth.swing.mechanics import rest_pose
from three_links import LEG, wanted

HEAD = (
    "part,vendor,material,included_angle [deg],leg_convention,rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],"
    "body_coils [1]\n"
)
BOUGHT, ONE_DAMPER = SpringChoice(make=False, rate_tolerance=0.5), DamperChoice()
DAMPERS = "part,vendor,direction,continuous,max_torque [N*m],speed [rpm]\n"


def spring_line(part: str, vendor: str, rate: float, wire: float, coils: float = 5.25) -> str:
    """A spring of music wire that has ``rate`` (N m/rad) with its clamped arms; its row states that of the body alone.

    The body's diameter by E d^4 / (64 D N) with E of that wire.
    """
    modulus = 200e9 if wire < 1.6 else 196.5e9 if wire < 3.2 else 193e9
    opening = travels(LEG, wanted().motions)["HKA".index(part[0])].opening
    body = rate
    for _ in range(20):
        mean = modulus * (wire * 1e-3) ** 4 / (64.0 * body * coils)
        body = rate / softening_by_arms(wire * 1e-3, mean, coils, opening, CadOptions())
    return f"{part},{vendor},music wire,90,tangent,{body},{wire},{mean * 1e3 + wire},{coils}\n"


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory: pytest.TempPathFactory) -> Catalogue:
    folder = tmp_path_factory.mktemp("parts")
    springs, dampers = folder / "springs.csv", folder / "dampers.csv"
    lines = [
        spring_line("H18", "Alpha", 18.0, 4.5), spring_line("H20", "Beta", 20.0, 4.5),
        spring_line("K2", "Alpha", 2.0, 2.2), spring_line("K1", "Beta", 1.0, 1.9),
        spring_line("A05", "Alpha", 0.5, 1.5), spring_line("A06", "Beta", 0.55, 1.524),
    ]  # fmt: skip
    springs.write_text(HEAD + "".join(lines))
    torque = {"DH": 5.236, "DK": 0.628, "DA": 0.157, "DA4": 0.0393}
    rows = "".join(f"{part},Gamma,both,yes,{value},50\n" for part, value in torque.items())
    one_way = "D1,Gamma,clockwise,yes,0.3142,50\n"
    dampers.write_text(DAMPERS + rows + one_way)
    whole = Catalogue.load([springs, dampers])
    own = {str(springs), str(dampers)}
    return replace(
        whole,
        springs=tuple(row for row in whole.springs if row.file in own),
        dampers=tuple(row for row in whole.dampers if row.file in own),
    )


def choose(
    catalogue: Catalogue,
    parts: PartsOptions = ANY,
    spring: SpringChoice = BOUGHT,
    damper: DamperChoice = ONE_DAMPER,
) -> SetsMade:
    response = wanted()
    choices = {name: JointChoice(spring, damper) for name in LEG.joint_names}
    turned = [2.0] * 3
    dampers = choose_dampers(response, choices, catalogue, {}, turned, law="linear", limits=DamperLimits(parts))
    sources = [
        SpringSource(name, spring, travel, catalogue, CadOptions(), parts)
        for name, travel in zip(LEG.joint_names, travels(LEG, response.motions), strict=True)
    ]
    return choose_sets(response, LEG, dampers, sources, parts).shown()


@pytest.fixture(scope="module")
def made(catalogue: Catalogue) -> SetsMade:
    return choose(catalogue)


def springs(made: SetsMade) -> list[str]:
    return [pair.spring.label for pair in made.chosen.pairs]


def test_the_exact_parts_are_chosen(made: SetsMade) -> None:
    assert springs(made) == ["H18", "K2", "A05"]
    assert [pair.damper.label for pair in made.chosen.pairs[1:]] == ["DK", "DA"]
    assert rest_pose(made.leg) == pytest.approx(rest_pose(LEG), abs=1e-9)


def test_sets_are_ordered_by_expected_error(made: SetsMade) -> None:
    expected = [item.ready.expected for item in made.sets[1:]]
    assert expected == sorted(expected)
    assert made.chosen.ready.expected <= expected[0] + np.radians(0.05)  # on other draws than the others
    assert all(item.forecast.expected >= item.forecast.nominal * 0.5 for item in made.sets)
    low, high = made.chosen.forecast.interval90
    assert low < made.chosen.forecast.expected < high
    assert made.found.exhaustive


def test_measured_free_angles_leave_a_smaller_error(made: SetsMade) -> None:
    assert made.measured.expected < made.chosen.forecast.expected
    assert made.measured.chance >= made.chosen.forecast.chance


def test_vendors_can_be_restricted(catalogue: Catalogue) -> None:
    found = choose(catalogue, PartsOptions(vendors=("beta", "Gamma")))
    assert springs(found)[0] == "H20"
    assert {option.row.vendor for each in found.springs.ranked for option in each if option.row} == {"Beta"}
    assert "not of beta or Gamma" in found.springs.left_out[0]


def test_an_excluded_part_is_replaced_by_the_first_alternative(catalogue: Catalogue, made: SetsMade) -> None:
    """A new choice without the part takes the first alternative."""
    ranked = [option for option in made.springs.ranked[2] if option.part != "A05" and not option.outside]
    found = choose(catalogue, PartsOptions(without=("a05",)))
    assert springs(found)[2] == ranked[0].label == "A06"
    assert found.chosen.error >= made.chosen.error - 1e-6


def test_wire_can_be_restricted_to_inch_or_metric(catalogue: Catalogue) -> None:
    inch = choose(catalogue, PartsOptions(system="inch"), SpringChoice(rate_tolerance=0.5, wire="music"))
    for options in inch.springs.ranked:
        for option in options:
            assert option.row is None or option.row.system in (None, "inch")
    metric = choose(catalogue, PartsOptions(system="metric"))
    assert springs(metric) == ["H18", "K2", "A05"]


def test_two_springs_in_parallel_reach_the_rate(catalogue: Catalogue) -> None:
    parts = PartsOptions(without=("K2",))
    asked = SpringChoice(make=False, rate_tolerance=0.2, parallel=2)
    with pytest.raises(UserError, match="knee: none of"):
        choose(catalogue, parts, replace(asked, parallel=1))
    found = choose(catalogue, parts, asked)
    assert springs(found)[1] == "2 x K1"
    assert found.springs.chosen[1].rate == pytest.approx(2.0, rel=1e-3)


def test_a_damper_behind_a_belt_is_chosen_when_it_fits_best(catalogue: Catalogue) -> None:
    """A quarter of the torque at twice the speed is the ankle's own: 2 T(2 w) = 4 T(w) where T is linear."""
    found = choose(catalogue, PartsOptions(without=("DA",)), damper=DamperChoice(ratios=(1.0, 2.0)))
    chosen = found.dampers.chosen[2]
    assert (chosen.part, chosen.arrangement.ratio) == ("DA4", 2.0)
    assert chosen.damper.rate == pytest.approx(4 * 0.0393 / (50 * np.pi / 30), rel=1e-6)


def test_one_way_dampers_are_used_in_pairs_only(catalogue: Catalogue) -> None:
    parts = PartsOptions(without=("DK", "DH", "DA", "DA4"))
    with pytest.raises(UserError, match="parallel: 2 allows a pair"):
        choose(catalogue, parts)
    found = choose(catalogue, parts, damper=DamperChoice(parallel=2))
    assert found.dampers.chosen[1].label == "a pair of D1, one each way"
    assert found.dampers.chosen[1].arrangement.pieces == 2


def test_errors_of_alternatives_are_those_of_the_changed_leg(made: SetsMade) -> None:
    """The alternatives' errors are those of the whole leg with that one part changed."""
    response, knee = wanted(), 1
    option = next(option for option in made.springs.ranked[knee] if option.label == "K1")
    acting = made.leg.joints[knee].spring
    assert acting is not None
    changed = made.leg.with_joints(knee={"spring": replace(acting, rate=option.rate)})
    assert option.outside is False  # within the 50 % that is asked
    assert option.error == pytest.approx(response.overall([response.at_rest_like_wanted(changed)])[0], rel=1e-3)


def test_a_damper_s_error_is_with_the_spring_that_is_named_beside_it(made: SetsMade) -> None:
    """The page named the rate tuned to the damper alone, beside the error with another."""
    chosen = made.dampers.chosen
    for j, ranked in enumerate(made.dampers.ranked):
        for option in (option for option in ranked if option is not chosen[j]):
            assert (option.partner_rate is None) == (option.partner == "")
            joint = made.leg.joints[j]
            assert joint.spring is not None
            spring = replace(joint.spring, rate=option.partner_rate or joint.spring.rate)
            joints = list(made.leg.joints)
            joints[j] = replace(joint, spring=spring, damper=option.damper)
            leg = wanted().at_rest_like_wanted(replace(made.leg, joints=tuple(joints)))
            assert option.error == pytest.approx(float(wanted().overall([leg])[0]), rel=0.01)


def test_a_bought_spring_is_within_tolerance_of_the_wound_one_s_rate(catalogue: Catalogue, made: SetsMade) -> None:
    """A wound spring is tuned to the set; a bought one of that rate was left out for the rate fitted before."""
    choice, damper = SpringChoice(rate_tolerance=0.2), made.dampers.chosen[2]
    source = SpringSource("ankle", choice, travels(LEG, wanted().motions)[2], catalogue, CadOptions(), ANY)
    wound = replace(spring_to_wind(source, 0.5)[0], asked=1.0)
    parts = JointParts(source, (damper,), {damper.label: (wound,)}, (), ())
    found = {pair.spring.label: pair.spring.outside for pair in _other_springs(Pair(wound, damper), parts)}
    assert (found["A05"], found["K1"]) == (False, True)


@pytest.mark.parametrize("tolerance", [0.2, 0.25])
def test_tolerance_reasons_and_notes_are_those_of_one_wanted_rate(catalogue: Catalogue, tolerance: float) -> None:
    """The fit gave 0.9 N*m/rad at the ankle, its damper moves as wanted with 0.5: A05 was taken as "none meets it"."""
    response, fitted = wanted(), LEG.joints[2].spring
    assert fitted is not None
    leg = LEG.with_joints(ankle={"spring": replace(fitted, rate=0.9)})
    asked = SpringChoice(rate_tolerance=tolerance)
    choices = {name: JointChoice(asked, ONE_DAMPER) for name in LEG.joint_names}
    dampers = choose_dampers(response, choices, catalogue, {}, [2.0] * 3, law="linear")
    sources = [
        SpringSource(name, asked, travel, catalogue, CadOptions(), ANY)
        for name, travel in zip(LEG.joint_names, travels(LEG, response.motions), strict=True)
    ]
    made = choose_sets(response, leg, dampers, sources, ANY).springs
    option, left_out = made.chosen[2], made.left_out[2]
    assert option.label == "A05"
    for each in made.chosen:
        assert each.row is None or abs(each.rate / each.asked - 1.0) <= tolerance
    assert not any("no bought spring" in text for text in made.warnings[2])
    (reason,) = (text for text in left_out if text.startswith("rate in the joint not within"))
    assert reason == f"rate in the joint not within {tolerance:.0%} of {option.asked:.4g} N*m/rad"
    entry = spring_entry(option)
    held, rate = (entry[key]["value"] for key in ("rate", "wanted_rate"))
    assert abs(held / rate - 1.0) <= tolerance
    (said,) = wanted_rate_note("ankle", option, "DA", 0.9, asked)
    assert f"wanted spring rate is {option.asked:.3g} N*m/rad" in said
    assert "fit to the recordings with this damper gives 0.9" in said
    assert wanted_rate_note("ankle", option, "DA", option.asked, asked) == []


def test_tolerances_can_change_the_choice(catalogue: Catalogue, tmp_path: Path) -> None:
    """A part that is a little off but exact comes before one that is right and may be anything."""
    mine = tmp_path / "exact.csv"
    head = HEAD.strip() + ",rate_tolerance [%],free_angle_tolerance [deg]\n"
    mine.write_text(
        head
        + spring_line("K2", "Alpha", 2.0, 2.2).strip() + ",10,25\n"
        + spring_line("KX", "Alpha", 2.05, 2.2).strip() + ",1,0.5\n"
    )  # fmt: skip
    rows = Catalogue.load([mine]).springs
    kept = [row for row in catalogue.springs if row.part != "K2"]
    both = replace(catalogue, springs=(*kept, *(row for row in rows if row.part in ("K2", "KX"))))
    assert springs(choose(both))[1] == "KX"
    exact = PartsOptions(tolerance=ToleranceOptions(rate=1e-6, free_angle=1e-6, torque=1e-6, temperature=0.0))
    assert springs(choose(both, exact))[1] == "K2"


def test_the_test_catalogue_is_complete(catalogue: Catalogue) -> None:
    for part in ("H18", "H20", "K2", "K1", "A05", "A06"):
        assert catalogue.find_spring(part).complete, catalogue.find_spring(part).status
    assert radians(90) == pytest.approx(catalogue.find_spring("K1").included_angle)


def test_a_vendor_without_dampers_does_not_exclude_dampers(catalogue: Catalogue) -> None:
    found = choose(catalogue, PartsOptions(vendors=("Alpha",)))
    assert found.dampers.chosen[1].row is not None
    assert found.dampers.chosen[1].row.vendor == "Gamma"
    assert springs(found) == ["H18", "K2", "A05"]


def test_a_step_to_the_next_round_computes_no_forecast_that_nobody_sees(
    catalogue: Catalogue, made: SetsMade, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A round that another one followed had all forecasts of its report."""

    def shows(*_: object, **__: object) -> None:
        raise AssertionError("a forecast that only the report shows")

    with monkeypatch.context() as strict:
        strict.setattr(SetsMade, "shown", lambda self: self)
        strict.setattr(Judge, "as_they_come", shows)
        step = choose(catalogue)
    assert step.sets[0].pairs == made.chosen.pairs
    assert step.shown().sets == made.sets


class _Tied:
    """Stands for ``Judge``: every set is allowed and as good as every other."""

    def allows(self, pairs: object) -> bool:
        return True

    def expected(self, pairs: object) -> float:
        return 1.0


def test_exchanges_of_equal_error_are_in_order(made: SetsMade, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two exchanges at one joint with the same expected error stopped the command with a traceback."""
    swap = Swap(made.chosen.pairs[0], 2.0, 2.0)
    none: tuple[tuple[Swap, ...], ...] = ((), (), ())
    table = Swaps(((swap, swap), (), ()), none, 1.0)
    monkeypatch.setattr(part_swaps, "swaps", lambda *_: table)
    monkeypatch.setattr(part_swaps, "_wound_to_suit", lambda judge, chosen, joints, held=None: chosen)
    assert without_better_swap(_Tied(), made.chosen.pairs, [None] * 3) == (made.chosen.pairs, table)  # type: ignore[arg-type, list-item]
