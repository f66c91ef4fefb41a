"""What a result depends on beside its inputs: one list for the cache, for resumed runs and for workers."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from synth.batch.task_outcome import differences, performed
from synth.files import program_versions, stage_cache
from synth.files.program_versions import source_hash, versions


def developed(folder: Path) -> Path:
    """A package whose folder of solids is a link to one beside it."""
    (folder / "synth").mkdir(parents=True)
    (folder / "synth" / "fit.py").write_text("one = 1\n")
    for name in ("cad", "reports", "catalogs"):
        (folder / name).mkdir()
        (folder / name / "a.txt").write_text(name)
    for name, place in (("cad", "cad"), ("reports", "reports"), ("_catalogs", "catalogs")):
        (folder / "synth" / name).symlink_to(folder / place)
    return folder / "synth"


def test_an_installed_package_has_the_hash_of_its_source(tmp_path: Path) -> None:
    root = developed(tmp_path / "here")
    installed = tmp_path / "there" / "synth"
    shutil.copytree(root, installed)  # follows the links
    assert not (installed / "cad").is_symlink()
    assert source_hash(installed) == source_hash(root)
    (installed / "cad" / "a.txt").write_text("changed")
    assert source_hash(installed) != source_hash(root)


def test_compiled_code_does_not_count_nor_what_another_process_is_writing_there(tmp_path: Path) -> None:
    root = developed(tmp_path)
    before = source_hash(root)
    (root / "__pycache__").mkdir()
    (root / "__pycache__" / "fit.cpython-311.pyc.140211").write_bytes(b"half")
    (root / ".fit.py.swp").write_bytes(b"an editor's")
    assert source_hash(root) == before
    (root / "fit.py").rename(root / "fitted.py")
    assert source_hash(root) != before


@pytest.mark.parametrize("library", ["cadquery", "cadquery-ocp", "numba", "jinja2"])
def test_a_library_that_decides_bytes_stops_a_worker_a_resumed_run_and_the_cache(
    library: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A solid of another kernel is another file."""
    wanted, key = versions(), stage_cache.key_of("solids")
    own = program_versions._version
    monkeypatch.setattr(program_versions, "_version", lambda name: "0.1" if name == library else own(name))
    outcome = performed(len, "four", wanted)
    assert outcome.value is None
    assert outcome.other == f"{library} 0.1 instead of {wanted[library]}"
    assert stage_cache.key_of("solids") != key


def test_another_source_of_the_same_version_differs() -> None:
    here = versions()
    assert differences(here, here) == ""
    assert differences(here, here | {"synth's source": "0123"}).startswith("synth's source 0123 instead of ")
