"""Results: written whole or not at all, the same bytes again, nothing of the user's lost."""

from __future__ import annotations

import hashlib
import json
import math
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth.errors import UserError
from synth.files import text_forms
from synth.files.output import output_folder, umask, write_csv, write_json, write_text
from synth.files.result_values import read_design, read_fit, read_result
from synth.files.run_manifest import MANIFEST, sha256_file


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def run(target: Path, text: str = "{}", name: str = "fit.json") -> None:
    with output_folder(target) as folder:
        assert folder.parent == target.parent
        (folder / name).write_text(text)
        (folder / "parts").mkdir(exist_ok=True)
        (folder / "parts" / "a.step").write_text("x")


def broken_run(target: Path, error: type[BaseException]) -> None:
    with output_folder(target) as folder:
        (folder / "half").write_text("x")
        raise error


def overtaken_run(target: Path) -> None:
    with output_folder(target) as folder:
        (folder / "fit.json").write_text("{}")
        target.mkdir()
        (target / "mine.txt").write_text("mine")


def test_appears_whole_and_is_replaced_whole(tmp_path: Path) -> None:
    target = tmp_path / "out"
    run(target, "1", "old.json")
    assert names(tmp_path) == ["out"]
    assert (target / "old.json").read_text() == "1"
    run(target, "2")
    assert names(tmp_path) == ["out"]
    assert [name for name in names(target) if not name.startswith(".")] == ["fit.json", "parts"]
    assert target.stat().st_mode & 0o777 == 0o777 & ~_umask()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_missing_parents_are_made_and_an_empty_folder_is_taken(tmp_path: Path) -> None:
    run(tmp_path / "a" / "b" / "out")
    (tmp_path / "empty").mkdir()
    run(tmp_path / "empty")
    assert (tmp_path / "empty" / "fit.json").exists()


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_of_a_run_that_fails(tmp_path: Path, error: type[BaseException]) -> None:
    run(tmp_path / "out", "1")
    for target in (tmp_path / "out", tmp_path / "new" / "deep"):
        with pytest.raises(error):
            broken_run(target, error)
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out" / "fit.json").read_text() == "1"


def test_the_old_run_comes_back_if_the_rename_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out"
    run(target, "1")
    rename = Path.rename

    def failing(self: Path, to: Path) -> Path:
        if ".partial-" in self.name:
            raise PermissionError(13, "denied")
        return rename(self, to)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(UserError, match="denied"), output_folder(target) as folder:
        (folder / "fit.json").write_text("2")
    monkeypatch.undo()
    assert names(tmp_path) == ["out"]
    assert (target / "fit.json").read_text() == "1"


def test_a_folder_with_other_files_is_refused(tmp_path: Path) -> None:
    target = tmp_path / "out"
    run(target)
    (target / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match=r"notes\.txt"):
        run(target)
    assert (target / "notes.txt").read_text() == "mine"
    (target / "notes.txt").unlink()
    (target / ".DS_Store").write_text("")
    run(target)  # what an operating system leaves is not the user's


@pytest.mark.parametrize("content", ["fit.json", "a/b.txt"])
def test_a_folder_that_no_run_wrote_is_refused(tmp_path: Path, content: str) -> None:
    target = tmp_path / "out"
    (target / content).parent.mkdir(parents=True)
    (target / content).write_text('{"format": "synth/fit/1"}')
    with pytest.raises(UserError, match="no earlier run wrote"):
        run(target)
    assert (target / content).exists()


def test_a_file_that_comes_during_the_run_is_not_lost(tmp_path: Path) -> None:
    target = tmp_path / "out"
    with pytest.raises(UserError, match=r"mine\.txt"):
        overtaken_run(target)
    assert names(tmp_path) == ["out"]
    assert names(target) == ["mine.txt"]


def test_refused_targets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("x")
    inside = tmp_path / "here"
    inside.mkdir()
    monkeypatch.chdir(inside)
    refused = {
        tmp_path / "file": "is a file",
        Path(): "current folder",
        tmp_path: "current folder",
        Path("/proc/synth/out"): "cannot be written",
        tmp_path / "file" / "x": r"file/x: cannot be written: .*file is a file",
        tmp_path / ("x" * 300): "cannot be written: File name too long",
    }
    for target, words in refused.items():
        with pytest.raises(UserError, match=words):
            run(target)
    (tmp_path / "disk").mkdir()
    with monkeypatch.context() as patched:
        patched.setattr(os.path, "ismount", lambda path: Path(path).name == "disk")
        with pytest.raises(UserError, match="a disk is mounted; name a folder in it"):
            run(tmp_path / "disk")
    run(inside / "out")
    with pytest.raises(UserError, match="holds an earlier run"), output_folder(inside / "out", overwrite=False):
        pass


