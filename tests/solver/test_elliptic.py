"""Elliptic integrals against mpmath: moduli to 1 - m = 1e-30, characteristics to 1 - n = 1e28."""

import math

import numba
import pytest
from mpmath import mp, mpf

from attitude._solver.elliptic import complete_and_phase, quarter_and_fraction
from tests.support.oracle import carlson_rj

PAIR = 2e-30  # relative: pairs carry 1.2e-32, and some hundred operations come together


@numba.njit(error_model="numpy")
def _in_pairs(kc, p, a, cosine, sine):
    return complete_and_phase(kc, p, a, cosine, sine)


@numba.njit(error_model="numpy")
def _in_doubles(b, cosine, sine):
    return quarter_and_fraction(b, cosine, sine)


def _pair(x):
    hi = float(x)
    return hi, float(x - mpf(hi))


def _value(pair):
    return mpf(pair[0]) + mpf(pair[1])


def _cel(kc, p, a):
    """cel(kc, p, a, 1) = (1/p) K-like sum: a Pi-type integral, by Carlson's R_F and R_J."""
    mc = kc**2
    quarter = mp.elliprf(0, mc, 1)
    # int (a cos^2 + sin^2) / (cos^2 + p sin^2) dtheta / sqrt(cos^2 + mc sin^2)
    return a * quarter + (1 - a * p) * carlson_rj(mpf(0), mc, p) / 3


COMPLEMENTS = ("1e-60", "1e-30", "1e-18", "1e-9", "1e-3", "0.03", "0.3", "0.7", "0.999", "1")
CHARACTERISTICS = ("1", "1.000000000000001", "1.3", "7", "1e3", "1e8", "1e14", "1e28")


@pytest.mark.parametrize("p", CHARACTERISTICS)
@pytest.mark.parametrize("mc", COMPLEMENTS)
def test_complete_integrals_in_pairs(mc, p):
    """K and the quotients Pi / K (weight 1) and their part for needles (weight 0)."""
    with mp.workdps(70):
        kc, p = _pair(mp.sqrt(mpf(mc))), _pair(mpf(p))
        quarter = mp.elliprf(0, _value(kc) ** 2, 1)
        for weight in (0.0, 1.0):
            found, complete, _ = _in_pairs(kc, p, (weight, 0.0), (1.0, 0.0), (0.0, 0.0))
            exact = _cel(_value(kc), _value(p), mpf(weight)) / quarter
            assert abs(_value(complete) / quarter - 1) < PAIR
            assert abs(_value(found) / exact - 1) < PAIR


# tangents of the amplitude, from 0 to a right angle
AMPLITUDES = ("0", "1e-300", "1e-30", "1e-15", "1e-3", "0.4", "1", "2.5", "1e3", "1e15", "1e200")


@pytest.mark.parametrize("tangent", [*AMPLITUDES, "inf"])
@pytest.mark.parametrize("mc", COMPLEMENTS)
def test_phase_in_pairs(mc, tangent):
    """F(phi | m) / 4 K in turns, any common factor of cosine and sine left out."""
    with mp.workdps(70):
        kc = _pair(mp.sqrt(mpf(mc)))
        if tangent == "inf":
            cosine, sine = mpf(0), mpf(3)
        else:
            cosine = mpf("0.37") / max(mpf(1), mpf(tangent))
            sine = cosine * mpf(tangent)
        cosine, sine = _pair(cosine), _pair(sine)
        _, _, turns = _in_pairs(kc, (1.0, 0.0), (1.0, 0.0), cosine, sine)
        c, s, modulus = _value(cosine), _value(sine), _value(kc) ** 2
        incomplete = s * mp.elliprf(c**2, c**2 + modulus * s**2, c**2 + s**2)
        exact = incomplete / (4 * mp.elliprf(0, modulus, 1))
        # turns at the epoch, which do not grow with time: an arctangent, halved a few times
        assert abs(_value(turns) - exact) <= min(2e-17, 4e-16 * exact)


@pytest.mark.parametrize("tangent", [*AMPLITUDES, "inf"])
@pytest.mark.parametrize("mc", COMPLEMENTS)
def test_phase_and_quarter_in_doubles(mc, tangent):
    """The complementary quarter period and eta / K': relative 2e-15."""
    with mp.workdps(50):
        b = math.sqrt(float(mc))
        sine = 1.0 if tangent == "inf" else float(tangent) / max(1.0, float(tangent))
        cosine = 0.0 if tangent == "inf" else 1.0 / max(1.0, float(tangent))
        quarter, fraction = _in_doubles(b, cosine, sine)
        c, s, modulus = mpf(cosine), mpf(sine), mpf(b) ** 2
        exact = mp.elliprf(0, modulus, 1)
        assert abs(quarter / exact - 1) < 1e-15
        part = s * mp.elliprf(c**2, c**2 + modulus * s**2, c**2 + s**2) / exact
        assert abs(fraction - part) <= 2e-15 * part


@pytest.mark.parametrize("ratio", ["1e-14", "1e-10", "1e-6", "1e-2", "0.1"])
def test_the_precession_of_needles_in_pairs(ratio):
    """Moments 1, 1 + r/3 and r: characteristic and modulus as they come from such a body."""
    with mp.workdps(70):
        r = mpf(ratio)
        i1, i2, i3 = 1 + r / 3, mpf(1), r  # long axis: descending
        w1, w2, w3 = mpf("0.3"), mpf("0.4"), mpf("0.2")
        d1 = i2 * (i2 - i1) * w2**2 + i3 * (i3 - i1) * w3**2
        d2 = i1 * (i1 - i2) * w1**2 + i3 * (i3 - i2) * w3**2
        mc = d2 * (i3 - i1) / (d1 * (i3 - i2))
        assert 0 < mc < 1
        p = _pair(i2 * (i1 - i3) / (i1 * (i2 - i3)))
        kc = _pair(mp.sqrt(mc))
        found, _, _ = _in_pairs(kc, p, (0.0, 0.0), (1.0, 0.0), (0.0, 0.0))
        quarter = mp.elliprf(0, _value(kc) ** 2, 1)
        assert abs(_value(found) * quarter / _cel(_value(kc), _value(p), mpf(0)) - 1) < PAIR
