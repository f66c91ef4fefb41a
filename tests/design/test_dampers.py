"""Choosing dampers, and the thesis' mistake of a linear secant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.design.assumed_laws import off_at_low_speed
from synth.design.choose_dampers import (
    DamperOption,
    MeasuredCurve,
    _options,
    choose_dampers,
    curves_at,
    measured_curves,
)
from synth.design.damper_warnings import curve_warnings, size_warnings, travel_warnings
from synth.design.forecast import damper_tolerance
from synth.design.reached_speeds import ReachedSpeeds, reached_speeds
from synth.design.response import WantedRelease, WantedResponse
from synth.design.spring_tuning import tuned_legs
from synth.errors import UserError
from synth.files.project_options import DamperChoice, JointChoice, SpringChoice, ToleranceOptions
from synth.parts.arrangement import Arrangement
from synth.parts.catalogs import Catalogue
from synth.parts.damper_law import low_speed_law, power_law_curve
from synth.parts.rows import RPM
from synth.remarks import severity_of, unlike
from synth.swing.chain import Conditions
from synth.swing.damper_curves import thin, torque_at
from synth.swing.leg_model import Damper, DamperCurve, Joint, Leg, Link, Spring
from three_links import LEG
from three_links import wanted as three_wanted

TIME = np.linspace(0.0, 1.4, 141)
TRAVEL = (2.0,)


def one_link(damper: Damper, rate: float = 1.2) -> Leg:
    """A knee with everything outboard of it."""
    link = Link(0.3, 0.3, 0.12, 4e-3)
    return Leg("knee alone", (Joint("knee", link, np.pi, 1, None, Spring(rate, np.pi), damper),))


def response(leg: Leg) -> WantedResponse:
    release = WantedRelease("a", TIME, np.array([0.25]), np.zeros(1), Conditions())
    return WantedResponse.of(leg, [release])


def choices(**damper: object) -> dict[str, JointChoice]:
    return {"knee": JointChoice(SpringChoice(), DamperChoice(**damper))}  # type: ignore[arg-type]


def turned_at(speed: float) -> ReachedSpeeds:
    """A joint that turns at this speed (rad/s) all the time."""
    return ReachedSpeeds(np.array([speed]), np.ones(1))


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


def swing_left(leg: Leg, wanted: WantedResponse) -> float:
    """How much the leg still swings in the second half of the release, over what the wanted one does then."""
    half = len(TIME) // 2
    motion, target = wanted.simulate([leg])[0][half:, 0, 0], wanted.motions[0][half:, 0]
    return float(np.std(motion) / np.std(target))


def test_the_linear_secant_chooses_too_strong_a_damper(catalogue: Catalogue) -> None:
    """Thesis section 4.3: chosen by the slope through (max speed, max torque), the first dampers were too strong.

    Between rest and its rated speed an oil damper resists more than that slope says. So the damper whose slope comes
    nearest the wanted rate really brakes several times as much; the law that is concave chooses a weaker one.
    """
    wanted = response(one_link(Damper(0.024)))  # between the secants of 6597K8, 0.0094, and 6597K19, 0.0418
    linear = choose_dampers(wanted, choices(), catalogue, {}, TRAVEL, law="linear")
    concave = choose_dampers(wanted, choices(), catalogue, {}, TRAVEL)
    by_secant, by_curve = linear.chosen[0].row, concave.chosen[0].row
    assert by_secant is not None
    assert by_curve is not None
    assert (by_secant.part, by_curve.part) == ("6597K19", "6597K8")
    legs = [one_link(row.damper("concave")) for row in (by_secant, by_curve)]
    real, better = tuned_legs(wanted, legs, [(0,), (0,)])
    assert wanted.overall([better])[0] < wanted.overall([real])[0]
    promised = swing_left(one_link(by_secant.damper("linear")), wanted)
    assert swing_left(one_link(by_secant.damper("concave")), wanted) < 0.5 * promised


def test_a_measured_curve_replaces_the_assumed_law(catalogue: Catalogue) -> None:
    wanted = response(one_link(Damper(0.13)))
    curve = power_law_curve(0.125, 1.0, 0.44)
    measured = {"knee": MeasuredCurve("6597K19", curve, "drops")}
    made = choose_dampers(wanted, choices(), catalogue, measured, TRAVEL)
    laws = {option.part: option.law for option in made.ranked[0]}
    assert laws == {"6597K19": "curve", "6597K21": "concave", "6597K8": "concave"}
    used = next(option for option in made.ranked[0] if option.part == "6597K19")
    assert used.damper.curve == curve


def test_a_measured_curve_holds_for_its_part_at_every_joint(catalogue: Catalogue) -> None:
    """One part number had two torque curves in one leg: the measured one and, at another joint, the assumed one."""
    knee, hip = power_law_curve(0.125, 1.0, 0.44), power_law_curve(0.14, 1.0, 0.44)
    measured = {
        "knee": MeasuredCurve("6597k19", knee, "drops"),
        "hip": MeasuredCurve("6597K21", hip, "drops"),
    }
    asked = {name: JointChoice(SpringChoice(), DamperChoice()) for name in LEG.joint_names}
    made = choose_dampers(three_wanted(), asked, catalogue, measured, (2.0,) * 3)
    seen = set()
    for name, ranked in zip(LEG.joint_names, made.ranked, strict=True):
        for option in ranked:
            known = {"6597K19": ("knee", knee), "6597K21": ("hip", hip)}.get(option.part)
            if known is None:
                assert (option.law, option.measured) == ("concave", None)
                continue
            at, curve = known
            assert (option.law, option.damper.curve) == ("curve", curve)
            elsewhere = name != at
            assert option.why == (f"measured at the {at}: drops" if elsewhere else "measured: drops")
            said = [text for text in curve_warnings(name, option, turned_at(1.0)) if "another specimen" in text]
            assert len(said) == elsewhere
            known_torque = damper_tolerance(option, ToleranceOptions())
            assert known_torque.torque == pytest.approx(0.15 if elsewhere else 0.05)
            assert known_torque.exponents is None  # of a measured law nothing is assumed
            seen.add((name, option.part))
    assert {("knee", "6597K19"), ("ankle", "6597K19")} <= seen


def test_a_joint_s_own_measurement_comes_first() -> None:
    curves = [DamperCurve((1.0,), (torque,)) for torque in (0.1, 0.2, 0.3)]
    asked = {name: JointChoice(SpringChoice(), DamperChoice()) for name in LEG.joint_names}
    first, second, third = (MeasuredCurve("A", curve, "drops") for curve in curves)
    measured = {"hip": first, "knee": second}
    assert curves_at("hip", asked, measured)["a"] is first
    assert curves_at("knee", asked, measured)["a"] is second
    assert curves_at("ankle", asked, measured)["a"] == replace(first, at="hip")
    unnamed = {"ankle": replace(third, part=None)}  # of the part that the joint's choice names, if any
    assert curves_at("knee", asked, unnamed) == {}
    asked["ankle"] = JointChoice(SpringChoice(), DamperChoice(part="B"))
    assert curves_at("knee", asked, unnamed) == {"b": replace(third, part=None, at="ankle")}


def test_a_part_that_is_ordered_by_its_torque_is_known_where_it_was_measured_only(catalogue: Catalogue) -> None:
    row = replace(catalogue.find_damper("6597K19"), torque_range=(0.1, 0.3))
    known = MeasuredCurve(row.part, power_law_curve(0.125, 1.0, 0.44), "drops")
    (own,) = _options([row], {"6597k19": known}, None)
    assert own.measured is known
    elsewhere = _options([row], {"6597k19": replace(known, at="hip")}, None)
    assert len(elsewhere) > 1
    assert {option.law for option in elsewhere} == {"concave"}


def test_dampers_are_ranked_by_response_error(catalogue: Catalogue) -> None:
    made = choose_dampers(response(one_link(Damper(0.13))), choices(), catalogue, {}, TRAVEL)
    errors = [option.error for option in made.ranked[0]]
    assert errors == sorted(errors)
    assert len({option.part for option in made.ranked[0]}) == 3
    assert [item.error for item in made.sets] == sorted(item.error for item in made.sets)


def test_a_damper_of_far_too_much_torque_is_left_out_with_the_reason(catalogue: Catalogue) -> None:
    """6597K21 has ten times the wanted torque at 1 rad/s; two are kept at any distance."""
    made = choose_dampers(response(one_link(Damper(0.1))), choices(), catalogue, {}, TRAVEL)
    assert {option.part for option in made.ranked[0]} == {"6597K19", "6597K8"}
    assert made.left_out[0]["torque at 1 rad/s more than 8 times off the wanted damper's"] == 1


def test_a_damper_required_by_part_number_is_chosen(catalogue: Catalogue) -> None:
    made = choose_dampers(response(one_link(Damper(0.1))), choices(part="6597K21"), catalogue, {}, TRAVEL)
    assert [option.part for option in made.ranked[0]] == ["6597K21"]


def test_a_gear_that_turns_a_damper_past_its_travel_is_left_out(catalogue: Catalogue) -> None:
    """80 deg of the joint are 120 deg behind a ratio of 1.5: more than the 110 deg of a vane damper, at 1 less."""
    vane = replace(catalogue.find_damper("6597K19"), continuous="no", travel=np.radians(110.0))
    alone, wanted = replace(catalogue, dampers=(vane,)), response(one_link(Damper(0.13)))
    for ratios, kept in (((1.0, 1.5), [1.0]), ((0.5, 1.0, 1.3), [0.5, 1.0, 1.3]), ((1.0, 1.3, 1.4), [1.0, 1.3])):
        made = choose_dampers(wanted, choices(ratios=ratios), alone, {}, (np.radians(80.0),))
        assert sorted(option.arrangement.ratio for option in made.ranked[0]) == kept


def test_no_suitable_damper_gives_the_reasons_and_a_remedy(catalogue: Catalogue) -> None:
    wanted = response(one_link(Damper(0.1)))
    with pytest.raises(UserError, match=r"knee: no damper.*incomplete.*select\.joints\.knee\.damper") as caught:
        choose_dampers(wanted, choices(max_outer_diameter=1e-3, travel=9.0), _without_sizes(catalogue), {}, TRAVEL)
    assert "turns less than 516 deg" in str(caught.value)


def _without_sizes(catalogue: Catalogue) -> Catalogue:
    """A catalogue whose complete dampers turn through 360 deg only."""
    rows = tuple(replace(row, continuous="no", travel=2 * np.pi) if row.complete else row for row in catalogue.dampers)
    return replace(catalogue, dampers=rows)


def test_a_damper_longer_than_allowed_is_left_out_and_an_unknown_length_is_said(catalogue: Catalogue) -> None:
    rows = tuple(replace(row, body_length=0.08) if row.part == "6597K19" else row for row in catalogue.dampers)
    wanted, asked = response(one_link(Damper(0.13))), choices(max_body_length=0.01)
    made = choose_dampers(wanted, asked, replace(catalogue, dampers=rows), {}, TRAVEL)
    assert "6597K19" not in {option.part for option in made.ranked[0]}
    assert made.left_out[0]["body length over 10 mm"] == 1
    (said,) = size_warnings("knee", made.chosen[0], asked["knee"].damper)
    assert said.endswith(f"state the body length of {made.chosen[0].part}; the limit of 10 mm was not checked")
    assert size_warnings("knee", made.chosen[0], choices()["knee"].damper) == []


def test_a_named_damper_that_damps_one_way_is_refused_unless_a_pair_is_allowed(catalogue: Catalogue) -> None:
    rows = tuple(replace(row, direction="clockwise") if row.part == "6597K19" else row for row in catalogue.dampers)
    one_way, wanted = replace(catalogue, dampers=rows), response(one_link(Damper(0.1)))
    with pytest.raises(UserError, match=r"6597K19 .* one way only.*parallel: 2 under select\.joints\.knee\.damper"):
        choose_dampers(wanted, choices(part="6597K19"), one_way, {}, TRAVEL)
    made = choose_dampers(wanted, choices(part="6597K19", parallel=2), one_way, {}, TRAVEL)
    assert made.chosen[0].label == "a pair of 6597K19, one each way"


@pytest.mark.parametrize(
    ("rpm", "most", "said", "severity"),
    [
        (49.0, 50.0, "", ""),
        (50.3, 50.0, "turned at up to 50.3 rpm; its vendor's maximum speed is 50.0 rpm", "decide"),
        (53.0, 50.0, "turned at up to 53 rpm; its vendor's maximum speed is 50 rpm", "decide"),
        (53.0, None, "", ""),
        (145.0, 50.0, "turned at up to 145 rpm; its vendor's maximum speed is 50 rpm", "decide"),
        (145.0, None, "turned at up to 145 rpm; its vendor states torque at 50 rpm", "check"),
        (145.0, 200.0, "turned at up to 145 rpm; its vendor states torque at 50 rpm", "check"),
        (400.0, None, "beyond it; the simulated torque there is 80% above the assumed law", "check"),
        (400.0, 50.0, "is 50 rpm; the simulated torque there is 80% above the assumed law", "decide"),
    ],
)
def test_a_maximum_speed_is_told_from_a_rated_point(
    catalogue: Catalogue, rpm: float, most: float | None, said: str, severity: str
) -> None:
    row = catalogue.find_damper("6597K19")
    assert row.max_speed == row.speed == pytest.approx(50 * RPM)  # published as "50 rpm max speed"
    row = replace(row, max_speed=None if most is None else most * RPM)
    option = DamperOption(row, row.damper(), "table", "")
    found = [text for text in curve_warnings("knee", option, turned_at(rpm * RPM)) if "turned" in text]
    assert bool(found) is bool(said)
    for text in found:
        assert said in text
        assert severity_of(text) == severity


@pytest.mark.parametrize(
    ("damper", "ratio", "said"),
    [
        ({"part": "6597K19"}, 1.0, "turns by 40 deg only, and the joint turns it by 115 deg from stop to stop"),
        ({"part": "6597K19", "travel": 0.5}, 1.0, "and the joint turns it by 115 deg from stop to stop"),
        ({"part": "6597K19", "travel": 6.2832}, 1.0, "turns by 40 deg only, and travel asks for 360 deg"),
        ({"part": "6597K19", "ratios": (0.25, 1.0)}, 0.25, ""),  # a quarter as far: the one that bears it is taken
    ],
)
def test_a_named_damper_that_turns_too_little_is_told(
    catalogue: Catalogue, damper: dict[str, object], ratio: float, said: str
) -> None:
    rows = tuple(replace(row, continuous="no", travel=np.radians(40)) for row in catalogue.dampers)
    asked = choices(**damper)
    made = choose_dampers(response(one_link(Damper(0.1))), asked, replace(catalogue, dampers=rows), {}, TRAVEL)
    assert made.chosen[0].arrangement.ratio == ratio
    found = travel_warnings("knee", made.chosen[0], asked["knee"].damper, TRAVEL[0])
    assert bool(found) is bool(said)
    for text in found:
        assert said in text
        assert severity_of(text) == "decide"


def test_a_named_damper_of_unknown_travel_is_told(catalogue: Catalogue) -> None:
    row = replace(catalogue.find_damper("6597K19"), continuous="", travel=None)
    option, choice = DamperOption(row, row.damper(), "concave", ""), choices(part="6597K19")["knee"].damper
    (said,) = travel_warnings("knee", option, choice, 1.0)
    assert said.endswith("does not state how far 6597K19 turns; that it turns 57 deg was not checked")


RISING = DamperCurve((5 * RPM, 10 * RPM, 20 * RPM), (0.06, 0.1, 0.12))
FALLING = DamperCurve((5 * RPM, 15 * RPM, 20 * RPM), (0.08, 0.135, 0.12))


@pytest.mark.parametrize("catalogued", [False, True])
@pytest.mark.parametrize(
    ("table", "rpm", "said"),
    [
        (RISING, 21.0, []),  # a tenth beyond the table
        (RISING, 64.0, ["at up to 64 rpm; its torque-speed table ends at 20 rpm, and beyond it goes on along its"]),
        (FALLING, 19.0, ["falls from 0.135 N*m at 15 rpm to 0.12 N*m at 20 rpm"]),
        (FALLING, 64.0, ["ends at 20 rpm, and beyond it keeps its last torque", "falls from 0.135 N*m at 15 rpm"]),
    ],
)
def test_a_damper_turned_beyond_its_table_is_told(
    catalogue: Catalogue, table: DamperCurve, rpm: float, said: list[str], catalogued: bool
) -> None:
    """The user's own table, and the points of a catalogue: in neither is the torque beyond known."""
    row = replace(catalogue.find_damper("6597K19"), max_speed=100 * RPM)
    if catalogued:
        row = replace(row, curve_speed=table.speed, curve_torque=table.torque)
        option = DamperOption(row, row.damper(), "table", "")
    else:
        measured = measured_curves({}, {"knee": (None, table)}, {})["knee"]
        option = DamperOption(row, Damper(curve=table), "curve", "", measured=measured)
    found = [text for text in curve_warnings("knee", option, turned_at(rpm * RPM)) if "table" in text]
    assert len(found) == len(said)
    for text, part in zip(found, said, strict=True):
        assert part in text


