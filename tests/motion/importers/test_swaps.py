"""Left and right: tracks that cross are left alone, exchanged ones restored, doubtful ones named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, points
from synth.arrays import Array
from synth.files.import_mapping import JointColumn, Mapping
from synth.motion.importers.convert import import_file
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.limb_sides import LimbExchange, exchanged_limb
from synth.motion.importers.points import TrackedAngles, track

COUNT = 400


def column(values: Array) -> Array:
    return np.asarray(values)[:, None]


def exchanged(one: Array, other: Array) -> LimbExchange:
    """Of a limb with one joint, whose angles (n,) of either side are given."""
    return exchanged_limb([column(one)], [column(other)])


def antiphase(generator: np.random.Generator, period: float, noise: float, still: int) -> tuple[Array, Array]:
    """Two angles (n,) deg about a common rest, after some still samples; ``period`` in samples."""
    at = np.arange(COUNT)
    size = 25.0 * np.clip((at - still) / 10.0, 0.0, 1.0) * np.exp(-at / generator.choice([3.0 * period, 1e9]))
    phase = 2.0 * np.pi * at / period + generator.uniform(0.0, 2.0 * np.pi)
    one = size * np.sin(phase) + generator.normal(0.0, noise, COUNT)
    other = -size * np.sin(phase * generator.uniform(0.9, 1.1)) + generator.normal(0.0, noise, COUNT)
    return one, other


@pytest.mark.parametrize("held", [1, 3])
@pytest.mark.parametrize("still", [-20, 300])
def test_sides_that_cross_are_left_alone(still: int, held: int) -> None:
    """Swings in antiphase, most of the recording still or nearly so, and logs that repeat each value."""
    generator = np.random.default_rng(4)
    rows = np.arange(COUNT) // held * held
    for noise in (0.0, 0.05, 0.25):
        for period in (12.0, 31.0, 100.0):
            one, other = antiphase(generator, period, noise, still)
            found = exchanged(one[rows], other[rows])
            assert not found.swapped.any(), (noise, period)
            assert not found.doubtful, (noise, period)


def test_random_exchanges_are_restored_or_named_and_never_misplaced() -> None:
    generator = np.random.default_rng(5)
    right = 0
    for _ in range(100):
        one, other = antiphase(generator, generator.uniform(30.0, 100.0), generator.choice([0.0, 0.05, 0.25]), -20)
        one += 60.0
        first = int(generator.integers(20, 350))
        wrong = np.zeros(COUNT, dtype=bool)
        wrong[first : first + int(generator.integers(1, 20))] = True
        found = exchanged(np.where(wrong, other, one), np.where(wrong, one, other))
        right += bool((found.swapped[0] == wrong).all())
        assert not found.swapped.any() or (found.swapped[0] == wrong).all()
    assert right >= 85


def test_an_exchange_without_a_way_back_is_named_with_its_time() -> None:
    at = np.arange(COUNT)
    one, other = 60.0 + 5.0 * np.sin(at / 9.0), 20.0 + 5.0 * np.cos(at / 9.0)
    wrong = at >= 150
    found = exchanged(np.where(wrong, other, one), np.where(wrong, one, other))
    assert not found.swapped.any()
    (note,) = found.notes(["knee"], at / 200.0)
    assert note.startswith("knee: left and right may be exchanged from or to 0.750 s, which is not certain; the recor")


def test_a_tracker_that_follows_the_wrong_side_after_a_meeting_is_named() -> None:
    """Each track turns back where the sides cross, and jumps to its own side later: which part is wrong is open."""
    at = np.arange(COUNT)
    one, other = 20.0 * np.sin(at / 15.0), -20.0 * np.sin(at / 15.0)
    wrong = ((at > 47) & (at < 80)) | ((at > 141) & (at < 180))  # they cross at 47.1 and 141.4
    found = exchanged(np.where(wrong, other, one), np.where(wrong, one, other))
    assert not found.swapped.any()
    assert {80, 180} <= set(found.doubtful)


def test_columns_that_pass_half_a_turn_at_once_are_not_exchanged(tmp_path: Path) -> None:
    time, measured = angles()
    knee = measured[:, 1] - measured[:, 1].mean()
    wrapped = {side: (180.0 + sense * knee) % 360.0 for side, sense in (("left", 1.0), ("right", -1.0))}
    wrapped = {side: (each + 180.0) % 360.0 - 180.0 for side, each in wrapped.items()}
    rows = [f"{t:.4f},{h:.5f},{a:.5f},{wrapped['left'][k]:.5f},{wrapped['right'][k]:.5f}"
            for k, (t, (h, _, a)) in enumerate(zip(time, measured, strict=True))]  # fmt: skip
    header = "time [s],hip [deg],ankle [deg],left knee [deg],right knee [deg]"
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]) + "\n")
    mapping = Mapping(joints={"knee": JointColumn("left knee")})
    found = import_file(tmp_path / "a.csv", leg(), mapping, name="a.csv", cut="keep")
    assert not any("exchanged" in note for note in found.notes)
    turns = np.degrees(found.angles[:, 1]) - 180.0 - knee
    np.testing.assert_allclose(turns, 360.0 * np.round(turns[0] / 360.0), atol=1e-4)


OTHER_ANGLES = 2.0 * angles()[1][-1] - angles()[1]  # the other leg, in antiphase: the sides meet at each rest
NAMES = tuple(f"{part}_{side}" for side in "rl" for part in PARTS)


def tracked(wrong: dict[str, slice], offset: float, noise: float, seed: int) -> tuple[TrackedAngles, Array, Array]:
    """What is found if these frames of these parts are exchanged; points (n, 4, 2) m of the leg as it is, as recorded.

    ``offset`` m between the hips.
    """
    right = points(angles()[1])
    both = np.concatenate([right, points(OTHER_ANGLES) + np.array([offset, offset / 4.0])], axis=1)
    both += np.random.default_rng(seed).normal(0.0, noise, both.shape)
    recorded = both.copy()
    for part, frames in wrong.items():
        k = PARTS.index(part)
        recorded[frames, k], recorded[frames, k + 4] = both[frames, k + 4], both[frames, k]
    markers = Markers("a.csv", NAMES, recorded, np.arange(float(len(both))), RATE, "m")
    return track(markers, leg(), Mapping(points=NAMES[:4])), both[:, :4], recorded[:, :4]


def test_a_limb_is_restored_whole_or_left_whole() -> None:
    """All points are exchanged in the same frames, which begin and end anywhere; a toe on the other ankle is no leg."""
    generator, right = np.random.default_rng(6), 0
    for seed in range(60):
        first = int(generator.integers(110, 180))
        wrong = slice(first, first + int(generator.integers(3, 40)))
        found, leg_s_own, recorded = tracked(dict.fromkeys(PARTS, wrong), 0.0, generator.choice([2e-4, 1e-3]), seed)
        restored = np.abs(found.points - leg_s_own)[:, 1:].max() < 1e-9  # the hips are at one place
        right += restored
        assert restored or (found.points == recorded).all(), (seed, wrong, found.notes)
        if not restored:
            assert any("left and right may be exchanged" in note for note in found.notes)
    assert right >= 30


@pytest.mark.parametrize("parts", [("toe",), ("knee",), ("knee", "ankle"), ("ankle", "toe")])
def test_single_points_are_restored_alone_where_the_links_say_so(parts: tuple[str, ...]) -> None:
    generator, right = np.random.default_rng(7), 0
    for seed in range(10):
        first = int(generator.integers(110, 180))
        wrong = slice(first, first + int(generator.integers(3, 40)))
        found, leg_s_own, recorded = tracked(dict.fromkeys(parts, wrong), 0.08, 2e-4, seed)
        restored = np.abs(found.points - leg_s_own).max() < 1e-9
        right += restored
        assert restored or (found.points == recorded).all(), (seed, wrong, found.notes)
    assert right >= 8


def test_angles_of_a_limb_are_restored_whole_or_left_whole(tmp_path: Path) -> None:
    """In columns: the knees are equal when the exchange begins; their columns show its end only."""
    time, measured = angles()
    other = OTHER_ANGLES + np.array([30.0, 0.0, 30.0])
    apart = np.abs(measured - OTHER_ANGLES)[:, 1]
    first = 110 + int(np.argmin(apart[110:140]))
    recorded = np.concatenate([measured, other], axis=1)
    wrong = slice(first, first + 12)
    recorded[wrong] = np.concatenate([other, measured], axis=1)[wrong]
    titles = [f"{side} {joint} [deg]" for side in ("right", "left") for joint in ("hip", "knee", "ankle")]
    lines = [",".join(f"{value:.6f}" for value in row) for row in np.column_stack([time, recorded])]
    (tmp_path / "a.csv").write_text("\n".join([",".join(["time [s]", *titles]), *lines]) + "\n")
    mapping = Mapping(joints={joint: JointColumn(f"right {joint}") for joint in ("hip", "knee", "ankle")})
    found = import_file(tmp_path / "a.csv", leg(), mapping, name="a.csv", cut="keep")
    whole = [np.abs(np.degrees(found.angles) - each).max() < 1e-4 for each in (measured, recorded[:, :3])]
    assert any(whole), found.notes
    assert any("left and right" in note for note in found.notes)
