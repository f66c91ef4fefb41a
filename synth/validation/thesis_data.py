"""The laboratory's data folder: legs, recordings, and the numbers of the thesis' tables (``published.json``)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.leg_file import read_leg
from synth.files.named_files import ProjectReader
from synth.files.paths import read_bytes
from synth.files.tolerance import Tolerance, read_tolerance
from synth.files.trial_list import read_trials
from synth.fit.recordings import Recording, recordings
from synth.swing.leg_model import Leg

JOINTS = ("hip", "knee", "ankle")
# The seven releases that the thesis used, in its order: the first repeat of each muscle, of the iliopsoas the fifth.
SEVEN = ("IP_5", "GS_1", "ST_1", "ST2_1", "VL_1", "BFp_1", "BFa_1")
RAT, DOG, DAMPERS, BUILT = "rat/rat.leg.yaml", "dog/dog.leg.yaml", "dog/dog_dampers.leg.yaml", "dog/dog_built.leg.yaml"
OPTIONS_FILE = "reproduce.yaml"  # optional: kind: reproduce, tolerance: {...}
SIZE_LIMIT = 10_000_000
_NEEDED_TABLES: Mapping[str, Sequence[str]] = {
    "thesis_table_1_rat": ("piecewise", "swarm"),
    "thesis_table_3_target": ("k", "b"),
    "thesis_table_4_free_angle_deg": (),
    "thesis_table_6": ("b_dampers", "k_given_dampers", "k_manufacturer"),
    "thesis_table_8_built": ("k", "b", "bounds_k", "bounds_b"),
    "thesis_table_A1": ("data", "achieved"),
}


@dataclass(frozen=True)
class _Options:
    """``reproduce.yaml``."""

    kind: str
    tolerance: Any = None


@dataclass(frozen=True, eq=False)
class LabData:
    """Content of the folder.

    ``published`` : the content of ``published.json``. ``inputs`` : file -> hash, for all files read. ``tolerance`` : of
    the leg files' numbers, from ``reproduce.yaml`` if it exists, else the defaults.
    """

    folder: Path
    rat: Leg
    dog: Leg
    dampers: Leg
    built: Leg
    published: Mapping[str, Any]
    inputs: Mapping[str, str]
    tolerance: Tolerance = field(default_factory=Tolerance)

    def releases(self) -> list[Recording]:
        """The seven releases, in the thesis' order.

        Raises
        ------
        UserError : one is missing or cannot be used.
        """
        return self.trials(self.rat, [f"rat/releases/{name}.csv" for name in SEVEN])

    def trials(self, leg: Leg, entries: Sequence[Any], sought: Sequence[str] | None = None) -> list[Recording]:
        """Recordings of a leg from ``entries`` in the form of a project's ``trials``."""
        return recordings(leg, read_trials(entries, self.folder, leg), sought)

    def rates(self, table: str, *keys: str) -> Array:
        """(2, 3) published spring and damper rates of a table."""
        found: Any = self.published[table]
        for key in keys:
            found = found[key]
        return np.array([found["k"], found["b"]], dtype=float)


def read_lab_data(folder: str | Path) -> LabData:
    """Read the legs and the published numbers.

    Raises
    ------
    UserError : not a folder, a missing or damaged file, or a leg whose joints are not hip, knee and ankle.
    """
    root = Path(folder)
    if not root.is_dir():
        raise UserError(Problem("is no folder; give the one with rat/, dog/ and published.json", str(root)))
    missing = [Problem("does not exist", str(root / name)) for name in (RAT, DOG, DAMPERS, BUILT, "published.json")
               if not (root / name).is_file()]  # fmt: skip
    if missing:
        raise UserError(missing)
    legs = [read_leg(root / name) for name in (RAT, DOG, DAMPERS, BUILT)]
    wrong = [
        Problem(f"has the joints {', '.join(leg.joint_names)}; hip, knee and ankle are needed", str(root / name))
        for leg, name in zip(legs, (RAT, DOG, DAMPERS, BUILT), strict=True)
        if leg.joint_names != JOINTS
    ]
    if wrong:
        raise UserError(wrong)
    names = [
        RAT,
        DOG,
        DAMPERS,
        BUILT,
        "published.json",
        *(p.relative_to(root).as_posix() for p in _recording_paths(root)),
    ]
    inputs = {name: sha256((root / name).read_bytes()).hexdigest() for name in names}
    if (root / OPTIONS_FILE).is_file():
        inputs[OPTIONS_FILE] = sha256((root / OPTIONS_FILE).read_bytes()).hexdigest()
    tolerance = _tolerance(root, legs[0])
    return LabData(
        root, legs[0], legs[1], legs[2], legs[3], _read_published(root / "published.json"), inputs, tolerance
    )


def _tolerance(root: Path, leg: Leg) -> Tolerance:
    """Tolerances of the leg files' numbers from ``reproduce.yaml``; the defaults without that file."""
    if not (root / OPTIONS_FILE).is_file():
        return Tolerance()
    reader = ProjectReader.open(root / OPTIONS_FILE, "reproduce")
    reader.section(_Options)
    tolerance = read_tolerance(reader, leg)
    reader.finish()
    assert tolerance is not None
    return tolerance


def _recording_paths(root: Path) -> list[Path]:
    folders = ("rat/releases", "dog/damper_drops", "dog/joint_tests")
    found = [path for folder in folders for path in sorted((root / folder).glob("*.csv"))]
    return [path for path in found if path.is_file()]


def _read_published(path: Path) -> Mapping[str, Any]:
    """The thesis' tables.

    Raises
    ------
    UserError : not valid JSON, or a table in ``_NEEDED_TABLES`` is missing.
    """
    try:
        found = json.loads(read_bytes(path, SIZE_LIMIT, "a dozen small tables are expected"))
    except json.JSONDecodeError as error:
        raise UserError(Problem(f"is not valid JSON: {error.msg}", str(path), error.lineno)) from None
    problems = []
    for table, keys in _NEEDED_TABLES.items():
        held = found.get(table) if isinstance(found, dict) else None
        if held is None:
            problems.append(Problem("is missing", str(path), key=table))
            continue
        problems += [Problem("is missing", str(path), key=f"{table}.{key}") for key in keys if key not in held]
    if problems:
        raise UserError(problems)
    return dict(found)
