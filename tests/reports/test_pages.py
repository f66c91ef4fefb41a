"""Whole pages: self-contained, repeatable, safe with any name, complete without optional parts."""

from __future__ import annotations

import ast
import base64
import hashlib
import json
import pickle
import re
import shutil
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from page_reader import check_words, drawings, page_of
from synth import reports
from synth.batch.folder_summary import fit_columns, fit_entry
from synth.files.kept_templates import FOLDER, KeptTemplates, kept_templates
from synth.remarks import about, decisive, noted, of_joint, read_remark, remark_json, severity_of
from synth.reports import ReportError, write_fit_report, write_leg_report
from synth.reports.many_pages import write_fits_report
from synth.reports.page import environment
from synth.reports.reading import read_result
from synth.reports.sections.warnings import warnings_of
from synth.reports.severity import foremost, warning_of

Json = dict[str, Any]
LegFolder = Callable[..., tuple[Path, Json]]
FitFolder = Callable[[list[str], int], tuple[Path, Json]]


def test_leg_page_needs_nothing_outside_itself(leg_folder: LegFolder) -> None:
    folder, _ = leg_folder()
    html, page = page_of(write_leg_report(folder))
    assert all(link.startswith("#") and link[1:] in page.ids for link in page.links)
    assert len(set(page.ids)) == len(page.ids)
    assert page.sources
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert not page.tags & {"link", "iframe", "object", "embed", "base", "form"}
    rest = re.sub(r"<title>.*?</title>|<script>.*?</script>", "", html, flags=re.S)
    assert not re.search(r"url\(|@import|https?://", rest)
    assert "default-src 'none'" in html