@pytest.mark.parametrize(("ratio", "said"), [(0.5, None), (1.0, "6.7 rad/s"), (3.0, "20 rad/s")])
def test_the_measured_range_is_of_the_dampers_own_speed(catalogue: Catalogue, ratio: float, said: str | None) -> None:
    """A joint of 6.7 rad/s turns a damper geared 0.5 at 3.35 rad/s, within drops that reached 5.1."""
    row, measured = catalogue.find_damper("6597K19"), MeasuredCurve("6597K19", RISING, "drops", 5.1)
    option = DamperOption(
        row, Damper(curve=RISING), "curve", "", arrangement=Arrangement(ratio=ratio), measured=measured
    )
    found = [text for text in curve_warnings("knee", option, turned_at(6.7)) if "measured" in text]
    assert bool(found) is (said is not None)
    for text in found:
        assert f"turned at up to {said}; it was measured up to 5.1 rad/s" in text


def test_a_similar_part_number_is_suggested(catalogue: Catalogue) -> None:
    with pytest.raises(UserError, match="6597K19"):
        choose_dampers(response(one_link(Damper(0.1))), choices(part="6597K9"), catalogue, {}, TRAVEL)


def test_the_response_uses_the_curve_not_its_secant() -> None:
    """A curve that is a straight line acts as a linear damper of that rate."""
    straight = one_link(Damper(curve=DamperCurve((10.0,), (1.0,))))
    assert response(one_link(Damper(0.1))).errors([straight])[0, 0] < 1e-5


