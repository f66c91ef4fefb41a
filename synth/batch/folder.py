"""The projects of one kind in a folder, and what a run has finished of them."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path, PurePosixPath

from synth.errors import Problem, UserError
from synth.files.paths import refuse_unreadable_name, text_of
from synth.files.yaml_lines import load

SUFFIXES = (".yaml", ".yml")
LEG_FILES = (".leg.yaml", ".leg.yml")
PROJECT_LIMIT = 20_000  # in a folder; more is most likely the wrong folder
WORDS = "what an interrupted run on a folder has finished; the same command goes on from here\n"
IDENTITY = "identity.json"


@dataclass(frozen=True)
class FolderProjects:
    """A project: its ``name`` in the results, and its file; ``problems`` where even its kind cannot be read."""

    name: str
    path: Path
    problems: tuple[Problem, ...] = ()


def find_projects(folder: Path, kind: str = "fit", done: str = "fitted") -> list[FolderProjects]:
    """Every project of a kind in the folder's tree, by name; ``case/KIND.yaml`` is called ``case``.

    A file that does not name its kind is meant to be fitted. ``done`` : what is to be done with them, for messages.

    A YAML file that cannot be read counts as a project: it may be meant as one. So does a folder that cannot be
    opened. Hidden folders are left alone, and so are files of other kinds.

    Raises
    ------
    UserError : there is none, or too many.
    """
    found: list[_File] = []

    def closed(error: OSError) -> None:
        place = Path(str(error.filename))
        problem = Problem(f"cannot be opened: {error.strerror}", text_of(place))
        found.append(_File(place.relative_to(folder).as_posix(), place, (problem,)))

    for place, folders, files in os.walk(folder, onerror=closed):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for file in sorted(files):
            if file.startswith(".") or not file.endswith(SUFFIXES) or file.endswith(LEG_FILES):
                continue
            path = Path(place) / file
            name = path.relative_to(folder).as_posix()
            try:
                refuse_unreadable_name(path.relative_to(folder))
                if load(path).value.get("kind", "fit") == kind:
                    found.append(_File(name, path))
            except UserError as error:
                found.append(_File(name, path, tuple(error.problems)))
    if not any(not item.problems for item in found):
        problems = [problem for item in found for problem in item.problems]
        text = f"holds no project that could be {done}: a YAML file with the line kind: {kind}"
        raise UserError([Problem(text, str(folder)), *problems])
    if len(found) > PROJECT_LIMIT:
        raise UserError(Problem(f"holds {len(found)} projects, at most {PROJECT_LIMIT} can be {done}", str(folder)))
    return _named(found, kind)


@dataclass(frozen=True)
class _File:
    """A project's file by its name ``below`` the folder that is fitted; ``problems`` as of ``FolderProjects``."""

    below: str
    path: Path
    problems: tuple[Problem, ...] = ()


def _named(files: Sequence[_File], kind: str) -> list[FolderProjects]:
    """Every project under a name of its own, as short as may be: ``case``, ``case/fit`` or ``case/fit.yaml``.

    The results of a project lie in a folder of its name. So no two names may be equal, and none may lie inside
    another: ``a/report.html.yaml`` would write its folder where ``a.yaml`` writes its report. Whole file names never
    clash, since a file is no folder; each round gives the names that clash their next longer form.
    """
    forms = [_forms(file.below, kind) for file in files]
    used = [0] * len(files)
    while clashing := _clashes([form[k] for form, k in zip(forms, used, strict=True)]):
        for index in clashing:
            used[index] = min(used[index] + 1, len(forms[index]) - 1)
    named = [
        FolderProjects(form[k], file.path, file.problems) for file, form, k in zip(files, forms, used, strict=True)
    ]
    return sorted(named, key=lambda item: item.name)


def _forms(below: str, kind: str) -> list[str]:
    """The names that a file may give its project, shortest first, each of text that can be written."""
    stem = below.removesuffix(Path(below).suffix)
    forms = [stem.removesuffix(f"/{kind}"), stem, below]
    return [text_of(form) for form in dict.fromkeys(forms)]


def _clashes(names: Sequence[str]) -> list[int]:
    """Places of the names that equal another, or in which another lies."""
    places: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        places.setdefault(name, []).append(index)
    found = {index for same in places.values() if len(same) > 1 for index in same}
    for name in names:
        for parent in map(str, PurePosixPath(name).parents):
            found |= set(places.get(parent, []))
    return sorted(found)


class Kept:
    """The folder ``.NAME.fits`` beside the folder that a run is to write, one folder a finished project.

    ``kind`` : another word than ``fits``, for other work that is kept one by one; ``words`` say in it what it is.

    Raises
    ------
    UserError : it holds something else, or cannot be written.
    """

    def __init__(self, target: Path, kind: str = "fits", words: str = WORDS) -> None:
        whole = Path(os.path.realpath(target))
        self.folder = whole.parent / f".{whole.name}.{kind}"
        self._one = kind.removesuffix("s")
        self.was_there = self.folder.exists()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            mark = self.folder / f"{kind}.txt"
            if not mark.exists():
                if any(self.folder.iterdir()):
                    raise UserError(Problem("holds what is no interrupted run; move it away", str(self.folder)))
                mark.write_text(words, encoding="utf-8")
            for left in self.folder.glob("partial-*"):
                shutil.rmtree(left, ignore_errors=True)
        except OSError as error:
            raise UserError(Problem(f"cannot be written: {error.strerror}", str(self.folder))) from None

    def place(self, name: str) -> Path:
        """Where what was made of this project is kept."""
        return self.folder / f"{self._one}-{sha256(name.encode()).hexdigest()[:24]}"

    def has(self, name: str, identity: Mapping[str, str]) -> bool:
        """Whether its result is kept, from these very files and unchanged; else it is thrown away."""
        place = self.place(name)
        if not place.is_dir():
            return False
        with suppress(OSError, ValueError, AttributeError):
            kept = json.loads((place / IDENTITY).read_text(encoding="utf-8"))
            if kept.get("identity") == dict(identity) and kept.get("files") == _hashes(place / "files"):
                return True
        shutil.rmtree(place)
        return False

    def save(self, name: str, identity: Mapping[str, str], files: Mapping[str, bytes]) -> None:
        """Keep a result's files, all or none, with their hashes."""
        partial = Path(tempfile.mkdtemp(prefix="partial-", dir=self.folder))
        for file, content in files.items():
            path = partial / "files" / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        kept = {"identity": dict(identity), "files": _hashes(partial / "files")}
        (partial / IDENTITY).write_text(json.dumps(kept, indent=1), encoding="utf-8")
        partial.chmod(0o755)
        partial.rename(self.place(name))

    def files(self, name: str) -> Path:
        """The folder with a kept result's files."""
        return self.place(name) / "files"

    def remove(self) -> None:
        """The run has written its result."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _hashes(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): sha256(path.read_bytes()).hexdigest() for path in files}
