"""Numbers as text, ticks, thinning, laws and the spring's drawing against closed forms."""

from __future__ import annotations

import itertools
import math
import re
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from synth.reports import quantities
from synth.reports.figures.axes import AxisScale, log_ticks, tick_text, ticks, with_margin
from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.figures.spring_drawing import DrawnSpring, arms_of, spring_drawing
from synth.reports.figures.svg import polyline_path, shorten_apart, thin_curve
from synth.reports.figures.torque_speed import RPM, law_points
from synth.reports.figures.trials import Curve, TrialPanel, shared_limits, trial_figure
from synth.reports.opening import cut_short
from synth.reports.parameter_rows import parameter_rows
from synth.reports.reading import ReportError, ResultTable, read_table
from synth.reports.response_files import Response, extremes, file_of
from synth.reports.sections.spring_sheet import drawing_of
from synth.reports.severity import count_by_level, warning_of
from synth.reports.stick_figure import MEASURED, FigureJoint, FigureMotion, Stick, stick_figure


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        ("a rate of 2.5 N*m/rad and 1e-3 kg*m^2", "a rate of 2.5 N·m/rad and 1e-3 kg·m²"),
        ("turned by -30 deg at 50 deg/s", "turned by -30° at 50°/s"),
        ("230 degC for 30 min, 89 %", "230\u00a0°C for 30 min, 89\u00a0%"),
        ("3 degrees, x * y, T = k*2", "3 degrees, x * y, T = k*2"),
    ],
)
def test_units_in_sentences(written: str, shown: str) -> None:
    assert quantities.prose(written) == shown


def test_one_warning_limits_two_limit() -> None:
    one = warning_of("", "it is near", "warnings[0]")
    assert [words for _, words, _ in count_by_level([one])] == ["limits the trust in a number"]
    assert [words for _, words, _ in count_by_level([one, one])] == ["limit the trust in a number"]


def quantity(value: float, unit: str, *interval: float | None) -> dict[str, object]:
    return {"value": value, "unit": unit, **({"interval90": list(interval)} if interval else {})}


@pytest.mark.parametrize(
    ("written", "shown", "between"),
    [
        (quantity(1.7104, "N*m/rad", 1.66, 1.76), "1.710\u00a0N·m/rad", "1.660 to 1.760"),
        (quantity(23.71828, "N*m/rad", 20.1, 27.9), "23.7\u00a0N·m/rad", "20.1 to 27.9"),
        (quantity(139.04, "deg", 138.6, 139.5), "139.04°", "138.60 to 139.50"),
        (quantity(-0.004, "deg", -0.8, 0.8), "0.00°", "−0.80 to 0.80"),
        (quantity(5.0, "N*m/rad", 3.0, None), "5.0\u00a0N·m/rad", "above 3.0"),
        (quantity(5.0, "N*m/rad", None, 9.0), "5.0\u00a0N·m/rad", "below 9.0"),
        (quantity(2.134, "deg", None, 2.374), "2.13°", "below 2.37"),
        (quantity(5.0, "N*m/rad", 0.31, None), "5.0\u00a0N·m/rad", "above 0.31"),
        (quantity(0.4913, "1", 0.4, 6.0), "0.49", "0.40 to 6.0"),
        (quantity(0.1017, "deg", 0.00573, 0.573), "0.10°", "0.0057 to 0.57"),
        (quantity(-0.4913, "1", -6.0, -0.4), "−0.49", "−6.0 to −0.40"),
        (quantity(0.0, "mH", 0.0, 0.4942), "0\u00a0mH", "0 to 0.49"),
        (quantity(9.231, "deg", None, None), "9.2°", "unknown"),
        (quantity(0.6180339, "1"), "0.618", ""),
        (quantity(1234.56, "MPa"), "1235\u00a0MPa", ""),
        (quantity(2.5e-7, "kg*m^2"), "2.5·10⁻⁷\u00a0kg·m²", ""),
        (quantity(-9.0, "deg"), "−9°", ""),
        (quantity(63.0, "deg", -785.0, 786.0), "unknown", ""),  # of a spring that may not be there
        (quantity(700.0, "deg", 690.0, 720.0), "700°", "690 to 720"),
        (quantity(2.4e-6, "deg"), "2.4·10⁻⁶\u00a0°", ""),
        (quantity(0.0099999999, "1"), "0.01", ""),
        ({}, "–", ""),
        (None, "–", ""),
    ],
)
def test_a_quantity_has_the_digits_that_its_interval_bears(written: object, shown: str, between: str) -> None:
    assert quantities.text(written) == shown
    assert quantities.interval_text(written) == between


