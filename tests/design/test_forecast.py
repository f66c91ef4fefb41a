"""Propagation of tolerances in lanes: against limit cases and a closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.arrays import Array
from synth.design import part_lanes
from synth.design.assumed_laws import off_at_low_speed
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.forecast import Forecaster, damper_tolerance, latin_hypercube, spring_tolerance
from synth.design.part_lanes import ActingElements, PartLanes, column
from synth.design.response import WantedRelease, WantedResponse
from synth.files.project_options import ToleranceOptions
from synth.parts.arrangement import Arrangement
from synth.parts.catalogs import Catalogue
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIME = np.linspace(0.0, 6.0, 241)
NONE = ToleranceOptions(1e-9, 1e-9, 1e-9, 1e-9, 0.0)


def knee(rate: float) -> Leg:
    """A knee without gravity whose damper is strong: it creeps back to where its spring is unloaded."""
    link = Link(0.3, 0.3, 0.12, 4e-3)
    return Leg("knee", (Joint("knee", link, np.pi, 1, None, Spring(rate, np.pi), Damper(1.0)),), gravity=0.0)


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue.load()


@pytest.fixture(scope="module")
def spring(catalogue: Catalogue) -> SpringOption:
    row = catalogue.find_spring("LTR135H 10 M")
    assert row.rate is not None
    assert row.included_angle is not None
    return SpringOption(row.rate, row.included_angle, row=row)


def forecaster(rate: float, asked: ToleranceOptions, within: float = 0.1) -> Forecaster:
    leg = knee(rate)
    wanted = WantedResponse.of(leg, [WantedRelease("a", TIME, np.array([0.4]), np.zeros(1), Conditions())])
    lanes = PartLanes(wanted, leg, [[ActingElements(rate, Damper(1.0))]])
    return Forecaster(lanes, asked, within)


MEASURED = DamperOption(None, Damper(1.0), "curve", "measured")


def test_without_tolerances_the_forecast_has_no_spread(spring: SpringOption) -> None:
    found = forecaster(spring.rate, NONE).forecast([(spring, MEASURED)], 32)
    assert found.nominal < 1e-5
    assert found.expected < 1e-5
    assert found.chance == 1.0


def test_free_angle_tolerance_gives_the_closed_form_error(spring: SpringOption) -> None:
    """Overdamped and slow, the error of a shift s is s times the RMS of 1 - exp(-k t / b), whatever its sign.

    Shifts are uniform within s0, so the error is uniform from 0 to s0 g: mean a half, nine tenths from 5 % to 95 %.
    """
    limit = np.radians(10.0)
    found = forecaster(spring.rate, replace(NONE, free_angle=float(limit)), within=0.05).forecast(
        [(spring, MEASURED)], 256, shares=True
    )
    # The exact overdamped response: two real rates of I s^2 + b s + k.
    inertia = 4e-3 + 0.3 * 0.12**2
    fast, slow = np.sort(np.roots([inertia, 1.0, spring.rate]))
    unit = 1.0 - (slow * np.exp(fast * TIME) - fast * np.exp(slow * TIME)) / (slow - fast)
    gain = float(np.sqrt(np.mean(unit**2)))
    assert found.expected == pytest.approx(0.5 * limit * gain, rel=0.01)
    assert found.interval90 == pytest.approx((0.05 * limit * gain, 0.95 * limit * gain), rel=0.05, abs=2e-3)
    assert found.chance == pytest.approx(0.05 / (limit * gain), abs=0.02)
    assert found.shares[0].cause == "free angle"
    assert found.shares[0].share == pytest.approx(1.0, abs=1e-6)
    # The mean square of a uniform shift is a third of its limit's.
    assert found.shares[0].alone == pytest.approx(limit * gain / np.sqrt(3.0), rel=1e-3)


def test_a_larger_tolerance_raises_the_error_and_lowers_the_chance(spring: SpringOption) -> None:
    tight, loose = (
        forecaster(spring.rate, replace(NONE, rate=share), within=0.01).forecast([(spring, MEASURED)], 64)
        for share in (0.02, 0.2)
    )
    assert tight.expected < 0.2 * loose.expected
    assert tight.chance > loose.chance


def test_temperature_changes_a_damper_by_its_coefficient(spring: SpringOption, catalogue: Catalogue) -> None:
    """A warm damper is weaker by exp(c dT): the same error as a torque that is off by as much."""
    row = replace(catalogue.find_damper("6597K19"), torque_per_kelvin=-0.02)
    option = DamperOption(row, row.damper("linear"), "linear", "secant")
    lanes = PartLanes(
        WantedResponse.of(knee(spring.rate), [WantedRelease("a", TIME, np.array([0.4]), np.zeros(1), Conditions())]),
        knee(spring.rate),
        [[ActingElements(spring.rate, option.damper)]],
    )
    warm = Forecaster(lanes, replace(NONE, temperature=10.0), 0.1)
    columns = warm._columns([(spring, option)], np.array([[0.0], [0.0], [0.0], [0.0], [1.0]]))
    assert columns[0][2, 0] == pytest.approx((option.damper.rate or 0.0) * np.exp(-0.2))


def torque_of(rows: Array, speed: Array) -> Array:
    """A lane's torque (N m) at speeds (rad/s), by hand: each of its twelve slopes acts up to its own speed."""
    limits, slopes = rows[3:15], rows[15:27]
    return np.array([sum(c * min(w, s) for c, s in zip(slopes, limits, strict=True)) for w in speed])