def test_a_page_with_a_store_of_templates_leaves_others_without(
    fit_folder: FitFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    folder, _ = fit_folder(["knee"], 1)
    plain = write_fit_report(folder).read_bytes()
    assert not (tmp_path / "cache").exists()
    assert write_fit_report(folder, KeptTemplates()).read_bytes() == plain
    assert any((tmp_path / "cache" / FOLDER).iterdir())
    assert environment().bytecode_cache is None
    assert environment(kept_templates()).bytecode_cache is kept_templates()


def test_pairs_that_fit_equally_well_stand_in_a_table(fit_folder: FitFolder) -> None:
    folder, fit = fit_folder(["hip", "knee"], 3)
    html, page = page_of(write_fit_report(folder))
    assert "hip: springs and dampers that fit about equally well" in page.text
    table = html.split("that fit about equally well</h3>")[1].split("</table>")[0]
    assert table.count("<tr") == 1 + len(fit["families"][0]["members"])
    assert table.count(", reported") == 1


@pytest.mark.parametrize(("ends", "said"), [((1.0, 3.0), "1.0 to 3.0"), ((0.0, 43.0), "0 to 43")])
def test_the_least_certain_rate_is_told_by_the_interval_of_the_table(
    fit_folder: FitFolder, ends: tuple[float, float], said: str
) -> None:
    """The page said: known to ±1262 %, and beside 0.064 to 0.76: not known."""
    folder, fit = fit_folder(["hip", "knee"], 3)
    fit["joints"]["knee"]["damper_rate"] = {"value": 2.0, "unit": "N*m*s/rad", "interval90": list(ends)}
    (folder / "fit.json").write_text(json.dumps(fit))
    _, page = page_of(write_fit_report(folder))
    words = page.text.replace("\u00a0", " ")
    assert f"Least certain: the knee's damper rate, {said} N·m·s/rad (90 %)." in words
    assert words.count(f"{said}") > 1  # the table below


def test_the_opening_comes_first_and_settings_last(leg_folder: LegFolder) -> None:
    folder, _ = leg_folder()
    html, page = page_of(write_leg_report(folder))
    order = "warnings built summary parts sets links spring-sheet damper-curves estimates motion checks pictures"
    order += " inputs files"
    shown = [name for name in page.ids if not re.fullmatch(r"E\d+|leg3d", name)]
    assert shown == [*order.split(), "equations"]
    assert "Left out" not in page.text
    assert html.count('<details class="section"') == len(shown) - 1
    assert re.findall(r'<details class="section" id="([^"]+)" open>', html) == ["built"]


def test_the_leg_s_opening_has_result_reliability_and_next_steps(leg_folder: LegFolder) -> None:
    folder, design = leg_folder()
    html, page = page_of(write_leg_report(folder))
    opening = html.split("<nav")[0].split("<body>")[1]
    text = " ".join(page.text.split("Wanted against built")[0].replace("\xa0", " ").split())
    assert "Not ready to build: no spring for the hip" in text  # the first joint's cannot be made
    assert "42 % of such legs stay within the allowed 3.00°" in text
    assert '<p class="next">' in opening
    assert opening.count('<th scope="row">') == len(design["joints"])
    shown, folded = opening.split('<details class="all-warnings">')
    assert 1 <= shown.count("<li>") <= 3
    found = warnings_of(read_result(folder, "design.json", "leg-design"))
    assert folded.count("<li>") == len(found)
    assert f"All {len(found)} warnings:" in page.text


def test_a_warning_s_level_is_the_one_it_was_raised_with() -> None:
    text = "it may break before 100 000 full turns"  # whose words alone say nothing
    assert warning_of("hip", text, "warnings[0]").level == "check"
    assert warning_of("hip", text, "warnings[0]", {"severity": "more than ever"}).level == "check"
    found = warning_of("hip", text, "warnings[0]", remark_json(decisive(text, "Take another.")))
    assert (found.level, found.remedy) == ("decide", "Take another.")
    assert warning_of("hip", text, "warnings[0]", remark_json(noted(text))).level == "note"


def test_of_many_warnings_three_kinds_stand_above_the_fold() -> None:
    texts = ["no single spring", *[f"it may break before {i} turns" for i in range(5)],
             *[f"the torque-speed law of 6597K{i} is assumed" for i in range(2)], "off the wanted motion"]  # fmt: skip
    stated = {"severity": "decide"}
    groups = foremost([warning_of(f"joint {i}", text, "", stated) for i, text in enumerate(texts)])
    assert [group.more for group in groups] == [0, 4, 1]
    assert groups[1].joints == tuple(f"joint {i}" for i in range(1, 6))


def test_a_remark_keeps_its_severity_through_prefixes_and_files() -> None:
    law = decisive("the law is assumed", "Record drops.")
    assert remark_json(about("hip", law)) == {
        "text": "hip: the law is assumed", "severity": "decide", "remedy": "Record drops."
    }  # fmt: skip
    assert severity_of(read_remark(remark_json(noted("thinned")))) == "note"
    assert severity_of(read_remark("an older file's text")) == "check"
    assert pickle.loads(pickle.dumps(law)).severity == "decide"


def test_a_remark_is_named_after_its_joint_once() -> None:
    found = [of_joint("hip", decisive("hip: it slips")), of_joint("hip", decisive("it slips")), of_joint(None, "30 s")]
    assert [str(text) for text in found] == ["hip: it slips", "hip: it slips", "30 s"]
    assert [severity_of(text) for text in found] == ["decide", "decide", "check"]


def test_only_the_page_s_own_scripts_may_run(leg_folder: LegFolder) -> None:
    folder, _ = leg_folder()
    html, _ = page_of(write_leg_report(folder))
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', html)
    assert policy
    assert "unsafe-inline" not in policy.group(1).split("script-src")[1]
    scripts = re.findall(r"<script>(.*?)</script>", html, re.S)
    assert scripts
    for text in scripts:
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy.group(1)


def test_same_input_gives_the_same_bytes_anywhere(leg_folder: LegFolder, tmp_path: Path) -> None:
    folder, _ = leg_folder()
    first = write_leg_report(folder).read_bytes()
    assert write_leg_report(folder).read_bytes() == first
    shutil.copytree(folder, tmp_path / "elsewhere")
    (tmp_path / "elsewhere" / "report.html").unlink()
    assert write_leg_report(tmp_path / "elsewhere").read_bytes() == first


def test_names_with_markup_stay_text(leg_folder: LegFolder) -> None:
    wicked = "<img src=x onerror=alert(1)>\"'&{{7*7}}"
    folder, design = leg_folder(joints=[wicked.replace("/", ""), "knee"], trials=2, name=f"</title><script>{wicked}")
    for joint in design["joints"].values():
        joint["damper"]["part"] = joint["warnings"][0] = wicked
        joint["left_out"] = {"springs": {wicked: 3}}
    design["joints"]["knee"]["spring"]["source"] = wicked
    design["stages"]["source"]["not_separable"] = [wicked]
    design["settings"]["time_scale"]["how"] = wicked
    design["settings"][wicked] = wicked
    design["defaults"][0] = {"key": wicked, "value": wicked, "why": wicked}
    design["versions"][wicked] = wicked
    design["pictures"][0]["caption"] = wicked
    design["files"].append({"path": wicked, "sha256": wicked})
    design["stages"]["source"]["trials"][0]["damping_ratio_validity"] = {"knee": wicked}
    design["stages"]["source"]["trials"][0]["damping_ratio"] = {"knee": {"value": 0.1, "unit": wicked}}
    (folder / "design.json").write_text(json.dumps(design))
    html, page = page_of(write_leg_report(folder))
    assert not page.events
    assert "<img src=x" not in html
    assert all(wicked not in text for text in re.findall(r"<script.*?</script>", html, re.S))
    assert unescape(page.text).count("<img src=x onerror=alert(1)>\"'&{{7*7}}") > 15
    assert drawings(html)


def test_the_page_says_what_is_estimated_from_held_out_trials(leg_folder: LegFolder) -> None:
    """With a free angle each, the trial's own is estimated too: the page said only the initial state."""
    folder, design = leg_folder()
    with_own = "its initial state and, within the spread of the fitted trials, its free angles are estimated"
    for mode, told in (("per_trial", with_own), ("common", "only its initial state is estimated")):
        design["stages"]["target"]["free_angle"]["mode"] = mode
        (folder / "design.json").write_text(json.dumps(design))
        _, page = page_of(write_leg_report(folder))
        assert f"predicted with the fitted rates; from each trial {told}." in unescape(page.text)


def test_every_key_that_a_caption_names_is_in_the_design(leg_folder: LegFolder) -> None:
    folder, design = leg_folder()
    _, page = page_of(write_leg_report(folder))
    keys = [code for code in page.codes if code.split(".")[0].split("[")[0] in design]
    assert len(keys) > 40
    assert not [key for key in keys if not _resolves(design, key)]


def _resolves(value: object, key: str) -> bool:
    """Whether a dotted key with ``[3]``, ``[*]`` and ``*`` leads to something."""
    if not key:
        return True
    head, _, rest = key.partition(".")
    name, _, index = head.partition("[")
    if name == "*":
        return isinstance(value, dict) and any(_resolves(item, rest) for item in value.values())
    if not isinstance(value, dict) or name not in value:
        return False
    found = value[name]
    if index:
        items = found if index == "*]" else found[int(index[:-1]) : int(index[:-1]) + 1]
        return any(_resolves(item, rest) for item in items)
    return _resolves(found, rest)


@pytest.mark.parametrize(
    "key",
    ["name", "versions", "inputs", "defaults", "settings", "stages", "held_out", "damper_laws", "joints", "links",
     "mass_rounds", "response", "warnings", "pictures", "files"],
)  # fmt: skip
@pytest.mark.parametrize("absent", ["missing", "null"])
def test_a_missing_part_leaves_the_rest(leg_folder: LegFolder, key: str, absent: str) -> None:
    folder, design = leg_folder(trials=2)
    design[key] = None
    if absent == "missing":
        del design[key]
    (folder / "design.json").write_text(json.dumps(design))
    _, page = page_of(write_leg_report(folder))
    assert "How each number is computed" in page.text
    said = {"joints": "design.json names no part", "pictures": "names no picture", "files": "lists no file"}
    if key in said:
        assert "Left out" in page.text
        assert said[key] in page.text


def test_what_trials_cannot_tell_apart_is_a_warning_alone_and_in_a_folder(
    fit_folder: FitFolder, tmp_path: Path
) -> None:
    folder, fit = fit_folder(["hip", "knee"], 2)
    told = "not separable: mass scale, from free swings alone"
    fit |= {"warnings": [], "remarks": [], "not_separable": [told]}
    (folder / "fit.json").write_text(json.dumps(fit))
    assert [warned.text for warned in warnings_of(read_result(folder, "fit.json", "fit"))] == [told]

    many = tmp_path / "many"
    many.mkdir()
    content = {"format": "synth/fits/1", "legs": [fit_entry("rig", folder)], "failed": []}
    assert set(fit_columns(content)["warnings"]) == {1}
    (many / "fits.json").write_text(json.dumps(content))
    text = " ".join(page_of(write_fits_report(many))[1].text.split())
    assert "1 of the fits has warnings." in text
    assert told in text


@pytest.mark.parametrize("last_head", ["From wanted, RMS", "Built minus wanted, rms"])
def test_the_free_angle_beside_the_chosen_spring_is_the_built_legs(leg_folder: LegFolder, last_head: str) -> None:
    """Arm offset and built.leg.yaml belong to it; the refit's and the wanted motion's are other numbers."""
    folder, design = leg_folder()
    html, _ = page_of(write_leg_report(folder))
    shown = html[html.index(f">{last_head}</th>") :].split("</table>")[0]
    for joint in design["joints"].values():
        assert f"{joint['spring']['free_angle']['value']:g}°" in shown
        assert f"{joint['refit']['free_angle']['value']:g}°" not in shown
        assert f"{joint['wanted']['free_angle']['value']:g}°" not in shown


def test_an_empty_design_has_a_page(tmp_path: Path) -> None:
    (tmp_path / "design.json").write_text('{"format": "synth/leg-design/1"}')
    _, page = page_of(write_leg_report(tmp_path))
    for title in ("The design in short", "Chosen parts", "Springs to make", "Files", "Measured against fitted motion"):
        assert f"{title} :" in page.text


def test_many_trials_show_the_worst_and_the_best(fit_folder: FitFolder) -> None:
    folder, fit = fit_folder(["hip", "knee"], 40)
    for index, trial in enumerate(fit["trials"]):
        trial["rms"] = {joint: {"value": 0.1 + 0.01 * ((index * 17) % 40), "unit": "deg"} for joint in ("hip", "knee")}
    (folder / "fit.json").write_text(json.dumps(fit))
    html, page = page_of(write_fit_report(folder))
    ranked = sorted(fit["trials"], key=lambda trial: -trial["rms"]["hip"]["value"])
    expected = {trial["file"] for trial in [*ranked[:8], *ranked[-4:]]}
    drawn = {found.split(" (")[0] for found in re.findall(r'figcaption class="above">(trials[^<]*)', html)}
    assert drawn == expected
    assert "12 of 40 trials are drawn" in page.text
    assert all(trial["file"] in page.text for trial in fit["trials"])


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6])
def test_no_words_leave_their_drawing(fit_folder: FitFolder, count: int) -> None:
    folder, _ = fit_folder([f"joint with a rather long name {i}" for i in range(count)], 2)
    html, _ = page_of(write_fit_report(folder))
    found = drawings(html)
    # two trials and the worst of them in the opening, a drawing a joint; swatches; the free angle's variants compared
    assert len(found) == 3 * count + 2 * 2 + 1
    for drawing in found:
        check_words(drawing)


