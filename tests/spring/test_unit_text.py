"""Sentences with quantities: metric as text, converted on the screen, whole through every join."""

from __future__ import annotations

import json
import pickle

from synth.files.shown_units import METRIC, ShownUnits
from synth.spring.unit_text import MeasuredText, UnitText, in_units, join_texts

INCH = ShownUnits("inch")


def test_a_sentence_is_metric_text_and_is_converted_as_a_whole() -> None:
    limit = UnitText("diameter ", MeasuredText(0.0254, "m"), ", allowed ", MeasuredText(0.0127, "m"))
    stress = UnitText("stress ", MeasuredText(6.894757e9, "Pa"), f" in {3} coils")
    text = join_texts("; ", [UnitText("has ", limit), "nothing else", stress])
    assert text == "has diameter 25.4 mm, allowed 12.7 mm; nothing else; stress 6895 MPa in 3 coils"
    assert in_units(text, METRIC) == text
    assert in_units(text, INCH) == "has diameter 1 in, allowed 0.5 in; nothing else; stress 1000 kpsi in 3 coils"
    assert in_units("plain, 3 mm", INCH) == "plain, 3 mm"
    assert json.loads(json.dumps([text])) == [str(text)]
    assert in_units(pickle.loads(pickle.dumps(text)), INCH) == in_units(text, INCH)


def test_a_number_reads_differently_from_its_limit_in_either_unit() -> None:
    value, limit = 0.0200001, 0.02
    found = UnitText(MeasuredText(value, "m", beside=limit), " of ", MeasuredText(limit, "m", beside=value))
    for shown, unit in ((METRIC, "mm"), (INCH, "in")):
        left, right = in_units(found, shown).split(" of ")
        assert left != right
        assert left.endswith(unit)
        assert right.endswith(unit)
    assert UnitText(MeasuredText(4.0, "1", beside=3.0)) == "4"


def test_a_stored_text_still_converts() -> None:
    text = UnitText("diameter ", MeasuredText(0.0254, "m", beside=0.0127), " of 3 coils")
    again = UnitText.from_data(json.loads(json.dumps(text.as_data())))
    assert again == text
    assert in_units(again, INCH) == in_units(text, INCH) != text
