"""Left and right: tracks that cross are left alone, exchanged ones restored, doubtful ones named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motion.importers.simulated_leg import angles, leg
from synth.arrays import Array
from synth.files.import_project import JointColumn, Mapping
from synth.motion.importers.convert import import_file
from synth.motion.importers.swaps import exchanged_frames, swap_notes

COUNT = 400


def column(values: Array) -> Array:
    return np.asarray(values)[:, None]


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
            found = exchanged_frames(column(one[rows]), column(other[rows]))
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
        found = exchanged_frames(column(np.where(wrong, other, one)), column(np.where(wrong, one, other)))
        right += bool((found.swapped == wrong).all())
        assert not found.swapped.any() or (found.swapped == wrong).all()
    assert right >= 85


def test_an_exchange_without_a_way_back_is_named_with_its_time() -> None:
    at = np.arange(COUNT)
    one, other = 60.0 + 5.0 * np.sin(at / 9.0), 20.0 + 5.0 * np.cos(at / 9.0)
    wrong = at >= 150
    found = exchanged_frames(column(np.where(wrong, other, one)), column(np.where(wrong, one, other)))
    assert not found.swapped.any()
    (note,) = swap_notes("knee", found, at / 200.0)
    assert note.startswith("knee: left and right may be exchanged from or to 0.750 s, which is not certain; the recor")


def test_a_tracker_that_follows_the_wrong_side_after_a_meeting_is_named() -> None:
    """Each track turns back where the sides cross, and jumps to its own side later: which part is wrong is open."""
    at = np.arange(COUNT)
    one, other = 20.0 * np.sin(at / 15.0), -20.0 * np.sin(at / 15.0)
    wrong = ((at > 47) & (at < 80)) | ((at > 141) & (at < 180))  # they cross at 47.1 and 141.4
    found = exchanged_frames(column(np.where(wrong, other, one)), column(np.where(wrong, one, other)))
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
