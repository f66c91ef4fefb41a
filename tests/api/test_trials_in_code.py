"""Trials made in code pass the checks of a recording's file, and wrapped angles are continued as there."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from math import inf, nan, pi, radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import synth
from synth.drives.servo import Servo, ServoSignals
from synth.files.made_in_code import in_code
from synth.files.trial_in_code import checked_trials
from synth.remarks import severity_of

FIT = Path(synth.__file__).parent / "examples" / "fit"
TIME = np.arange(0.0, 1.5, 0.0075)
TURN = 2.0 * pi
LINK = synth.Link(0.22, 0.207, 0.075, 1.0885e-3)
# Of the exact pendulum that the swings below have: rate 1.7 N m/rad, damper 0.02 N m s/rad, without gravity.
INERTIA = LINK.inertia + LINK.mass * LINK.com**2


def swing(first: float) -> NDArray[np.float64]:
    """(n,) rad about 0, of a damped oscillator released at ``first`` rad."""
    decay = 0.5 * 0.02 / INERTIA
    fast = (1.7 / INERTIA - decay**2) ** 0.5
    noise = radians(0.05) * np.random.default_rng(int(abs(first) * 100)).normal(size=len(TIME))
    return first * np.exp(-decay * TIME) * (np.cos(fast * TIME) + decay / fast * np.sin(fast * TIME)) + noise


def wrapped(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    return (angle + pi) % TURN - pi


def of(zero: float = 0.0, **changed: Any) -> synth.Leg:
    """A leg whose spring rests with the link straight, at ``zero`` rad."""
    spring, damper = synth.Spring(1.7, zero), synth.Damper(rate=0.02)
    joint = synth.Joint("knee", LINK, zero=zero, spring=spring, damper=damper)
    return synth.Leg("shank", (replace(joint, **changed),), gravity=0.0)


def trial(**changed: Any) -> synth.Trial:
    return synth.Trial(**{"name": "a", "time": TIME, "angles": swing(0.6)[:, None], **changed})


def written(folder: Path, trials: Sequence[synth.Trial]) -> list[str]:
    for each in trials:
        rows = "\n".join(f"{t!r},{a!r}" for t, a in zip(each.time.tolist(), each.angles[:, 0].tolist(), strict=True))
        (folder / each.name).write_text(f"time [s],knee [rad]\n{rows}\n", encoding="utf-8")
    return [each.name for each in trials]


ANGLES, MIDDLE = trial().angles, len(TIME) // 2
SLIPPED = np.where(np.arange(len(TIME)) < MIDDLE, 0.0, radians(300.0))[:, None] + ANGLES
BAD = [
    (
        {"angles": np.degrees(ANGLES) + 1000.0},
        r"angles\[0, 0\] \(knee\): .* rad is .* deg, beyond any .* numpy.radians",
    ),
    ({"angles": np.degrees(ANGLES)[::7] + 500.0, "time": TIME[::7]}, r"angles\[0, 0\] \(knee\): .* numpy.radians"),
    ({"angles": SLIPPED}, rf"angles\[{MIDDLE}, 0\] \(knee\): goes from .* may be a whole turn or not; .* nan"),
    ({"angles": ANGLES[:, 0]}, r"angles: has the shape \(200,\), where \(200, 1\) is needed.*write angles\[:, None\]"),
    (
        {"angles": ANGLES[:-1]},
        r"angles: has the shape \(199, 1\), where \(200, 1\) is needed: samples by joints \(knee",
    ),
    ({"angles": np.hstack([ANGLES, ANGLES])}, r"angles: has the shape \(200, 2\)"),
    ({"angles": ANGLES * nan}, r"angles\[:, 0\] \(knee\): is empty"),
    ({"angles": np.where(ANGLES[7] == ANGLES, inf, ANGLES)}, r"angles\[7, 0\]: inf is not allowed"),
    ({"angles": "swing.csv"}, "angles: 'swing.csv' is not allowed: an array"),
    ({"angles": None}, r"angles: has the shape \(\)"),
    ({"time": np.where(TIME[7] == TIME, nan, TIME)}, r"time\[7\]: has no time"),
    ({"time": TIME[::-1]}, r"time\[1\]: time runs backwards: 1.4925, then 1.485 \(and in 198 more"),
    ({"time": np.where(TIME[7] == TIME, TIME[6], TIME)}, r"time\[7\]: time repeats: 0.045, then 0.045"),
    ({"time": TIME * 1000.0}, "time: the samples are 7.5 s apart; .* In code it is in s"),
    ({"time": TIME[:, None]}, r"time: has the shape \(200, 1\), where \(samples,\) is needed"),
    ({"time": TIME[:0], "angles": ANGLES[:0]}, "has 0 samples; a trial needs at least 8"),
    ({"velocities": ANGLES[:10]}, r"velocities: has the shape \(10, 1\)"),
    ({"torques": ANGLES * nan}, r"torques\[:, 0\] \(knee\): is empty"),
    (
        {"torques": np.where(TIME < 0.5, nan, 1.0)[:, None]},
        r"torques\[.*\] \(knee\): no torque is given between 0 s and",
    ),
    ({"locked": ("hip",)}, 'locked: "hip" is no joint of the leg'),
    ({"locked": ("knee",)}, "locked: every joint is locked"),
    ({"locked": "knee"}, "locked: 'knee' is not allowed: write a tuple"),
    ({"tip_mass": -0.05}, "tip_mass: -0.05 kg is not allowed: it must be at least 0"),
    ({"tip_mass": "50 g"}, 'tip_mass: "50 g" is not allowed: in code this is a number in kg'),
    ({"tip_mass": 0.05, "tip_inertia": -1e-6}, "tip_inertia: -1e-06 kg"),
    ({"tip_at": nan}, "tip_at: nan is not allowed"),
    ({"tilt": 20.0}, "tilt: 20 rad is not allowed: it can be at most 360 deg; in code angles are in rad"),
    ({"held_out": 1}, "held_out: 1 is not allowed: write true or false"),
    ({"signals": "voltage"}, "signals: 'voltage' is not allowed: no joint has a servo"),
    ({"leg": of()}, "leg: a trial with its own leg is supported by synth gap only"),
]


@pytest.mark.parametrize(("changed", "said"), BAD, ids=[said[:40] for _, said in BAD])
def test_what_a_file_may_not_say_is_refused(changed: dict[str, Any], said: str) -> None:
    others = (trial(name="b"), trial(name="c"))
    with pytest.raises(synth.UserError, match=f"^a: {said}"):
        synth.fit(of(), [trial(**changed), *others])
    if "leg" not in changed:
        with pytest.raises(synth.UserError, match=f"^a: {said}"):
            synth.gap(of(), [trial(**changed), *others])


def test_trials_are_compared_with_each_other() -> None:
    made = [trial(name=name) for name in "abc"]
    slow = replace(made[0], time=TIME[:30] * 50.0, angles=ANGLES[:30])
    fast = [replace(each, time=each.time / 10.0) for each in made[1:]]
    said = r"^a: time: its samples are .* In code it is in s: divided by 1000, they would be 0\.000375 s apart$"
    with pytest.raises(synth.UserError, match=said):
        synth.fit(of(), [slow, *fast])
    with pytest.raises(synth.UserError, match=r"^trials\[1\]: name: 5 is no name"):
        synth.fit(of(), [made[0], trial(name=5)])


def test_two_trials_of_one_name_are_refused() -> None:
    """As two files of one name in two folders are, when each is read by itself; no page tells them apart."""
    made = [trial(name=name, angles=swing(first)[:, None]) for name, first in (("a", 0.6), ("b", 0.4), ("a", 0.8))]
    said = r"^a: name: is the name of trials\[0\], trials\[2\]; name each trial once: dataclasses.replace"
    for refuse in (synth.fit, synth.gap):
        with pytest.raises(synth.UserError, match=said):
            refuse(of(), made)
    with pytest.raises(synth.UserError, match=said):
        synth.compare(made, {"model": of()})
    assert len(checked_trials([*made[:2], replace(made[2], name="c")], of(), in_code(FIT))) == 3


def test_wrapped_angles_give_what_their_files_give(tmp_path: Path) -> None:
    """Within rounding: the file's unit is the same, and so are all numbers."""
    leg = of(zero=radians(252.0))
    whole = [swing(first) + radians(252.0) for first in (1.5, -1.5, 1.2)]
    made = [trial(name=f"{k}.csv", angles=wrapped(angle)[:, None]) for k, angle in enumerate(whole)]
    read = synth.read_trials(written(tmp_path, made), leg, folder=tmp_path)
    assert any(any(each.jumps) for each in read)
    for mine, file in zip(checked_trials(made, leg, in_code(tmp_path)), read, strict=True):
        np.testing.assert_array_equal(mine.angles, file.angles)
        assert (mine.jumps or (0,)) == file.jumps
    by_code, by_file = synth.fit(leg, made), synth.fit(leg, read)
    assert by_code.joints == by_file.joints
    assert by_code.warnings == by_file.warnings
    assert any("jumps by a whole turn were removed (knee" in text for text in by_code.warnings)
    assert by_code.joints["knee"].spring_rate.value == pytest.approx(1.7, rel=0.01)
    # Continued once, they are taken as they are, with the same note.
    again = synth.fit(leg, by_code.project.trials)
    assert all(new is old for new, old in zip(again.project.trials, by_code.project.trials, strict=True))
    assert again.warnings == by_code.warnings
    assert made[0].angles.flags.writeable
    assert abs(made[0].angles).max() <= pi


