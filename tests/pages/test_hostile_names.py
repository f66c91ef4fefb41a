"""Names with markup and script stay text in a real browser."""

from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType
from typing import Any

from pages.browser import opened

WICKED = "</script><img src=x onerror=\"document.title='caught'\">"


def test_names_with_markup_run_no_script(browser: Any, made: ModuleType, tmp_path: Path) -> None:
    from synth.reports import write_leg_report

    joints = [WICKED.replace("/", "|"), "knee", "a]b\"'c"]
    design = made.make_design(tmp_path / "leg", joints=joints, trials=2, name=WICKED)
    design["warnings"] = [
        {"joint": joints[0], "text": f"it may break {WICKED}", "severity": "decide", "remedy": WICKED},
        {"joint": None, "text": WICKED},
    ]
    for joint in design["joints"].values():
        joint["damper"]["part"] = WICKED
    made.write_json(tmp_path / "leg" / "design.json", design)
    page = {
        "format": "synth/page/1",
        "leg": {"tilt": 0.0, "joints": [
            {"name": name, "zero": 180.0, "sign": 1, "length": 0.2, "rest": 170.0, "range": [90.0, 200.0], "rate": 2.0,
             "rotation": -0.1, "damper": {"rate": 0.1}} for name in joints
        ]},
        "replay": {"unsupported": [], "of": 1, "releases": [
            {"name": WICKED, "time": [0.0, 0.1, 0.2], "rotation": [0.1, 0.2, 0.1], "rate": [0.0, 0.0, 0.0],
             "locked": [], "tilt": 0.0, "inertia": [[0.03, 0.01, 0.002], [0.01, 0.01, 0.002], [0.002, 0.002, 0.001]],
             "gravity": [1.0, 0.4, 0.1], "wanted": [[170.0, 171.0, 172.0]] * 3}
        ]},
        "joints": {name: {"holding": {"rotation": -0.2, "torque": 0.1},
                          "springs": [{"part": WICKED, "vendor": WICKED, "rate": 2.0, "error": 1.0, "outer_mm": None,
                                       "stress_per_torque": None, "allowed_mpa": None, "choice": WICKED}],
                          "dampers": [{"part": WICKED, "law": WICKED, "error": 1.0, "spring_rate": None, "rate": 0.1,
                                       "choice": WICKED}]} for name in joints},
    }  # fmt: skip
    (tmp_path / "leg" / "page.json").write_text(json.dumps(page))
    path = write_leg_report(tmp_path / "leg")
    for size in ("wide", "narrow"):
        with opened(browser, path, size) as found:
            found.page.locator("#swap-parts[data-error]").wait_for(state="attached")
            found.page.locator("details#built .plot").first.hover()
            assert found.page.title() != "caught"
            assert found.page.locator("img[src=x]").count() == 0
            assert WICKED in found.page.locator("h1").text_content()
            assert found.page.locator("#swap-parts select").nth(1).locator("option").first.text_content().count(WICKED)
            assert not found.said, found.said
            assert not [url for url in found.asked if not url.startswith(("file:", "data:"))]
