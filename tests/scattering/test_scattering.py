"""Scattering laws: reciprocity and energy for each, limits, and sbpy for phase functions."""

import warnings

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from mpmath import mp

from attitude import scattering
from attitude.errors import AttitudeError
from attitude.scattering import (
    Hapke,
    Lambert,
    LommelSeeliger,
    LommelSeeligerLambert,
    Material,
    Materials,
    hg,
    hg1g2,
    law,
)

COOK = Material(0.3, 0.5, "cook-torrance", roughness=0.3, f0=0.5)
LAWS = [
    Lambert(0.4),
    LommelSeeliger(0.3),
    LommelSeeligerLambert(),
    Hapke(),
    Hapke(w=0.6, g=0.2, roughness=0.0),
    Hapke(w=0.9, g=-0.2, roughness="40 deg"),
    Material(0.3, 0.5),
    COOK,
]


def directions(incidence, emission, azimuth):
    """mu0, mu and the phase angle, from the vectors."""
    sun = np.array([np.sin(incidence), 0.0 * incidence, np.cos(incidence)])
    seen = np.array([np.sin(emission) * np.cos(azimuth), np.sin(emission) * np.sin(azimuth)])
    seen = np.array([*seen, np.cos(emission)])
    cross = np.linalg.norm(np.cross(sun, seen))
    return sun[2], seen[2], np.arctan2(cross, sun @ seen)


