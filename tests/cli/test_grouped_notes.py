"""Notes on many recordings are told together where they differ in numbers and joints only."""

from __future__ import annotations

from synth.commands.grouped_notes import MANY, grouped_notes

JOINTS = ("hip", "knee", "ankle")


def test_notes_of_one_form_are_one_line_with_ranges() -> None:
    """Thirty-four recordings gave eighty lines."""
    notes = [(f"{k}.csv", f"until {2.7 + 0.01 * k:.2f} s a torque acts on the {JOINTS[k % 3]} (-5 to 7%)")
             for k in range(MANY)]  # fmt: skip
    notes += [("1.csv", "knee: 1 sample is an outlier"), ("9.csv", "nothing was cut")]
    assert grouped_notes(notes, JOINTS) == [
        f"{MANY} of {MANY + 1} recordings: until 2.70 to 2.73 s a torque acts on the hip, knee or ankle (-5 to 7%)",
        "1.csv: knee: 1 sample is an outlier",
        "9.csv: nothing was cut",
    ]


def test_few_notes_stand_by_their_recording() -> None:
    notes = [(f"{k}.csv", f"cut at {k} s") for k in range(MANY - 1)]
    assert grouped_notes(notes, JOINTS) == [f"{k}.csv: cut at {k} s" for k in range(MANY - 1)]
    twice = [("a.csv", f"{name}: 1 sample is an outlier") for name in JOINTS]
    assert len(grouped_notes(twice * MANY, JOINTS)) == len(twice) * MANY
    assert grouped_notes([], JOINTS) == []


def test_a_joint_whose_name_is_part_of_another() -> None:
    notes = [(f"{k}.csv", f"{'hip' if k % 2 else 'hip left'}: outside") for k in range(MANY)]
    assert grouped_notes(notes, ("hip", "hip left")) == [f"{MANY} of {MANY} recordings: hip or hip left: outside"]


def test_no_joint_of_a_recording_is_lost() -> None:
    """Two lost samples of the hip were told, 300 of the ankle in the same four recordings were not."""
    lost = {"hip": "2", "ankle": "300"}
    notes = [(f"{k}.csv", f"{name}: {lost[name]} of 47{k} samples are missing") for k in range(MANY) for name in lost]
    assert grouped_notes(notes, JOINTS) == [
        f"{MANY} of {MANY} recordings: {name}: {lost[name]} of 470 to 47{MANY - 1} samples are missing" for name in lost
    ]
    alone = [*notes, ("0.csv", "ankle: 7 of 470 samples are missing")]
    assert [line for line in grouped_notes(alone, JOINTS) if "7 of 470" in line] == [
        "0.csv: ankle: 7 of 470 samples are missing"
    ]
    assert len(grouped_notes(alone, JOINTS)) == 1 + MANY + 1
