"""Write docs/reference: a page and a JSON Schema for each kind of file, from the schema classes (`make reference`)."""

from __future__ import annotations

from pathlib import Path

from synth.files.reference.pages import pages

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "reference"


def main() -> None:
    """Write every page; remove those of kinds that are gone."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    made = pages()
    for path in FOLDER.iterdir():
        if path.name not in made:
            path.unlink()
    for name, text in made.items():
        (FOLDER / name).write_text(text, encoding="utf-8")
    print(f"{len(made)} files in {FOLDER}")


if __name__ == "__main__":
    main()