@pytest.mark.parametrize(
    ("value", "limit", "style", "texts"),
    [
        (53.0, 50.0, ".0f", ("53", "50")),
        (50.004, 50.0, ".0f", ("50.004", "50.000")),
        (1342.01, 1342.0, ".4g", ("1342.01", "1342")),
        (2.0, 2.0, ".4g", ("2", "2")),
        (float("inf"), 2.0, ".3g", ("inf", "2")),
    ],
)
def test_a_value_beyond_its_limit_reads_so(value: float, limit: float, style: str, texts: tuple[str, str]) -> None:
    assert unlike(value, limit, style) == texts


def law_table(exponent: float, *rpm: float) -> DamperCurve:
    """Exact points of 0.2 N*m (n / 50)^exponent at these speeds, rpm."""
    return DamperCurve(tuple(n * RPM for n in rpm), tuple(0.2 * (n / 50) ** exponent for n in rpm))


@pytest.mark.parametrize("exponent", [0.36, 0.47, 0.8, 1.0, 1.6])
@pytest.mark.parametrize("rpm", [(10, 20, 30, 40, 50), (20, 50), (10, 50), (5, 6, 50), (1, 50), tuple(range(4, 51))])
def test_a_table_goes_on_below_its_lowest_point_by_the_law_of_its_points(
    exponent: float, rpm: tuple[float, ...]
) -> None:
    """Known points of a known law: straight to zero it had a third of the torque at a tenth of the lowest speed."""
    table = law_table(exponent, *rpm)
    below = low_speed_law(table)
    assert below is not None
    assert below.found
    assert below.exponent == pytest.approx(exponent, abs=1e-9)
    curve = below.curve()
    assert curve.speed[-len(rpm) :] == table.speed
    assert curve.torque[-len(rpm) :] == table.torque
    assert curve.speed[0] == pytest.approx(table.speed[-1] / 500)
    slow = np.geomspace(curve.speed[0], table.speed[0], 500)
    assert torque_at(curve, slow) == pytest.approx(0.2 * (slow / (50 * RPM)) ** exponent, rel=0.055)
    as_simulated = torque_at(thin(curve), slow)  # by twelve points
    assert as_simulated == pytest.approx(torque_at(curve, slow), rel=0.1, abs=0.002)


