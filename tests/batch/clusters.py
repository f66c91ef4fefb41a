"""A Dask scheduler and workers as processes of their own, so that one can be killed as the system would kill it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

QUIET = {"DASK_DISTRIBUTED__LOGGING__DISTRIBUTED": "critical"}


@dataclass
class Processes:
    """``address`` of the scheduler; its process and the workers'."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]

    def kill_worker(self) -> None:
        """As when a machine loses its current."""
        os.kill(self.workers[0].pid, signal.SIGKILL)
        assert self.workers[0].wait(timeout=30) == -signal.SIGKILL


@contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[Processes]:
    """Real processes, ended with the block."""
    file = folder / "scheduler.json"
    environment = os.environ | QUIET
    started: list[subprocess.Popen[bytes]] = []

    def start(name: str, *words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{name}", "--scheduler-file", str(file), "--no-dashboard"]
        with (folder / f"{name}-{len(started)}.log").open("wb") as log:
            process = subprocess.Popen([*command, *words], env=environment, stdout=log, stderr=log, cwd=folder)
        started.append(process)
        return process

    try:
        scheduler = start("dask_scheduler", "--host", "127.0.0.1", "--port", "0")
        wait_until(lambda: file.exists() and file.stat().st_size > 0, 60)  # it is written after it is made
        options = ("--nthreads", "1", "--no-nanny", "--host", "127.0.0.1", "--memory-limit", "0")
        made = [start("dask_worker", *options) for _ in range(workers)]
        yield Processes(json.loads(file.read_text())["address"], scheduler, made)
    finally:
        for process in started:
            process.kill()
            process.wait(timeout=30)


def wait_until(condition: Callable[[], object], seconds: float) -> None:
    """Until it holds; fails after so many seconds."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "took too long"
        time.sleep(0.02)
