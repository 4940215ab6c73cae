"""The derivatives by the parameters of a fit, against central differences of the motion."""

import numpy as np
import pytest

from attitude import Body
from attitude.fitting._model import Model, Point
from attitude.frames import quaternion as forms
from attitude.frames import representations as frames_representations

WXYZ = np.array([1.0, -2.0, 3.0, 0.5]) / np.sqrt(14.25)
OMEGA = np.array([0.3, 0.2, 0.7])
T = np.linspace(0.0, 60.0, 31)
TENSOR = np.array([[2.0, 0.3, -0.2], [0.3, 2.5, 0.1], [-0.2, 0.1, 3.0]])
# Shapes of a free tensor: logarithms of the second moments of mass, and the other elements.
FREE = {
    "generic": (0.7, -0.2, 0.1, -0.3, 0.25),
    "sphere": (0.0, 0.0, 0.0, 0.0, 0.0),
    "symmetric about z": (0.4, 0.4, 0.0, 0.0, 0.0),
    "symmetric about x": (0.9, -0.45, 0.0, 0.0, 0.0),
    "symmetric about another axis": (-0.1, -0.1, 0.3, 0.3, 0.3),
    "nearly symmetric": (0.4, 0.4 + 1e-10, 1e-10, 0.0, 0.0),
    "beside the symmetric": (0.4, 0.4 + 1e-6, 1e-6, 0.0, 0.0),
}


def cases():
    for name, shape in FREE.items():
        yield pytest.param(Model(None, "free"), shape, id=f"free, {name}")
    for shape in ((0.7, -0.2), (0.0, 0.0), (0.4, 0.4)):
        yield pytest.param(Model(None, "principal"), shape, id=f"principal {shape}")
    yield pytest.param(Model(Body(tensor=TENSOR), "principal"), (), id="a known tensor")
    yield pytest.param(Model(Body(moments=(1, 2, 2.5)), "principal"), (), id="known moments")


def motion(model, point):
    """Attitudes of the body, and its angular velocities over the body axes."""
    found = model.predict(point, T, rates=True)
    to_body = forms.from_matrix(found.axes)
    wxyz = forms.multiply(found.wxyz, forms.conjugate(to_body))
    return wxyz, found.omega @ found.axes.T


def differences(model, point, k):
    """Derivatives of attitudes (ICRF axes) and rates by one parameter: five points, fourth order.

    The angle turned is 50 rad: the error is (50 h)^4 / 30 = 2e-11 of it, and rounding 1e-13 / h.
    """
    step = 1e-4 * np.eye(model.count)[k]
    wxyz = motion(model, point)[0]
    turns, rates = [], []
    for factor in (1.0, -1.0, 2.0, -2.0):
        there = motion(model, point.moved(factor * step))
        turn = forms.multiply(there[0], forms.conjugate(wxyz))
        turns.append(frames_representations.to_rotation_vector(turn))
        rates.append(there[1])
    return tuple((8.0 * (a - b) - (c - d)) / (12.0 * np.sum(step)) for a, b, c, d in (turns, rates))


@pytest.mark.parametrize(("model", "shape"), list(cases()))
def test_columns_are_those_of_differences(model, shape):
    point = Point(WXYZ, OMEGA, np.array(shape))
    found = model.predict(point, T, rates=True)
    # Derivatives at eigenvalues 3e-8 apart differ by that times the angle turned, 50 rad; those of
    # eigenvalues 1e-6 apart by 1e-13 / 1e-6.
    limit = 3e-6 if model.axes == "free" and shape != FREE["generic"] else 2e-8
    for k in range(model.count):
        turns, rates = differences(model, point, k)
        for given, expected in ((found.attitude, turns), (found.rates, rates @ found.axes)):
            size = max(np.max(np.abs(expected)), 1.0)
            assert np.max(np.abs(given[:, k].T - expected)) < limit * size, k


def test_rates_are_left_out_where_none_are_observed():
    found = Model(None, "free").predict(Point(WXYZ, OMEGA, np.zeros(5)), T, rates=False)
    assert found.omega is None and found.rates is None
