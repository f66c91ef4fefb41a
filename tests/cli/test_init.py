"""``synth init``: example projects are copied into empty folders only."""

from __future__ import annotations

import os
import shlex
import signal
from pathlib import Path

import pytest

from synth.cli import main
from synth.commands import init
from synth.files.leftovers import held_folder

EXAMPLES = Path(init.__file__).resolve().parent.parent / "examples"


def files_in(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_every_example_can_be_initialised() -> None:
    assert sorted(init.PROJECTS) == sorted(path.name for path in EXAMPLES.iterdir() if path.is_dir())
    assert all((EXAMPLES / kind / project).is_file() for kind, project in init.PROJECTS.items())


@pytest.mark.parametrize("kind", init.PROJECTS)
def test_the_copy_is_complete_and_the_printed_command_runs(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "new folder" / "my <b>leg</b>"
    assert main(["init", kind, str(target)]) == 0
    found, given = files_in(target), files_in(EXAMPLES / kind)
    assert set(found) == set(given) | {name for name in found if name.startswith("schemas")}
    for name, content in given.items():
        head, _, rest = found[name].partition(b"\n")
        named = b"# yaml-language-server: $schema="
        assert found[name] == content or (head.startswith(named) and rest == content)
        assert head.startswith(named) == name.endswith(".yaml")
        if name.endswith(".yaml"):
            assert ((target / name).parent / head.removeprefix(named).decode()).is_file()
    assert [path.name for path in target.parent.iterdir()] == [target.name]
    command = shlex.split(capsys.readouterr().out.splitlines()[-1])
    assert command[:3] == ["synth", kind, str(target / init.PROJECTS[kind])]
    assert main([*command[1:], "--dry-run"]) == 0
    assert "is valid" in capsys.readouterr().out


def test_the_copy_of_a_read_only_package_is_writable(tmp_path: Path) -> None:
    source = tmp_path / "installed"
    (source / "trials").mkdir(parents=True)
    (source / "trials" / "a.csv").write_text("time [s]\n")
    (source / "trials" / "a.csv").chmod(0o444)
    (source / "trials").chmod(0o555)
    try:
        init.copy_example(source, tmp_path / "copy")
    finally:
        (source / "trials").chmod(0o755)
    copied = tmp_path / "copy" / "trials"
    assert copied.stat().st_mode & 0o700 == 0o700
    assert (copied / "a.csv").stat().st_mode & 0o200


def test_an_empty_folder_is_filled_even_when_it_is_the_current_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    assert main(["init", "fit", "."]) == 0
    assert (Path.cwd() / "fit.yaml").is_file()
    assert [path.name for path in tmp_path.iterdir()] == ["empty"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("full", "is not empty"),
        ("full/mine.txt", "is a file"),
        ("full/mine.txt/below", "mine.txt is a file"),
        ("/proc/synth-example", "cannot be written"),
        ("a\0b", "cannot be written: embedded null"),
        ("x" * 300, "cannot be written: File name too long"),
    ],
)
def test_existing_files_are_not_replaced(
    name: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if name.startswith("/proc") and not Path("/proc").is_dir():
        pytest.skip("no /proc here")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    assert main(["init", "leg", name]) == 2
    shown = capsys.readouterr()
    assert shown.err.startswith("synth: ")
    assert message in shown.err
    assert shown.err.count("\n") == 1
    assert files_in(tmp_path) == {str(Path("full", "mine.txt")): b"mine"}


@pytest.mark.parametrize("sent", [None, signal.SIGTERM])
def test_an_empty_folder_is_filled_completely_or_not_at_all(
    sent: signal.Signals | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk, or a signal, came after the third entry: the next `synth init` refused the half project."""
    target, rename, moved = tmp_path / "project", Path.rename, list[str]()
    target.mkdir()

    def renamed(self: Path, to: Path) -> Path:
        if to.parent == target:
            moved.append(to.name)
            if len(moved) == 3 and sent is None:
                raise OSError(28, "No space left on device")
            if len(moved) == 3 and sent is not None:
                os.kill(os.getpid(), sent)
        return rename(self, to)

    before = None if sent is None else signal.signal(sent, signal.SIG_DFL)
    try:
        with monkeypatch.context() as patch:
            patch.setattr(Path, "rename", renamed)
            if sent is None:
                assert main(["-q", "init", "fit", str(target)]) == 2
            else:
                with pytest.raises(SystemExit):
                    main(["-q", "init", "fit", str(target)])
    finally:
        if sent is not None:
            signal.signal(sent, before)
    assert [path.name for path in tmp_path.iterdir()] == ["project"]
    whole = {path.name for path in (init.EXAMPLES / "fit").iterdir() if path.name != "__pycache__"} | {init.SCHEMAS}
    assert {path.name for path in target.iterdir()} == (set() if sent is None else whole)


def test_a_signal_during_the_copy_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(init, "with_schemas", lambda folder: os.kill(os.getpid(), signal.SIGTERM))
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        with pytest.raises(SystemExit):
            main(["-q", "init", "fit", str(tmp_path / "project")])
    finally:
        signal.signal(signal.SIGTERM, before)
    assert list(tmp_path.iterdir()) == []


def test_two_copies_into_one_folder_the_second_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, lock = held_folder(tmp_path, ".project.partial-")
    try:
        assert main(["init", "fit", str(tmp_path / "project")]) == 2
    finally:
        if lock is not None:
            os.close(lock)
    assert "being written by another run" in capsys.readouterr().err
