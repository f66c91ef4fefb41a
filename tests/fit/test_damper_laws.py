"""Damper laws from drops: MuJoCo drops a shank with a known damper; the right law and its numbers are found."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fit.simulated_legs import Rig, bare, release, robot
from synth.files.trial_list import Trial
from synth.fit.damper_laws import DamperLaw, _speed_range, find_damper_law
from synth.fit.recordings import Recording, recordings
from synth.swing.damper_curves import torque_at

LEG = bare(robot())
STARTS = (84.0, 96.0, 108.0, 120.0)  # deg of the knee, measured; it hangs at 180
Drag = Callable[[float], float]


def drops(drag: Drag, seed: int = 1) -> list[Recording]:
    """Drops of shank and foot about the knee, hip and ankle held straight, ``drag`` N m at a speed (rad/s) >= 0."""

    def torque(rotation: np.ndarray, rate: np.ndarray) -> np.ndarray:
        return np.array([0.0, -np.sign(rate[1]) * drag(abs(rate[1])), 0.0])

    generator, rig = np.random.default_rng(seed), Rig(duration=2.0, rate=200, step=4e-4)
    made: list[Trial] = []
    for start in STARTS:
        away = np.array([0.0, start - 180.0, 0.0])
        made.append(release(LEG, away, generator, rig, name=f"{start:g}", locked=("hip", "ankle"), extra_torque=torque))
    return recordings(LEG, made, ["knee"])


def power(speed: float) -> float:
    return 0.1168 * speed * np.hypot(speed, 1e-3) ** (0.44 - 1)


def linear(speed: float) -> float:
    return 0.1 * speed


def friction(speed: float) -> float:
    return 0.05 * speed / np.hypot(speed, 0.01) + 0.05 * speed


def piecewise_linear(speed: float) -> float:
    return float(np.interp(speed, [0, 0.2, 1, 6], [0, 0.08, 0.12, 0.5]))


def values(found: DamperLaw, law: str) -> list[float]:
    fit = next(fit for fit in found.fits if fit.law.name == law)
    return [quantity["value"] for quantity in fit.parameters.values()]


def rms(found: DamperLaw, law: str) -> float:
    """Held-out RMS, deg."""
    return float(np.degrees(next(fit.rms_held_out for fit in found.fits if fit.law.name == law)))


def test_power_law_is_found() -> None:
    found = find_damper_law(LEG, "knee", drops(power))
    assert found.used.law.name == "power"
    assert values(found, "power") == pytest.approx([0.1168, 0.44], rel=0.01)
    assert found.how_held_out == "every second drop in turn"
    assert rms(found, "power") < 0.2
    assert rms(found, "linear") > 10 * rms(found, "power")
    assert not any("do not tell" in text for text in found.warnings)


def test_the_linear_law_is_chosen_unless_a_richer_one_predicts_better() -> None:
    found = find_damper_law(LEG, "knee", drops(linear))
    assert found.used.law.name == "linear"
    assert values(found, "linear") == pytest.approx([0.1], rel=2e-3)
    assert values(found, "power") == pytest.approx([0.1, 1.0], rel=5e-3)  # and these agree with it
    assert rms(found, "linear") == pytest.approx(0.1, rel=0.05)
    assert any("do not distinguish linear from" in text for text in found.warnings)


def test_dry_friction_and_a_linear_rate_are_found_together() -> None:
    # Friction to 8 % only: below 0.3 of the slowest speed the law is straight, where the joint in fact sticks
    found = find_damper_law(LEG, "knee", drops(friction))
    assert found.used.law.name == "coulomb_viscous"
    torque, rate = values(found, "coulomb_viscous")
    assert torque == pytest.approx(0.05, rel=0.08)
    assert rate == pytest.approx(0.05, rel=0.06)
    assert rms(found, "coulomb_viscous") < 0.35
    assert rms(found, "power") > 3 * rms(found, "coulomb_viscous")


def test_a_curve_of_no_listed_law_becomes_a_table_with_concave_extrapolation() -> None:
    recorded = drops(piecewise_linear)
    found = find_damper_law(LEG, "knee", recorded[:3], recorded[3:])
    assert found.used.law.name == "table"
    assert found.trials[-1] == ("120", True)
    assert found.how_held_out == "the trials marked held_out"
    assert rms(found, "table") == pytest.approx(0.1, rel=0.15)
    speed = np.linspace(0.15, found.speeds.high, 30)
    wanted = np.array([piecewise_linear(s) for s in speed])
    np.testing.assert_allclose(torque_at(found.used.curve, speed), wanted, atol=0.01)
    # beyond the drops it follows the power law's exponent, not the last slope
    exponent = values(found, "power")[1]
    end = 1.2 * found.speeds.fastest
    beyond = torque_at(found.used.curve, np.array([end, 2 * end, 16 * end]))
    assert beyond[1] / beyond[0] == pytest.approx(2**exponent, rel=1e-6)
    assert beyond[2] / beyond[0] == pytest.approx(16**exponent, rel=1e-6)


def test_the_warning_states_the_recorded_speed_range() -> None:
    found = find_damper_law(LEG, "knee", drops(linear)[::3])
    smooth = [np.abs(r.smoothed.rate[:, 1]) for r in drops(linear)[::3]]
    assert found.speeds.fastest == pytest.approx(max(s.max() for s in smooth))
    assert 0 < found.speeds.low < found.speeds.high < found.speeds.fastest
    assert f"{found.speeds.high:.3g} rad/s" in found.warnings[0]
    written = found.as_json()
    assert [law["used"] for law in written["laws"]].count(True) == 1
    assert written["speed_range"][1] == {"value": pytest.approx(found.speeds.high), "unit": "rad/s"}


def test_stiction_gives_a_warning() -> None:
    def sticky(speed: float) -> float:
        return 0.12 * speed / np.hypot(speed, 2e-3) + 0.03 * speed

    recorded = drops(sticky)
    found = find_damper_law(LEG, "knee", recorded)
    said = next(text for text in found.warnings if text.endswith("it sticks"))
    moment = (0.207 * 0.075 + 0.090 * (0.220 + 0.030)) * 9.81  # shank and foot, straight, about the knee
    held = np.median([moment * abs(np.sin(r.rotation[-20:, 1].mean())) for r in recorded])
    assert f"gravity still exerts {held:.2g} N*m" in said
    assert not any("it sticks" in text for text in find_damper_law(LEG, "knee", drops(linear)).warnings)


def test_springs_and_dampers_of_the_leg_file_are_ignored() -> None:
    recorded = drops(linear)[::2]
    with_parts = find_damper_law(robot(), "knee", recorded)
    assert values(with_parts, "linear") == values(find_damper_law(LEG, "knee", recorded), "linear")


def test_a_single_drop_warns_that_fit_and_score_share_it() -> None:
    found = find_damper_law(LEG, "knee", drops(power)[:1])
    assert "fitted and scored" in found.how_held_out
    assert any("a single drop" in text for text in found.warnings)


def test_a_damper_is_measured_between_the_outer_fiftieths_of_its_speeds() -> None:
    """Two drops, one each way, whose speeds rise evenly to 10 rad/s: at rest below 0.2, 2 % of the rest left out."""
    even = np.linspace(0.0, 10.0, 10_001)
    recorded: Any = [
        SimpleNamespace(smoothed=SimpleNamespace(rate=np.stack([100.0 + even, way * even], axis=1))) for way in (1, -1)
    ]
    found = _speed_range(recorded, 1)
    assert (found.low, found.high) == pytest.approx((0.2 + 0.02 * 9.8, 0.2 + 0.98 * 9.8), abs=2e-3)
    assert found.fastest == 10.0
