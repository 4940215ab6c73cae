"""Order conditions of splitting schemes, in the free algebra of the two parts of the motion.

A series is a dict from words in A (free motion) and B (kick) to coefficients.  The exact step is
exp(A + B), in which a word of length n has the coefficient 1/n!.
"""

from itertools import product as words_of

from mpmath import mp, mpf

# [B, [A, B]], the force gradient.
_GRADIENT = {"BAB": 2, "BBA": -1, "ABB": -1}


def step(kicks, flights, gradients, order):
    """The series of a step, words up to a length."""
    total = {"": mpf(1)}
    for k, kick in enumerate(kicks):
        gradient = {word: factor * mpf(gradients[k]) for word, factor in _GRADIENT.items()}
        total = _product(total, _exponential({"B": mpf(kick), **gradient}, order), order)
        if k < len(flights):
            total = _product(total, _exponential({"A": mpf(flights[k])}, order), order)
    return total


def residual(scheme, length):
    """The largest difference from the exact step among words of a length.

    scheme: kicks, flights and gradients, in units of the step and of its cube.
    """
    found = step(*scheme, length)
    exact = 1 / mp.factorial(length)
    words = ("".join(letters) for letters in words_of("AB", repeat=length))
    return max(abs(found.get(word, 0) - exact) for word in words)


def third_order(kicks, flights):
    """The coefficients of [A, [A, B]] and [B, [B, A]] in the error of a symmetric step."""
    found = step(kicks, flights, [0] * len(kicks), 3)
    return found["AAB"] - mpf(1) / 6, found["ABB"] - mpf(1) / 6


def _exponential(series, order):
    total, power = {"": mpf(1)}, {"": mpf(1)}
    for n in range(1, order + 1):
        power = _product(power, series, order)
        for word, x in power.items():
            total[word] = total.get(word, 0) + x / mp.factorial(n)
    return total


def _product(one, other, order):
    total = {}
    for left, x in one.items():
        for right, y in other.items():
            if len(left) + len(right) <= order:
                total[left + right] = total.get(left + right, 0) + x * y
    return total