def test_what_was_read_is_taken_as_it_is() -> None:
    leg = synth.read_leg(FIT / "robot.leg.yaml")
    trials = synth.read_trials("trials/*.csv", leg, folder=FIT)
    found = checked_trials(trials, leg, in_code(FIT))
    assert all(new is old for new, old in zip(found, trials, strict=True))


def test_lists_and_whole_numbers_are_arrays() -> None:
    plain = trial(velocities=np.full_like(ANGLES, nan), tilt=np.float64(0.1), held_out=False)
    lists = replace(plain, time=TIME.tolist(), angles=ANGLES.tolist(), locked=[])
    found = checked_trials([lists, trial(name="b", torques=np.zeros((200, 1), dtype=int))], of(), in_code(FIT))
    np.testing.assert_array_equal(found[0].angles, ANGLES)
    assert found[0].locked == ()
    assert found[1].torques is not None
    assert found[1].torques.dtype == float


def test_a_servos_inputs_are_needed_in_their_shapes() -> None:
    leg = of(drive=Servo(2.0))
    one = np.ones((200, 1))
    good = ServoSignals(TIME, 0.0 * one, one, one, (0,))
    assert checked_trials([trial(signals=good)], leg, in_code(FIT))[0].signals is good
    for signals, said in (
        (None, "signals: is missing: the servo of knee needs its inputs"),
        ("voltage", "signals: 'voltage' is not allowed: ServoSignals are needed"),
        (replace(good, command=one[:, 0]), r"signals.command: has the shape \(200,\), where \(200, 1\)"),
        (replace(good, supply=nan * one), "signals.supply: .* no finite number"),
        (replace(good, time=TIME[::-1]), "signals.time: time must increase"),
    ):
        with pytest.raises(synth.UserError, match=f"^a: {said}"):
            checked_trials([trial(signals=signals)], leg, in_code(FIT))
    turned = wrapped(swing(1.5) + radians(170.0))[:, None]
    with pytest.raises(synth.UserError, match=r"angles\[:, 0\] \(knee\): jumps by whole turns .* continue both"):
        checked_trials([trial(angles=turned, signals=good)], leg, in_code(FIT))


