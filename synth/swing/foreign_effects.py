"""Effects from outside this package: how long they are known, and what a result made with them depends on."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache

from synth.errors import Problem, UserError
from synth.swing import effects
from synth.swing.effects.definition import FUNCTIONS, Effect
from synth.swing.effects.users_own import OwnFile, blamed_on, executed, load_file
from synth.swing.leg_model import Leg

OURS = __name__.partition(".")[0]  # the package
SHOWN = 16  # digits of a hash in messages; by chance two are equal once in 2**64


@contextmanager
def known_effects(files: Sequence[str]) -> Iterator[None]:
    """Within the block the effects of these files are known wherever a leg is read; they are executed.

    Raises
    ------
    UserError : a file holds no valid effect, or its code fails within the block.
    """
    before = dict(effects.from_files)
    try:
        for file in files:
            load_file(file)
        with blamed_on({os.path.realpath(file): file for file in files}):
            yield
    finally:
        effects.from_files.clear()
        effects.from_files.update(before)


def own_files(*legs: Leg) -> tuple[OwnFile, ...]:
    """The files of the user's own effects that these legs hold; without a leg, of all that are known."""
    listed = [given for leg in legs for given in (leg.effects, *(joint.effects for joint in leg.joints))]
    held = {name for each in listed for name in each}
    known = effects.from_files.values()
    return tuple(executed[each.module] for each in known if not legs or each.name in held)


def own_hashes(*legs: Leg) -> dict[str, str]:
    """Name -> SHA-256 of ``own_files``, as a result lists its inputs."""
    return {each.path.name: each.sha256 for each in own_files(*legs)}


@cache
def know(file: OwnFile) -> None:
    """Load an effect that another process of this command knows.

    Raises
    ------
    UserError : the file was changed since.
    """
    if executed[load_file(file.path).module] != file:
        raise UserError(Problem("was changed while the command ran; repeat it", str(file.path)))


def digests() -> dict[str, str]:
    """``effect NAME`` -> hash of an effect's definition and of all that its functions reach, of each foreign effect.

    One whose functions reach what cannot be hashed has another hash in each process: nothing that was made with it is
    taken for the same.
    """
    if not effects.any_foreign():
        return {}
    foreign = [each for each in effects.registered() if each.module.partition(".")[0] != OURS]
    return {f"effect {effect.name}": _digest(effect) for effect in foreign}


def _digest(effect: Effect) -> str:
    from synth.compiling.reached_code import reached_by  # loads the compiler

    names = {FUNCTIONS[effect.way], "start", "to_rotation", effect.bounds, effect.deviation, effect.controls}
    functions = [getattr(effect.loaded, name) for name in sorted(names) if hasattr(effect.loaded, name)]
    words = [repr(effect), *(reached_by(function).digest for function in functions)]
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:SHOWN]
