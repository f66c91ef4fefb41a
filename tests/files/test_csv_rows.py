"""The reader of users' tables: cells with their lines; ambiguous ones are refused with their line."""

from __future__ import annotations

import csv
import io
import os
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth.cli import main
from synth.errors import UserError
from synth.files.csv_rows import csv_rows

ROOT = Path(__file__).resolve().parents[2]
CELL = st.text(st.characters(codec="utf-8", exclude_characters="\0\r"), max_size=8)


@given(st.lists(st.lists(CELL, min_size=2, max_size=5), min_size=1, max_size=6), st.sampled_from(",;\t"))
def test_what_csv_writes_is_read_again_with_the_lines_that_rows_begin_in(rows: list[list[str]], separator: str) -> None:
    stream = io.StringIO(newline="")
    begins = []
    for row in rows:
        begins.append(stream.getvalue().count("\n") + 1)
        csv.writer(stream, delimiter=separator, lineterminator="\n").writerow(row)
    found = list(csv_rows(stream.getvalue().encode(), "x.csv", separator=separator))
    assert [cells for _, cells in found] == rows
    assert [line for line, _ in found] == begins


@pytest.mark.parametrize(("data", "said"), [
    (b"a,b\n1,\xff\n", "x.csv:2: is not UTF-8 text"),
    ("a,b\n".encode("utf-16"), "x.csv: is UTF-16 text"),
    (b"PK\x03\x04rest", "is a spreadsheet or an archive"),
    (b"a,b\n\0,1\n", "x.csv:2: is not text: it holds a zero byte"),
    (b'a,b\n"' + b"x" * 200_000 + b'",1\n', "x.csv:2: cannot be read as CSV: field larger than field limit"),
])  # fmt: skip
def test_a_file_that_is_not_a_table_is_refused_with_its_line(data: bytes, said: str) -> None:
    with pytest.raises(UserError, match=re.escape(said)):
        list(csv_rows(data, "x.csv"))


def test_an_unclosed_quote_is_refused_in_strict_mode() -> None:
    with pytest.raises(UserError, match=r"x\.csv:2: cannot be read as CSV: unexpected end of data"):
        list(csv_rows('a,b\n"A1,1\n', "x.csv", strict=True))


def test_cells_are_split_in_one_place() -> None:
    """CAD's tables ship with it and pages read our own results: neither may import from synth, each has one reader."""
    splits = re.compile(r"csv\.(reader|DictReader)\(")
    found = [
        str(path.relative_to(ROOT))
        for tree in ("synth", "cad", "reports")
        for path in sorted((ROOT / tree).rglob("*.py"))
        if splits.search(path.read_text(encoding="utf-8"))
    ]
    assert found == ["synth/files/csv_rows.py", "cad/hardware.py", "reports/reading.py"]


def test_a_pipe_is_no_vendors_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    command = ["catalog", "import", str(tmp_path / "pipe.csv"), "--vendor", "X", "--out", str(tmp_path / "out")]
    assert main(command) == 2
    assert "is not a regular file" in capsys.readouterr().err


def test_a_quoted_cell_over_two_lines_is_one_cell_of_a_loggers_table(tmp_path: Path) -> None:
    from synth.files.import_mapping import Mapping
    from synth.motion.importers.plain_csv import read_plain_csv

    file = tmp_path / "a.csv"
    file.write_text('# made by a logger\n\ntime (s),"hip angle (deg)"\n0,1\n1,"2\n"\n2,x\n')
    with pytest.raises(UserError, match=r'a\.csv:7: .*"x" is not a number'):
        read_plain_csv(file, Mapping(), "a.csv")
