import copy
import json
import pickle

import numpy as np
import pytest

import squeakscope as s

FIELDS = {
    "name": "x",
    "curve": [1.0, 2.5],
    "lines": [{"frequency_hz": 1.0, "label": "f1"}, {"frequency_hz": 2.0, "label": None}],
    "inner": {"none": None},
    "pairs": [[1, 2], [3, 4]],
    "words": ["a", "b"],
}


def test_fields_are_attributes_that_cannot_be_changed() -> None:
    result = s.Result(copy.deepcopy(FIELDS))
    assert result.name == "x" and result.inner.none is None
    assert isinstance(result.curve, np.ndarray) and result.pairs.shape == (2, 2)
    assert result.lines[1].frequency_hz == 2.0 and result.words == ("a", "b")
    assert result.to_dict() == FIELDS
    assert json.loads(json.dumps(result.to_dict())) == FIELDS
    assert "curve" in dir(result) and result == s.Result(FIELDS)
    assert pickle.loads(pickle.dumps(result)) == result
    with pytest.raises(AttributeError, match="cannot be changed"):
        result.name = "y"
    with pytest.raises(ValueError, match="read-only"):
        result.curve[0] = 3.0
    with pytest.raises(AttributeError, match="it has name, curve"):
        result.absent


def test_a_long_result_has_a_short_text() -> None:
    event = {"frequency_hz": 1.0, "ridge": [{"time_s": float(k)} for k in range(1000)]}
    shown = repr(s.Result({"events": [event, event], "pairs": [[1.0] * 9, [2.0] * 9], "name": "x"}))
    assert shown == "Result(events=[2 results], pairs=[[9 values], [9 values]], name='x')"


def test_results_show_themselves_in_a_notebook() -> None:
    result = s.Result(FIELDS)
    assert "<th>name</th>" in result._repr_html_()
    table = result.lines._repr_html_()
    assert table.count("<tr>") == 3 and "frequency_hz" in table
    assert s.Result({"x": "<b>"})._repr_html_().count("<b>") == 0


def test_results_are_tables() -> None:
    pyarrow = pytest.importorskip("pyarrow")
    table = s.Result(FIELDS).lines.to_arrow()
    assert table.column_names == ["frequency_hz", "label"]
    assert pyarrow.table(s.Result(FIELDS).lines) == table


def test_estimates_are_an_array_with_half_widths() -> None:
    rates = s.Result({"rates": [{"value": 1.5, "half_width": 0.1}, {"value": -2.0, "half_width": 0.2}]}).rates
    assert rates.sum() == -0.5 and rates.tolist() == [1.5, -2.0] and rates.half_width.tolist() == [0.1, 0.2]


def test_arrays_become_lists_in_a_dictionary(run: s.Run) -> None:
    found = s.spectrum(run.u, run.scene.sample_rate)
    assert isinstance(found.to_dict()["amplitude"], list)
    assert found == copy.deepcopy(found)
