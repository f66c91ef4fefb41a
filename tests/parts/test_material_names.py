"""A wire material in the spellings of vendors and standards, and a spring whose material nobody knows."""

from __future__ import annotations

from pathlib import Path

import pytest

from synth.cli import main
from synth.parts.catalogs import Catalogue, check_catalogue
from synth.parts.material_names import same_material
from synth.spring.bought_spring import travel_to_yield

HEAD = (
    "part,vendor,material,rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],body_coils [1],included_angle [deg]\n"
)
CATALOGUE = Catalogue.load()
SPELLINGS = {
    "music wire": ("Music Wire (ASTM A228)", "A 228", "ASTM A228/A228M-16", "PIANO-WIRE, zinc plated", "SWP-B"),
    "hard drawn": ("hard drawn steel wire ASTM A227",),
    "chrome silicon": ("Oil tempered chrome-silicon ASTM A401", "CrSi"),
    "stainless 302": ("302", "SS302", "Stainless Steel 304", "stainless steel", "EN 10270-3 1.4310", "A313 type 302"),
    "stainless 316": ("AISI 316", "1.4401"),
    "stainless 17-7": ("17-7PH", "17-7 PH stainless steel", "Stainless 17/7 PH", "1.4568"),
    "EN 10270-1 SH": ("DIN EN 10270-1-SH", "EN 10270-1:2011 SH", "music wire EN 10270-1 SH"),
    "EN 10270-2 VDSiCr": ("oil tempered EN 10270-2 VDSiCr",),
    "inconel X-750": ("Inconel X750",),
}  # fmt: skip
NONE = (
    "302/316", "stainless music wire", "stainless 301", "304L", "spring steel", "steel", "EN 10270-1", "music wire XL",
    "müsic wire", "",
)  # fmt: skip


def own_table(*materials: str, rate: float = 1.683) -> Path:
    """A table of springs of 2 mm wire whose geometry gives 1.683 N m/rad, one of each material."""
    rows = (f"Y{k},W,{material},{rate},2.0,15.47,2.1667,120\n" for k, material in enumerate(materials))
    path = Path("own.csv")
    path.write_text(HEAD + "".join(rows))
    return path


@pytest.mark.parametrize(("name", "written"), [(name, each) for name, texts in SPELLINGS.items() for each in texts])
def test_a_usual_spelling_is_the_material(name: str, written: str) -> None:
    assert CATALOGUE.find_material(written).name == name
    assert same_material(name, written)


@pytest.mark.parametrize("written", NONE)
def test_a_text_of_two_materials_or_with_an_unknown_word_names_none(written: str) -> None:
    assert CATALOGUE.known_materials.name(written) is None


def test_a_spelling_changes_no_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """``music wire ASTM A228`` was complete without a check of yield and rate, and chosen."""
    monkeypatch.chdir(tmp_path)
    table = own_table("music wire", "music wire ASTM A228")
    assert check_catalogue([table]) == []
    catalogue = Catalogue.load([table])
    plain, standard = (catalogue.find_spring(part) for part in ("Y0", "Y1"))
    assert plain.complete
    assert standard.complete
    assert travel_to_yield(plain, catalogue) == travel_to_yield(standard, catalogue) is not None
    wrong = Catalogue.load([own_table("Music Wire ASTM A228", rate=16.83)])
    assert wrong.find_spring("Y0").state == "contradiction"


def test_a_spring_of_unknown_strength_is_no_candidate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its yield cannot be checked; A230 has a modulus, but no strength."""
    monkeypatch.chdir(tmp_path)
    springs = Catalogue.load([own_table("unobtainium", "musik wire", "A230")])
    assert [springs.find_spring(part).choosable for part in ("Y0", "Y1", "Y2")] == [False, False, False]
    assert springs.find_spring("Y0").status == 'incomplete: material "unobtainium" is not a known wire material'
    assert "did you mean music wire" in springs.find_spring("Y1").status
    assert "no strength" in springs.find_spring("Y2").status


def test_what_an_import_calls_usable_passes_the_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The row of 302 was the usable one, and refused by the check."""
    monkeypatch.chdir(tmp_path)
    head = "Part Number,Wire Dia. (mm),O.D. (mm),Leg Angle (deg),Spring Rate (N*m/rad),Coils,Material\n"
    rows = "A1,2,15.47,120,1.5,2.1667,Stainless Steel 302\nA2,2,15.47,120,1.683,2.1667,unobtainium\n"
    Path("vendor.csv").write_text(head + rows)
    assert main(["-q", "catalog", "import", "vendor.csv", "--vendor", "Acme", "--out", "mine"]) == 0
    said = capsys.readouterr().out
    assert "2 rows, 1 usable" in said
    assert 'A2: not usable, incomplete: material "unobtainium" is not a known wire material' in said
    assert [problem.line for problem in check_catalogue([Path("mine/acme.csv")])] == [3]
