"""Runs that are killed, hung up, doubled, or written to disks and folders that refuse them: nothing half, no litter."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import textwrap
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from synth.batch.folder import RunCheckpoint
from synth.cli import main
from synth.errors import UserError
from synth.files import leftovers, output
from synth.files.leftovers import PARTIAL, REPLACED, held_folder
from synth.files.output import output_folder, write_bytes_whole, write_csv
from synth.hopper.checkpoint import MANIFEST, Checkpoint

WAITING = """
    import sys, time
    from synth.files.output import output_folder
    with output_folder(sys.argv[1]) as folder:
        (folder / "half").write_text("x")
        print("ready", flush=True)
        time.sleep(float(sys.argv[2]))
"""


@contextmanager
def running(target: Path, seconds: float = 60.0, *before: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process that has begun to write the result, and is killed at the end."""
    words = [*before, sys.executable, "-c", textwrap.dedent(WAITING), str(target), str(seconds)]
    # Tests that were themselves started by nohup have the signal ignored, and hand that on; here it is to arrive.
    before_here = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    finally:
        signal.signal(signal.SIGHUP, before_here)
    assert process.stdout is not None
    with process.stdout:
        assert process.stdout.readline() == b"ready\n"
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def run(target: Path, text: str = "1") -> None:
    with output_folder(target) as folder:
        (folder / "fit.json").write_text(text)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no such signal here")
def test_a_hang_up_leaves_nothing_and_nohup_is_respected(tmp_path: Path) -> None:
    with running(tmp_path / "out") as process:
        process.send_signal(signal.SIGHUP)
        assert process.wait(timeout=20) == 128 + signal.SIGHUP
    assert names(tmp_path) == []
    with running(tmp_path / "out", 1.0, "nohup") as process:
        process.send_signal(signal.SIGHUP)
        assert process.wait(timeout=20) == 0
    assert names(tmp_path) == ["out"]


@pytest.mark.parametrize(("sent", "raised"), [(signal.SIGTERM, SystemExit), (signal.SIGINT, KeyboardInterrupt)])
def test_a_signal_that_a_library_turns_into_its_own_error_is_still_the_signal(
    sent: signal.Signals, raised: type[BaseException], tmp_path: Path
) -> None:
    """As a module in C does that is being loaded: ImportError, initialization failed."""

    def loading() -> None:
        try:
            os.kill(os.getpid(), sent)
        except BaseException as error:
            raise ImportError("initialization failed") from error

    outer = signal.getsignal(sent)
    # A shell that starts the tests in the background has them ignore SIGINT; here it is to arrive.
    before = signal.default_int_handler if sent == signal.SIGINT else outer
    signal.signal(sent, before)
    try:
        with pytest.raises(raised), output_folder(tmp_path / "out"):
            loading()
        assert names(tmp_path) == []
        assert signal.getsignal(sent) == before
    finally:
        signal.signal(sent, outer)


def test_leftovers_of_a_killed_run_are_removed_and_those_of_a_running_one_stay(tmp_path: Path) -> None:
    with running(tmp_path / "out") as process:
        process.kill()
        process.wait()
    assert [name.startswith(".out.partial-") for name in names(tmp_path)] == [True]
    (tmp_path / ".out.replaced-dead" / "old").mkdir(parents=True)
    (tmp_path / ".outer.partial-dead").mkdir()  # another result's
    with running(tmp_path / "other") as process:
        run(tmp_path / "out")
        left = names(tmp_path)
    assert [name for name in left if not name.startswith(".other.partial-")] == [".outer.partial-dead", "out"]
    assert len(left) == 3


def test_leftovers_of_a_killed_copy_of_an_example_are_removed(tmp_path: Path) -> None:
    (tmp_path / ".leg.partial-dead" / "project").mkdir(parents=True)
    assert main(["-q", "init", "leg", str(tmp_path / "leg")]) == 0
    assert names(tmp_path) == ["leg"]


def test_a_result_that_a_killed_run_had_moved_aside_comes_back(tmp_path: Path) -> None:
    run(tmp_path / "out", "1")
    (tmp_path / ".out.replaced-dead").mkdir()
    (tmp_path / "out").rename(tmp_path / ".out.replaced-dead" / "old")
    with pytest.raises(RuntimeError), output_folder(tmp_path / "out"):
        raise RuntimeError
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out" / "fit.json").read_text() == "1"


def test_two_runs_into_one_folder_the_second_is_refused(tmp_path: Path) -> None:
    with running(tmp_path / "out"):
        with pytest.raises(UserError, match="being written by another run"):
            run(tmp_path / "out")
        assert len(names(tmp_path)) == 1
    run(tmp_path / "out")


