"""The numbers of the package against benchmarks/make_coefficients.py, which remakes them."""

import math
from dataclasses import replace

import pytest
from mpmath import mp, mpf

from attitude.torques._schemes import SCHEMES
from benchmarks import make_coefficients
from benchmarks.coefficients import minimax, rules, schemes, sources
from benchmarks.coefficients.table import PRECISION, Claim, ulps

TABLES = make_coefficients.tables()
IDS = [f"{each.file}:{each.owners[0]}:{k}" for k, each in enumerate(TABLES)]


# ---- the tables --------------------------------------------------------------------------------


@pytest.mark.parametrize("table", TABLES, ids=IDS)
def test_stored_numbers_are_those_remade(table):
    """Doubles bit by bit where they have one definition, and every bound that a comment states."""
    assert table.broken_claims(table.measure()) == []


@pytest.fixture(scope="module")
def long_constants():
    """The computed and measured numbers of the package."""
    return sources.long_constants()


def test_every_computed_number_of_the_package_has_a_table(long_constants):
    """Floats of more than ten digits are remade by the script, or are measured ones it names."""
    known = {(each.file, owner) for each in TABLES for owner in each.owners}
    found = long_constants
    missing = found - known - make_coefficients.MEASURED
    assert not missing, f"give {missing} a table in benchmarks/coefficients, or add to MEASURED"
    assert found - known >= make_coefficients.MEASURED


def test_the_search_finds_names_literals_and_series(long_constants):
    found = long_constants
    for file, owner in (
        ("_solver/chains.py", "_GAUSS"),  # an array
        ("_solver/series.py", "_SIN_1_LOW"),  # one of two names in one statement
        ("_solver/step.py", "_SINE_3"),  # a quotient of short numbers
        ("_solver/elliptic.py", "_turns"),  # a literal in a function
        ("averaged/_rates.py", "slopes"),  # quotients in a function
    ):
        assert (file, owner) in found
    assert ("_solver/constants.py", "_NO_RATE") not in found  # a power of two
    assert ("_solver/step.py", "LONGEST_PIECE") not in found


# ---- that a wrong number is seen ---------------------------------------------------------------


def _with_stored(table, place, change):
    stored = table.read()
    stored[place] = change(stored[place])
    return replace(table, read=lambda: stored)


def _table(name):
    return next(each for each in TABLES if each.owners[0] == name)


@pytest.mark.parametrize("name", ["_ROOT", "_INVERSE", "TWO_PI", "_LN2", "_XI", "_SINE_0"])
def test_an_ulp_is_seen(name):
    table = _with_stored(_table(name), -1, lambda x: x * (1 + 2.0**-52) + 2.0**-1070)
    broken = table.broken_claims(table.measure())
    assert any("doubles differ by" in sentence for sentence in broken)


@pytest.mark.parametrize("place", range(6))
def test_a_wrong_digit_of_a_least_maximum_polynomial_is_seen(place):
    """In any coefficient, where it moves the sine of an eighth of a turn by 2e-19."""
    change = 2e-19 * 8.0 ** (3 + 2 * place)
    table = _with_stored(_table("_SIN_3"), place, lambda x: x + max(change, math.ulp(x)))
    assert any("polynomials differ by" in each for each in table.broken_claims(table.measure()))


def test_a_bound_that_is_too_small_is_seen():
    (claim,) = _table("_EXP_1").claims
    table = replace(_table("_EXP_1"), claims=(replace(claim, bound=1e-17),))
    assert "the error is 1.41e-17" in table.broken_claims(table.measure())[0]


def test_words_that_the_file_does_not_hold_are_seen():
    table = replace(_table("_LN2"), claims=(Claim(1.0, "to 3e-17 of it"),))
    assert 'the file does not say "to 3e-17 of it"' in table.broken_claims(table.measure())


def test_a_table_that_grew_is_seen():
    table = _table("_LN2")
    with pytest.raises(ValueError, match="_LN2 has 2 numbers, 1 were remade"):
        replace(table, read=lambda: [0.5, 0.5]).measure()


def test_the_script_prints_its_tables(capsys, monkeypatch):
    good = _table("_LN2")
    monkeypatch.setattr(make_coefficients, "tables", lambda: [good])
    assert make_coefficients.main() == 0
    assert "attitude/light_curve/_sums.py: _LN2" in capsys.readouterr().out
    wrong = _with_stored(good, 0, lambda x: 2.0 * x)
    monkeypatch.setattr(make_coefficients, "tables", lambda: [good, wrong])
    assert make_coefficients.main() == 1
    assert "2 tables, 1 wrong" in capsys.readouterr().out


# ---- how they are remade -----------------------------------------------------------------------


def test_the_best_polynomial_of_a_power():
    """x^5 by degree 4 on [-1, 1]: T_5 / 16 is left (Chebyshev 1854)."""
    fit = minimax.PolynomialFit(lambda x: x**5, lambda x: 1, 5, "-1", "1")
    with mp.workdps(PRECISION):
        coefficients, error = fit.best
        assert abs(error - mpf(1) / 16) < 1e-9
        exact = [0, mpf(-5) / 16, 0, mpf(5) / 4, 0]
        assert all(abs(a - b) < 1e-4 for a, b in zip(coefficients, exact, strict=True))


def test_the_best_polynomial_with_a_weight():
    """A line for 1/(1 + x) to least relative error, 1 - (a + b x)(1 + x) = T_2(2 x - 1) / 17."""
    fit = minimax.PolynomialFit(lambda x: 1 / (1 + x), lambda x: 1 + x, 2, "0", "1")
    with mp.workdps(PRECISION):
        _, error = fit.best
        assert abs(error - mpf(1) / 17) < 1e-9
        assert abs(fit.error([mpf(16) / 17, mpf(-8) / 17]) - mpf(1) / 17) < 1e-9


@pytest.mark.parametrize(("count", "power"), [(2, 0), (4, 2), (10, 0), (22, 0)])
def test_rules_are_exact_up_to_their_degree(count, power):
    with mp.workdps(PRECISION):
        nodes, weights = rules.gauss(count, power)
        for k in range(2 * count):
            total = sum(w * x**k for x, w in zip(nodes, weights, strict=True))
            assert abs(total - mpf(1) / (power + k + 1)) < 1e-55
        assert 0 < nodes[0] < nodes[-1] < 1


def test_the_stored_rule_in_pairs_is_exact():
    """Ten points integrate powers up to 19 to the last digits of pairs."""
    stored = [mpf(x) for x in sources.named("_solver/chains.py", "_GAUSS")]
    with mp.workdps(PRECISION):
        sums = [high + low for high, low in zip(stored[::2], stored[1::2], strict=True)]
        lower = list(zip(sums[::2], sums[1::2], strict=True))
        rule = [*lower, *((1 - x, w) for x, w in lower)]
        for k in range(20):
            assert abs(sum(w * x**k for x, w in rule) - mpf(1) / (k + 1)) < 1e-32


@pytest.mark.parametrize("name", SCHEMES)
def test_schemes_have_the_order_they_state(name):
    assert schemes.order_of_error(name) == SCHEMES[name].order + 1


def test_ulps_count_doubles():
    assert ulps(1.0, 1.0) == 0
    assert ulps(1.0 + 2.0**-52, 1.0) == 1
    assert ulps(1.0 - 2.0**-53, 1.0) == -1
    assert ulps(5e-324, -5e-324) == 2
    assert ulps(0.0, -0.0) == 0
