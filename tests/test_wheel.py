"""The wheel in an environment that has what it asks for and nothing more: no extra, nothing of the tests."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import synth

ROOT = Path(__file__).resolve().parent.parent
ROOMS = ("cad", "reports")  # links in the repository, folders in the wheel


def files_in(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy so that nothing is left behind in the repository."""
    source = tmp_path_factory.mktemp("source") / "repository"
    unwanted = shutil.ignore_patterns(
        ".venv", ".git", ".*_cache", ".hypothesis", "__pycache__", "demo", "build", "dist"
    )
    shutil.copytree(ROOT, source, symlinks=True, ignore=unwanted)
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(out)]
    subprocess.run(command, check=True, timeout=120, cwd=source, capture_output=True)
    (built,) = out.glob("*.whl")
    return built


def test_it_holds_packages_catalogues_and_examples(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    wanted = {f"synth/{name}" for name in files_in(ROOT / "synth")}
    for room, folder in (("_catalogs", "catalogs"), *zip(ROOMS, ROOMS, strict=True)):
        wanted |= {f"synth/{room}/{name}" for name in files_in(ROOT / folder)}
    assert len(wanted) > 700
    assert sorted(wanted - names) == []
    tops = {name.split("/")[0] for name in names}
    assert tops == {"synth", f"limb_synth-{synth.__version__}.dist-info"}


def test_it_is_not_named_after_a_package_of_others_and_carries_the_licence(wheel: Path) -> None:
    archive = zipfile.ZipFile(wheel)
    (metadata,) = (name for name in archive.namelist() if name.endswith("dist-info/METADATA"))
    text = archive.read(metadata).decode()
    assert f"Name: limb-synth\nVersion: {synth.__version__}\n" in text
    assert "License-Expression: MIT" in text
    assert any(name.endswith("licenses/LICENSE") for name in archive.namelist())


@dataclass(frozen=True)
class Environment:
    """A fresh environment with the wheel installed."""

    folder: Path

    @property
    def binaries(self) -> Path:
        return self.folder / ("Scripts" if os.name == "nt" else "bin")

    def run(self, words: Sequence[str], **variables: str) -> subprocess.CompletedProcess[str]:
        environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | variables
        return subprocess.run(
            words, capture_output=True, text=True, cwd=self.folder, env=environment, timeout=300, check=False
        )

    def synth(self, *words: str) -> subprocess.CompletedProcess[str]:
        return self.run([str(self.binaries / "synth"), *words])

    def python(self, code: str) -> subprocess.CompletedProcess[str]:
        return self.run([str(self.binaries / "python"), "-c", code])


def needed(wheel: Path) -> set[str]:
    """Distributions that the wheel asks for without any extra, and those that these ask for."""
    archive = zipfile.ZipFile(wheel)
    (metadata,) = (name for name in archive.namelist() if name.endswith("dist-info/METADATA"))
    waiting = re.findall(r"^Requires-Dist: (.*)$", archive.read(metadata).decode(), re.MULTILINE)
    found: set[str] = set()
    while waiting:
        requirement = Requirement(waiting.pop())
        extras = ["", *requirement.extras]
        if requirement.marker and not any(requirement.marker.evaluate({"extra": extra}) for extra in extras):
            continue
        if requirement.name not in found:
            found.add(requirement.name)
            waiting += distribution(requirement.name).requires or []
    return found


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Environment:
    """A new venv; what the wheel needs is linked there from ours, so that it takes seconds and no network."""
    made = Environment(tmp_path_factory.mktemp("fresh"))
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(made.folder)], check=True, timeout=120)
    into = Path(made.python("import sysconfig; print(sysconfig.get_path('purelib'))").stdout.strip())
    for name in sorted(needed(wheel)):
        files = distribution(name).files or []
        for top in sorted({file.parts[0] for file in files if file.parts[0] not in ("..", "__pycache__")}):
            if not (into / top).exists():
                (into / top).symlink_to(Path(str(distribution(name).locate_file(top))).resolve())
    pip = [sys.executable, "-m", "pip", "--python", str(made.binaries / "python"), "install", "--quiet"]
    subprocess.run([*pip, "--no-deps", "--no-index", "--no-compile", str(wheel)], check=True, timeout=120)
    return made


def test_nothing_of_a_general_name_is_imported(environment: Environment) -> None:
    names = ["cad", "reports", "catalogs", "tools", "mujoco", "pandas", "pytest", "synth"]
    done = environment.python(f"import importlib.util as u; print([n for n in {names} if u.find_spec(n)])")
    assert done.stdout.strip() == "['synth']"
    where = environment.python("import synth; print(synth.__file__)").stdout.strip()
    assert Path(where).is_relative_to(environment.folder)


# What imports every module in a system that has none of POSIX's own modules and calls, as far as ours ask for them.
EVERY_MODULE = """
import builtins, os, pkgutil, signal, importlib
import synth
own, plain = ("fcntl", "resource", "pwd", "grp", "termios", "posix"), builtins.__import__
def without(name, globals=None, *rest):
    if name in own and str((globals or {}).get("__name__")).startswith("synth"):
        raise ImportError(name)
    return plain(name, globals, *rest)
builtins.__import__ = without
for module, names in ((os, "fork getuid geteuid getgid mkfifo setsid killpg"), (signal, "SIGHUP SIGKILL SIGALRM")):
    for name in names.split():
        delattr(module, name)
extras = ("mujoco", "pandas", "matplotlib", "h5py", "ezc3d", "distributed", "sleap_io", "mcap", "rosbags", "playwright")
from synth.compiling import compiled
compiled.compiled = lambda signature, **options: lambda function: function  # a minute of machine code is not needed
names = [m.name for m in pkgutil.walk_packages(synth.__path__, "synth.") if "__main__" not in m.name]
names = [name for name in names if not name.startswith("synth.examples")]
for name in names:
    importlib.import_module(name)
import sys
print(len(names), [name for name in extras if name in sys.modules])
"""


def test_every_module_is_imported_without_extras_and_without_posix(environment: Environment) -> None:
    done = environment.python(EVERY_MODULE)
    assert done.returncode == 0, done.stderr
    count, extras = done.stdout.split(maxsplit=1)
    assert int(count) > 600
    assert extras.strip() == "[]"


def test_the_command_works(environment: Environment) -> None:
    helped = environment.synth("--help")
    assert (helped.returncode, helped.stderr) == (0, "")
    assert environment.synth("init", "leg", "leg").returncode == 0
    ready = environment.synth("leg", "leg/leg-design.yaml", "--out", "out", "--dry-run")
    assert ready.returncode == 0, ready.stderr
    made = environment.synth("spring", "--rate", "1.7 N*m/rad", "--travel", "40 deg", "--out", "spring")
    assert made.returncode == 0, made.stderr
    files = {path.suffix for path in (environment.folder / "spring").rglob("*")}
    assert files >= {".step", ".stl", ".html", ".json"}


def test_model_c_names_the_extra_that_it_needs(environment: Environment) -> None:
    assert environment.synth("init", "hopper", "hopper").returncode == 0
    project = environment.folder / "hopper" / "hopper.yaml"
    text = re.sub("model: full .*", "model: C", project.read_text(encoding="utf-8"))
    project.write_text(text.replace("step: 10 mm", "step: 50 mm"), encoding="utf-8")
    done = environment.synth("hopper", str(project), "--out", "jumps")
    assert done.returncode == 2
    assert 'pip install "limb-synth[mujoco]"' in done.stderr
