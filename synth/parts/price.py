"""The price of a part: a number of 0 or more with one currency, ``12.50 EUR``."""

from __future__ import annotations

import re

from synth.errors import did_you_mean
from synth.units_spelling import comma_mend, plain_signs

# ISO 4217, as in Debian's iso-codes 4.15, without metals, funds' units and codes for tests.
_CODES = (
    "AED AFN ALL AMD ANG AOA ARS AUD AWG AZN BAM BBD BDT BGN BHD BIF BMD BND BOB BRL BSD BTN BWP BYN BZD CAD CDF CHF "
    "CLP CNY COP CRC CUC CUP CVE CZK DJF DKK DOP DZD EGP ERN ETB EUR FJD FKP GBP GEL GHS GIP GMD GNF GTQ GYD HKD HNL "
    "HRK HTG HUF IDR ILS INR IQD IRR ISK JMD JOD JPY KES KGS KHR KMF KPW KRW KWD KYD KZT LAK LBP LKR LRD LSL LYD MAD "
    "MDL MGA MKD MMK MNT MOP MRU MUR MVR MWK MXN MYR MZN NAD NGN NIO NOK NPR NZD OMR PAB PEN PGK PHP PKR PLN PYG QAR "
    "RON RSD RUB RWF SAR SBD SCR SDG SEK SGD SHP SLE SLL SOS SRD SSP STN SVC SYP SZL THB TJS TMT TND TOP TRY TTD TWD "
    "TZS UAH UGX USD UYU UZS VED VES VND VUV WST XAF XCD XOF XPF YER ZAR ZMW ZWL"
)
CURRENCIES = frozenset(_CODES.split())
# What a sign may mean; one with several meanings needs the code in the column's header.
SIGNS = {
    "€": ("EUR",), "£": ("GBP",), "US$": ("USD",), "¥": ("JPY", "CNY"),
    "$": ("USD", "AUD", "CAD", "HKD", "MXN", "NZD", "SGD", "TWD"),
}  # fmt: skip
_PRICE = re.compile(r"([^\d.,+\-\s]*)\s*(\d+(?:\.\d*)?|\.\d+)\s*([^\d.,+\-\s]*)")
_NEGATIVE = re.compile(r"\D*-\s*[\d.,]+\D*")


def price(text: str, currency: str = "") -> str:
    """A price as number and ISO 4217 code, the number as written.

    Parameters
    ----------
    text : ``12.50``, ``12.50 EUR``, ``EUR 12.50`` or ``€12.50``.
    currency : code of the column's currency, empty if its header has none.

    Raises
    ------
    ValueError
        If it is no number of 0 or more, its currency is missing, ambiguous or unknown, or it is not the column's.
    """
    plain = plain_signs(text)
    found = _PRICE.fullmatch(plain)
    if found is None:
        if _NEGATIVE.fullmatch(plain):
            raise ValueError(f'"{text}" must be at least 0')
        known = "; leave the cell empty if it is not known" if not any(c.isdigit() for c in plain) else ""
        mend = comma_mend(plain.lstrip("".join(SIGNS))) or known
        raise ValueError(f'"{text}" is not a price: write one number and one currency, such as 12.50 EUR{mend}')
    before, number, after = found.groups()
    meanings = [_meanings(word) for word in (before, after) if word]
    possible = [code for code in meanings[0] if all(code in other for other in meanings)] if meanings else []
    if meanings and not possible:
        raise ValueError(f'"{text}" has two currencies; write one, such as {number} {meanings[-1][0]}')
    if currency:
        if meanings and currency not in possible:
            raise ValueError(
                f'"{text}" is in {before or after}, its column in {currency}: write the price in {currency}, or leave '
                "the currency out of the header and write it into each cell"
            )
        return f"{number} {currency}"
    if not possible:
        raise ValueError(f'"{text}" has no currency: write it like {number} EUR, or the header like price [EUR]')
    if len(possible) > 1:
        raise ValueError(
            f'"{text}": {before or after} is the sign of several currencies; write it like {number} {possible[0]}, or '
            f"the header like price [{possible[0]}]"
        )
    return f"{number} {possible[0]}"


def currency_code(text: str) -> str:
    """The ISO 4217 code of a header's currency: ``EUR`` for ``EUR``, ``eur`` or ``€``.

    Raises
    ------
    ValueError
        If it is unknown, or a sign of several currencies.
    """
    codes = _meanings(text.strip())
    if len(codes) > 1:
        raise ValueError(f'"{text}" is the sign of several currencies: write a code, such as price [{codes[0]}]')
    return codes[0]


def _meanings(word: str) -> tuple[str, ...]:
    """The codes that a code or sign may mean."""
    code = word.upper()
    if code in CURRENCIES:
        return (code,)
    if code in SIGNS:
        return SIGNS[code]
    near = did_you_mean(word, sorted(CURRENCIES))
    raise ValueError(f'"{word}" is no currency{near or "; write a code of ISO 4217, such as EUR or USD"}')