def test_a_folder_that_is_seen_before_it_is_locked_is_made_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, made = output.tempfile.mkdtemp, []

    def overtaken(**words: str) -> str:
        made.append(make(**words))
        if len(made) == 1:
            Path(made[0]).rmdir()  # as another run's cleaning would
        return made[-1]

    monkeypatch.setattr(output.tempfile, "mkdtemp", overtaken)
    path, handle = held_folder(tmp_path, PARTIAL.format("x"))
    assert path == Path(made[-1])
    assert path.is_dir()
    if handle is not None:
        os.close(handle)


def test_files_are_on_the_disk_before_the_rename(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flushed: list[str] = []
    monkeypatch.setattr(output, "_flush", lambda path: flushed.append(path.name))
    rename = Path.rename

    def renamed(self: Path, to: Path) -> Path:
        flushed.append("renamed")
        return rename(self, to)

    monkeypatch.setattr(Path, "rename", renamed)
    run(tmp_path / "out")
    before = flushed[: flushed.index("renamed")]
    assert {"fit.json", ".synth-output"} < set(before)
    assert any(name.startswith(".out.partial-") for name in before)
    assert flushed[-1] == tmp_path.name


def test_files_wait_for_the_disk_together_and_one_that_fails_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    both, waiting = threading.Event(), []

    def flush(path: Path) -> None:
        waiting.append(path.name)
        if len(waiting) > 1:
            both.set()
        assert both.wait(5.0)
        if path.name == "fit.json":
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(output, "_flush", flush)
    with pytest.raises(UserError, match="No space left"):
        run(tmp_path / "out")
    assert names(tmp_path) == []


def test_an_earlier_result_without_write_permission_is_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(tmp_path / "out", "1")
    (tmp_path / "out").chmod(0o555)
    access = os.access
    # root may write everywhere, so that this stands in for a plain user's answer
    monkeypatch.setattr(os, "access", lambda path, mode: access(path, mode) and bool(Path(path).stat().st_mode & 0o200))
    with pytest.raises(UserError, match=r"may not be written \(chmod u\+w\)"), output_folder(tmp_path / "out"):
        raise AssertionError("the run began")
    (tmp_path / "out").chmod(0o755)
    (tmp_path / "out" / "fit.json").chmod(0o444)
    run(tmp_path / "out", "2")
    assert names(tmp_path) == ["out"]


def test_a_full_disk_elsewhere_is_reported_with_its_own_name(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"^/cache/x: cannot be written: No space"), output_folder(tmp_path / "out"):
        raise OSError(28, "No space left on device", "/cache/x")
    with pytest.raises(UserError, match="out: cannot be written: No space"), output_folder(tmp_path / "out"):
        raise OSError(28, "No space left on device")


IDENTITY = {"project file": "a"}
CHUNK = np.arange(12.0).reshape(3, 4)


def test_a_sweep_goes_on_after_a_disk_that_was_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(UserError, match="No space left"):
            Checkpoint(tmp_path / "out", IDENTITY)
    assert names(tmp_path) == []  # nothing was kept, so nothing is left
    checkpoint = Checkpoint(tmp_path / "out", IDENTITY)
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(OSError, match="No space left"):
            checkpoint.save(0, CHUNK)
    assert names(tmp_path) == []
    checkpoint = Checkpoint(tmp_path / "out", IDENTITY)
    (checkpoint.folder / ".chunk_000000.npy.x.partial").write_bytes(b"cut by a kill")
    (checkpoint.folder / MANIFEST).write_text('{"cut')
    checkpoint = Checkpoint(tmp_path / "out", IDENTITY)
    checkpoint.save(0, CHUNK)
    assert names(checkpoint.folder) == ["chunk_000000.npy", MANIFEST]
    assert np.array_equal(Checkpoint(tmp_path / "out", IDENTITY).load(0), CHUNK)  # type: ignore[arg-type]


@pytest.mark.parametrize("damage", ["cut", "a bit turned", "emptied", "of an older version"])
def test_a_damaged_chunk_is_dropped(damage: str, tmp_path: Path) -> None:
    checkpoint = Checkpoint(tmp_path / "out", IDENTITY)
    checkpoint.save(0, CHUNK)
    (path,) = checkpoint.folder.glob("chunk_*.npy")
    data = path.read_bytes()
    changed = {"cut": data[:100], "a bit turned": data[:-40] + bytes([data[-40] ^ 1]) + data[-39:], "emptied": b"",
               "of an older version": data[:-32]}  # fmt: skip
    path.write_bytes(changed[damage])
    assert checkpoint.load(0) is None
    assert checkpoint.finished == 0
    checkpoint.save(0, CHUNK)
    assert np.array_equal(checkpoint.load(0), CHUNK)  # type: ignore[arg-type]


def test_chunks_of_another_sweep_and_a_user_s_files_are_left_alone(tmp_path: Path) -> None:
    checkpoint = Checkpoint(tmp_path / "out", IDENTITY)
    checkpoint.save(0, CHUNK)
    with pytest.raises(UserError, match="another project file"):
        Checkpoint(tmp_path / "out", {"project file": "b"})
    (checkpoint.folder / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match=r"than an interrupted sweep's \(notes.txt\)"):
        Checkpoint(tmp_path / "out", IDENTITY)
    assert len(names(checkpoint.folder)) == 3


def test_a_kept_fit_that_was_changed_is_made_again(tmp_path: Path) -> None:
    kept = RunCheckpoint(tmp_path / "out")
    kept.save("a", IDENTITY, {"fit.json": b"{}", "responses/x.csv": b"1"})
    assert kept.has("a", IDENTITY)
    (kept.files("a") / "fit.json").write_bytes(b"{")
    assert not kept.has("a", IDENTITY)
    assert not kept.place("a").exists()


def test_a_file_beside_a_result_is_whole_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_bytes_whole(tmp_path / "x", b"1")

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_bytes_whole(tmp_path / "x", b"2")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"x": b"1"}


