"""Options made in code are checked as those of a file: misspelt words and wrong numbers are refused, not replaced."""

from __future__ import annotations

import pickle
from dataclasses import fields
from math import radians
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

import pytest

import synth
from synth.files.fit_words import allowed_values
from synth.spring.spring_task import SpringLimits

FIT = Path(synth.__file__).parent / "examples" / "fit"
RATE, TRAVEL = "1.7 N*m/rad", "40 deg"


@pytest.fixture(scope="module")
def leg() -> synth.Leg:
    return synth.read_leg(FIT / "robot.leg.yaml")


@pytest.fixture(scope="module")
def trials(leg: synth.Leg) -> tuple[synth.Trial, ...]:
    return synth.read_trials("trials/free_1.csv", leg, folder=FIT)


def words_of(options: type[Any]) -> list[tuple[str, tuple[str, ...]]]:
    """Every field that takes words, with them."""
    found = []
    for name, hint in get_type_hints(options).items():
        for each in (hint, *get_args(hint)):
            if get_origin(each) is Literal:
                found.append((name, get_args(each)))
    return found


@pytest.mark.parametrize("options", [synth.FitOptions, synth.FitSettings])
def test_every_misspelt_word_is_refused_with_the_near_one(
    leg: synth.Leg, trials: tuple[synth.Trial, ...], options: type[Any]
) -> None:
    named = words_of(options)
    assert len(named) >= 3
    for name, words in named:
        given = options(**{name: f"{words[0]}s"})
        settings = given if options is synth.FitSettings else synth.FitSettings(options=given)
        for arguments in ((leg, trials), (FIT / "fit.yaml", ())):
            with pytest.raises(
                synth.UserError, match=rf'{name}: "{words[0]}s" is not allowed; did you mean {words[0]}'
            ):
                synth.fit(*arguments, settings)


def test_library_file_and_command_line_take_the_same_words() -> None:
    words = dict(words_of(synth.FitOptions))
    assert {name: allowed_values(name) for name in words} == words


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (synth.FitSettings(options=synth.FitOptions(seed=-1)), "fit.seed: -1 is not allowed"),
        (synth.FitSettings(options="swarm"), "fit: 'swarm' is no FitOptions: write synth.FitOptions"),  # type: ignore[arg-type]
        (synth.FitSettings(options={"method": "swarms"}), 'method: "swarms" is not allowed; did you mean swarm'),
        (synth.FitSettings(prior=synth.RatePrior(spring=-0.1)), "prior.spring: .* must be more than 0"),
        (synth.FitSettings(tolerance=synth.Tolerance(mass=-0.1)), "tolerance.mass: .* must be at least 0"),
        (synth.FitSettings(tolerance=synth.Tolerance(mass="1 %")), 'mass: "1 %" is not allowed: .* such as 0.05'),  # type: ignore[arg-type]
        (
            synth.FitSettings(tolerance=synth.Tolerance(joints={"knee": {"mass": 0.9}})),
            "tolerance.knee.mass: .* at most",
        ),
        (synth.FitSettings(tolerance={"mass": 0.1}), r"is no Tolerance: write synth.Tolerance"),  # type: ignore[arg-type]
    ],
)
def test_numbers_are_in_the_ranges_of_the_file(
    leg: synth.Leg, trials: tuple[synth.Trial, ...], settings: synth.FitSettings, said: str
) -> None:
    with pytest.raises(synth.UserError, match=said):
        synth.fit(leg, trials, settings)


def test_a_diagnosis_checks_its_tolerance_and_seed(leg: synth.Leg, trials: tuple[synth.Trial, ...]) -> None:
    springs = leg.with_joints(**{name: {"spring": synth.Spring(1.0, 2.0)} for name in leg.joint_names})
    with pytest.raises(synth.UserError, match=r"tolerance\.spring: .* at least 0"):
        synth.gap(springs, trials, tolerance=synth.Tolerance(spring=-1.0))
    with pytest.raises(synth.UserError, match="seed: -1 is not allowed"):
        synth.gap(springs, trials, seed=-1)


def test_a_diagnosis_takes_noise_and_accuracy(leg: synth.Leg, trials: tuple[synth.Trial, ...]) -> None:
    """Only a project file could state them."""
    springs = leg.with_joints(**{name: {"spring": synth.Spring(1.0, 2.0)} for name in leg.joint_names})
    first = leg.joint_names[0]
    for given, said in (
        ({"accuracy": -0.1}, "accuracy: .* at least 0"),
        ({"accuracy": 2.0}, r"accuracy: .* at most 90 deg"),
        ({"noise": {"hp": 1e-4}}, r'noise\.hp: "hp" is no joint of'),
        ({"noise": {first: 0.5}}, rf"noise\.{first}: .* at most 10 deg"),
        ({"noise": {first: "0.02 deg"}}, rf"noise\.{first}: .* in code this is a number in rad"),
    ):
        with pytest.raises(synth.UserError, match=said):
            synth.gap(springs, trials, **given)  # type: ignore[arg-type]


