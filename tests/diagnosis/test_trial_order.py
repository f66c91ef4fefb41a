"""The same trials listed in another order get the same answer, to the last digit."""

from __future__ import annotations

from dataclasses import replace

from diagnosis.simulated_releases import ONE, off, recorded, with_effects
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.trial_order import as_listed, in_canonical_order
from synth.files.tolerance import Tolerance

TRIALS = recorded(with_effects(off(ONE, 1), {"knee": {"coulomb_friction": {"torque": 0.05}}}), held_out=2)


def test_the_order_of_the_list_changes_no_number() -> None:
    backwards = TRIALS[::-1]
    one, other = (diagnose(ONE, trials, Tolerance()) for trials in (TRIALS, backwards))
    assert one.scored_on == ("2.csv", "3.csv")
    assert other.scored_on == ("3.csv", "2.csv")
    assert [trial.name for trial in other.trials] == ["3.csv", "2.csv"]
    assert other.as_json() | {"gap": {}} == one.as_json() | {"gap": {}}
    assert (other.before, other.after, other.shrink) == (one.before, one.after, one.shrink)


def test_trials_are_taken_by_name_and_numbers_by_size() -> None:
    names = ["b/t10.csv", "b/t9.csv", "a/t10.csv", "b/t9", "b/t09.csv"]
    made = [replace(TRIALS[0], name=name) for name in names]
    expected = ["a/t10.csv", "b/t9", "b/t09.csv", "b/t9.csv", "b/t10.csv"]
    assert [trial.name for trial in in_canonical_order(made)] == expected
    assert as_listed(expected[1:], [1, 2, 3, 4], made) == (4, 3, 1, 2)


def test_trials_of_one_name_are_taken_by_their_content() -> None:
    made = [replace(TRIALS[0], sha256=text) for text in ("c", "a", "b")]
    assert [trial.sha256 for trial in in_canonical_order(made)] == ["a", "b", "c"]