def test_no_cell_of_any_table_is_a_formula(tmp_path: Path) -> None:
    wicked = ["=1+1", "+1", "-x", "@x", "\t=1", "|x", "plain"]
    write_csv(tmp_path / "x.csv", {"=title": wicked, "number": np.linspace(-1.0, 1.0, 7)})
    lines = (tmp_path / "x.csv").read_text().splitlines()
    assert [line.partition(",")[0] for line in lines] == ["'=title", *(f"'{cell}" for cell in wicked[:-1]), "plain"]
    assert lines[1].endswith(",-1")


STREAMS = {
    "full": (">/dev/full", 74),
    "closed": (">&-", 0),
    "errors full": ("2>/dev/full", 0),
    "all closed": (">&- 2>&- <&-", 0),
}


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no such device here")
@pytest.mark.parametrize("name", STREAMS)
def test_standard_output_may_be_full_or_closed(name: str, tmp_path: Path) -> None:
    redirect, status = STREAMS[name]
    target = tmp_path / "spring.json"
    words = f"-m synth spring --rate '3 N*m/rad' --travel '30 deg' --json '{target}'"
    done = subprocess.run(["sh", "-c", f"'{sys.executable}' {words} {redirect}"], capture_output=True, text=True)
    assert done.returncode == status
    assert "Traceback" not in done.stderr
    assert json.loads(target.read_text())["format"].startswith("synth/spring/")
    if name == "full":
        said = "synth: standard output: cannot be written: No space left on device; the command itself is complete\n"
        assert done.stderr.endswith(said)


def test_leftovers_are_distinguished_by_the_result_s_whole_name() -> None:
    assert not PARTIAL.format("a.b").startswith(PARTIAL.format("a"))
    assert PARTIAL.format("a") != REPLACED.format("a")


@pytest.mark.parametrize("half", ["/old", "/out"])
@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_during_the_exchange_leaves_a_whole_result(
    sent: signal.Signals, half: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It arrives after the rename that moves the earlier result aside, or after the one that brings the new one."""
    run(tmp_path / "out", "1")
    rename = Path.rename

    def renamed(self: Path, to: Path) -> Path:
        there = rename(self, to)
        if str(to).endswith(half):
            os.kill(os.getpid(), sent)
            os.kill(os.getpid(), sent)
        return there

    monkeypatch.setattr(Path, "rename", renamed)
    outer = signal.signal(sent, signal.default_int_handler if sent == signal.SIGINT else signal.SIG_DFL)
    try:
        with pytest.raises((SystemExit, KeyboardInterrupt)):
            run(tmp_path / "out", "2")
    finally:
        signal.signal(sent, outer)
    assert names(tmp_path) == ["out"]
    assert (tmp_path / "out" / "fit.json").read_text() == "2"


def test_an_earlier_result_that_cannot_be_moved_back_at_once_is_not_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(tmp_path / "out", "1")
    rename = Path.rename

    def refused(self: Path, to: Path) -> Path:
        if to == tmp_path / "out":
            raise OSError(5, "Input/output error")
        return rename(self, to)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "rename", refused)
        with pytest.raises(UserError, match="Input/output error"):
            run(tmp_path / "out", "2")
    with pytest.raises(RuntimeError), output_folder(tmp_path / "out"):
        raise RuntimeError
    assert (tmp_path / "out" / "fit.json").read_text() == "1"


def without_system_locks(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(leftovers, "fcntl", None)


def without_file_system_locks(patch: pytest.MonkeyPatch) -> None:
    def flock(handle: int, how: int) -> None:
        raise OSError(errno.ENOTSUP, "Operation not supported")

    patch.setattr(leftovers.fcntl, "flock", flock)


@pytest.mark.parametrize("without", [without_system_locks, without_file_system_locks])
def test_without_locks_a_killed_run_does_not_block_its_result(
    without: Callable[[pytest.MonkeyPatch], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / ".out.partial-dead").mkdir()
    without(monkeypatch)
    run(tmp_path / "out", "1")
    run(tmp_path / "out", "2")
    assert names(tmp_path) == [".out.partial-dead", "out"]  # nobody knows whether its run lives
