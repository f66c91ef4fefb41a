"""What readers of project files share: legs and trials named in them, with messages that point at the line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

from synth.errors import Problem
from synth.files.leg import PartResolver, read_leg
from synth.files.paths import inside
from synth.files.schema import Default
from synth.files.trials import Trial, read_trials
from synth.files.validate import gathering, near, raise_if_any
from synth.files.yaml_lines import Document, Key
from synth.model.leg import Leg


@dataclass(frozen=True)
class InputFile:
    """A file that a result rests on, by its name relative to the project's folder."""

    name: str
    sha256: str


@dataclass
class ProjectReader:
    """Reads what a project names; mistakes are collected and reading goes on."""

    document: Document
    resolve_part: PartResolver | None = None
    problems: list[Problem] = field(default_factory=list)
    defaults: list[Default] = field(default_factory=list)
    inputs: list[InputFile] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.inputs.append(InputFile(self.document.path.name, sha256(self.document.data).hexdigest()))

    @property
    def folder(self) -> Path:
        return self.document.path.parent

    def refuse(self, text: str, key: Key) -> None:
        self.problems.append(self.document.problem(text, key))

    def note(self, path: Path) -> None:
        """Record a file among the inputs."""
        name = path.relative_to(self.folder).as_posix()
        if all(known.name != name for known in self.inputs):
            self.inputs.append(InputFile(name, sha256(path.read_bytes()).hexdigest()))

    def leg(self, name: str, key: Key) -> Leg | None:
        """The leg file named at ``key``."""
        with gathering(self.problems, self.document, key):
            path = inside(self.folder, name)
            leg = read_leg(path, resolve_part=self.resolve_part)
            self.note(path)
            return leg
        return None

    def trials(self, entries: Sequence[Any], leg: Leg, key: Key, locked: Sequence[str] = ()) -> tuple[Trial, ...]:
        """The trials listed at ``key``, of which at least one must be left to fit."""
        with gathering(self.problems, self.document, key):
            trials = read_trials(entries, self.folder, leg, document=self.document, key=key, locked=locked)
            if all(trial.held_out for trial in trials):
                self.refuse("every trial is held out: none is left to fit", key)
            return tuple(trials)
        return ()

    def known_joints(self, names: Mapping[str, Any], leg: Leg, key: Key) -> None:
        """Refuse names that are no joint of ``leg``."""
        for name in names:
            if name not in leg.joint_names:
                self.refuse(f'"{name}" is no joint of {leg.name}{near(name, leg.joint_names)}', (*key, name))

    def finish(self) -> None:
        """Raise what was collected: the project's own mistakes by line, then those of the files it names."""
        own = self.document.name
        raise_if_any(sorted(self.problems, key=lambda p: (p.file != own, (p.line or 0) if p.file == own else 0)))
