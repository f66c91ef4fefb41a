"""A case in a separate process, forked from one that has loaded and compiled everything, and its permitted files."""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil
import signal
import sys
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

with suppress(ImportError):  # cases are forked: on POSIX alone
    import resource

from fuzzing.bases import Base, bases
from fuzzing.mutations import change

LIMIT = 60.0  # s, of a case
MEMORY = 3e9  # bytes of address space in addition to the parent's
FAILURES = ("CRASHED", "HUNG", "DIED", "WROTE", "HALF", "SAID")
SLOW_RUNS = 0.15  # of the cases whose project runs long, that are run and not only checked
RESULTS = ("fit.json", "fits.json", "gap.json", "design.json", "hopper.json", "motor.json", "pull-ups.json",
           "jumps.json", "import.json", "spring.json")  # fmt: skip


@dataclass(frozen=True)
class Case:
    """A seed's project, its changes, and its outcome: ``tag`` DONE, REFUSED or one of ``FAILURES``."""

    seed: int
    base: str
    changes: tuple[str, ...]
    command: tuple[str, ...]
    tag: str
    why: str
    status: int
    seconds: float

    def as_json(self) -> dict[str, Any]:
        """For the report."""
        return asdict(self)


def prepared() -> None:
    """Load everything that commands load, for the forks: imports and compiled equations."""
    os.environ.setdefault("SYNTH_THREADS", "1")
    import synth.cli
    import synth.design.leg_design
    import synth.diagnosis.plants.swinging_chain.chain_diagnosis
    import synth.hopper.study
    import synth.motion.importers.convert  # noqa: F401
    from synth.swing.chain import compiled_chain

    for links in (1, 2, 3):
        compiled_chain(links).load()
    bases()


def run_case(seed: int, room: Path, *, undamaged: bool = False, quick: bool = False) -> Case:
    """Make the case of a seed in a folder of its own under ``room``, run it, judge it, and remove it if it is well.

    ``undamaged`` : the project of that number as it is. ``quick`` : what runs for many seconds is only checked.
    """
    generator = random.Random(seed)
    base = bases()[seed] if undamaged else generator.choice(bases())
    box = room / f"case-{seed}"
    shutil.rmtree(box, ignore_errors=True)
    folder = box / "project"
    (box / "outside").mkdir(parents=True)
    folder.mkdir()
    for name, data in base.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    command = _command(generator, base, quick) if not undamaged else list(base.command)
    if undamaged and quick and base.slow and ("--dry-run",) in base.options:
        command.append("--dry-run")
    changes = []
    for _ in range(0 if undamaged else generator.choice([0, 1, 1, 1, 2, 3]) if base.files else 1):
        names = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
        changes.append(change(generator, folder, command, [name for name in names if name.isprintable()]))
    words = [word.replace("{out}", "out") for word in command]
    before = _contents(box, folder / "out")
    began = time.monotonic()
    status, peak = _forked(words, folder, box)
    seconds = time.monotonic() - began
    tag, why = _judged(status, box, folder, before, words, peak)
    if tag not in FAILURES:
        shutil.rmtree(box, ignore_errors=True)
    return Case(seed, base.name, tuple(changes), tuple(words), tag, why, status, round(seconds, 2))


def _command(generator: random.Random, base: Base, quick: bool) -> list[str]:
    command = list(base.command)
    for option in base.options:
        if generator.random() < 0.12:
            command += option
    checked = generator.random() > SLOW_RUNS or quick
    if base.slow and checked and ("--dry-run",) in base.options and "--dry-run" not in command:
        command.append("--dry-run")
    return command


def _contents(box: Path, out: Path) -> dict[str, str]:
    """Every file of the folder except the result's: its type and bytes."""
    found = {}
    for place, folders, files in os.walk(box):
        if Path(place) == out or out in Path(place).parents:
            continue
        for name in (*folders, *files):
            path = Path(place) / name
            if path == out or path in (box / "stdout", box / "stderr"):
                continue
            if path.is_symlink():
                what = f"link {path.readlink()}"
            elif path.is_file() and path.stat().st_size < 50_000_000:
                what = hashlib.sha256(path.read_bytes()).hexdigest()
            else:
                what = str(path.lstat().st_mode)
            found[os.fsencode(path).decode("utf-8", "backslashreplace")] = what
    return found


