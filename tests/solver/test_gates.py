"""Where numbers come in: units, shapes and kinds, and that nothing is changed on the way."""

import math

import numpy as np
import pytest
from astropy import units as u
from astropy.table import Column, QTable

from attitude import AttitudeError
from attitude._support import validation

UNKNOWN = u.Unit("furlongs", parse_strict="silent")


@pytest.mark.parametrize(
    "value",
    [
        (1, 2.5, 3),
        [1.0, 2.5, 3.0],
        np.array([1.0, 2.5, 3.0], dtype=np.float32),
        np.ma.masked_array([1.0, 2.5, 3.0], mask=False),
        [1000, 2500, 3000] * u.mm,
        (1 * u.m, 250 * u.cm, 0.003 * u.km),
        ("1 m", "250 cm", "0.003 km"),
        ["1 m", "2.5 m", 3 * u.m],
        QTable({"x": [1, 2.5, 3] * u.m})["x"],
        [1, 2.5, 3] * u.dimensionless_unscaled,
    ],
)
def test_numbers_of_any_kind_become_float64_in_si(value):
    array = validation.real(value, "value", shape=(3,), unit="m")
    assert type(array) is np.ndarray and array.dtype == np.float64
    assert np.allclose(array, (1.0, 2.5, 3.0), rtol=3e-16)
    array[0] = 7.0  # a new array, that the caller may keep


def test_numbers_whose_sum_overflows_are_finite():
    few = [1.7e308, 1.7e308, 1.0]
    assert validation.real(few, "few").tolist() == few
    for bad in (math.nan, math.inf):
        with pytest.raises(AttitudeError, match=f"few holds {bad}"):
            validation.real([*few, bad], "few")


def test_a_gate_never_changes_a_value():
    given = np.array([0.1, -0.0, 5e-324, 1.7976931348623157e308])
    assert validation.real(given, "given").tobytes() == given.tobytes()
    assert validation.real([2**53 - 1, -(2**53)], "given").tolist() == [2**53 - 1, -(2**53)]
    given[0] = 5.0
    assert validation.rows(given, "given", 4) is given
    assert validation.seconds(given, "given") is given


@pytest.mark.parametrize(
    ("value", "options", "message"),
    [
        (None, {}, "x is None; give real numbers"),
        ("five", {}, "x is 'five', which is not a number with a unit"),
        (
            ("1 m", "2 s"),
            {"unit": "m"},
            "x is .* not numbers with units that convert",
        ),
        (("1 m", 2), {"unit": "m"}, "x is"),
        (1j, {}, "x is 1j; give real numbers"),
        (True, {}, "x is True; give real numbers"),
        ([[1, 2], [3]], {}, "x is ragged; give an array with rows of equal length"),
        ([1, None], {}, "give real numbers"),
        ({}, {}, "give real numbers"),
        (np.array(["2026"], dtype="datetime64[s]"), {}, "give real numbers"),
        (1 * u.kg, {"unit": "m"}, "x is in kg; give it in m or a unit that converts to it"),
        (1 * u.kg, {}, "x is in kg; it must be a pure number"),
        (1 * u.mag, {"unit": "m"}, "x is in mag; give it in m or a unit"),
        (1 * u.ABmag, {"unit": "rad"}, r"x is in mag\(AB\); give it in rad or a unit"),
        # As astropy keeps a unit of a file that it does not know.
        (u.Quantity(1, UNKNOWN), {"unit": "m"}, "x is in furlongs; give it in m or a unit"),
        (u.Quantity(1, UNKNOWN), {}, "x is in furlongs; it must be a pure number"),
        (Column([1.0], unit=UNKNOWN), {"unit": "m"}, "x is in furlongs; give it in m"),
        (math.nan, {}, "x holds nan; every number in it must be finite"),
        ([1, -math.inf], {}, "x holds -inf"),
        ([1, 2], {"shape": (3,)}, r"x has shape \(2,\); give \(3\)"),
        ([1, 2], {"shape": ()}, r"x has shape \(2,\); give a single number"),
        (1.0, {"shape": (..., 3)}, r"x is one number; give \(..., 3\)"),
        (np.ma.masked_array([1.0, 2.0], mask=[0, 1]), {}, "x has masked entries"),
    ],
)
def test_what_is_no_number_is_told(value, options, message):
    with pytest.raises(AttitudeError, match=message):
        validation.real(value, "x", **options)


def test_rows():
    assert validation.rows([[1, 2, 3]], "x", 3).shape == (1, 3)
    assert np.isnan(validation.rows((math.nan, 1, 2), "x", 3)[0])  # the compiled solution tells
    with pytest.raises(AttitudeError, match=r"x has shape \(2,\); give \(..., 3\)"):
        validation.rows((1, 2), "x", 3)
    with pytest.raises(AttitudeError, match=r"x has shape \(\)"):
        validation.rows(1.0, "x", 3)


def test_seconds():
    assert validation.seconds(1.5, "t").shape == ()
    assert validation.seconds(np.float64(1.5), "t") == 1.5
    assert validation.seconds([1, 2] * u.h, "t").tolist() == [3600.0, 7200.0]
    assert validation.seconds("2 min", "t") == 120.0
    assert np.isnan(validation.seconds([1.0, math.nan], "t")[1])


def test_one_number():
    assert validation.number("2 km", "x", unit="m") == 2000.0
    assert validation.positive(np.float32(0.5), "x") == 0.5
    for value in (0.0, -1.0):
        with pytest.raises(AttitudeError, match=f"x is {value}; it must be greater than zero"):
            validation.positive(value, "x")


def test_one_of():
    assert validation.one_of("a", "x", ("a", "b")) == "a"
    with pytest.raises(AttitudeError, match="x is 'c'; it must be one of 'a', 'b'"):
        validation.one_of("c", "x", ("a", "b"))
    with pytest.raises(AttitudeError, match="must be one of"):
        validation.one_of(["a"], "x", ("a", "b"))


def test_long_values_are_shortened():
    with pytest.raises(AttitudeError) as caught:
        validation.real(["x" * 1000], "x")
    assert len(str(caught.value)) < 200


def test_one_grammar_of_text():
    """Several numbers before one unit, as in files and on the command line."""
    np.testing.assert_allclose(
        validation.real("298, -58 deg", "pole", shape=(2,), unit="rad"), np.radians([298, -58])
    )
    assert validation.real("3 d", "t", unit="s") == 259200.0
    np.testing.assert_allclose(
        validation.real(["250 deg", "-75 deg"], "pole", unit="deg"), [250.0, -75.0]
    )


@pytest.mark.parametrize("text", ["3 furlongs", "3 kg", "three"])
def test_no_error_of_astropy_in_the_traceback(text):
    with pytest.raises(AttitudeError) as raised:
        validation.real(text, "t", unit="s")
    error = raised.value
    assert error.__cause__ is None
    assert error.__context__ is None or error.__suppress_context__
