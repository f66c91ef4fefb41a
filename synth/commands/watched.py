"""Run ``synth`` with some folders closed: ``python watched.py FOLDER:FOLDER... -- gap gap.yaml --out DIR``.

File modes do not restrict an administrator, who often runs the tests. An audit hook (PEP 578) blocks
every way in which Python opens or lists files and cannot be removed. It therefore proves that a diagnosis
read neither the answers nor the generator.

With ``--ends-with-input`` before the ``--`` it ends when its standard input closes.
"""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path

ENDS_WITH_INPUT = "--ends-with-input"
EVENTS = frozenset({"open", "os.listdir", "os.scandir", "os.chmod", "os.rename", "shutil.copyfile", "shutil.move"})


def forbid(folders: list[str]) -> None:
    """Refuse access to these folders for the rest of the process."""
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


def end_with_input() -> None:
    """End this process when its standard input closes: the process that holds the other end has then ended, killed too.

    A session or group of its own would hear no signal meant for that process, and nothing at all of its death.
    """

    def listen() -> None:
        while os.read(0, 1):
            pass
        os._exit(1)

    threading.Thread(target=listen, daemon=True).start()


def main(arguments: list[str]) -> int:
    place = arguments.index("--")
    if ENDS_WITH_INPUT in arguments[:place]:
        end_with_input()
    # Modules beside this file are importable only as `synth.commands`.
    here = str(Path(__file__).resolve().parent)
    sys.path[:] = [entry for entry in sys.path if os.path.realpath(entry or ".") != here]
    from synth.cli import main as synth

    forbid(arguments[0].split(os.pathsep))
    return synth(arguments[place + 1 :])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