@pytest.mark.parametrize(
    "table",
    [
        DamperCurve((10 * RPM,), (0.1,)),  # one point
        DamperCurve((10 * RPM, 50 * RPM), (0.1, 0.11)),  # dry friction
        DamperCurve((10 * RPM, 50 * RPM), (0.1, 0.08)),
        DamperCurve((10 * RPM, 11 * RPM, 50 * RPM), (0.02, 0.05, 0.2)),
    ],
)
def test_points_without_a_plausible_law_are_continued_by_the_assumed_one(table: DamperCurve) -> None:
    below = low_speed_law(table)
    assert below is not None
    assert (below.exponent, below.found) == (0.47, False)
    (torque,) = torque_at(below.curve(), np.array([table.speed[0] / 4]))
    assert torque == pytest.approx(table.torque[0] * 4**-0.47, rel=0.02)


def test_a_table_from_slow_speeds_or_without_torque_stays_as_it_is() -> None:
    for table in (
        DamperCurve((0.1 * RPM, 50 * RPM), (0.01, 0.2)),
        DamperCurve((10 * RPM, 20 * RPM), (0.0, 0.1)),
    ):
        assert low_speed_law(table) is None


@pytest.mark.parametrize("catalogued", [False, True])
@pytest.mark.parametrize(("slow", "share", "severity"), [(1, "1%", "check"), (60, "60%", "decide"), (0, "", "")])
def test_time_below_a_table_is_told(
    catalogue: Catalogue, catalogued: bool, slow: int, share: str, severity: str
) -> None:
    """A joint turns its damper twice as fast: ``slow`` of 100 s at 4 rpm, 8 of the damper, which is known from 10."""
    row, table = catalogue.find_damper("6597K19"), law_table(0.5, 10, 20, 50)
    arrangement = Arrangement(ratio=2.0)
    if catalogued:
        row = replace(row, curve_speed=table.speed, curve_torque=table.torque)
        option = DamperOption(row, arrangement.at_joint(row.damper()), "table", "", arrangement=arrangement)
    else:
        known = measured_curves({}, {"knee": (None, table)}, {})["knee"]
        damper = arrangement.at_joint(Damper(curve=known.curve))
        option = DamperOption(row, damper, "curve", known.words, arrangement=arrangement, measured=known)
        assert (
            option.why == "measured: torque-speed table, below 10 rpm a power law, exponent 0.50 of its lowest points"
        )
    speeds = ReachedSpeeds(np.array([4.0, 6.0]) * RPM, np.array([slow, 100.0 - slow]))
    found = [text for text in curve_warnings("knee", option, speeds) if "more slowly" in text]
    assert [severity_of(text) for text in found] == ([severity] if severity else [])
    for text in found:
        assert "measured from 10 rpm upwards, and turned more slowly for " + share in text
        assert "exponent 0.50 (of its lowest points)" in text


