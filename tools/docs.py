"""Build the documentation: `make docs`. Warnings are errors, and the build itself needs no network.

Sphinx, its theme and MyST are the extra `docs` of pyproject.toml. They are not part of the locked environment, which
keeps `make setup` short; they are installed at the first build.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MODULES = {"sphinx": "sphinx", "pydata-sphinx-theme": "pydata_sphinx_theme", "myst-parser": "myst_parser"}


def missing() -> list[str]:
    """Requirements of the extra `docs` that are not installed."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    return [item for item in extras["docs"] if not find_spec(MODULES[re.split(r"[^A-Za-z0-9-]", item)[0]])]


def build(to: Path) -> int:
    """Build the pages into ``to``; returns Sphinx's exit status."""
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q"]
    read = to.parent / "docs-read"  # Sphinx's cache of unchanged pages
    return subprocess.run([*command, "-d", str(read), str(ROOT / "docs"), str(to)], check=False).returncode


def main() -> int:
    """Install missing requirements, build, and print the path of the first page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, default=ROOT / "build" / "docs")
    to = parser.parse_args().to.resolve()
    if wanted := missing():
        subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", *wanted], check=True)
    status = build(to)
    if status == 0:
        print(f"The documentation: {to / 'index.html'}")
    return status


if __name__ == "__main__":
    sys.exit(main())
