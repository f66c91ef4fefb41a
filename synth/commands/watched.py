"""Run ``synth`` where some folders cannot be opened: ``python watched.py FOLDER:FOLDER... -- gap gap.yaml --out DIR``.

Modes of files do not stop an administrator, and much of what runs tests does so as one. An audit hook (PEP 578) stops
every way in which Python opens or lists, cannot be taken off again, and so proves that a diagnosis that ended well has
seen neither the answers nor the generator.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

EVENTS = frozenset({"open", "os.listdir", "os.scandir", "os.chmod", "os.rename", "shutil.copyfile", "shutil.move"})


def forbid(folders: list[str]) -> None:
    """Refuse what is in these folders for the rest of the process."""
    closed = tuple(os.path.realpath(folder) for folder in folders)

    def watch(event: str, arguments: tuple[object, ...]) -> None:
        if event not in EVENTS:
            return
        for given in arguments:
            if not isinstance(given, (str, bytes, os.PathLike)):
                continue
            path = os.path.realpath(os.fsdecode(given))
            if any(path == folder or path.startswith(folder + os.sep) for folder in closed):
                raise PermissionError(f"{path} is closed to a diagnosis")

    sys.addaudithook(watch)


def main(arguments: list[str]) -> int:
    place = arguments.index("--")
    # Modules beside this file are `synth.commands`, and by no other name.
    here = str(Path(__file__).resolve().parent)
    sys.path[:] = [entry for entry in sys.path if os.path.realpath(entry or ".") != here]
    from synth.cli import main as synth

    forbid(arguments[0].split(os.pathsep))
    return synth(arguments[place + 1 :])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
