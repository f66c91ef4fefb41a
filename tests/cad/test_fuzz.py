"""``make fuzz``: seeds determine designs, outcomes have tags, and earlier failures stay fixed."""

from __future__ import annotations

import os
import time
from dataclasses import replace

import pytest

from synth.cad import MountDimensions
from synth.cad.hardware import shaft_sizes
from synth.cad.hinge import bore_radius
from tool_modules import tool


@pytest.fixture(scope="module")
def fuzz():
    return tool("fuzz_joints")


def simplified_design(fuzz, seed):
    """The design of a seed as it was before other mounts, pairs of springs and springs turned round were drawn."""
    design = fuzz.design(seed)
    return replace(design, springs=1, closes=-1, mount=MountDimensions() if design.mount else None)


def test_a_seed_determines_the_design(fuzz):
    for seed in range(3):
        assert fuzz.design(seed) == fuzz.design(seed)
    assert len({fuzz.design(seed).wall for seed in range(30)}) > 25
    assert 10 < sum(fuzz.design(seed).springs == 2 for seed in range(100)) < 40


@pytest.mark.parametrize("seed", [1045, 2098])
def test_earlier_fuzz_failures_stay_fixed(fuzz, seed):
    """1045: a damper of its own shaft on a rod of 15 mm. 2098: an arbor had a mandrel's tenth and no clearance."""
    assert fuzz.outcome(simplified_design(fuzz, seed)) == {"tag": "CHECKED", "what": "", "text": ""}


@pytest.mark.parametrize("seed", [91011, 91045])
def test_a_seat_too_long_for_its_rising_arm_is_refused(fuzz, seed):
    """The cap's end would have cut into the pad: 91011 by its load, 91045 by its own seat_length."""
    found = fuzz.outcome(fuzz.design(seed))
    assert (found["tag"], found["what"]) == ("REFUSED", "seat_length")
    assert "at most" in found["text"]


def test_a_thrust_washer_rests_on_the_ear_at_any_clearance(fuzz):
    """91097: with a clearance of 1.55 mm the washer of a 3 mm shaft fell into the ear's bore."""
    design = fuzz.design(91097)
    assert bore_radius(design) < design.hardware.washer.outer_diameter / 2
    for diameter in shaft_sizes():
        for clearance in (0.1, 0.4, 2.0):
            drawn = replace(design, shaft_diameter=diameter, clearance=clearance)
            ring = drawn.hardware.washer
            assert bore_radius(drawn) <= (ring.bore + ring.outer_diameter) / 4
            assert bore_radius(drawn) >= diameter / 2 + min(clearance, 0.5)


def test_an_unloaded_spring_goes_into_a_joint_whose_stops_keep_it_loaded(fuzz):
    """91102: its free angle is 11 deg below its range, and the pocket's wall was in the way of the upper arm."""
    assert fuzz.outcome(fuzz.design(91102)) == {"tag": "CHECKED", "what": "", "text": ""}


def test_a_damper_thinner_than_its_shaft_is_refused(fuzz):
    """92012: a body of 14.1 mm round a shaft of 15 mm was drawn without its body."""
    found = fuzz.outcome(fuzz.design(92012))
    assert (found["tag"], found["what"]) == ("REFUSED", "damper.outer_diameter")
    assert "at least 16.64 mm" in found["text"]


def test_refused_random_joints_name_their_dimension(fuzz, monkeypatch):
    monkeypatch.setattr(
        "synth.cad.checks.check_joint", lambda joint: ()
    )  # seconds each, of joints that are not refused
    found = [fuzz.outcome(fuzz.design(seed)) for seed in range(2, 62, 3)]
    refused = [outcome for outcome in found if outcome["tag"] == "REFUSED"]
    assert len(refused) >= 15
    assert all(outcome["what"] and outcome["text"] for outcome in refused)


def test_crashes_hangs_and_deaths_are_distinguished(fuzz, monkeypatch, tmp_path):
    def outcome(dimensions):
        if dimensions == 1:
            raise ZeroDivisionError("by zero")
        if dimensions == 2:
            while True:  # it works without end
                pass
        if dimensions == 4:
            time.sleep(60)
        if dimensions == 3:
            os._exit(11)
        return {"tag": "CHECKED", "what": "", "text": ""}

    monkeypatch.setattr(fuzz, "design", lambda seed: seed)
    monkeypatch.setattr(fuzz, "outcome", outcome)
    monkeypatch.setattr(fuzz, "WAITING", 3.0)
    found = fuzz.run([0, 1, 2, 3, 4], tmp_path, workers=5, limit=1.0)
    tags = {seed: item["tag"] for seed, item in found.items()}
    assert tags == {0: "CHECKED", 1: "CRASHED", 2: "TIMEOUT", 3: "DIED", 4: "TIMEOUT"}
    text = fuzz.report(found)
    assert text.splitlines()[0].startswith("5 designs: ")
    assert "seed 1: CRASHED: by zero" in text
    assert list(tmp_path.iterdir()) == []