def reflected(given_law, incidence, count=300):
    """Share of the light falling in that leaves again: integral of r mu / mu0 over the sky."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    mu, weights = (nodes + 1.0) / 2.0, weights / 2.0
    azimuth = (np.arange(2 * count) + 0.5) * np.pi / (2 * count)
    mu0 = np.cos(incidence)
    mu, azimuth = mu[:, None], azimuth[None]
    sine = np.sqrt(1.0 - mu * mu)
    cosine = mu * mu0 + sine * np.sin(incidence) * np.cos(azimuth)
    other = np.hypot(sine * np.sin(azimuth), sine * np.cos(azimuth) * mu0 - mu * np.sin(incidence))
    r = given_law.reflectance(mu0, np.broadcast_to(mu, cosine.shape), np.arctan2(other, cosine))
    return np.sum(weights[:, None] * r * mu) * np.pi / count / mu0


def test_every_law_has_a_row_among_the_laws_of_the_tests():
    """Those of the package: other tests define their own."""
    laws = scattering.laws().values()
    shipped = {kind for kind in laws if kind.__module__.startswith("attitude.")}
    assert {type(known) for known in LAWS} == shipped


@pytest.mark.parametrize("given_law", LAWS, ids=repr)
@given(
    st.floats(0.0, 1.57),
    st.floats(0.0, 1.57),
    st.floats(0.0, np.pi),
)
@example(1.0, 1.5, 0.0)  # one plane: the azimuth is the root of what rounding leaves
def test_reciprocity(given_law, incidence, emission, azimuth):
    mu0, mu, alpha = directions(incidence, emission, azimuth)
    there = given_law.reflectance(mu0, mu, alpha) * mu
    back = given_law.reflectance(mu, mu0, alpha) * mu0
    assert there == pytest.approx(back, rel=1e-12, abs=1e-300)
    assert there >= 0.0


# Kaasalainen's phase function is a fit of any scale, f(0) = 1.5: it promises no energy.
@pytest.mark.parametrize("given_law", [x for x in LAWS if x != LommelSeeligerLambert()], ids=repr)
@pytest.mark.parametrize("incidence", [0.0, 0.5, 1.0, 1.4])
def test_no_law_returns_more_light_than_it_gets(given_law, incidence):
    assert 0.0 < reflected(given_law, incidence) <= 1.0


@pytest.mark.parametrize("incidence", [0.0, 0.5, 1.0, 1.4])
def test_energy_in_closed_form(incidence):
    mu0 = np.cos(incidence)
    assert reflected(Lambert(0.7), incidence) == pytest.approx(0.7, rel=1e-12)
    expected = 0.5 * (1.0 - mu0 * np.log((1.0 + mu0) / mu0))
    assert reflected(LommelSeeliger(), incidence) == pytest.approx(expected, rel=1e-9)
    # Lafortune & Willems normalise the mirror lobe at vertical incidence, where it is whole.
    if incidence == 0.0:
        gloss = Material(0.0, 1.0, exponent=50.0)
        assert reflected(gloss, incidence) == pytest.approx(1.0, rel=1e-9)
    # Hapke 2012, eq. 11.13, with his H: the hypergeometric integrals agree to 8%.
    gamma = np.sqrt(0.5)
    expected = (1.0 - gamma) / (1.0 + 2.0 * gamma * mu0)
    isotropic = Hapke(w=0.5, g=0.0, b0=0.0, roughness=0.0)
    assert reflected(isotropic, incidence) == pytest.approx(expected, rel=0.12)


def test_a_smooth_dark_isotropic_hapke_surface_is_lommel_seeliger():
    dark = Hapke(w=1e-6, g=0.0, b0=0.0, roughness=0.0)
    simple = LommelSeeliger(1e-6)
    mu0, mu, alpha = directions(0.7, 1.1, 2.0)
    ours, theirs = dark.reflectance(mu0, mu, alpha), simple.reflectance(mu0, mu, alpha)
    assert ours == pytest.approx(theirs, rel=2e-6)  # multiple scattering is of order w


def test_roughness_goes_to_smooth_continuously():
    mu0, mu, alpha = directions(0.7, 1.1, 2.0)
    smooth = Hapke(roughness=0.0).reflectance(mu0, mu, alpha)
    for slope in (1e-3, 1e-5, 1e-7):
        rough = Hapke(roughness=slope).reflectance(mu0, mu, alpha)
        assert rough == pytest.approx(smooth, rel=10 * slope**2 + 1e-13)


def test_opposition_doubles_a_hapke_surge_of_one():
    surging = Hapke(b0=1.0, g=0.0, w=1e-9, roughness=0.0)
    plain = Hapke(b0=0.0, g=0.0, w=1e-9, roughness=0.0)
    assert surging.reflectance(0.5, 0.5, 0.0) / plain.reflectance(0.5, 0.5, 0.0) == pytest.approx(2)
    assert surging.reflectance(0.1, 0.1, 3.0) == pytest.approx(
        plain.reflectance(0.1, 0.1, 3.0), rel=2e-3
    )


def hapke_written_out(law, i, e, psi):
    """Hapke 1984, eqs. 46-58, and 1986, from the angles, term by term."""
    cos_g = np.cos(i) * np.cos(e) + np.sin(i) * np.sin(e) * np.cos(psi)
    g = np.arccos(cos_g)
    surge = law.b0 / (1.0 + np.tan(g / 2.0) / law.h)
    single = (1.0 - law.g**2) / (1.0 + 2.0 * law.g * cos_g + law.g**2) ** 1.5
    tan = np.tan(law.roughness)
    chi = 1.0 / np.sqrt(1.0 + np.pi * tan**2)

    def e1(x):
        return np.exp(-2.0 / np.pi / tan / np.tan(x))

    def e2(x):
        return np.exp(-1.0 / np.pi / tan**2 / np.tan(x) ** 2)

    def eta(x):
        return chi * (np.cos(x) + np.sin(x) * tan * e2(x) / (2.0 - e1(x)))

    def h(x):
        return (1.0 + 2.0 * x) / (1.0 + 2.0 * x * np.sqrt(1.0 - law.w))

    half = np.sin(psi / 2.0) ** 2
    hidden = np.exp(-2.0 * np.tan(psi / 2.0))
    if i <= e:
        below = 2.0 - e1(e) - psi / np.pi * e1(i)
        mu0 = chi * (np.cos(i) + np.sin(i) * tan * (np.cos(psi) * e2(e) + half * e2(i)) / below)
        mu = chi * (np.cos(e) + np.sin(e) * tan * (e2(e) - half * e2(i)) / below)
        last = np.cos(i) / eta(i)
    else:
        below = 2.0 - e1(i) - psi / np.pi * e1(e)
        mu0 = chi * (np.cos(i) + np.sin(i) * tan * (e2(i) - half * e2(e)) / below)
        mu = chi * (np.cos(e) + np.sin(e) * tan * (np.cos(psi) * e2(i) + half * e2(e)) / below)
        last = np.cos(e) / eta(e)
    shadow = mu / eta(e) * np.cos(i) / eta(i) * chi / (1.0 - hidden + hidden * chi * last)
    share = law.w / (4.0 * np.pi) * mu0 / (mu0 + mu)
    return share * ((1.0 + surge) * single + h(mu0) * h(mu) - 1.0) * shadow


@pytest.mark.parametrize("given_law", [Hapke(), Hapke(w=0.9, g=0.3, roughness=np.radians(40.0))])
def test_hapke_against_the_paper_written_out(given_law):
    rng = np.random.default_rng(4)
    for i, e, psi in zip(
        *rng.uniform(0.05, 1.5, (2, 200)), rng.uniform(0.05, 3.0, 200), strict=True
    ):
        ours = given_law.reflectance(*directions(i, e, psi))
        assert ours == pytest.approx(hapke_written_out(given_law, i, e, psi), rel=1e-10)


def hapke_exact(law, mu0, mu, half):
    """Hapke 1984, eqs. 46-58, and 1986, in mpmath from the cosines and half the phase angle."""
    mu0, mu, half = (mp.mpf(float(each)) for each in (mu0, mu, half))
    i, e, g = mp.acos(mu0), mp.acos(mu), mp.mpf(law.g)
    surge = mp.mpf(law.b0) / (1 + mp.tan(half) / mp.mpf(law.h))
    single = (1 + surge) * (1 - g**2) / (1 + 2 * g * mp.cos(2 * half) + g**2) ** mp.mpf(1.5)

    def h(x):
        return (1 + 2 * x) / (1 + 2 * x * mp.sqrt(1 - mp.mpf(law.w)))

    scale = mp.mpf(law.w) / (4 * mp.pi)
    if law.roughness == 0.0:
        return scale * mu0 / (mu0 + mu) * (single + h(mu0) * h(mu) - 1)
    sin2 = (mp.sin(half) ** 2 - mp.sin((i - e) / 2) ** 2) / (mp.sin(i) * mp.sin(e))
    psi = 2 * mp.asin(mp.sqrt(sin2))
    tan = mp.tan(mp.mpf(law.roughness))
    chi = 1 / mp.sqrt(1 + mp.pi * tan**2)
    e1 = {x: mp.exp(-2 / mp.pi / tan / mp.tan(x)) for x in (i, e)}
    e2 = {x: mp.exp(-1 / mp.pi / tan**2 / mp.tan(x) ** 2) for x in (i, e)}
    eta = {x: chi * (mp.cos(x) + mp.sin(x) * tan * e2[x] / (2 - e1[x])) for x in (i, e)}
    a, b = min(i, e), max(i, e)
    below = 2 - e1[b] - psi / mp.pi * e1[a]
    xa = chi * (mp.cos(a) + mp.sin(a) * tan * (mp.cos(psi) * e2[b] + sin2 * e2[a]) / below)
    xb = chi * (mp.cos(b) + mp.sin(b) * tan * (e2[b] - sin2 * e2[a]) / below)
    hidden = mp.exp(-2 * mp.tan(psi / 2))
    shadow = (xa if e == a else xb) / eta[e] * mu0 / eta[i] * chi
    shadow /= 1 - hidden + hidden * chi * mp.cos(a) / eta[a]
    share = scale * (xa if i == a else xb) / (xa + xb)
    return share * (single + h(xa) * h(xb) - 1) * shadow


@pytest.mark.parametrize(
    "given_law",
    [
        Hapke(),
        Hapke(w=0.9, g=0.3, roughness="55 deg"),
        Hapke(roughness="1 deg"),
        Hapke(roughness=0),
    ],
    ids=repr,
)
@pytest.mark.parametrize("grazing", [False, True])
def test_hapke_to_40_digits(given_law, grazing):
    """To 1e-12; not within 0.03 rad of one plane, where r is the root of a rounded difference."""
    rng = np.random.default_rng(9)
    i, e = rng.uniform(0.05, 1.57, (2, 150))
    if grazing:
        i = np.pi / 2 - 10.0 ** rng.uniform(-8, -1, 150)
        e[::2] = (np.pi / 2 - 10.0 ** rng.uniform(-8, -1, 150))[::2]
    psi = rng.uniform(0.03, np.pi - 0.03, 150)
    mu0, mu, alpha = np.transpose([directions(*one) for one in zip(i, e, psi, strict=True)])
    found = given_law.reflectance(mu0, mu, alpha)
    with mp.workdps(40):
        for k in range(len(mu0)):
            exact = hapke_exact(given_law, mu0[k], mu[k], 0.5 * alpha[k])
            assert abs(found[k] / exact - 1) < 1e-12, (mu0[k], mu[k], alpha[k])


@pytest.mark.parametrize("exponent", [1.0, 100.0, 256.0, 33.3, 1000.0])
def test_phong_to_40_digits(exponent):
    """To 1e-13 and what the rounded cosine of the mirror direction costs."""
    rng = np.random.default_rng(10)
    mu0, mu, alpha = np.transpose(
        [directions(*one) for one in zip(*rng.uniform(0.0, 1.57, (2, 300)),
                                         rng.uniform(0.5, np.pi, 300), strict=True)]
    )  # fmt: skip
    found = Material(0.0, 0.7, exponent=exponent).reflectance(mu0, mu, alpha)
    with mp.workdps(40):
        for a, b, angle, r in zip(mu0, mu, alpha, found, strict=True):
            mirrored = 2 * mp.mpf(float(a)) * mp.mpf(float(b)) - mp.cos(mp.mpf(float(angle)))
            if mirrored > 0.1:
                exact = mp.mpf(0.7) * (exponent + 2) / (2 * mp.pi) * mirrored**exponent * float(a)
                if exact > 1e-290:
                    assert abs(r / exact - 1) < 1e-13 + 4e-16 * exponent / mirrored


def test_cook_torrance_against_the_paper_written_out():
    rng = np.random.default_rng(5)
    for i, e, psi in zip(
        *rng.uniform(0.05, 1.5, (2, 200)), rng.uniform(0.05, 3.0, 200), strict=True
    ):
        sun = np.array([np.sin(i), 0.0, np.cos(i)])
        seen = np.array([np.sin(e) * np.cos(psi), np.sin(e) * np.sin(psi), np.cos(e)])
        half = (sun + seen) / np.linalg.norm(sun + seen)
        tilt = np.arccos(half[2])
        spread = np.exp(-((np.tan(tilt) / 0.3) ** 2)) / (np.pi * 0.3**2 * np.cos(tilt) ** 4)
        fresnel = 0.5 + 0.5 * (1.0 - half @ sun) ** 5
        grooves = min(1.0, *(2.0 * half[2] * v[2] / (half @ sun) for v in (sun, seen)))
        expected = sun[2] * (
            0.3 / np.pi + 0.5 * spread * fresnel * grooves / (4 * sun[2] * seen[2])
        )
        assert COOK.reflectance(*directions(i, e, psi)) == pytest.approx(expected, rel=1e-10)


def test_gloss_shines_in_the_mirror_direction():
    for gloss in (Material(0.1, 0.8, exponent=1000.0), Material(0.1, 0.8, "cook-torrance")):
        mirror = gloss.reflectance(*directions(0.6, 0.6, np.pi))
        aside = gloss.reflectance(*directions(0.6, 0.6, 2.0))
        assert mirror > 10.0 * aside
        assert aside == pytest.approx(0.1 / np.pi * np.cos(0.6), rel=1e-2)


def test_backlit_grazing_and_opposite_are_finite():
    tiny = [1e-300, 1e-250, 1e-30, 1e-18, 1e-9, 1e-3]
    for given_law in LAWS:
        for alpha in (3.0, 3.1415926, np.pi):
            assert np.all(np.isfinite(given_law.reflectance(tiny, np.transpose([tiny]), alpha)))
    for given_law in LAWS:
        value = given_law.reflectance([0.0, 1e-300, 1e-9, 1.0], [1e-9, 1e-300, 1e-9, 1.0],
                                      [np.pi, np.pi, np.pi, 0.0])  # fmt: skip
        assert np.all(np.isfinite(value)) and value[0] == 0.0


def test_kaasalainens_phase_function_stops_at_zero():
    function = LommelSeeligerLambert().phase
    assert function(0.0) == pytest.approx(1.5)
    assert function(np.array([2.0, 2.5, 3.0])) == pytest.approx([0.0, 0.0, 0.0], abs=1e-8)


def test_phase_functions_against_sbpy():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # astropy's, of its test runner, through sbpy
        photometry = pytest.importorskip("sbpy.photometry", reason="sbpy, the witness, is missing")
        alpha = np.radians(np.linspace(0.0, 150.0, 1001))
        theirs = photometry.HG.evaluate(alpha, 3.3, 0.2)
        assert np.max(np.abs(hg(alpha, 3.3, 0.2) - theirs)) < 1e-13
        for g1, g2 in ((0.62, 0.14), (0.1, 0.8), (0.0, 0.0)):
            part = alpha if g1 else alpha[alpha < np.radians(29.0)]
            theirs = photometry.HG1G2.evaluate(part, 3.3, g1, g2)
            assert np.max(np.abs(hg1g2(part, 3.3, g1, g2) - theirs)) < 1e-12


def test_phase_functions_at_their_ends():
    # The published slope of phi1, 6/pi, is rounded to 8 digits.
    assert hg(0.0, 5.0) == 5.0 and hg1g2(0.0, 5.0) == pytest.approx(5.0, abs=2e-9)
    assert hg1g2(np.pi) == np.inf
    assert hg1g2("40 deg", g1=0.0, g2=0.0) == np.inf
    assert hg(np.pi) > 100.0


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Lambert(1.1), "albedo is 1.1; it must lie from 0 to 1"),
        (lambda: LommelSeeliger(-0.1), "albedo is -0.1"),
        (lambda: LommelSeeligerLambert(d=0.0), "d is 0.0"),
        (lambda: Hapke(w=2.0), "w is 2.0"),
        (lambda: Hapke(g=1.0), "g is 1.0"),
        (lambda: Hapke(roughness="70 deg"), "roughness is 1.22.* rad"),
        (lambda: Hapke(h=np.nan), "h holds nan"),
        (lambda: Material(0.6, 0.5), "add up to more than 1"),
        (lambda: Material(0.6, model="blinn"), "model is 'blinn'"),
        (lambda: Material(0.6, 0.1, exponent=0.5), "exponent is 0.5"),
        (lambda: Materials({}), "Materials is empty"),
        (lambda: Materials({"body": 0.3}), "material 'body' is 0.3"),
        (lambda: Materials({"body": COOK})["wing"], "material 'wing' is unknown; known are 'body'"),
        (lambda: law("oren-nayar"), "law is 'oren-nayar'; give one of 'lambert'"),
        (lambda: hg(-0.1), "alpha must lie from 0 to pi"),
        (lambda: hg(0.1, 0.0, 2.0), "g is 2.0"),
        (lambda: hg1g2(0.1, 0.0, 0.9, 0.2), "nor their sum above 1"),
        (lambda: Materials(5), "Materials is given 5; give a dict"),
        (lambda: law(Hapke), r"law is the class Hapke; .*Hapke\(\.\.\.\)"),
        (lambda: Lambert().reflectance(2.0, 0.5, 0.1), "cosines lie from -1 to 1"),
        (lambda: Lambert().reflectance([0.1, 0.2], [0.1] * 3, 0.1), r"mu0 \(2,\), mu \(3,\)"),
    ],
)
def test_parameters_out_of_range_are_refused(make, sentence):
    with pytest.raises(AttitudeError, match=sentence):
        make()
