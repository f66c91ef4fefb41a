"""JSON records with cells that are no numbers: the message names the column, the record and the cell."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from motion.importers.simulated_leg import angles, leg
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

TIME, MEASURED = angles()
COLUMNS = {joint: JointColumn(f"j.{joint}", "deg") for joint in ("hip", "knee", "ankle")}


def imported(path: Path, odd: dict[str, Any], columns: dict[str, JointColumn] | None = None) -> ImportedRecording:
    """Of a record per line; the ninth has the ``odd`` cells."""
    records = [{"t": t, "j": {"hip": h, "knee": k, "ankle": a}, "q": [h, k, a]}
               for t, (h, k, a) in zip(TIME.tolist(), MEASURED.tolist(), strict=True)]  # fmt: skip
    records[8]["j"] |= odd
    path.write_text("\n".join(json.dumps(each) for each in records) + "\n")
    mapping = Mapping(time="t", time_unit="s", joints=COLUMNS if columns is None else columns)
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        ("139.2", r'the text "139\.2"; write the number without quotes'),
        ("lost", 'the text "lost"; leave the field out, or write null, where a sample is missing'),
        ("nan", 'the text "nan"; leave the field out, or write null, where a sample is missing'),
        ([1.0], "a list; write each of its numbers as a field of its own"),
    ],
)
def test_a_cell_that_is_no_number_is_named(tmp_path: Path, cell: Any, words: str) -> None:
    said = rf'a.jsonl: ankle: the column "j\.ankle" is not all numbers: in record 9 of 300 it is {words}$'
    with pytest.raises(UserError, match=said):
        imported(tmp_path / "a.jsonl", {"ankle": cell})


def test_a_list_in_each_record_is_named(tmp_path: Path) -> None:
    columns = {joint: JointColumn(f"q.{k}", "deg") for k, joint in enumerate(("hip", "knee", "ankle"))}
    said = 'there is no column "q.1"; the file has t, j.hip, j.knee, j.ankle; left out because they are not numbers: q'
    with pytest.raises(UserError, match=said.replace(".", r"\.")):
        imported(tmp_path / "a.jsonl", {}, columns)
    columns["knee"] = JointColumn("q", "deg")
    with pytest.raises(UserError, match=r'knee: the column "q" is not all numbers: in record 1 of 300 it is a list'):
        imported(tmp_path / "a.jsonl", {}, columns)


def test_other_columns_that_are_no_numbers_are_left_out_with_a_note(tmp_path: Path) -> None:
    found = imported(tmp_path / "a.jsonl", {"ankle": None, "mode": "swing"})
    assert "left out because they are not numbers: q, j.mode" in found.notes