def test_percent_is_of_the_whole() -> None:
    assert quantities.percent(2.1, 2.0) == "+5.0\u00a0%"
    assert quantities.percent(1.0, 2.0) == "−50\u00a0%"
    assert quantities.percent(2.0, 2.0) == "0\u00a0%"
    assert quantities.percent(None, 2.0) == quantities.percent(1.0, 0.0) == "–"


@settings(deadline=None)  # the machine may be busy
@given(st.floats(1e-6, 1e6), st.floats(-1e6, 1e6), st.integers(2, 12))
def test_ticks_are_few_even_and_inside(span: float, low: float, most: int) -> None:
    assume(span > 1e-9 * abs(low))  # a narrower axis has no ticks to tell apart in floating point
    found = ticks(low, low + span, most)
    assert 1 <= len(found) <= most
    assert all(low - 1e-6 * span <= tick <= low + span * (1 + 1e-6) for tick in found[1:])
    steps = [b - a for a, b in itertools.pairwise(found)]
    assert all(math.isclose(step, steps[0], rel_tol=1e-3) for step in steps)


def test_an_axis_has_a_scale() -> None:
    """Of 48 to either side fifties leave only the zero."""
    assert ticks(-48.0, 48.0, 4) == [-40.0, 0.0, 40.0]
    assert ticks(-50.0, 50.0, 4) == [-50.0, 0.0, 50.0]


@settings(deadline=None)  # the machine may be busy
@given(st.floats(1e-3, 1e3), st.floats(1.05, 1e5))
def test_logarithmic_ticks_are_inside(low: float, ratio: float) -> None:
    found = log_ticks(low, low * ratio, 9)
    assert 1 <= len(found) <= 9
    assert all(low * (1 - 1e-6) <= tick <= low * ratio * (1 + 1e-6) for tick in found)


def test_tick_labels_have_the_decimals_of_their_step() -> None:
    assert [tick_text(tick, [0.0, 0.05, 0.1]) for tick in (0.0, 0.05, 0.1)] == ["0", "0.05", "0.10"]
    assert [tick_text(tick, [-20.0, -10.0, 0.0]) for tick in (-20.0, 0.0)] == ["−20", "0"]
    assert [tick_text(tick, [0.1, 1.0, 10.0]) for tick in (0.1, 1.0, 10.0)] == ["0.1", "1", "10"]


def test_a_scale_maps_its_ends_and_the_middle() -> None:
    assert AxisScale(2.0, 6.0, 100.0, 0.0)(3.0) == pytest.approx(75.0)
    assert AxisScale(1.0, 100.0, 0.0, 10.0, logarithmic=True)(10.0) == pytest.approx(5.0)
    assert math.isnan(AxisScale(1.0, 100.0, 0.0, 10.0, logarithmic=True)(-1.0))
    assert with_margin([3.0, math.nan, 3.0], least=2.0) == pytest.approx((1.88, 4.12))


@settings(deadline=None)  # the machine may be busy
@given(st.lists(st.one_of(st.floats(-1e3, 1e3), st.just(math.nan)), min_size=1, max_size=400), st.integers(1, 30))
def test_thinning_keeps_extremes_and_order(values: list[float], buckets: int) -> None:
    times = [float(i) for i in range(len(values))]
    kept = thin_curve(times, values, buckets)
    assert [t for t, _ in kept] == sorted(t for t, _ in kept)
    assert len(kept) <= max(len(values) if len(values) <= 2 * buckets else 0, 2 * buckets + 2)
    finite = [v for v in values if math.isfinite(v)]
    if finite:
        shown = [v for _, v in kept if math.isfinite(v)]
        assert (min(shown), max(shown)) == (min(finite), max(finite))