def test_a_trials_own_leg_is_checked() -> None:
    longer = of(link=replace(LINK, length=0.3))
    others = (trial(name="b"), trial(name="c"))
    for own, said in (
        (of(link=replace(LINK, mass=-1.0)), "a: leg.joints.knee.link.mass: -1 kg is not allowed"),
        (of(name="hip"), "a: leg: shank has other joints"),
        (of(zero=1.0), "a: leg: shank and shank differ in a joint's zero or sign"),
        ("long.leg.yaml", "a: leg: 'long.leg.yaml' is no Leg"),
    ):
        with pytest.raises(synth.UserError, match=said):
            synth.gap(of(), [trial(leg=own), *others])
    taken = checked_trials([trial(leg=longer)], of(), in_code(FIT), own_legs=True)
    assert taken[0].leg is longer


def test_recordings_in_code_are_continued_as_a_side_too() -> None:
    leg = of(zero=radians(178.0))
    turned = trial(angles=wrapped(swing(1.2) + radians(178.0))[:, None])
    found = synth.compare([turned], {"model": leg})
    (motion,) = found.result.sides[0].motions
    assert np.nanmax(np.abs(np.diff(motion.rotation[:, 0]))) < 1.0
    with pytest.raises(synth.UserError, match=r"^a: angles: has the shape \(200,\)"):
        synth.compare([trial(angles=ANGLES[:, 0])], {"model": leg})