def drawn(option: DamperOption, spring: SpringOption, asked: ToleranceOptions, cause: int) -> Array:
    """(27, 3) the knee's column with this cause at its lower limit, nominal, and at its upper one."""
    ends = np.zeros((5, 3))
    ends[cause] = -1.0, 0.0, 1.0
    return forecaster(spring.rate, asked)._columns([(spring, option)], ends)[0]


SPEEDS = np.array([0.02, 0.1, 0.5, 1.0, 3.0, 5.2])  # rad/s, to the 50 rpm that its vendor states
VENDOR = 31 * 28.349523e-3 * 9.80665 * 0.0254 * (SPEEDS / (50 * 2 * np.pi / 60)) ** 0.47  # N m: 31 in-oz at 50 rpm


def test_a_damper_stronger_by_its_tolerance_is_so_at_every_speed(catalogue: Catalogue, spring: SpringOption) -> None:
    row = catalogue.find_damper("6597K19")
    option = DamperOption(row, row.damper(), "concave", "assumed")
    columns = drawn(option, spring, replace(NONE, torque=0.15), 2)
    for lane, share in enumerate((0.85, 1.0, 1.15)):  # within 1 %: the law is straight between twelve points
        assert torque_of(columns[:, lane], SPEEDS) == pytest.approx(share * VENDOR, rel=0.01)


def test_forty_kelvin_weaken_a_damper_as_they_hasten_a_lid(catalogue: Catalogue, spring: SpringOption) -> None:
    """A lid with a TOK TD14 closes in 7.3 s at 0 degC and in 6 s at 40 degC: by the torque, 20 K below and above."""
    row = catalogue.find_damper("6597K19")
    assert row.torque_per_kelvin is None
    option = DamperOption(row, row.damper(), "concave", "assumed")
    columns = drawn(option, spring, replace(NONE, temperature=20.0), 4)
    cold, mild, warm = (torque_of(columns[:, lane], SPEEDS) for lane in range(3))
    assert warm / cold == pytest.approx(6.0 / 7.3)
    assert mild == pytest.approx(VENDOR, rel=0.01)


def test_the_exponent_of_an_assumed_law_is_drawn_between_its_limits(catalogue: Catalogue, spring: SpringOption) -> None:
    row = catalogue.find_damper("6597K19")
    option = DamperOption(row, row.damper(), "concave", "assumed")
    made = forecaster(spring.rate, replace(NONE, torque=1e-9))
    ends = np.zeros((5, 3))
    ends[3] = -1.0, 0.0, 1.0
    columns = made._columns([(spring, option)], ends)[0]
    for lane, exponent in enumerate((0.44, 0.47, 0.50)):
        assert columns[3:, lane] == pytest.approx(column(0.0, 0.0, row.damper("concave", exponent))[3:], rel=1e-6)


def test_the_error_with_assumed_laws_off_to_either_side(catalogue: Catalogue, spring: SpringOption) -> None:
    """The chance of staying within the limit took the assumed law as true; a weaker or stronger one leads elsewhere."""
    row = catalogue.find_damper("6597K19")
    option = DamperOption(row, row.damper("concave", 0.47), "concave", "assumed")
    made = forecaster(spring.rate, NONE)
    laws = made.forecast([(spring, option)], 16, shares=True).laws_off
    assert laws is not None
    assert laws.joints == ("knee",)
    weak, strong = (
        float(made.lanes.errors_of([column(spring.rate, made.lanes.rest(0, spring.rate), off)[:, None]])[0])
        for off in (off_at_low_speed(option.damper, factor) for factor in (0.5, 2.0))
    )
    assert (laws.least, laws.most) == pytest.approx((min(weak, strong), max(weak, strong)), rel=1e-4)
    assert made.forecast([(spring, MEASURED)], 16, shares=True).laws_off is None
    assert made.forecast([(spring, option)], 16).laws_off is None  # of sets that are only compared


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_law_off_at_low_speed_keeps_the_vendor_s_point_and_rises(catalogue: Catalogue, factor: float) -> None:
    plain = catalogue.find_damper("6597K19").damper("concave", 0.47).curve
    off = off_at_low_speed(catalogue.find_damper("6597K19").damper("concave", 0.47), factor).curve
    assert plain is not None
    assert off is not None
    ratio = np.array(off.torque) / np.array(plain.torque)
    assert ratio[-1] == 1.0
    assert ratio[0] == pytest.approx(factor)
    assert np.all(np.diff(off.torque) > 0.0)


