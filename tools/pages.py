"""Write every command's page from the built-in examples and open it in a real browser, which takes a picture.

``make pages`` keeps the results of an earlier run and rewrites only their pages from the present templates; ``--fresh``
computes the results again.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TESTS = ROOT / "tests"
EXAMPLES = ROOT / "synth" / "examples"
SLOWEST = 1500.0  # ms, aim for opening a page in a headless browser on two cores
REHEARSED = "8"  # cases: enough for a page with every table; a minute on two cores
SPRING = ["--rate", "1.7 N*m/rad", "--travel", "40 deg", "--included-angle", "120 deg", "--arbor", "12 mm"]


def commands(projects: Path, results: Path) -> dict[str, list[str]]:
    """Page name -> arguments of ``synth``; some use the results of earlier commands."""
    return {
        "leg": ["leg", str(projects / "leg" / "leg-design.yaml")],
        "fit": ["fit", str(projects / "fit" / "fit.yaml")],
        "gap": ["gap", str(projects / "gap" / "gap.yaml")],
        "hopper": ["hopper", str(projects / "hopper" / "hopper.yaml")],
        "jump-gap": ["gap", str(projects / "hopper" / "gap.yaml")],
        "fits": ["fit", str(projects / "many")],
        "gaps": ["gap", str(projects / "many-gaps")],
        "legs": ["leg", str(projects / "many-legs"), "--no-cad"],
        "spring": ["spring", *SPRING],
        "check": ["check", str(projects / "gap" / "nominal.leg.yaml")],
        "check-hopper": ["check", str(projects / "hopper" / "hopper.yaml")],
        "compare": [
            "compare",
            f"gap={results / 'gap'}",
            f"robot={projects / 'leg' / 'leg-design.yaml'}#animal,wanted",
        ],
        "truth": ["hopper", "--truth"],
        "import": ["import", str(projects / "import" / "import.yaml")],
        "gap-check": ["gap", "--check", str(projects / "gap" / "gap.yaml")],
        "rehearsal": ["gap", "--rehearse", str(projects / "gap" / "gap.yaml"), "--count", REHEARSED],
        "reproduction": ["reproduce", "jump"],
    }


def writers() -> dict[str, Callable[[Path], Path]]:
    """Page name -> function that writes it from its result folder."""
    from synth import reports
    from synth.reports import comparison_page, hopper_pages, many_pages, model_checks, reproduction

    return {
        "leg": reports.write_leg_report,
        "fit": reports.write_fit_report,
        "gap": reports.write_gap_report,
        "hopper": hopper_pages.write_hopper_report,
        "jump-gap": hopper_pages.write_jump_gap_report,
        "fits": many_pages.write_fits_report,
        "gaps": many_pages.write_gaps_report,
        "legs": many_pages.write_legs_report,
        "spring": reports.write_winding_sheet,
        "check": model_checks.write_checks_report,
        "check-hopper": model_checks.write_checks_report,
        "compare": comparison_page.write_comparison_report,
        "truth": hopper_pages.write_truth_report,
        "import": reports.write_import_report,
        "gap-check": reports.write_check_report,
        "rehearsal": reports.write_rehearsal_report,
        "reproduction": reproduction.write_reproduction_report,
    }


def make(to: Path, only: list[str], *, fresh: bool) -> None:
    """Write results of every command and their pages into ``to/results``."""
    projects, results = to / "projects", to / "results"
    if fresh:
        shutil.rmtree(to, ignore_errors=True)
    results.mkdir(parents=True, exist_ok=True)
    for example in ("leg", "fit", "gap", "hopper", "import"):
        shutil.copytree(EXAMPLES / example, projects / example, dirs_exist_ok=True)
    for folder, example in (("many", "fit"), ("many-gaps", "gap"), ("many-legs", "leg")):
        for name in ("first", "second"):
            shutil.copytree(EXAMPLES / example, projects / folder / name, dirs_exist_ok=True)
    for name, arguments in commands(projects, results).items():
        if only and name not in only:
            continue
        if (results / name).exists():
            writers()[name](results / name)
            continue
        print(f"{name}: synth {' '.join(arguments[:2])} ...", flush=True)
        command = [sys.executable, "-m", "synth", "-q", *arguments, "--out", str(results / name)]
        subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def opening_times(results: Path) -> str:
    """A table of size and opening time of each page; the shortest of three, because the machine may be busy."""
    # This file's folder is on the path; the tests' folder ``pages`` would be looked for in this module.
    sys.path[:] = [str(TESTS), *(each for each in sys.path if Path(each) != Path(__file__).parent)]
    from pages.browser import chromium, missing, opened

    if missing():
        return ""
    lines = [f"{'page':14} {'MB':>5} {'opens in':>9}"]
    with chromium() as browser:
        for path in sorted((*results.glob("*/report.html"), *results.glob("*/winding_sheet.html"))):
            times = []
            for _ in range(3):
                with opened(browser, path) as found:
                    found.page.wait_for_load_state("load")
                    times.append(float(found.audit()["opened"]))
            slow = "  too slow" if min(times) > SLOWEST else ""
            lines.append(f"{path.parent.name:14} {path.stat().st_size / 1e6:5.2f} {min(times) / 1e3:7.2f} s{slow}")
    return "\n".join(lines)


def main() -> int:
    """Write the pages and open them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, default=ROOT / "build" / "pages")
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="NAME", help=f"of {', '.join(commands(Path(), Path()))}"
    )
    parser.add_argument("--fresh", action="store_true", help="compute the results again too")
    arguments = parser.parse_args()
    to = arguments.to.resolve()
    make(to, arguments.only, fresh=arguments.fresh)
    where = {"PAGES_FROM": str(to / "results"), "PAGES_PICTURES": str(to)}
    tests = [sys.executable, "-m", "pytest", "tests/pages", "-n", "0", "-q"]
    status = subprocess.run(tests, cwd=ROOT, env={**os.environ, **where}, check=False).returncode
    print(opening_times(to / "results"))
    print(f"pictures: {to}/*.png")
    return status


if __name__ == "__main__":
    sys.exit(main())
