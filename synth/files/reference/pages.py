"""The reference as Markdown: a page and a schema a kind of file, and one that lists them."""

from __future__ import annotations

import json

from synth.files.reference.catalogue_texts import CATALOGUES
from synth.files.reference.json_schema import json_schema
from synth.files.reference.keys import KeyRow, rows
from synth.files.reference.result_schema import result_schema
from synth.files.reference.result_texts import COLUMNS, RESULTS
from synth.files.reference.sections import KINDS, KeySection, kind_word, sections
from synth.files.reference.texts import KIND_TEXTS, SECTION_TEXTS

NOTE = "<!-- made from the schema classes by `make reference`; edit those, and the texts in synth/files/reference -->"


def pages() -> dict[str, str]:
    """File name -> content of every page and schema."""
    found = {f"{kind}.md": _page(kind, section) for kind, section in KINDS.items()}
    found |= {f"{kind}.schema.json": json.dumps(json_schema(kind), indent=1) + "\n" for kind in KINDS}
    found["README.md"] = _overview()
    found["results.md"] = _results()
    for name in RESULTS:
        schema = json.dumps(result_schema(name), indent=1) + "\n"
        found[f"{name.removesuffix('.json')}.result.schema.json"] = schema
    found["catalogues.md"] = _catalogues()
    return found


def _overview() -> str:
    lines = [
        NOTE,
        "",
        "# Files",
        "",
        "Every quantity carries its unit: `200 mm`, `1/2 in`, `1.7 Nm/rad`, `15 in-lb`.",
        "",
    ]
    lines += ["| kind | what it is | read by |", "|---|---|---|"]
    for kind in KINDS:
        what, command = KIND_TEXTS[kind]
        lines.append(f"| [{kind}]({kind}.md) | {what} | {command} |")
    lines += [
        "",
        "Fields of results and columns of tables: [results](results.md). Columns of catalogues: "
        "[catalogues](catalogues.md).",
        "",
        "An editor with the YAML language server checks and completes a file whose first line names its schema:",
        "",
        "    # yaml-language-server: $schema=fit.schema.json",
        "",
        "`synth init` writes the line and the schema beside the project.",
    ]
    return "\n".join(lines) + "\n"


def _results() -> str:
    """Fields of result files and columns of tables."""
    lines = [
        NOTE,
        "",
        "# Results and tables",
        "",
        'A field with a unit is `{"value", "unit"}`, with `interval90` (a 90 %',
    ]
    lines += [
        "interval) where it is an estimate. `NAME` stands for a name, `[]` for the items of a list, `WHY` for any text."
    ]
    lines += ["`gap.result.schema.json` and similar files beside this page contain the same for programs.", ""]
    for head, texts in {**RESULTS, **COLUMNS}.items():
        what = "column" if head in COLUMNS else "field"
        lines += [f"## {head}", "", f"| {what} | meaning |", "|---|---|"]
        lines += [f"| `{key}` | {text} |" for key, text in texts.items()]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _catalogues() -> str:
    """Columns of the tables in ``catalogs``."""
    lines = [NOTE, "", "# Catalogues", "", "`catalogs/README.md` describes the tables.", ""]
    for file, texts in CATALOGUES.items():
        lines += [f"## {file}", "", "| column | meaning |", "|---|---|"]
        lines += [f"| `{column}` | {text} |" for column, text in texts.items()]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _page(kind: str, section: KeySection) -> str:
    what, command = KIND_TEXTS[kind]
    lines = [NOTE, "", f"# kind: {kind_word(kind)}", "", f"{what[0].upper()}{what[1:]}. Read by {command}.", ""]
    for name, inner in sections(section).items():
        if inner is not section:
            lines += [f"## {name.replace('_', ' ')}", "", SECTION_TEXTS[name], ""]
        lines += _table(rows(inner))
    return "\n".join(lines).rstrip() + "\n"


def _table(found: list[KeyRow]) -> list[str]:
    lines = ["| key | type | unit | allowed | default | meaning | example |", "|---|---|---|---|---|---|---|"]
    for row in found:
        default = "**must be given**" if row.default is None else f"`{row.default}`"
        if row.why:
            default += f" ({row.why})"
        shown = f"`{row.name}: {row.example}`" if row.example else ""
        cells = [f"`{row.name}`", row.type, row.unit, row.allowed, default, row.meaning, shown]
        lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return [*lines, ""]