def test_what_is_no_recording_is_told(leg: synth.Leg) -> None:
    springs = leg.with_joints(**{name: {"spring": synth.Spring(1.0, 2.0)} for name in leg.joint_names})
    for function in (synth.fit, synth.gap):
        with pytest.raises(synth.UserError, match="no recording is given beside the leg"):
            function(springs, [])
        with pytest.raises(synth.UserError, match=r"'a\.csv' is no recording that was read, but a str"):
            function(springs, ["a.csv"])  # type: ignore[list-item]


@pytest.mark.parametrize("name", ["convention", "system", "objective", "hand", "rate_form"])
def test_a_misspelt_word_of_a_spring_is_refused(name: str) -> None:
    with pytest.raises(synth.UserError, match=f'{name}: "massive" is not allowed'):
        synth.spring(RATE, TRAVEL, wish={name: "massive"})


def test_every_quantity_of_a_spring_is_text_or_a_number() -> None:
    by_text = {
        "included_angle": "120 deg", "opening_travel": "5 deg", "leg_lengths": ("20 mm", 0.02),
        "limits": {"arbor_diameter": "6 mm", "max_outer_diameter": "0.8 in", "safety": 1.2},
    }  # fmt: skip
    limits = SpringLimits(arbor_diameter=0.006, max_outer_diameter=0.8 * 0.0254, safety=1.2)
    numbers = {
        "included_angle": radians(120), "opening_travel": radians(5), "leg_lengths": (0.02, 0.02), "limits": limits,
    }  # fmt: skip
    told, given = synth.spring(RATE, TRAVEL, wish=by_text), synth.spring(RATE, TRAVEL, wish=numbers)
    assert told.best is not None
    assert told.headline == given.headline
    assert told.wish.included_angle == pytest.approx(given.wish.included_angle)


def test_every_number_of_a_spring_has_its_unit() -> None:
    from synth.api.spring_wish import LIMITS, UNITS
    from synth.spring.requirement_ranges import RANGES

    hints = {item.name for item in fields(SpringLimits)}
    assert set(LIMITS) == hints
    kept = {
        name for name, hint in get_type_hints(synth.SpringAnswer)["wish"].__annotations__.items() if "float" in hint
    }
    assert set(UNITS) == kept
    assert set(RANGES) == {*UNITS, *LIMITS}


@pytest.mark.parametrize(
    ("wish", "said"),
    [
        ({"included_angle": "120"}, "included_angle: .*unit"),
        ({"included_angle": [1]}, r"included_angle: \[1\] is not allowed: write a number in rad, or text"),
        ({"included": "120 deg"}, "included: is no requirement on a spring; did you mean included_angle"),
        ({"max_outer_diameter": "20 mm"}, "max_outer_diameter: .* it is one of the limits"),
        ({"limits": {"max_outer": "20 mm"}}, r"limits\.max_outer: .* did you mean max_outer_diameter"),
        ({"limits": {"max_outer_diameter": "20 deg"}}, r"limits\.max_outer_diameter: "),
        ({"leg_lengths": "20 mm"}, "leg_lengths: .* write 2 values"),
        ({"rate": 1.0}, "rate: is an argument of its own"),
        ({"included_angle": 120}, "included_angle: 120 rad must be from 0 to below 360 deg; .* is in rad"),
        ({"included_angle": "400 deg"}, 'included_angle: "400 deg" must be from 0 to below 360 deg'),
        ({"opening_travel": -0.1}, "opening_travel: -0.1 rad must be from 0 to 3600 deg"),
        ({"leg_lengths": (0.02, 25)}, "leg_lengths: 25 m must be from 0 to 1 m"),
        ({"pitch": 0.5}, "pitch: 0.5 must be from 1"),
        ({"pitch": None}, "pitch: None is not allowed"),
        ({"wire_range": ("3 mm", "2 mm")}, "wire_range: .* write the lower end first"),
        ({"limits": {"max_outer_diameter": 20}}, r"limits\.max_outer_diameter: 20 m must be above 0 and at most 1 m"),
        ({"limits": SpringLimits(max_outer_diameter=20)}, r"limits\.max_outer_diameter: 20 m must be above 0"),
        ({"limits": {"safety": 0.9}}, r"limits\.safety: 0\.9 must be 1 or more"),
        ({"limits": {"cycles": 1e7}}, r"limits\.cycles: 1e\+07 must be from 1 to 1e6"),
        ({"limits": {"max_coils": float("inf")}}, r"limits\.max_coils: inf must be"),
        ({"limits": {"min_coils": 9, "max_coils": 5}}, r"limits\.min_coils: 9 is above max_coils, 5"),
        ({"material": 5}, "material: 5 is not allowed"),
        ({"free_arm": "20 deg"}, "free_arm: "),
        ({"free_arm": 20}, "free_arm: 20 m must be from 0 to 1 m"),
        ({"calibration": "calibration.json"}, "calibration: .* is not allowed: read the file with"),
    ],
)
def test_a_wish_that_cannot_be_read_is_a_message(wish: dict[str, Any], said: str) -> None:
    with pytest.raises(synth.UserError, match=said):
        synth.spring(RATE, TRAVEL, wish=wish)


