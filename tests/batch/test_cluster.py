"""Fits on a real Dask cluster: two worker processes, one of them killed; and the message if there is none."""

from __future__ import annotations

import builtins
import socket
import subprocess
import sys
from pathlib import Path

import distributed
import pytest

from batch.clusters import cluster, wait_until
from batch.legs import folder_of_legs, same_bytes
from synth.batch import cluster as ours
from synth.batch.cluster import connected
from synth.batch.task_outcome import performed
from synth.cli import main
from synth.errors import UserError
from synth.files import program_versions
from synth.files.program_versions import versions


@pytest.mark.slow  # ``make kill`` kills clusters too
def test_neither_a_killed_worker_nor_a_killed_scheduler_loses_a_fit_or_changes_a_byte(tmp_path: Path) -> None:
    """Half-way one of two workers dies, then the scheduler; without a cluster it goes on, to a local run's bytes."""
    legs = folder_of_legs(tmp_path / "legs", 9)
    kept = tmp_path / ".far.fits"

    def finished() -> dict[str, int]:
        return {path.name: path.stat().st_mtime_ns for path in kept.glob("fit-*")}

    with cluster(tmp_path) as made:
        with pytest.MonkeyPatch.context() as patch:
            more = (*program_versions.LIBRARIES, "pytest")  # the worker asks for no such thing
            patch.setattr(program_versions, "LIBRARIES", more)
            with pytest.raises(UserError, match=r"worker at .* has pytest missing"):
                connected(made.address).__enter__()
        words = ["-q", "fit", str(legs), "--out", str(tmp_path / "far")]
        running = subprocess.Popen(
            [sys.executable, "-m", "synth", *words, "--scheduler", made.address], stderr=subprocess.PIPE, text=True
        )
        wait_until(lambda: len(finished()) >= 2 or running.poll() is not None, 120)
        made.kill_worker()
        at_the_kill = len(finished())
        wait_until(lambda: len(finished()) >= at_the_kill + 2 or running.poll() is not None, 120)
        made.scheduler.kill()
        said = running.communicate(timeout=120)[1]
    assert running.returncode == 2
    assert said.startswith(f"synth: {made.address}: the scheduler is gone. Finished results are kept")
    assert said.count("\n") == 1
    before = finished()
    assert 2 <= at_the_kill < len(before) < 9
    assert main([*words, "--workers", "1"]) == 0
    assert not kept.exists()
    assert main([*words[:-1], str(tmp_path / "near"), "--workers", "1"]) == 0
    assert len(same_bytes(tmp_path / "far", tmp_path / "near")) > 3 * 9


def test_a_result_that_died_with_its_worker_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between a task's end and the reading of its result: the scheduler then calls the result lost, not the task."""
    with distributed.Client(processes=False, n_workers=1, threads_per_worker=1, dashboard_address=None) as client:
        lost: list[str] = []

        class LosesTheFirst(distributed.as_completed):  # type: ignore[misc]
            def __next__(self) -> distributed.Future:
                future = super().__next__()
                if not lost:
                    lost.append(future.key)
                    client._handle_lost_data(future.key)
                    client.loop.call_later(0.2, client._handle_key_in_memory, future.key)
                return future

        monkeypatch.setattr(distributed, "as_completed", LosesTheFirst)
        ended = dict(ours.Cluster(client, "here").run(len, [("one", "a"), ("two", "bc")]))
    assert lost
    assert {key: outcome.value for key, outcome in ended.items()} == {"one": 1, "two": 2}


def test_where_nothing_answers_one_message_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ours, "CONNECT", 0.5)
    legs = folder_of_legs(tmp_path / "legs", 1)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        closed = f"tcp://127.0.0.1:{taken.getsockname()[1]}"
        for address in (closed, "nowhere://x"):
            assert main(["-q", "fit", str(legs), "--out", str(tmp_path / "out"), "--scheduler", address]) == 2
            said = capsys.readouterr().err
            assert said.startswith(f"synth: --scheduler: no Dask scheduler at {address}: ")
            assert said.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["legs"]


def test_without_distributed_the_message_says_how_to_install_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    known = builtins.__import__

    def absent(name: str, *rest: object, **more: object) -> object:
        if name == "distributed":
            raise ModuleNotFoundError("No module named 'distributed'")
        return known(name, *rest, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(builtins, "__import__", absent)
    legs = folder_of_legs(tmp_path / "legs", 1)
    assert main(["-q", "fit", str(legs), "--out", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:1"]) == 2
    assert "pip install 'limb-synth[cluster]'" in capsys.readouterr().err


def test_a_worker_with_other_versions_runs_nothing_and_names_them() -> None:
    wanted = versions()
    assert performed(len, "abc", wanted).value == 3
    refused = performed(len, "abc", wanted | {"numpy": "0.9"})
    assert refused.value is None
    assert refused.other == f"numpy {wanted['numpy']} instead of 0.9"


def test_a_folder_only_goes_to_a_cluster(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    legs = folder_of_legs(tmp_path / "legs", 1)
    (project,) = legs.rglob("fit.yaml")
    assert main(["-q", "fit", str(project), "--out", str(tmp_path / "out"), "--scheduler", "tcp://a:1"]) == 2
    assert "is a single project; this applies to a folder of projects" in capsys.readouterr().err
    assert main(["-q", "fit", str(legs), "--out", str(tmp_path / "o"), "--scheduler", "a", "--workers", "2"]) == 2
    assert "--workers: applies to this machine" in capsys.readouterr().err
