"""Runs killed at random moments: earlier results stay complete, no process survives, the next run gives the same bytes.

Each round starts a command, sends its process a signal at a moment drawn between start and end of a run that was not
disturbed, looks at what is left, and gives the command again to its end.
"""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from batch.clusters import cluster
from batch.legs import folder_of_legs
from synth.files.run_manifest import MANIFEST, write_manifest

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "synth" / "examples"
SIGNALS = tuple(getattr(signal, name, signal.SIGTERM) for name in ("SIGKILL", "SIGKILL", "SIGTERM", "SIGHUP"))
CASES = ("gap", "leg", "folder", "sweep", "cluster")
PATIENCE = 30.0  # s, for the processes of a killed run to end


@dataclass
class Case:
    """A command that writes ``folder/out``; ``words`` are its arguments, given in ``folder``."""

    name: str
    folder: Path
    words: Sequence[str]
    environment: dict[str, str] = field(default_factory=dict)
    whole: dict[str, str] = field(default_factory=dict)  # each file of a result with its hash
    seconds: float = 0.0

    @property
    def out(self) -> Path:
        """The result."""
        return self.folder / "out"

    def start(self) -> subprocess.Popen[bytes]:
        """The command in a session of its own, so that its processes can be told."""
        return subprocess.Popen(
            [sys.executable, "-m", "synth", "-q", *self.words, "--out", "out"],
            cwd=self.folder, env=os.environ | self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE, start_new_session=True,
        )  # fmt: skip

    def finish(self) -> str:
        """Give the command to its end; what it wrote on standard error if it failed."""
        process = self.start()
        said = process.communicate()[1].decode(errors="replace")
        return "" if process.returncode == 0 else f"exit {process.returncode}: {said[-400:]}"

    def forget(self) -> None:
        """Away with kept stages, so that the next run does its work; compiled code stays."""
        shutil.rmtree(Path(self.environment["SYNTH_CACHE"]) / "stages", ignore_errors=True)


@dataclass(frozen=True)
class Round:
    """One kill: when it came, s, by which signal, over an earlier result or none; and all that went wrong."""

    case: str
    moment: float
    signal: str
    over: bool
    ended: bool  # the command was done before the signal came
    faults: tuple[str, ...]


@contextmanager
def prepared(names: Sequence[str], folder: Path, legs: int = 3) -> Iterator[list[Case]]:
    """The cases with what they need, each run once undisturbed."""
    folder.mkdir(parents=True)
    environment = {"SYNTH_CACHE": str(folder / "cache"), "PYTHONPATH": str(ROOT)}
    (folder / "cache").mkdir(mode=0o700)
    with cluster(folder) if "cluster" in names else _nothing() as made:
        words = {
            "gap": ["gap", "project/gap.yaml"],
            "leg": ["leg", "project/leg-design.yaml", "--no-pictures"],
            "folder": ["fit", "project", "--workers", "2"],
            "sweep": ["hopper", "project/hopper.yaml"],
            "cluster": ["fit", "project", "--scheduler", made.address if made is not None else ""],
        }
        cases = [Case(name, folder / name, words[name], environment) for name in names]
        for case in cases:
            case.folder.mkdir()
            if case.name in ("folder", "cluster"):
                folder_of_legs(case.folder / "project", legs)
            else:
                example = {"sweep": "hopper"}.get(case.name, case.name)
                shutil.copytree(EXAMPLES / example, case.folder / "project")
            for again in (False, True):  # the first compiles
                case.forget()
                shutil.rmtree(case.out, ignore_errors=True)
                begun = time.monotonic()
                said = case.finish()
                case.seconds = time.monotonic() - begun
                if said:
                    raise RuntimeError(f"{case.name} fails undisturbed: {said}")
                if again and hashes(case.out) != case.whole:
                    raise RuntimeError(f"{case.name} gives other bytes undisturbed: {_other(case)}")
                case.whole = hashes(case.out)
        yield cases


@contextmanager
def _nothing() -> Iterator[None]:
    yield None


def killed(case: Case, draw: random.Random) -> Round:
    """One round; an earlier result, of another content, is there in half of them."""
    over = draw.random() < 0.5
    case.forget()
    if over:
        _earlier(case)
    else:
        shutil.rmtree(case.out, ignore_errors=True)
    before = hashes(case.out)
    moment, sent = draw.uniform(0.0, case.seconds), draw.choice(SIGNALS)
    process = case.start()
    time.sleep(moment)
    ended = process.poll() is not None
    if not ended:
        process.send_signal(sent)
    said = process.communicate()[1].decode(errors="replace")
    faults = [f"a traceback: {said[-300:]}"] if "Traceback" in said else []
    faults += [f"process {number} lives on" for number in _outlived(process.pid)]
    left = hashes(case.out)
    if left not in (before, case.whole):
        faults.append("what is left is neither the earlier result nor the new one")
    said = case.finish()
    faults += [f"the next run fails: {said}"] if said else []
    faults += ["the next run gives other bytes"] if hashes(case.out) != case.whole else []
    litter = sorted(path.name for path in case.folder.iterdir() if path.name not in ("out", "project"))
    litter += [str(path) for path in Path(case.environment["SYNTH_CACHE"]).rglob(".partial-*")]
    faults += [f"litter: {', '.join(litter)}"] if litter else []
    return Round(case.name, moment, sent.name, over, ended, tuple(faults))


def hashes(folder: Path) -> dict[str, str]:
    """Each file of the folder with its SHA-256; none where there is no folder."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def _earlier(case: Case) -> None:
    """An earlier run's result of another content, which that run listed."""
    files = [name for name in case.whole if name != MANIFEST]
    for name in files:
        (case.out / name).write_bytes(b"earlier\n" + (case.out / name).read_bytes())
    write_manifest(case.out, files)


def _other(case: Case) -> list[str]:
    now = hashes(case.out)
    return sorted(name for name in now.keys() | case.whole.keys() if now.get(name) != case.whole.get(name))[:5]


def _outlived(session: int) -> list[int]:
    """Processes of the session that are there after a while, which then are ended."""
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until and _of_session(session):
        time.sleep(0.1)
    living = _of_session(session)
    for number in living:
        os.kill(number, signal.SIGKILL)
    return living


def _of_session(session: int) -> list[int]:
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found