def test_a_missing_sample_breaks_the_line() -> None:
    path = polyline_path([(0, 0), (1, 1), (2, math.nan), (3, 3), (4, 4)])
    assert path == "M0 0L1 1M3 3L4 4"
    assert polyline_path([(0, math.nan)]) == ""


def test_laws_agree_with_their_formulas() -> None:
    power = law_points("power", {"torque_at_1_rad_per_s": 0.1, "exponent": 0.5}, 4.0 / RPM)
    assert power is not None
    assert power[-1] == pytest.approx((4.0 / RPM, 0.2))
    friction = law_points("coulomb_viscous", {"friction": 0.3, "rate": 0.1}, 2.0 / RPM)
    assert friction is not None
    assert friction[-1][1] == pytest.approx(0.5)
    assert friction[0][1] > 0.3
    assert law_points("table", {"slope_1": 1.0}, 10.0) is None
    assert law_points("power", {"exponent": 0.5}, 10.0) is None


@settings(deadline=None)  # the machine may be busy
@given(st.floats(2.0, 30.0), st.floats(0.5, 6.0), st.floats(5.0, 60.0))
def test_drawn_arms_are_tangent_and_enclose_the_included_angle(coils: float, wire: float, leg: float) -> None:
    """The wire turns 2 pi N counter-clockwise from the first arm's root to the second's, whatever N."""
    included = math.radians((180.0 - 360.0 * (coils % 1.0)) % 360.0)
    mean = 8 * wire
    first, second = arms_of(DrawnSpring(wire, mean, coils, included, (leg, leg), wire * (coils + 1)))
    for arm in (first, second):
        assert math.hypot(*arm.root) == pytest.approx(mean / 2)
        assert arm.root[0] * arm.direction[0] + arm.root[1] * arm.direction[1] == pytest.approx(0.0, abs=1e-9 * mean)
        assert math.dist(arm.root, arm.end) == pytest.approx(leg)
    angles = [math.atan2(arm.direction[1], arm.direction[0]) for arm in (first, second)]
    assert math.remainder(angles[0] - angles[1] - included, math.tau) == pytest.approx(0.0, abs=1e-9)
    roots = [math.atan2(arm.root[1], arm.root[0]) for arm in (first, second)]
    assert math.remainder(roots[1] - roots[0] - math.tau * coils, math.tau) == pytest.approx(0.0, abs=1e-6)
    # The first arm runs into the circle along the winding sense, the second leaves along it.
    for arm, sense in ((first, -1.0), (second, 1.0)):
        across = arm.root[0] * arm.direction[1] - arm.root[1] * arm.direction[0]
        assert across * sense > 0.0


@pytest.mark.parametrize("degrees", [0.0, 30.0, 90.0, 180.0, 240.0, 330.0])
@pytest.mark.parametrize("arms", ["tangent", "radial", "axial"])
def test_any_included_angle_can_be_drawn(degrees: float, arms: str) -> None:
    make = {
        "wire_diameter": quantity(2.0, "mm"), "mean_diameter": quantity(20.0, "mm"), "body_coils": quantity(5.0, "1"),
        "included_angle": quantity(degrees, "deg"), "body_length": quantity(12.0, "mm"), "leg_convention": arms,
    }  # fmt: skip
    drawing = drawing_of("spring", make)
    assert drawing is not None
    assert f"{degrees:g}°" in drawing or arms == "axial"
    assert drawing_of("spring", {**make, "wire_diameter": None}) is None


def test_rms_skips_missing_samples() -> None:
    table = ResultTable({"time": [0, 1, 2], "a b wanted": [0.0, 0.0, math.nan], "a b built": [3.0, 4.0, 9.0]}, {})
    response = Response("x", "x.csv", table)
    assert response.joints("wanted") == ["a b"]
    assert response.rms("a b", "wanted", "built") == pytest.approx(math.sqrt(12.5))
    assert response.rms("a b", "wanted", "animal") is None


