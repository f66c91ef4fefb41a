"""Run the tests with each supported Python, with the locked and with the lowest versions of all packages.

``python tools/matrix.py --to FOLDER [TESTS ...]`` (``make matrix``) makes one environment for each combination in the
folder, runs the tests there, and prints a table. A Python that is missing on this machine is skipped and marked in the
table; on POSIX install it with ``pyenv install`` or ``uv python install``. The lowest versions are the lower bounds in
pyproject.toml, or the next versions with a wheel for that Python; uv chooses them (``--resolution lowest-direct``).
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("3.11", "3.12", "3.13")
KINDS = ("locked", "lowest")
# Tests that use every package: wheel and all imports, pint, pydantic, numba with MuJoCo, CadQuery.
TESTS = (
    "tests/test_wheel.py", "tests/test_units.py", "tests/files", "tests/estimation", "tests/swing/test_chain.py",
    "tests/motion", "tests/api", "tests/hopper/test_mujoco.py", "tests/cad/test_solids.py", "tests/reports",
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """Result in one environment; ``message`` : pytest's last line, or why nothing ran; ``held`` None: skipped."""

    python: str
    kind: str
    held: bool | None
    message: str
    seconds: float = 0.0


def interpreter(version: str) -> Path | None:
    """A Python of this version, from the path or from pyenv; None if there is none."""
    found = [shutil.which(f"python{version}"), shutil.which(f"python{version}", path=_pyenv(version))]
    for place in filter(None, found):
        code = "import sys; print('%d.%d' % sys.version_info[:2])"
        asked = subprocess.run([place, "-c", code], capture_output=True, text=True, check=False)
        if asked.returncode == 0 and asked.stdout.strip() == version:  # a pyenv shim may point to no installation
            return Path(place)
    return None


def _pyenv(version: str) -> str:
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    return os.pathsep.join(str(path / "bin") for path in sorted(root.glob(f"{version}.*"), reverse=True))


def environment_of_uv() -> dict[str, str]:
    """Environment variables for uv, which does not read pip's certificates."""
    return {"SSL_CERT_FILE": os.environ["PIP_CERT"], **os.environ} if "PIP_CERT" in os.environ else dict(os.environ)


def uv(folder: Path) -> str:
    """The command ``uv``; if it is missing, installed into the folder."""
    if found := shutil.which("uv"):
        return found
    own = folder / "uv"
    if not (own / "bin" / "uv").exists():
        subprocess.run([sys.executable, "-m", "venv", str(own)], check=True)
        subprocess.run([str(own / "bin" / "pip"), "install", "--quiet", "uv"], check=True)
    return str(own / "bin" / "uv")


def made(folder: Path, python: Path, version: str, kind: str) -> Path:
    """Make an environment with this project and the packages of this kind; returns its interpreter.

    Raises
    ------
    subprocess.CalledProcessError : a package is not available for this Python; ``stderr`` names it.
    """
    tool, place = uv(folder), folder / f"{version}-{kind}"

    def call(*words: str) -> None:
        subprocess.run([tool, *words], check=True, capture_output=True, text=True, cwd=ROOT, env=environment_of_uv())

    call("venv", "--quiet", "--seed", "--clear", "--python", str(python), str(place))
    inside = str(place / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))
    install = ["pip", "install", "--quiet", "--python", inside, "--only-binary", ":all:"]
    if kind == "locked":
        call(*install, "--require-hashes", "--requirement", "requirements.txt")
    else:
        lowest = folder / f"{version}-lowest.txt"
        bounds = ["--resolution", "lowest-direct", "--python-version", version, "--extra", "dev", "pyproject.toml"]
        call("pip", "compile", "--quiet", "--only-binary", ":all:", *bounds, "--output-file", str(lowest))
        call(*install, "--requirement", str(lowest))
    call("pip", "install", "--quiet", "--python", inside, "--no-deps", "--no-build-isolation", "--editable", ".")
    return Path(inside)


def tried(folder: Path, version: str, kind: str, tests: Sequence[str], workers: int) -> Outcome:
    """Make one environment and run the tests in it; their output is stored beside it."""
    python = interpreter(version)
    if python is None:
        return Outcome(version, kind, None, f"no Python {version} here: pyenv install {version}")
    begun = time.perf_counter()
    try:
        inside = made(folder, python, version, kind)
    except subprocess.CalledProcessError as error:
        last = [line.strip() for line in error.stderr.splitlines() if line.strip()]
        return Outcome(version, kind, False, f"no environment: {' '.join(last)[:300]}", time.perf_counter() - begun)
    command = [str(inside), "-m", "pytest", "-q", "-n", str(workers), "-p", "no:cacheprovider", *tests]
    variables = {**os.environ, "PYTHONPATH": str(ROOT), "SYNTH_CACHE": str(folder / f"{version}-{kind}-cache")}
    done = subprocess.run(command, cwd=ROOT, env=variables, capture_output=True, text=True, check=False)
    (folder / f"{version}-{kind}.log").write_text(done.stdout + done.stderr, encoding="utf-8")
    counts = re.findall(r"^=*\s?(\d+ .* in [\d.]+s.*?)\s?=*$", done.stdout, re.MULTILINE)
    message = counts[-1] if counts else done.stderr.strip()[-200:]
    return Outcome(version, kind, done.returncode == 0, message, time.perf_counter() - begun)


def main() -> int:
    """Run all combinations; returns 1 if tests fail in one."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tests", nargs="*", default=TESTS, help="files or folders; else a room of every package used")
    parser.add_argument("--to", required=True, type=Path, metavar="FOLDER")
    parser.add_argument("--python", action="append", choices=PYTHONS, help="may be given more than once; default all")
    parser.add_argument("--kind", action="append", choices=KINDS, help="may be given more than once; default both")
    parser.add_argument("--workers", type=int, default=2)
    chosen = parser.parse_args()
    folder = chosen.to.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    outcomes = []
    for version in chosen.python or PYTHONS:
        for kind in chosen.kind or KINDS:
            outcome = tried(folder, version, kind, chosen.tests, chosen.workers)
            word = {True: "holds", False: "FAILS", None: "skipped"}[outcome.held]
            print(f"{version:5} {kind:7} {word:8} {outcome.seconds:6.0f} s  {outcome.message}", flush=True)
            outcomes.append(outcome)
    print(f"output of the tests: {folder}/*.log")
    return 1 if any(outcome.held is False for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
