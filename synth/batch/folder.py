"""The projects of one kind in a folder, and the finished results of a run."""

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
from synth.files.validate import check_kind, may_be_of
from synth.files.yaml_lines import load

SUFFIXES = (".yaml", ".yml")
LEG_FILES = (".leg.yaml", ".leg.yml")
PROJECT_LIMIT = 20_000  # projects in a folder; more is probably the wrong folder
WORDS = "finished results of an interrupted run on a folder; repeat the command to resume\n"
IDENTITY = "identity.json"


@dataclass(frozen=True)
class FolderProject:
    """A project of a folder: its ``name`` in the results and its file; ``problems`` if its kind cannot be read."""

    name: str
    path: Path
    problems: tuple[Problem, ...] = ()


def find_projects(folder: Path, kind: str = "fit", done: str = "fitted") -> list[FolderProject]:
    """Every project of a kind below the folder, by name; ``case/KIND.yaml`` is called ``case``.

    A file without a kind counts as a fit. ``done`` : the work in messages, such as "fitted".

    A YAML file or folder that cannot be read counts as a project, because it may be meant as one; so does a file whose
    kind is misspelt, or unknown or missing beside a project's keys. Hidden folders and other kinds are skipped.

    Raises
    ------
    UserError : there are none, or too many.
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
                document = load(path)
                if may_be_of(document, kind) or (kind == "fit" and "kind" not in document.value):
                    check_kind(document, kind)
                    found.append(_File(name, path))
            except UserError as error:
                found.append(_File(name, path, tuple(error.problems)))
    if not any(not item.problems for item in found):
        problems = [problem for item in found for problem in item.problems]
        text = f"contains no project that can be {done}, that is no YAML file with the line kind: {kind}"
        raise UserError([Problem(text, str(folder)), *problems])
    if len(found) > PROJECT_LIMIT:
        raise UserError(Problem(f"contains {len(found)} projects; at most {PROJECT_LIMIT} can be {done}", str(folder)))
    return _named(found, kind)


@dataclass(frozen=True)
class _File:
    """A project's file by its name ``below`` the fitted folder; ``problems`` as in ``FolderProject``."""

    below: str
    path: Path
    problems: tuple[Problem, ...] = ()


def _named(files: Sequence[_File], kind: str) -> list[FolderProject]:
    """Every project under a unique name, as short as possible: ``case``, ``case/fit`` or ``case/fit.yaml``.

    The results of a project go to a folder of its name. No two names may therefore be equal or nested:
    ``a/report.html.yaml`` would create a folder where ``a.yaml`` writes its report. Complete file names never
    clash, since a file is not a folder; each round replaces clashing names by their next longer form.
    """
    forms = [_forms(file.below, kind) for file in files]
    used = [0] * len(files)
    while clashing := _clashes([form[k] for form, k in zip(forms, used, strict=True)]):
        for index in clashing:
            used[index] = min(used[index] + 1, len(forms[index]) - 1)
    named = [FolderProject(form[k], file.path, file.problems) for file, form, k in zip(files, forms, used, strict=True)]
    return sorted(named, key=lambda item: item.name)


def _forms(below: str, kind: str) -> list[str]:
    """The possible names of a file's project, shortest first, in characters that can be written."""
    stem = below.removesuffix(Path(below).suffix)
    forms = [stem.removesuffix(f"/{kind}"), stem, below]
    return [text_of(form) for form in dict.fromkeys(forms)]


def _clashes(names: Sequence[str]) -> list[int]:
    """Indices of names that equal another name, or contain one."""
    places: dict[str, list[int]] = {}
    for index, name in enumerate(names):
        places.setdefault(name, []).append(index)
    found = {index for same in places.values() if len(same) > 1 for index in same}
    for name in names:
        for parent in map(str, PurePosixPath(name).parents):
            found |= set(places.get(parent, []))
    return sorted(found)


class RunCheckpoint:
    """The folder ``.NAME.fits`` beside the output folder, with one subfolder per finished project.

    ``kind`` : a word other than ``fits`` for other results; ``words`` describe them.

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
                    raise UserError(
                        Problem("contains other files than an interrupted run's; move it away", str(self.folder))
                    )
                mark.write_text(words, encoding="utf-8")
            for left in self.folder.glob("partial-*"):
                shutil.rmtree(left, ignore_errors=True)
        except OSError as error:
            raise UserError(Problem(f"cannot be written: {error.strerror}", str(self.folder))) from None

    def place(self, name: str) -> Path:
        """The folder of this project's results."""
        return self.folder / f"{self._one}-{sha256(name.encode()).hexdigest()[:24]}"

    def has(self, name: str, identity: Mapping[str, str]) -> bool:
        """Whether a result of exactly these files is stored and undamaged; otherwise it is deleted."""
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
        """Store a result's files with their hashes, all or none."""
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
        """The folder of a stored result."""
        return self.place(name) / "files"

    def remove(self) -> None:
        """Remove the checkpoint after the run has written its result."""
        shutil.rmtree(self.folder, ignore_errors=True)


def _hashes(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): sha256(path.read_bytes()).hexdigest() for path in files}