def _forked(words: list[str], folder: Path, box: Path) -> tuple[int, float]:
    """The exit status, negative for a signal, and the most memory in bytes."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.setsid()
            os.chdir(folder)
            for number, name in ((0, os.devnull), (1, box / "stdout"), (2, box / "stderr")):
                opened = os.open(name, os.O_RDONLY if number == 0 else os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
                os.dup2(opened, number)
            sys.stdout = os.fdopen(1, "w", encoding="utf-8", closefd=False)
            sys.stderr = os.fdopen(2, "w", encoding="utf-8", closefd=False)
            from synth.cli import main

            status = main(["-q", *words])
        except BaseException:
            import traceback

            traceback.print_exc()
            status = 1
        finally:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            os._exit(status)
    busy = max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))  # longer on a busy machine
    deadline = time.monotonic() + LIMIT * busy
    while True:
        done, status, used = os.wait4(child, os.WNOHANG)
        if done:
            code = os.WEXITSTATUS(status) if os.WIFEXITED(status) else -os.WTERMSIG(status)
            return code, used.ru_maxrss * 1024.0
        if time.monotonic() > deadline:
            os.killpg(child, signal.SIGKILL)
            os.waitpid(child, 0)
            return -99, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024.0
        time.sleep(0.01)


def _judged(
    status: int, box: Path, folder: Path, before: dict[str, str], words: list[str], peak: float
) -> tuple[str, str]:
    """The case's tag and its reason."""
    said = (box / "stderr").read_text(encoding="utf-8", errors="replace") if (box / "stderr").exists() else ""
    told = (box / "stdout").read_text(encoding="utf-8", errors="replace") if (box / "stdout").exists() else ""
    last = said.strip().splitlines()[-1] if said.strip() else ""
    if status == -99:
        return "HUNG", f"more than {LIMIT:.0f} s"
    if status < 0:
        return "DIED", f"signal {-status}"
    if status not in (0, 1, 2) or "Traceback" in said + told:
        return "CRASHED", last
    if status == 1 and not (said + told).strip():
        return "CRASHED", "exit status 1 and not a word"
    after = _contents(box, folder / "out")
    allowed = {str(folder / "out.json")} if status in (0, 1) else set()  # 1: an answer, that it cannot be had
    kept = str(folder / ".out.fits") if (folder / "out" / "fits.json").exists() else str(folder / "\0")
    new = sorted(name for name in after if before.get(name) != after[name] and name not in allowed)
    new = [name for name in new if not name.startswith(kept)]  # what a folder keeps of the fits that went well
    gone = sorted(set(before) - set(after))
    if (new or gone) and not _told_where(words, status):
        return "WROTE", ", ".join([*new, *gone])[:300]
    if peak > MEMORY:
        return "DIED", f"{peak / 1e9:.1f} GB"
    return _result(status, folder / "out", said)


def _told_where(words: list[str], status: int) -> bool:
    """Whether the changed command line itself names another place to write."""
    named = [words[k + 1] for k, word in enumerate(words[:-1]) if word in ("--out", "--json")]
    named += [word.partition("=")[2] for word in words if word.startswith(("--out=", "--json="))]
    return status in (0, 1) and (any(name not in ("out", "out.json") for name in named) or words[0] == "init")


def _result(status: int, out: Path, said: str) -> tuple[str, str]:
    """The message of a refusal, and the content of a result."""
    if status == 2:
        if out.exists() and not (out / "fits.json").exists() and not (out / "catalog").exists():
            return "HALF", "refused, and a result is there"
        return _message(said)
    if said.strip() and (status == 0 or not said.startswith("synth: ")):
        return "SAID", said.strip().splitlines()[0][:300]
    for name in RESULTS:
        if (out / name).is_file():
            try:
                json.loads((out / name).read_text(encoding="utf-8"), parse_constant=_no_number)
            except ValueError as error:
                return "HALF", f"{name}: {error}"
    return "DONE", ""


def _message(said: str) -> tuple[str, str]:
    """Whether a refusal is one message as the program writes it."""
    lines = said.splitlines()
    strange = [line for line in lines if not line.startswith(("synth: ", "usage: ", " "))]
    if not lines or strange:
        return "SAID", strange[0][:300] if strange else "nothing"
    if max(map(len, lines)) > 3000:
        return "SAID", f"a line of {max(map(len, lines))} characters"
    return "REFUSED", lines[0][:200]


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no JSON")
