"""A kind of work on the projects of a folder: how to read, perform and summarise them."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.batch.folder_summary import Failed
from synth.files.input_hashes import input_hashes
from synth.files.program_versions import versions

if TYPE_CHECKING:
    from synth.files.input_hashes import Project

Content = dict[str, Any]


@dataclass(frozen=True)
class FolderTask:
    """One kind of work on many projects.

    ``read`` gives a project in a form that can be sent to a worker; ``files`` gives the worker's result, content by
    relative name, and reads none of the user's files, because a cluster's workers do not have them. Both raise
    ``UserError``. ``files`` must be a function of a module, because it is sent too.
    """

    kind: str  # of the project files
    made: str  # "fits": the summary is fits.json and fits.csv, the unfinished run .NAME.fits
    done: str  # "fitted"
    read: Callable[[Path], Any]
    identity: Callable[[Any], dict[str, str]]  # inputs that determine the numbers: files with their SHA-256, versions
    checked: Callable[[Any], int]  # checks that need no work; the number of trials
    files: Callable[[Any], dict[str, bytes]]
    entry: Callable[[str, Path], Content]  # of a project's name and its finished folder, for the summary
    columns: Callable[[Mapping[str, Any]], dict[str, list[Any]]]  # the summary as a table
    page: Callable[[Path], object]  # writes the page over all
    effects: bool = True  # whether the equations with all effects are needed
    refused: Callable[[Content], tuple[str, ...]] = lambda entry: ()  # faults that an entry reports of its own result


def identity_of(project: Project) -> dict[str, str]:
    """What determines the numbers of a project's result: its input files by their SHA-256, and versions."""
    return input_hashes(project) | versions()


def files_of(write: Callable[[Path], object]) -> dict[str, bytes]:
    """The files that ``write`` creates in a folder, content by relative name."""
    with tempfile.TemporaryDirectory(prefix="synth-one-") as name:
        folder = Path(name)
        write(folder)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def summary_json(
    task: FolderTask, folder: Path, finished: Sequence[str], failed: Sequence[Failed], version: str
) -> Content:
    """The content of the summary, from the results of ``finished`` below ``folder``/legs."""
    return {
        "format": f"synth/{task.made}/1",
        "versions": {"synth": version},
        "legs": [task.entry(name, folder / "legs" / name) for name in finished],
        "failed": [{"name": f.name, "messages": list(f.messages), "crash": f.crash} for f in failed],
    }
