"""Compiled templates are stored once, give the same page, and are not executed once they are changed."""

from __future__ import annotations

from pathlib import Path

import pytest
from jinja2 import DictLoader, Environment

from synth.files.kept_templates import FOLDER, KeptTemplates


def _templates(text: str = "{{ name }}!") -> Environment:
    return Environment(loader=DictLoader({"page.html": text}), autoescape=True, bytecode_cache=KeptTemplates())


def test_a_template_is_compiled_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    assert _templates().get_template("page.html").render(name="<a>") == "&lt;a&gt;!"
    (kept,) = (tmp_path / "cache" / FOLDER).iterdir()
    again = _templates()
    monkeypatch.setattr(Environment, "_generate", None)  # what compiles
    assert again.get_template("page.html").render(name="b") == "b!"
    assert list((tmp_path / "cache" / FOLDER).iterdir()) == [kept]


def test_another_text_and_a_changed_file_are_compiled_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    _templates().get_template("page.html")
    assert _templates("{{ name }}?").get_template("page.html").render(name="b") == "b?"
    for kept in (tmp_path / "cache" / FOLDER).iterdir():
        kept.write_bytes(kept.read_bytes()[:-1])
    assert _templates().get_template("page.html").render(name="b") == "b!"


def test_without_a_folder_that_is_the_users_nothing_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    (tmp_path / "cache").mkdir(mode=0o700)
    (tmp_path / "cache" / FOLDER).write_text("a file")
    assert _templates().get_template("page.html").render(name="b") == "b!"