def test_no_words_leave_the_drawings_of_a_leg(leg_folder: LegFolder) -> None:
    folder, _ = leg_folder()
    html, _ = page_of(write_leg_report(folder))
    for drawing in drawings(html):
        check_words(drawing)


def test_axes_carry_units_and_panels_their_rms(fit_folder: FitFolder) -> None:
    folder, _ = fit_folder(["hip", "knee"], 1)
    html, _ = page_of(write_fit_report(folder))
    words = [text.text or "" for drawing in drawings(html.split("<main>")[1]) for text in drawing.iter("text")]
    assert "hip angle [°]" in words
    assert words.count("time [s]") == 2
    assert "rms 0.300°" in words


def test_a_lost_response_file_is_named(fit_folder: FitFolder) -> None:
    folder, _ = fit_folder(["hip"], 3)
    (folder / "responses" / "source" / "free_2.csv").unlink()
    _, page = page_of(write_fit_report(folder))
    assert "so not drawn: trials/free_2.csv" in page.text


def test_pictures_outside_the_folder_are_not_read(leg_folder: LegFolder, tmp_path: Path) -> None:
    folder, design = leg_folder(trials=1)
    secret = tmp_path / "secret.png"
    secret.write_bytes((folder / "parts" / "knee.png").read_bytes())
    (folder / "link.png").symlink_to(secret)
    design["pictures"] = [{"path": name} for name in ("../secret.png", "link.png", str(secret), "none.png")]
    (folder / "design.json").write_text(json.dumps(design))
    _, page = page_of(write_leg_report(folder))
    assert not page.sources
    assert "not a PNG in the folder: ../secret.png, link.png" in page.text


