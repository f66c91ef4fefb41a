"""Parts by vendor: only those named, in any case of letters; a family that they do not sell stays whole."""

from __future__ import annotations

import pytest

from synth.files.project_options import PartsOptions, SpringChoice
from synth.parts.catalogs import Catalogue
from synth.parts.part_candidates import of_family, spring_reasons

SPRINGS = Catalogue.load().springs


def reasons(vendors: tuple[str, ...], without: tuple[str, ...] = ()) -> dict[str, list[str]]:
    """Part -> why it is left out, every part asked with the same options."""
    parts = of_family(PartsOptions(vendors=vendors, without=without), SPRINGS)
    return {f"{row.vendor} {row.part}": list(spring_reasons(row, SpringChoice(), None, parts)) for row in SPRINGS}


def test_every_row_of_other_vendors_is_left_out_and_none_of_the_named_one() -> None:
    names = sorted({row.vendor for row in SPRINGS})
    assert len(names) > 1
    for name in names:
        found = reasons((name.upper(),))
        out = {part for part, why in found.items() if any(text.startswith("not of") for text in why)}
        # An incomplete row only lists what it lacks: it cannot be chosen.
        assert out == {f"{row.vendor} {row.part}" for row in SPRINGS if row.vendor != name and row.choosable}


def test_a_vendor_that_sells_no_springs_keeps_none_out() -> None:
    assert reasons(("maker of dampers only",)) == reasons(())


def test_an_excluded_part_is_left_out_alone() -> None:
    row = SPRINGS[0]
    found = reasons((), (row.part.lower(),))
    out = {part for part, why in found.items() if "excluded by select.without" in why}
    assert out == {f"{other.vendor} {other.part}" for other in SPRINGS if other.part.casefold() == row.part.casefold()}


@pytest.mark.parametrize("count", [1, 2])
def test_the_filter_names_the_requested_vendors(count: int) -> None:
    names = tuple(sorted({row.vendor for row in SPRINGS}))[:count]
    other = next(row for row in SPRINGS if row.vendor not in names)
    said = next(iter(spring_reasons(other, SpringChoice(), None, PartsOptions(vendors=names))))
    assert said == f"not of {' or '.join(names)}"