def test_the_share_of_slow_time_is_that_of_a_swing() -> None:
    """Of sin t the speed is below s for 2/pi asin s of the time, whether sampled evenly or not."""
    even, uneven = np.linspace(0.0, 2 * np.pi, 4001), 2 * np.pi * np.linspace(0.0, 1.0, 4001) ** 2
    motions = [np.stack([np.sin(time), 0.5 * np.sin(time)], axis=1) for time in (even, uneven)]
    first, second = reached_speeds(motions, [even, uneven])
    assert (first.fastest, second.fastest) == pytest.approx((1.0, 0.5), rel=1e-3)
    for speed in (0.1, 0.5, 0.9):
        assert first.share_below(speed) == pytest.approx(2 / np.pi * np.arcsin(speed), abs=2e-3)
        assert second.share_below(0.5 * speed) == pytest.approx(2 / np.pi * np.arcsin(speed), abs=2e-3)


@pytest.mark.parametrize("at", ["", "hip"])
def test_the_law_below_a_table_is_as_uncertain_as_an_assumed_one(catalogue: Catalogue, at: str) -> None:
    """Its exponent is drawn, above the lowest point nothing but the torque, and at low speed it may be off by two."""
    row, table = catalogue.find_damper("6597K19"), law_table(0.6, 10, 20, 50)
    known = replace(measured_curves({}, {"knee": ("6597K19", table)}, {})["knee"], at=at)
    option = DamperOption(row, Damper(curve=known.curve), "curve", known.words, measured=known)
    tolerance = damper_tolerance(option, ToleranceOptions())
    assert tolerance.exponents == pytest.approx((0.57, 0.63))
    assert tolerance.torque == pytest.approx(0.15 if at else 0.05)
    speeds = np.array([1.0, 10.0, 20.0, 50.0]) * RPM
    for exponent in (0.57, 0.63):
        curve = option.with_exponent(exponent).curve
        assert curve is not None
        truth = 0.2 * (speeds / (50 * RPM)) ** 0.6
        truth[0] = 0.2 * 0.2**0.6 * 0.1**exponent
        assert torque_at(curve, speeds) == pytest.approx(truth, rel=0.01)
    for factor in (0.5, 2.0):
        off = off_at_low_speed(option.damper, factor, option.known_from).curve
        assert off is not None
        ratio = torque_at(off, speeds) / torque_at(known.curve, speeds)
        assert ratio == pytest.approx([factor, 1.0, 1.0, 1.0], rel=0.05)
        assert np.all(np.diff(off.torque) > 0.0)
