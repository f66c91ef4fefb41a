"""A part's price: a number of 0 or more with one currency, in the user's table and in the list of parts."""

from __future__ import annotations

from pathlib import Path

import pytest

from synth.errors import UserError
from synth.parts.catalogs import Catalogue, check_catalogue
from synth.parts.price import CURRENCIES, SIGNS, price

HEAD = "part,vendor,material,hand,included_angle [deg],rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],"


@pytest.mark.parametrize(
    ("text", "currency", "read"),
    [
        ("12.50 EUR", "", "12.50 EUR"),
        ("EUR 12.50", "", "12.50 EUR"),
        ("eur12.50", "", "12.50 EUR"),
        ("€12.50", "", "12.50 EUR"),
        ("$12.50 USD", "", "12.50 USD"),
        ("US$ .5", "", ".5 USD"),
        ("12.50", "EUR", "12.50 EUR"),
        ("12.50 EUR", "EUR", "12.50 EUR"),
        ("$12.50", "CAD", "12.50 CAD"),
        ("0", "JPY", "0 JPY"),
    ],
)
def test_a_price_is_a_number_with_one_currency(text: str, currency: str, read: str) -> None:
    assert price(text, currency) == read


@pytest.mark.parametrize(
    ("text", "currency", "said"),
    [
        ("-3", "EUR", '"-3" must be at least 0'),
        ("−3 EUR", "", "must be at least 0"),
        ("abc", "EUR", "leave the cell empty if it is not known"),
        ("nan EUR", "", "is not a price"),
        ("12.50 USD", "EUR", "is in USD, its column in EUR"),
        ("$12.50", "EUR", "is in \\$, its column in EUR"),
        ("12,50 USD", "EUR", "decimals take a point, not a comma: write 12.50 USD"),
        ("1,250.00 EUR", "", "leave the commas out: 1250.00 EUR"),
        ("12.50", "", "has no currency: write it like 12.50 EUR, or the header like price \\[EUR\\]"),
        ("$12.50", "", "the sign of several currencies; write it like 12.50 USD"),
        ("EUR 3 USD", "", "has two currencies"),
        ("3 EUT", "", "did you mean EUR?"),
        ("3 per piece", "EUR", "is not a price"),
    ],
)
def test_any_other_price_is_refused(text: str, currency: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        price(text, currency)


def test_every_sign_stands_for_codes_of_the_list() -> None:
    assert all(code in CURRENCIES for codes in SIGNS.values() for code in codes)
    assert all(len(code) == 3 for code in CURRENCIES)


def test_prices_of_a_table_are_checked_with_line_and_column(tmp_path: Path) -> None:
    """-3, abc and another currency were read, and stood in the list of parts as "'-3 EUR" and "12.50 USD EUR"."""
    path = tmp_path / "mine.csv"
    row = ",Mine,music wire,right,120,1.15,2.7,23,6.1667,"
    rows = "".join(f"X{k}{row}{cell}\n" for k, cell in enumerate(("-3", "12.50 USD", "abc", "12.50", "")))
    path.write_text(HEAD + "body_coils [1],price [EUR]\n" + rows, encoding="utf-8")
    problems = check_catalogue([path])
    assert [(problem.file, problem.line, problem.key) for problem in problems] == [
        (str(path), line, "price [EUR]") for line in (2, 3, 4)
    ]
    path.write_text(HEAD + "body_coils [1],Price (€)\n" + f"X1{row}12.50\nX2{row}\n", encoding="utf-8")
    catalogue = Catalogue.load([path])
    assert [catalogue.find_spring(part).price for part in ("X1", "X2")] == ["12.50 EUR", ""]


def test_a_header_s_currency_is_checked(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text("part,rate [N*m/rad],price [each]\nX1,1,3\n", encoding="utf-8")
    with pytest.raises(UserError, match=r'mine\.csv:1: price: "each" is no currency'):
        Catalogue.load([path])