@pytest.mark.parametrize("first", [radians(2.0), radians(6.0)])
def test_degrees_of_a_small_swing_given_for_radians_are_doubted(first: float) -> None:
    """Their numbers are no larger than radians may be, but the joint would turn farther than a limb's does."""
    doubt = "cover [0-9]+ deg, more than the joint is known to do. If the numbers are degrees"
    given = trial(angles=swing(first)[:, None])
    right = synth.fit(of(), [given])
    assert not any(re.search(doubt, text) for text in right.warnings)
    wrong = synth.fit(of(), [replace(given, angles=np.degrees(given.angles))])
    (found,) = [text for text in wrong.warnings if re.search(doubt, text)]
    assert found.startswith("knee: the angles of a, in radians, cover ")
    assert severity_of(found) == "decide"
    turning = synth.fit(of(range=(radians(-360.0), radians(360.0))), [replace(given, angles=np.degrees(given.angles))])
    assert not any(re.search(doubt, text) for text in turning.warnings)


def test_only_angles_that_are_called_radians_are_doubted(tmp_path: Path) -> None:
    """A header that says degrees states the unit, and a single wrong reading is no travel."""
    wide = np.degrees(swing(radians(2.0)))
    leg, made = of(), trial(name="rad.csv", angles=wide[:, None])
    text = (tmp_path / written(tmp_path, [made])[0]).read_text(encoding="utf-8")
    (tmp_path / "deg.csv").write_text(
        text.partition("\n")[0].replace("[rad]", "[deg]")
        + "\n"
        + "".join(f"{t!r},{a!r}\n" for t, a in zip(TIME.tolist(), np.degrees(wide).tolist(), strict=True))
    )
    (by_radians,) = synth.read_trials("rad.csv", leg, folder=tmp_path)
    (by_degrees,) = synth.read_trials("deg.csv", leg, folder=tmp_path)
    assert by_radians.unusual[0] > radians(150.0)
    place = in_code(tmp_path)
    for file, expected in ((by_radians, True), (by_degrees, False)):
        assert any(file.unusual) is expected
        assert any(checked_trials([file], leg, place)[0].unusual) is expected
    glitch = swing(0.6)
    glitch[MIDDLE : MIDDLE + 2] += 3.0
    (found,) = checked_trials([trial(angles=glitch[:, None])], leg, place)
    assert not any(found.unusual)


@pytest.mark.parametrize("form", [lambda a: a, lambda a: list(a), lambda a: a.astype(np.float32)])
def test_the_mask_of_an_array_marks_missing_samples(form: Any) -> None:
    """A logger's filler behind the mask was fitted as if it were measured."""
    bad = np.zeros((len(TIME), 1), dtype=bool)
    bad[40:60] = True
    filled = np.where(bad, 9.0, ANGLES)
    (found,) = checked_trials([trial(angles=form(np.ma.masked_array(filled, mask=bad)))], of(), in_code(Path("x")))
    np.testing.assert_array_equal(np.isnan(found.angles), bad)
    np.testing.assert_allclose(found.angles[~bad], ANGLES[~bad], atol=1e-6)
    assert not isinstance(found.angles, np.ma.MaskedArray)


def test_numbers_that_are_not_real_are_refused() -> None:
    whole = np.ma.masked_array(np.zeros((len(TIME), 1), dtype=int), mask=np.arange(len(TIME))[:, None] == 9)
    (found,) = checked_trials([trial(torques=whole)], of(), in_code(Path("x")))
    assert found.torques is not None
    assert found.torques.dtype == float
    for changed, key in (
        ({"angles": ANGLES + 0j}, "angles"),
        ({"angles": np.ma.masked_array(ANGLES + 0j, mask=ANGLES > 0.1)}, "angles"),
        ({"time": (TIME * 1e9).astype("datetime64[ns]")}, "time"),
        ({"time": (TIME * 1e9).astype("timedelta64[ns]")}, "time"),
    ):
        with pytest.raises(synth.UserError, match=rf"a: {key}: an array of \S+ is not allowed: "):
            checked_trials([trial(**changed)], of(), in_code(Path("x")))
    masked = np.ma.masked_array(TIME, mask=np.arange(len(TIME)) == 3)
    with pytest.raises(synth.UserError, match=r"a: time\[3\]: has no time"):
        checked_trials([trial(time=masked)], of(), in_code(Path("x")))
