"""The reference: every key has a text, the pages are those of the classes, the schemas fit the examples."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import pytest
import yaml
from pydantic import TypeAdapter

import synth
from diagnosis.made_result import made_result
from result_fields import require_explained, unexplained
from synth.api.gap_folder import _entry
from synth.cli import main
from synth.files.gap_kind import is_hopper_gap
from synth.files.reference.catalogue_texts import CATALOGUES
from synth.files.reference.json_schema import json_schema
from synth.files.reference.keys import model_of, rows
from synth.files.reference.pages import pages
from synth.files.reference.result_texts import COLUMNS
from synth.files.reference.sections import KINDS, KeySection, sections
from synth.files.reference.texts import KIND_TEXTS, SECTION_TEXTS, TEXTS
from synth.files.validate import COMMANDS
from synth.files.yaml_lines import load
from synth.parts.rows import (
    CatalogueRow,
    CurvePointRow,
    DamperRow,
    GearMotorRow,
    MaterialRow,
    TorsionSpringRow,
    WireRow,
)  # fmt: skip

ROOT = Path(synth.__file__).parent
FOLDER = ROOT.parent / "docs" / "reference"
EXAMPLES = sorted((ROOT / "examples").rglob("*.yaml"))
ROWS: dict[type[CatalogueRow], str] = {
    TorsionSpringRow: "torsion_springs.csv",
    DamperRow: "dampers.csv",
    CurvePointRow: "damper_curves.csv",
    WireRow: "wire_diameters.csv",
    MaterialRow: "wire_materials.csv",
    GearMotorRow: "gearmotors.csv",
}
EVERY = [(kind, section) for kind, whole in KINDS.items() for section in sections(whole).values()]


def test_every_key_has_a_text_and_every_text_a_key() -> None:
    keys = {f"{section.name}.{name}" for _, section in EVERY for name in model_of(section).model_fields}
    assert keys - TEXTS.keys() == set()
    assert TEXTS.keys() - keys == set()
    assert {section.name for _, section in EVERY} - set(SECTION_TEXTS) == {whole.name for whole in KINDS.values()}
    assert set(KIND_TEXTS) == set(KINDS)


def test_every_kind_that_a_command_reads_has_a_page() -> None:
    without = {"reproduce"}  # its one key is `tolerance`, as of fit
    assert set(COMMANDS) - without <= set(KINDS)


def test_rows_have_type_unit_default_and_range() -> None:
    mass = {row.name: row for row in rows(KINDS["leg"].inner["joints"].inner["link"])}["mass"]
    assert (mass.type, mass.unit, mass.default) == ("quantity", "g", None)
    assert mass.allowed == "more than 0 g, at most 1e+06 kg"
    assert mass.example == "740 g"
    cad = {row.name: row for row in rows(KINDS["leg-design"].inner["cad"])}
    assert (cad["wall"].default, cad["encoder"].default) == ("3 mm", "true")
    assert cad["wall"].why.startswith("seven lines of print")
    fit = {row.name: row for row in rows(KINDS["fit"])}
    assert fit["release"].allowed == "free, recorded"
    assert fit["leg"].example == "rat.leg.yaml"


@pytest.mark.parametrize(("kind", "section"), EVERY, ids=[f"{kind}-{section.name}" for kind, section in EVERY])
def test_no_example_is_refused(kind: str, section: KeySection) -> None:
    """`free_angle: 105 deg` stood beside the mode of the fit and beside a tolerance of at most 90 deg."""
    fields = model_of(section).model_fields
    for row in rows(section):
        if row.example and row.name not in section.inner:
            item = fields[row.name]
            written: Any = Annotated[(item.annotation, *item.metadata)] if item.metadata else item.annotation
            TypeAdapter(written).validate_python(yaml.safe_load(row.example))


def test_an_example_is_of_the_keys_size() -> None:
    """No key shows just any length or mass: its own default, or what is usual for it."""
    shown = {line for page in pages().values() for line in page.splitlines() if "200 mm" in line or "740 g" in line}
    assert {line.split("`")[1] for line in shown if line.startswith("| `")} <= {
        "length",
        "mass",
        "link",
        "upper_length",
        "most",
    }
    spring = KINDS["leg-design"].inner["select"].inner["joints"].inner["spring"]
    cycles = {row.name: row for row in rows(spring)}["cycles"]
    assert float(cycles.example) > 1.0


def test_the_pages_are_those_of_the_classes() -> None:
    """After a change of a key: make reference."""
    written = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.iterdir()}
    assert written == pages()


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: str(path.relative_to(ROOT / "examples")))
def test_the_schemas_take_the_examples_and_refuse_what_is_misspelt(path: Path) -> None:
    jsonschema = pytest.importorskip("jsonschema")
    content = load(path).value
    kind = "gap-of-jumps" if content["kind"] == "gap" and is_hopper_gap(path) else content["kind"]
    schema = json_schema(kind)
    jsonschema.Draft7Validator.check_schema(schema)
    found = list(jsonschema.Draft7Validator(schema).iter_errors(content))
    assert [error.message for error in found] == []
    assert list(jsonschema.Draft7Validator(schema).iter_errors({**content, "trails": []}))


def test_a_bare_number_is_no_quantity_for_the_schema() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    link = json_schema("leg")["properties"]["joints"]["items"]["anyOf"][0]["properties"]["link"]
    good = {"length": "200 mm", "mass": "1/2 lb", "com": "3.5 in", "inertia": "3.5e-3 kg*m^2"}
    assert not list(jsonschema.Draft7Validator(link).iter_errors(good))
    for bad in ({"length": 200}, {"length": "200"}, {"mass": "heavy"}):
        assert list(jsonschema.Draft7Validator(link).iter_errors(good | bad))


def test_every_field_of_a_diagnosis_has_a_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("synth.api.gaps.diagnose", lambda *rest, **options: made_result())
    synth.gap(ROOT / "examples" / "gap" / "gap.yaml").save(tmp_path / "gap")
    content = json.loads((tmp_path / "gap" / "gap.json").read_text(encoding="utf-8"))
    require_explained("gap.json", content)
    many = {"format": "", "versions": {"synth": ""}, "legs": [_entry("name", tmp_path / "gap")], "failed": []}
    require_explained("gaps.json", many)


def test_every_column_of_a_catalogue_has_a_text() -> None:
    catalogs = ROOT / "_catalogs"
    assert {path.name for path in catalogs.glob("*.csv")} == set(CATALOGUES)
    for name, texts in CATALOGUES.items():
        head = (catalogs / name).read_text(encoding="utf-8").splitlines()[0]
        assert [column for column in head.split(",") if column.split(" [")[0] not in texts] == [], name
    for row, name in ROWS.items():
        columns = {item.name for item in row.columns()}
        assert columns - set(CATALOGUES[name]) == set(), name
        assert set(CATALOGUES[name]) - columns == set(), name


def test_every_field_of_a_result_has_a_text(tmp_path: Path) -> None:
    fitted = synth.fit(ROOT / "examples" / "fit" / "fit.yaml")
    fitted.save(tmp_path / "fit")
    synth.spring("1.7 Nm/rad", "40 deg").save(tmp_path / "spring")
    assert (
        main(["import", str(ROOT / "examples" / "import" / "import.yaml"), "--out", str(tmp_path / "import"), "-q"])
        == 0
    )
    names = {*fitted.joints, "trials", "synth", "numpy", "scipy"} - {"trials"}
    for name in ("fit.json", "import.json", "spring.json"):
        content = json.loads((tmp_path / name.removesuffix(".json") / name).read_text(encoding="utf-8"))
        require_explained(name, content, names)
    head = (tmp_path / "fit" / "responses" / "source" / "check.csv").read_text(encoding="utf-8").splitlines()[0]
    for column in head.split(","):
        assert not unexplained({column}, COLUMNS["responses/source/*.csv of synth fit"])