def test_a_changed_file_of_an_earlier_run_is_not_replaced(tmp_path: Path) -> None:
    target = tmp_path / "out"
    run(target)
    run(target, "2")  # nobody changed the first
    (target / "fit.json").write_text("mine")
    with pytest.raises(UserError, match=r"out: holds files that were changed .* \(fit.json\); name a new folder"):
        run(target, "3")
    assert (target / "fit.json").read_text() == "mine"
    (target / MANIFEST).write_text("fit.json\nparts/a.step\n")  # of an earlier version: names alone
    run(target, "3")
    assert (target / "fit.json").read_text() == "3"


def test_a_folder_that_the_run_reads_is_not_replaced(tmp_path: Path) -> None:
    """`synth fit found/fit.yaml --out found` deleted the trials and the leg that `synth import` had written there."""
    target = tmp_path / "found"
    run(target)
    read = [tmp_path / "other.yaml", tmp_path / "sub" / ".." / "found" / "parts" / "a.step"]
    (tmp_path / "sub").mkdir()
    said = r"found: holds what this run reads \(parts/a.step\)"
    with pytest.raises(UserError, match=said), output_folder(target, inputs=read):
        pass
    assert names(target) == [MANIFEST, "fit.json", "parts"]
    with output_folder(target, inputs=read[:1]) as folder:
        (folder / "new").write_text("x")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_parent_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(UserError, match="cannot be written"):
        run(tmp_path / "out")


def test_a_full_disk_is_reported_and_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="No space left"), output_folder(tmp_path / "out"):
        raise OSError(28, "No space left on device")
    assert names(tmp_path) == []


def test_a_terminated_run_leaves_nothing(tmp_path: Path) -> None:
    code = f"""
        import time
        from synth.files.output import output_folder
        with output_folder({str(tmp_path / "out")!r}) as folder:
            (folder / "half").write_text("x")
            print("ready", flush=True)
            time.sleep(60)
    """
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE)
    assert process.stdout is not None
    with process.stdout:
        assert process.stdout.readline() == b"ready\n"
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=20) == 128 + signal.SIGTERM
    assert names(tmp_path) == []


def test_json_is_rounded_plain_and_stable(tmp_path: Path) -> None:
    value = {
        "format": "synth/fit/1",
        "a": {"value": np.float64(1 / 3), "unit": "N*m/rad", "interval90": (0.1 + 0.2, None)},
        "b": [np.int64(3), True, np.bool_(False), "é", -0.0],
        "c": np.array([[1.0, 2.0], [3.0, 1e-320]]),
        "d": {},
        "e": [],
    }
    path = tmp_path / "x.json"
    write_json(path, value)
    text = path.read_text(encoding="utf-8")
    assert text.endswith("}\n")
    assert '"a": {"value": 0.3333333333, "unit": "N*m/rad", "interval90": [0.3, null]}' in text
    back = json.loads(text)
    assert list(back) == list(value)
    assert back["b"] == [3, True, False, "é", 0.0]
    assert "-0.0" not in text
    assert back["c"][0] == [1.0, 2.0]
    write_json(tmp_path / "y.json", json.loads(text))
    assert (tmp_path / "y.json").read_text(encoding="utf-8") == text


json_values = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**9), 10**9) | st.floats(-1e300, 1e300) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


@given(json_values)
def test_any_json_reads_back_to_ten_digits(value: object) -> None:
    text = text_forms.json_text(text_forms.plain(value, ""), 0)
    assert json.loads(text) == _rounded(value)


def _rounded(value: object) -> object:
    if isinstance(value, float):
        return pytest.approx(value, rel=1e-9, abs=1e-300)
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return {k: _rounded(v) for k, v in value.items()} if isinstance(value, dict) else value


@pytest.mark.parametrize("bad", [math.nan, math.inf, np.float64("-inf"), np.array([1.0, np.nan])])
def test_json_refuses_what_is_not_finite(tmp_path: Path, bad: object) -> None:
    with pytest.raises(ValueError, match=r"joints\.knee"):
        write_json(tmp_path / "x.json", {"joints": {"knee": [bad]}})


