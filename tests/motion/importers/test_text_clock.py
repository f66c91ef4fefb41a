"""Clocks that a table writes as text, each against the seconds that ``datetime`` makes of them."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from motion.importers.simulated_leg import angles, leg
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.motion.importers.text_clock import text_clock

TIME, MEASURED = angles()
NOON, MIDNIGHT = datetime(2024, 3, 5, 11, 59, 59, 500000), datetime(2024, 12, 31, 23, 59, 59, 500000)
Form = Callable[[datetime], str]


def table(path: Path, begin: datetime, form: Form, title: str = "time", separator: str = ";") -> Path:
    lines = [separator.join([title, "hip [deg]", "knee [deg]", "ankle [deg]"])]
    for seconds, row in zip(TIME, MEASURED, strict=True):
        at = form(begin + timedelta(microseconds=round(1e6 * seconds)))
        lines.append(separator.join([at, *(f"{value:.9f}" for value in row)]))
    path.write_text("\n".join(lines) + "\n")
    return path


def imported(path: Path) -> ImportedRecording:
    return import_file(path, leg(), Mapping(), name=path.name, cut="keep")


def us_american(at: datetime) -> str:
    return at.strftime("%m/%d/%Y %I:%M:%S.%f %p")


FORMS: dict[str, Form] = {
    "iso": lambda at: at.isoformat(),  # without a fraction where it is 0
    "utc": lambda at: at.isoformat(timespec="milliseconds") + "Z",
    "day": lambda at: at.strftime("%H:%M:%S.%f")[:-3],
    "us": us_american,
    "german": lambda at: at.strftime("%d.%m.%Y %H:%M:%S,%f")[:-3],
    "minutes": lambda at: at.strftime("%M:%S.%f")[:-3],
}


@pytest.mark.parametrize("begin", [NOON, MIDNIGHT])
@pytest.mark.parametrize("form", FORMS)
def test_a_text_clock_is_read_in_seconds_also_past_midnight(tmp_path: Path, form: str, begin: datetime) -> None:
    found = imported(table(tmp_path / "a.csv", begin, FORMS[form]))
    np.testing.assert_allclose(found.time - found.time[0], TIME, atol=1e-9)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-6)
    wraps = {"iso": "", "utc": "", "minutes": "past the hour"}.get(form, "past midnight" if begin == MIDNIGHT else "")
    assert ("continued" in " ".join(found.notes)) == bool(wraps)
    assert wraps in " ".join(found.notes)


def test_a_header_that_says_s_and_a_comma_table(tmp_path: Path) -> None:
    found = imported(table(tmp_path / "a.csv", NOON, FORMS["day"], "Time [s]", ","))
    np.testing.assert_allclose(found.time - found.time[0], TIME, atol=1e-9)


@pytest.mark.parametrize("cells", [["11:59", "12:00"], ["1.5", "2.5"], ["2024-02-30 10:00:00"], ["12:00:00.1", "x"],
                                   ["25:00:00.0"], ["13:00:00.0 PM"], ["", ""]])  # fmt: skip
def test_other_texts_are_no_clock(cells: list[str]) -> None:
    assert text_clock(cells) is None


def test_a_missing_time_stays_missing_and_digits_stay() -> None:
    assert text_clock(["11:59:59.1234567890", "", "00:00:00,1"]) == (
        ["43199.1234567890", "", "0.1"], "times of day"
    )  # fmt: skip


def test_a_clock_that_runs_backwards_is_no_midnight(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", NOON, FORMS["day"])
    path.write_text(path.read_text().replace("12:00:00.500", "10:00:00.500"))
    with pytest.raises(UserError, match="runs backwards"):
        imported(path)


def test_a_text_that_is_no_clock_is_told_how_to_write_one(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r'"time \[s\]" is no clock|"time" is no clock: write numbers with a unit'):
        imported(table(tmp_path / "a.csv", NOON, lambda at: at.strftime("%A %H:%M"), "time [s]"))


@pytest.mark.parametrize("first", ["sep=;", '"sep=;"', "SEP=;", "sep=;;;;"])
def test_the_separator_that_a_spreadsheet_is_told(tmp_path: Path, first: str) -> None:
    path = table(tmp_path / "a.csv", NOON, lambda at: f"{(at - NOON).total_seconds():.3f}", "time [s]")
    path.write_text(f"{first}\n{path.read_text().replace('.', ',')}")
    found = imported(path)
    np.testing.assert_allclose(found.time, TIME, atol=1e-9)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-6)


def test_another_separator_is_refused(tmp_path: Path) -> None:
    path = table(tmp_path / "a.csv", NOON, FORMS["day"])
    path.write_text(f"sep=|\n{path.read_text()}")
    with pytest.raises(UserError, match=r'states the separator "\|"'):
        imported(path)
