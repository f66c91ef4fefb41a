"""Shared by readers of project files: legs and trials named in them, with messages that name the line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

from synth.errors import Problem
from synth.files.leg_file import PartResolver, read_leg
from synth.files.paths import matching, name_from, read_bytes, shared
from synth.files.schema import Default, Section, read_section
from synth.files.trial_list import Trial, read_trials
from synth.files.validate import check_kind, gathering, near, raise_if_any
from synth.files.yaml_lines import Document, Key, load
from synth.swing.foreign_effects import own_hashes
from synth.swing.leg_model import Leg

LARGEST = 100_000_000  # bytes; each format has a limit of its own below


@dataclass(frozen=True)
class InputFile:
    """An input file of a result, by its name relative to the project's folder."""

    name: str
    sha256: str


@dataclass
class ProjectReader:
    """Reads the files of a project; collects mistakes and continues."""

    document: Document
    resolve_part: PartResolver | None = None
    problems: list[Problem] = field(default_factory=list)
    defaults: list[Default] = field(default_factory=list)
    inputs: list[InputFile] = field(default_factory=list)

    @classmethod
    def open(cls, path: str | Path, kind: str, resolve_part: PartResolver | None = None) -> ProjectReader:
        """Open a project file.

        Raises
        ------
        UserError : it cannot be read, or is of another kind.
        """
        document = load(path)
        check_kind(document, kind)
        return cls(document, resolve_part)

    def __post_init__(self) -> None:
        self.inputs.append(InputFile(self.document.path.name, sha256(self.document.data).hexdigest()))

    @property
    def folder(self) -> Path:
        """The project's folder; all named files lie below it, except leg files (``paths.shared``)."""
        return self.document.path.parent

    @property
    def stem(self) -> str:
        """The file's name without extension, the default name of a project."""
        return self.document.path.stem

    @property
    def written(self) -> dict[str, Any]:
        """The file's own mapping, unchecked."""
        value: dict[str, Any] = self.document.value
        return value

    def section(self, section: type[Section], key: str = "") -> Section | None:
        """The mapping under ``key``, or without one the whole file, as a dataclass; applied defaults are recorded."""
        place: Key = (key,) if key else ()
        value = self.written.get(key) if key else self.written
        return read_section(section, self.document, place, self.problems, self.defaults, value)

    def entry(self, section: type[Section], key: Key, value: Any) -> Section | None:
        """The value at ``key`` as a dataclass whose defaults are not recorded."""
        return read_section(section, self.document, key, self.problems, value=value)

    def refuse(self, text: str, key: Key) -> None:
        """Collect a mistake at ``key``."""
        self.problems.append(self.document.problem(text, key))

    def note(self, path: Path) -> None:
        """Record a file as an input."""
        name = name_from(self.folder, path)
        if all(known.name != name for known in self.inputs):
            with gathering(self.problems):
                data = read_bytes(path, LARGEST, "no file of a project is so large")
                self.inputs.append(InputFile(name, sha256(data).hexdigest()))

    def leg(self, name: str, key: Key) -> Leg | None:
        """The leg file named at ``key``; it and the files that it names are inputs."""
        with gathering(self.problems, self.document, key):
            path = shared(self.folder, name)
            named = [path]
            leg = read_leg(path, resolve_part=self.resolve_part, opened=named.append)
            for each in named:
                self.note(each)
            own = (InputFile(*each) for each in own_hashes(leg).items())  # named by the user, who may keep it anywhere
            self.inputs += [each for each in own if each not in self.inputs]
            return leg
        return None

    def leg_and_trials(self, *, other_legs: bool = False) -> tuple[Leg | None, tuple[Trial, ...]]:
        """The leg under ``leg`` and its trials under ``trials``; missing keys are reported by the check of the file.

        ``other_legs`` : whether a trial may name its own leg.
        """
        name, entries = self.written.get("leg"), self.written.get("trials")
        leg = self.leg(name, ("leg",)) if isinstance(name, str) else None
        if leg is None or not isinstance(entries, list) or not entries:
            return leg, ()
        return leg, self.trials(entries, leg, ("trials",), other_legs=other_legs)

    def matched(self, patterns: Sequence[str], key: Key) -> tuple[Path, ...]:
        """The files of the patterns listed at ``key``, each once."""
        found: list[Path] = []
        for index, pattern in enumerate(patterns):
            with gathering(self.problems, self.document, (*key, index)):
                found += [path for path in matching(self.folder, pattern) if path not in found]
        for path in found:
            self.note(path)
        return tuple(found)

    def trials(
        self, entries: Sequence[Any], leg: Leg, key: Key, locked: Sequence[str] = (), *, other_legs: bool = False
    ) -> tuple[Trial, ...]:
        """The trials listed at ``key``; at least one must not be held out."""
        other = self.leg if other_legs else None
        with gathering(self.problems, self.document, key):
            trials = read_trials(
                entries, self.folder, leg, document=self.document, key=key, locked=locked, other_leg=other
            )
            if all(trial.held_out for trial in trials):
                self.refuse("every trial is held out: none remains to fit", key)
            return tuple(trials)
        return ()

    def known_joints(self, names: Mapping[str, Any], leg: Leg, key: Key) -> None:
        """Refuse names that are not joints of ``leg``."""
        for name in names:
            if name not in leg.joint_names:
                self.refuse(f'"{name}" is no joint of {leg.name}{near(name, leg.joint_names)}', (*key, name))

    def finish(self) -> None:
        """Raise all collected mistakes: the project's own by line, then those of the named files."""
        own = self.document.name
        raise_if_any(sorted(self.problems, key=lambda p: (p.file != own, (p.line or 0) if p.file == own else 0)))