def test_json_refuses_what_has_no_form(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="set"):
        write_json(tmp_path / "x.json", {"a": {1}})
    with pytest.raises(TypeError, match="no text"):
        write_json(tmp_path / "x.json", {1: 2})


def test_csv(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    write_csv(path, {"time [s]": np.array([0.1 + 0.2, np.nan]), "part": ['6597K21, "x"', None], "n": [1, 2]})
    assert path.read_bytes() == b'time [s],part,n\n0.3,"6597K21, ""x""",1\n,,2\n'
    with pytest.raises(ValueError, match="argument 2"):
        write_csv(path, {"a": [1], "b": [1, 2]})
    with pytest.raises(ValueError, match="inf"):
        write_csv(path, {"a": [math.inf]})


def test_sha256(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"abc")
    assert sha256_file(tmp_path / "x") == hashlib.sha256(b"abc").hexdigest()


def test_results_read_back(tmp_path: Path) -> None:
    path = tmp_path / "fit.json"
    write_json(path, {"format": "synth/fit/1", "joints": {}, "rms": {}, "trials": []})
    assert read_fit(path)["trials"] == []
    with pytest.raises(UserError, match="of kind fit where leg-design is needed"):
        read_design(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not valid JSON"),
        ("[]", "format is missing"),
        ("{}", "its format is None"),
        ('{"format": "synth/fit/2"}', "update it"),
        ('{"format": "other/1"}', "not a result"),
        ('{"format": "synth/fit/1"}', "joints: is missing"),
        ('{"format": "synth/fit/1", "x": NaN}', "not a JSON number"),
        ("[" * 100_000, "not a result"),
        ("\ufffe", "not valid JSON"),
        ('{"format": "synth/fit/1", "x": ' + "9" * 10_000 + "}", "too long"),
    ],
)
def test_bad_results(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "fit.json").write_text(text)
    with pytest.raises(UserError) as caught:
        read_fit(tmp_path / "fit.json")
    assert words in str(caught.value)


def test_a_large_result_is_refused_by_size(tmp_path: Path) -> None:
    path = tmp_path / "fit.json"
    with path.open("wb") as stream:
        stream.truncate(300_000_000)
    start = time.process_time()
    with pytest.raises(UserError, match="300 MB"):
        read_result(path, "fit")
    assert time.process_time() - start < 1.0


def test_a_link_that_leads_to_itself_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(UserError, match="leads to itself"), output_folder(tmp_path / "loop"):
        raise AssertionError("the work must not begin")
    assert names(tmp_path) == ["loop"]


def test_two_threads_write_two_results_at_once(tmp_path: Path) -> None:
    """Each within the other's block, and none into the other's folder."""
    both = threading.Barrier(2, timeout=10.0)

    def save(name: str) -> None:
        with output_folder(tmp_path / name) as folder:
            both.wait()
            write_text(folder / "text.txt", name)
            with pytest.raises(UserError, match="leads out of the folder"):
                write_text(tmp_path / f"beside {name}", name)
            both.wait()

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(save, ("first", "second")))
    assert [(tmp_path / name / "text.txt").read_text() for name in names(tmp_path)] == ["first", "second"]


def test_threads_that_ask_for_the_usual_permissions_leave_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """The system gives the mask only to who sets it: another thread must not ask meanwhile."""
    really = os.umask
    usual = really(0o027)

    def slow(mask: int) -> int:
        found = really(mask)
        if mask == 0:
            time.sleep(0.02)
        return found

    monkeypatch.setattr(os, "umask", slow)
    try:
        with ThreadPoolExecutor(2) as pool:
            assert list(pool.map(lambda _: umask(), range(8))) == [0o027] * 8
        assert really(usual) == 0o027
    finally:
        really(usual)


def test_times_are_written_to_a_nanosecond_whatever_the_clock(tmp_path: Path) -> None:
    for begin in (0.0, 12.0, 4321.0, 12345678.0, 1.7e9):
        time = begin + np.arange(5) / 240.0
        write_csv(tmp_path / "x.csv", {"time [s]": time, "knee [deg]": time})
        found = np.loadtxt(tmp_path / "x.csv", delimiter=",", skiprows=1)[:, 0]
        np.testing.assert_allclose(found, time, atol=5.1e-10, rtol=0.0)
    write_csv(tmp_path / "x.csv", {"time [s]": np.array([1.7e9, np.nan, 1.7e9 + 0.5])})
    assert (tmp_path / "x.csv").read_text().split() == ["time", "[s]", "1700000000", '""', "1700000000.5"]