def test_trials_find_their_files() -> None:
    files = ["responses/source/a_1.csv", "responses/source/rat_a_2.csv"]
    assert file_of("trials/a_1.csv", files) == files[0]
    assert file_of("rat/a_2.csv", files) == files[1]
    assert file_of("a_3.csv", files) is None


def test_extremes_keep_their_order() -> None:
    names = [f"t{i}" for i in range(20)]
    kept = extremes(names, {name: float(i) for i, name in enumerate(names)})
    assert kept == names[:4] + names[12:]
    assert extremes(names[:12], {}) == names[:12]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,hip [deg]\n1,2\n", "name \\[unit\\]"),
        ("t [s],a [deg]\n1\n", "2 cells"),
        ("t [s]\nx\n", "could not"),
        ("", "headers"),
    ],
)
def test_a_damaged_table_is_refused(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(text)
    with pytest.raises(ReportError, match=said):
        read_table(path)


@pytest.mark.parametrize(("hand", "sense"), [("right", 1.0), ("left", -1.0)])
@pytest.mark.parametrize("arms", ["tangent", "radial"])
def test_work_turns_the_near_arm_along_the_wires_winding(hand: str, sense: float, arms: str) -> None:
    """The arrow's end lies a travel on from the near arm, and by the coil's law that changes the included angle.

    Seen by the viewer the wire of a right-hand coil comes nearer counter-clockwise, so work turns the near arm on
    counter-clockwise: 0.3 rad more of turns. Tangent arms enclose pi - 2 pi frac(N), radial ones 2 pi frac(N).
    """
    angle, travel = math.radians(120.0), 0.3
    spring = DrawnSpring(2.0, 20.0, 5.0, angle, (25.0, 25.0), 12.0, arms, None, hand, travel)
    near = arms_of(spring)[1].direction
    start = math.atan2(near[1], near[0])
    html = str(spring_drawing("x", spring))
    arrow = re.search(
        r"M([\d.]+) ([\d.]+)A([\d.]+) [\d.]+ 0 0 (\d) ([\d.]+) ([\d.]+)\"[^>]*#d55e00", html, re.IGNORECASE
    )
    assert arrow is not None
    x0, y0, radius, sweep, x1, y1 = (float(value) for value in arrow.groups())
    turned = 2.0 * math.asin(math.hypot(x1 - x0, y1 - y0) / 2.0 / radius)
    assert turned == pytest.approx(travel, abs=0.01)
    assert sweep == (0.0 if sense > 0 else 1.0)  # on paper y points down
    middle = (x0 - radius * math.cos(start), y0 + radius * math.sin(start))
    end = math.atan2(-(y1 - middle[1]), x1 - middle[0])
    assert math.remainder(end - start, math.tau) == pytest.approx(sense * travel, abs=0.02)
    far = arms_of(spring)[0].direction
    enclosed = abs(math.remainder(end - math.atan2(far[1], far[0]), math.tau))
    assert enclosed == pytest.approx(angle - travel if arms == "tangent" else angle + travel, abs=0.02)


def test_a_long_text_is_cut_where_a_reader_expects_it() -> None:
    assert cut_short("One sentence here. Another one", 25) == "One sentence here."
    assert cut_short("A clause goes here; another one", 25) == "A clause goes here …"
    assert cut_short("words without any stop at all", 25) == "words without any stop …"
    assert cut_short("short", 25) == "short"


def test_digits_that_an_interval_does_not_justify_are_not_shown() -> None:
    """A rate of a big machine was "746741 N·m/rad 597216 to 896266", an insect's spring had four digits."""
    big = {"value": 746741.4, "unit": "N*m/rad", "interval90": [597216.4, 896266.4]}
    assert (quantities.text(big), quantities.interval_text(big)) == ("750000\u00a0N·m/rad", "600000 to 900000")
    small = {"value": 9.513e-8, "unit": "N*m/rad", "interval90": [7.501e-8, 1.1526e-7]}
    assert quantities.interval_text(small) == "7.5·10⁻⁸ to 1.15·10⁻⁷"
    assert quantities.value_text({"value": -3.0, "unit": "N*m", "interval90": [-400.0, 394.0]}) == "0"


def test_parameters_are_read_as_what_they_are() -> None:
    """A change was listed as the rate itself, and a parameter was called "knee" in rows whose joint is the knee."""
    shown = {
        "rate": {"label": "change of rate", "form": "change", "added_to": "spring_rate"},
        "error": {"label": "error", "form": "relative change"},
        "knee": {"label": "sharpness", "form": "value"},
    }
    document = {
        "effects": {"made_up": {"parameters": shown}},
        "designed": {"slew": {"spring_rate": {"value": 2.5e6, "unit": "N*m/rad"}}},
    }
    values = {
        "rate": {"value": 746741.4, "unit": "N*m/rad", "interval90": [597216.4, 896266.4]},
        "error": {"value": -0.0291, "unit": "1", "interval90": [-0.04, -0.018]},
        "knee": {"value": 1.5, "unit": "1"},
    }
    rate, error, knee = parameter_rows({"effect": "made_up", "joint": "slew", "parameters": values}, document)
    assert (rate["name"], rate["value"], rate["interval"]) == (
        "change of rate", "+750000\u00a0N·m/rad", "600000 to 900000",
    )  # fmt: skip
    assert rate["becomes"] == "gives 3.25·10⁶\u00a0N·m/rad for 2.50·10⁶\u00a0N·m/rad designed"
    assert (error["value"], error["interval"], error["becomes"]) == ("−2.9\u00a0%", "−4.0 to −1.8", "")
    assert (knee["name"], knee["value"]) == ("sharpness", "1.5")
    places = {
        "effects": {"made_up": {"parameters": {"place": {"label": "read", "choices": ["before it", "behind it"]}}}}
    }
    for value, place in ((0.0, "before it"), (1.0, "behind it"), (0.5, "0.5")):
        cause = {"effect": "made_up", "joint": "slew", "parameters": {"place": {"value": value, "unit": "1"}}}
        (row,) = parameter_rows(cause, places)
        assert (row["name"], row["value"], row["interval"]) == ("read", place, "")
    (plain,) = parameter_rows({"effect": "old", "joint": "slew", "parameters": {"in_an_older": values["knee"]}}, {})
    assert (plain["name"], plain["value"]) == ("in an older", "1.5")


def test_names_with_a_common_start_stay_different_when_cut() -> None:
    joints = ["left_hind_coxofemoral_joint_of_prototype_7", "left_hind_femorotibial_joint_of_prototype_7"]
    for most in (30, 34):
        cut = shorten_apart([f"backlash, {name}" for name in joints], most)
        assert all(len(words) <= most for words in cut)
        assert len(set(cut)) == 2
    assert shorten_apart(["a short one"], 30) == ["a short one"]
    figure = str(bar_figure("bars", joints, [BarColumn("n", [Bar(1.0, "1"), Bar(1.0, "1")], 1.0)], 400.0, 160.0))
    assert len(set(re.findall(r"<text[^>]*>([^<]*…[^<]*)<title>", figure))) == 2


def test_a_panel_s_title_keeps_clear_of_its_remark() -> None:
    curve = Curve([0.0, 1.0], MEASURED)
    panel = TrialPanel("left_hind_coxofemoral_joint_of_prototype_7", "deg", [0.0, 1.0], [curve], "RMS 0.71° → 0.10°")
    drawing = str(trial_figure("a.csv", [panel], shared_limits([panel])))
    title = re.findall(r"<text[^>]*font-weight[^>]*>([^<]*)", drawing)[0]
    assert title.endswith(" angle [°]")
    assert 7.0 * len(title) + 6.0 * len(panel.remark) < 340.0 - 16.0


def test_the_angle_of_a_stick_figure_s_label_is_never_cut() -> None:
    joints = (FigureJoint("left_hind_coxofemoral_joint_of_prototype_7", 0.0, 1.0, 200.0),)
    stick = Stick(joints, 0.0)
    motion = FigureMotion([0.0, 1.0], [(95.0,), (80.0,)])
    labels = re.findall(r">([^<]*…[^<]*)<title>", str(stick_figure("a", stick, motion)))
    assert labels
    assert all(label.endswith(" 95° ↺") for label in labels)