def test_a_wish_may_hold_the_free_length_of_clamped_arms() -> None:
    """It ended in a traceback where it was no function."""
    found = [synth.spring(RATE, TRAVEL, wish={"free_arm": arm}) for arm in ("20 mm", 0.02, lambda *sizes: 0.02)]
    assert len({each.headline for each in found}) == 1
    assert pickle.loads(pickle.dumps(found[0])).headline == found[0].headline
    assert found[0].headline != synth.spring(RATE, TRAVEL).headline


@pytest.mark.parametrize("name", ["missing/a.leg.yaml", "folder", "a.csv/a.leg.yaml"])
def test_a_leg_that_cannot_be_written_there_is_a_message(name: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "a.csv").touch()
    leg = synth.Leg("one", (synth.Joint("knee", synth.Link(0.2, 0.3, 0.1, 1e-3)),))
    with pytest.raises(synth.UserError, match=r"no folder|is a folder"):
        synth.write_leg(leg, tmp_path / name)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["a.csv", "folder"]


def test_recordings_of_a_hopper_are_for_the_command_line(tmp_path: Path) -> None:
    """The message said that "synth hopper" reads the file and that it does not."""
    (tmp_path / "m.yaml").write_text("kind: hopper-motor\ngear_ratio: 150\nstall: [stall.csv]\n")
    told = '"synth hopper" reads a file of kind hopper-motor on the command line only; here "kind: hopper-design"'
    with pytest.raises(synth.UserError, match=told):
        synth.hopper(tmp_path / "m.yaml")


def test_rate_and_travel_in_code_are_in_the_ranges_of_the_command() -> None:
    for rate, travel, said in (
        (-1.7, TRAVEL, "rate: -1.7 N"),
        (RATE, 0.0, "travel: 0 rad"),
        (RATE, 63.0, "travel: 63"),
    ):
        with pytest.raises(synth.UserError, match=said):
            synth.spring(rate, travel)
    assert (
        "over 2292 deg" in synth.spring(RATE, 40).headline
    )  # possible for a long coil of thin wire, not for this rate


def test_a_travel_of_many_turns_that_no_spring_has_is_asked_for_its_unit() -> None:
    """40 for 40 degrees got the answer that no spring turns by 2292."""
    assert synth.spring(RATE, 40).headline.endswith('A number is in rad: for degrees write "40 deg"')
    assert synth.spring("500 N*m/rad", "90 deg").headline.endswith("within the limits")


@pytest.mark.parametrize("given", [3, None, ["a.yaml"], ""])
def test_what_is_no_file_s_name_is_told(given: Any, leg: synth.Leg) -> None:
    """A bare TypeError of pathlib, which names neither function nor argument; an empty name was the current folder."""
    calls = synth.read_leg, synth.design, synth.hopper, synth.jump_gap, synth.gap, synth.fit
    for call in (*calls, lambda path: synth.write_leg(leg, path)):
        with pytest.raises(synth.UserError, match=r"no file's name|neither a project's file|the file's name is empty"):
            call(given)


@pytest.mark.parametrize("given", [3, None])
def test_what_is_no_list_of_recordings_is_told(given: Any, leg: synth.Leg) -> None:
    with pytest.raises(synth.UserError, match=r"is no list of recordings: synth\.read_trials"):
        synth.read_trials(given, leg)


def test_a_gap_of_the_other_kind_of_leg_names_its_function() -> None:
    """``jump_gap`` of a swinging leg asked for "motor" and "length"."""
    examples = Path(synth.__file__).parent / "examples"
    with pytest.raises(synth.UserError, match=r"describes a swinging leg: read it with synth\.gap$"):
        synth.jump_gap(examples / "gap" / "gap.yaml")
    with pytest.raises(synth.UserError, match=r"describes a jumping leg: read it with synth\.jump_gap$"):
        synth.gap(examples / "hopper" / "gap.yaml")