def test_draws_are_a_seeded_latin_hypercube() -> None:
    """A Latin hypercube: of n draws each n-th of every axis holds one."""
    made = forecaster(1.0, NONE)
    drawn = made._draws(2, 16)
    assert drawn.shape == (9, 16)
    for axis in drawn:
        assert sorted(np.floor(8.0 * (axis + 1.0))) == list(range(16))
    assert np.array_equal(drawn, forecaster(1.0, NONE)._draws(2, 16))


def test_parallel_parts_spread_less(catalogue: Catalogue, spring: SpringOption) -> None:
    both = replace(spring, count=4, rate=4 * spring.rate)
    asked = ToleranceOptions()
    assert spring_tolerance(both, asked).rate == pytest.approx(0.5 * spring_tolerance(spring, asked).rate)
    row = catalogue.find_damper("6597K19")
    one = DamperOption(row, row.damper(), "concave", "assumed")
    four = replace(one, arrangement=Arrangement(count=2, pair=True))
    assert damper_tolerance(four, asked).torque == pytest.approx(0.5 * damper_tolerance(one, asked).torque)


def test_tolerances_of_row_and_project_override_the_default(spring: SpringOption) -> None:
    assert spring.row is not None
    stated = replace(spring, row=replace(spring.row, rate_tolerance=0.03, free_angle_tolerance=0.02))
    found = spring_tolerance(stated, ToleranceOptions())
    assert (found.rate, found.free_angle, found.source) == (0.03, 0.02, "the catalogue row")
    usual = spring_tolerance(spring, ToleranceOptions())
    assert usual.rate == 0.10
    assert np.degrees(usual.free_angle) == pytest.approx(10.0)
    assert spring_tolerance(stated, ToleranceOptions(rate=0.2)).rate == 0.2


def test_each_tolerance_is_reported_with_its_own_source(catalogue: Catalogue, spring: SpringOption) -> None:
    of_rate = spring_tolerance(spring, ToleranceOptions(rate=0.02)).source
    assert of_rate.startswith("rate by the project file; free angle usual: Lee")
    assert spring_tolerance(spring, ToleranceOptions(rate=0.02, free_angle=0.1)).source == "the project file"
    assert spring.row is not None
    stated = replace(spring, row=replace(spring.row, free_angle_tolerance=0.02))
    assert spring_tolerance(stated, ToleranceOptions()).source.endswith("; free angle by the catalogue row")
    row = catalogue.find_damper("6597K19")
    of_torque = damper_tolerance(DamperOption(row, row.damper(), "concave", ""), ToleranceOptions(torque=0.05)).source
    assert of_torque.startswith("torque by the project file; temperature TOK TD14")
    assert of_torque.endswith("; exponent of the assumed law 0.44 to 0.5")


def test_the_same_seed_gives_the_same_forecast(spring: SpringOption) -> None:
    one, two = (forecaster(spring.rate, ToleranceOptions()).forecast([(spring, MEASURED)], 32) for _ in range(2))
    assert one == two


def test_forecasts_of_a_set_are_cached(spring: SpringOption, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sets are ranked, shown and held against exchanges: each asks for the same draws, and for the nominal parts."""
    ours, ran = forecaster(spring.rate, ToleranceOptions()), []
    errors_of = ours.lanes.errors_of
    monkeypatch.setattr(ours.lanes, "errors_of", lambda columns: ran.append(columns[0].shape[1]) or errors_of(columns))
    expected = ours.expected([(spring, MEASURED)], 32)
    assert ran == [32]  # what sets are compared by needs no nominal lane
    whole = ours.forecast([(spring, MEASURED)], 32)
    assert (whole.expected, ran) == (expected, [32, 1])
    assert ours.forecast([(spring, MEASURED)], 32) == whole
    ours.forecast([(replace(spring, rate=1.01 * spring.rate), MEASURED)], 32)
    assert ran == [32, 1, 32, 1]


def test_forecasts_do_not_depend_on_the_number_of_threads(
    spring: SpringOption, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for threads in (1, 2, 3):
        monkeypatch.setattr(part_lanes, "thread_count", lambda threads=threads: threads)
        found.append(forecaster(spring.rate, ToleranceOptions()).forecast([(spring, MEASURED)], 96))
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize(("n", "n_sample", "seed"), [(13, 64, 0), (5, 200, 7)])
def test_draws_are_those_of_scipys_latin_hypercube(n: int, n_sample: int, seed: int) -> None:
    from scipy.stats.qmc import LatinHypercube

    drawn = LatinHypercube(n, rng=np.random.default_rng(seed)).random(n_sample)
    np.testing.assert_array_equal(latin_hypercube(n, n_sample, seed), 2.0 * drawn.T - 1.0)