@pytest.mark.parametrize(
    ("content", "said"),
    [("{", "not valid JSON"), ("[]", "its format is None"), ('{"format": "synth/fit/1"}', "synth/leg-design/1")],
)
def test_a_damaged_design_is_refused(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / "design.json").write_text(content)
    with pytest.raises(ReportError, match=said):
        write_leg_report(tmp_path)
    assert not (tmp_path / "report.html").exists()


def test_a_missing_design_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ReportError, match="is missing"):
        write_leg_report(tmp_path)


def test_reports_import_nothing_from_synth_and_no_plotting_library() -> None:
    for path in Path(reports.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not {name.split(".")[0] for name in names} & {"matplotlib", "numpy", "pandas"}, path
            assert all(name.startswith("synth.reports") for name in names if name.split(".")[0] == "synth"), path


def test_sets_show_the_expected_error_and_its_causes(leg_folder: LegFolder) -> None:
    folder, design = leg_folder()
    _, page = page_of(write_leg_report(folder))
    text = " ".join(page.text.split())
    assert "the probability of staying within the allowed 3.00° is 42 %" in text.replace("\xa0", " ")
    assert "hip: free angle" in text
    assert "Measure the springs first." in text
    assert "1,200 sets of parts met the constraints; every one was simulated." in text
    assert "instead, another rate" in text
    assert "costs +0.30°" in text
    del design["response"]["forecast"]
    (folder / "design.json").write_text(json.dumps(design))
    _, page = page_of(write_leg_report(folder))
    assert "Sets of parts under tolerance :" in page.text
    assert "sets" not in page.ids
