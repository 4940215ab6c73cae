"""Checks of the principal axes of tensors for `battery`: against mpmath, in whole numbers."""

import math
from fractions import Fraction
from random import Random

import numpy as np
from mpmath import mp, mpf

# Bits after the point of words, for eigenvalues and axes.
_BITS = 444
# Those that are kept of them.
_KEPT = 384
_OMEGA = ((0.3, -0.2, 0.6), (-1e-9, 5.0, 1e-300), (0.0, 0.0, -3e200))
_TENSORS = [
    ((2.0, 0.1, 0.2), (0.1, 2.5, 0.5), (0.2, 0.5, 2.9)),
    ((2.9, -0.5, 0.2), (-0.5, 2.0, -0.1), (0.2, -0.1, 2.5)),
    ((3.0, 1.0, 0.0), (1.0, 3.0, 0.0), (0.0, 0.0, 3.0)),
    ((8.0, 1.0, 1.0), (1.0, 8.0, 1.0), (1.0, 1.0, 8.0)),
    ((2.0, 0.0, 0.0), (0.0, 2.5, 0.5), (0.0, 0.5, 2.5)),
    ((2.5, 0.0, -0.5), (0.0, 2.0, 0.0), (-0.5, 0.0, 2.5)),
    ((1.0, 1e-16, 0.0), (1e-16, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ((2.0, 1e-17, 3e-18), (1e-17, 2.0, -1e-17), (3e-18, -1e-17, 3.0)),
    ((2.0, 1e-200, 0.0), (1e-200, 3.0, 1e-100), (0.0, 1e-100, 4.0)),
    ((4.0, 1e-40, 1e-60), (1e-40, 3.0, 1e-50), (1e-60, 1e-50, 2.0)),
    ((1e-300, 0.0, 0.0), (0.0, 2e-300, 1e-301), (0.0, 1e-301, 2e-300)),
    ((2e30, 3e29, 0.0), (3e29, 2.5e30, -1e29), (0.0, -1e29, 1.9e30)),
    # elements beside the diagonal larger than those on it
    ((1e-3, 0.7, 0.2), (0.7, 2e-3, 0.9), (0.2, 0.9, 3e-3)),
    ((1e-3, 0.2, 0.1), (0.2, 2e-3, 3.9), (0.1, 3.9, 3e-3)),
    ((1e-3, 3.9, 0.1), (3.9, 2e-3, 0.2), (0.1, 0.2, 3e-3)),
    ((1e-3, 0.2, 3.9), (0.2, 2e-3, 0.1), (3.9, 0.1, 3e-3)),
    ((1.0, 0.0, 1e-3), (0.0, 1.0 + 1e-6, 0.0), (1e-3, 0.0, 1.5)),
    ((3.0, 0.0, 0.5), (0.0, 1.0, 0.0), (0.5, 0.0, 4.0)),
    # axes of the body to all bits that are kept, in another order
    ((4.0, 1e-200, 0.0), (1e-200, 3.0, 0.0), (0.0, 0.0, 2.0)),
]
# Moments of bodies that are turned by random rotations.
_MOMENTS = (
    (1.0, 2.0, 2.5),
    (2.5, 1.0, 2.0),
    (2.0, 2.5, 1.0),
    (2.5, 2.0, 1.0),
    (1.0, 2.5, 2.0),
    (1.0, 1.0 + 1e-3, 1.5),
    (1.0, 1.5, 1.0 + 1e-5),
    (1.5, 1.0 + 2.0**-20, 1.0),
    (1.0, 1.0 + 1e-8, 1.5),
    (1.0, 1.0 + 1e-13, 1.5),
    (1e-4, 1.0, 1.0),
    (1e-4, 1.0, 1.00005),
)


def _tensors():
    """Symmetric tensors as tuples of rows."""
    random = Random(17)
    found = list(_TENSORS)
    for k, moments in enumerate(_MOMENTS):
        q = np.array([random.gauss(0.0, 1.0) for _ in range(4)])
        w, x, y, z = (q / np.linalg.norm(q)).tolist()
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        tensor = turn @ np.diag(moments) @ turn.T
        tensor = 0.5 * (tensor + tensor.T) * 2.0 ** (k % 3)
        found.append(tuple(map(tuple, tensor.tolist())))
    return found


def truths_of_axes(kept):
    """Tensors with their moments, axes, and angular velocities over them; numbers near 1."""
    kept.tensors = [(tensor, _axes_of(tensor)) for tensor in _tensors()]
    random = Random(3)
    kept.roots = []
    for _ in range(12):
        x = random.randint(1 << (_BITS - 2), 2 << _BITS)
        kept.roots.append((x, math.isqrt((1 << (3 * _BITS)) // x)))
    kept.roots += [(1 << _BITS, 1 << _BITS), (1 << (_BITS - 2), 2 << _BITS)]


def _axes_of(tensor):
    """Moments over 2**exponent and columns, as integers, and what is exact of each rate."""
    largest = max(abs(x) for row in tensor for x in row)
    exponent = math.frexp(largest)[1]
    with mp.workdps(400):
        scaled = mp.matrix([[mp.ldexp(mpf(x), -exponent) for x in row] for row in tensor])
        values, vectors = mp.eigsy(scaled)
        order = sorted(range(3), key=lambda k: values[k])
        values = [values[k] for k in order]
        columns = [[vectors[i, k] for i in range(3)] for k in order]
        for column in columns:
            if column[_largest(column)] < 0:
                column[:] = [-x for x in column]
        if mp.det(mp.matrix(columns)) < 0:
            columns[2] = [-x for x in columns[2]]
        # the discriminant of doubles is a whole number over 2**-300, or zero
        gaps = [values[1] - values[0], values[2] - values[1]]
        distinct = all(gap > mpf(10) ** -150 for gap in gaps)
        rows = [_rates_of(values, columns, omega) for omega in _OMEGA] if distinct else []
        return {
            "exponent": exponent,
            "distinct": distinct,
            "values": [_kept(x) for x in values],
            "columns": [[_kept(x) for x in column] for column in columns],
            "moments": [_pair(mp.ldexp(x, exponent)) for x in values],
            "rates": rows,
        }


def _largest(column):
    """The first of the components that are largest but for 1e-150."""
    most = max(abs(x) for x in column)
    return next(k for k, x in enumerate(column) if abs(x) > most * (1 - mpf(10) ** -150))


def _kept(x):
    """A number with 384 bits after the point, as an integer over 2**444."""
    return int(mp.floor(mp.ldexp(x, _KEPT) + mpf(0.5))) << (_BITS - _KEPT)


def _pair(x):
    high = float(x)
    return high, float(x - mpf(high))


def _rates_of(values, columns, omega):
    """Angular velocities over the axes, and the three differences, as pairs."""
    rates = [sum(c * mpf(w) for c, w in zip(column, omega, strict=True)) for column in columns]
    least, middle, greatest = values
    most = max(abs(x) for x in rates)
    inertia, tempo = math.frexp(float(greatest))[1], mp.frexp(most)[1]
    d2 = greatest * (greatest - middle) * rates[2] ** 2 - least * (middle - least) * rates[0] ** 2
    differences = (
        mp.ldexp(middle - least, -inertia),
        mp.ldexp(greatest - middle, -inertia),
        mp.ldexp(d2, -2 * (inertia + tempo)),
    )
    return [_pair(x) for x in rates], [_pair(x) for x in differences]


def _same_pairs(pairs, exact, apart, size=None):
    """Rows of pairs (N, 2) that differ by at most `apart` of their size."""
    for k, (pair, wanted) in enumerate(zip(np.asarray(pairs).tolist(), exact, strict=True)):
        assert abs(pair[1]) <= 0.5 * math.ulp(pair[0])
        off = (Fraction(pair[0]) + Fraction(pair[1])) - (Fraction(wanted[0]) + Fraction(wanted[1]))
        assert abs(off) <= apart * abs(Fraction(wanted[0] if size is None else size)), (k, pair)


def check_principal_axes(truths):
    """Moments, axes and rates over them, in words and in pairs, against mpmath."""
    from attitude._compilation import wide
    from attitude._solver.principal_axes import COLUMNS, VALUES, PrincipalAxes
    from attitude.frames import quaternion

    tensors = np.array([tensor for tensor, _ in truths.tensors])
    together = PrincipalAxes.of(tensors)
    assert np.array_equal(together.words[3], PrincipalAxes.of(tensors[3:4]).words[0])
    for k, (tensor, exact) in enumerate(truths.tensors):
        words = together.words[k]
        moments, axes = together.moments[k], together.axes[k]
        values = [wide.load(words, VALUES + n) for n in range(3)]
        if not -1e-15 * moments[2, 0] <= exact["moments"][0][0] <= 0.0:
            assert values == exact["values"], (tensor, values)
            _same_pairs(moments, exact["moments"], Fraction(2) ** -104)
        columns = [[wide.load(words, COLUMNS + 3 * n + i) for i in range(3)] for n in range(3)]
        for n in range(3):
            pairs = [(float(x), float(x - int(float(x)))) for x in columns[n]]
            scaled = [[math.ldexp(x, -_BITS) for x in pair] for pair in pairs]
            assert axes[:, n].tolist() == scaled
        if exact["distinct"]:
            assert columns == exact["columns"], tensor
        _check_axes(tensor, exact["exponent"], values, columns)
        turn = axes[..., 0]
        assert abs(np.linalg.det(turn) - 1.0) < 1e-14
        wxyz = together.wxyz[k]
        assert wxyz[0] >= 0.0 and np.max(np.abs(quaternion.matrix(wxyz) - turn)) < 1e-15
        for omega, (rates, differences) in zip(_OMEGA, exact["rates"], strict=False):
            found = together.words[k : k + 1]
            found = PrincipalAxes(found, *together[1:]).over_axes(np.array([omega]))
            size = max(abs(x) for x in omega)
            _same_pairs(found[0][0], rates, Fraction(2) ** -104, size)
            if moments[0, 0] != 0.0:
                _same_pairs(found[1][0][:2], differences[:2], Fraction(2) ** -104)
                _same_pairs(found[1][0][2:], differences[2:], Fraction(2) ** -200, 1.0)
    chosen = [k for k, (_, exact) in enumerate(truths.tensors) if exact["distinct"]]
    some = PrincipalAxes.of(tensors[chosen])
    rows = np.array([_OMEGA[k % 3] for k in range(len(chosen))])
    many = some.over_axes(rows)
    for k in range(len(chosen)):
        alone = PrincipalAxes(some.words[k : k + 1], *some[1:]).over_axes(rows[[k, k]])
        for one, other in zip(alone, many, strict=True):
            assert np.array_equal(one[1], other[k], equal_nan=True)


def _check_axes(tensor, exponent, values, columns):
    """Axes are orthogonal to 1e-114, and turn the tensor into its moments."""
    one = Fraction(2) ** _BITS
    axes = [[Fraction(x) / one for x in column] for column in columns]
    scale = Fraction(2) ** -exponent
    rows = [[Fraction(x) * scale for x in row] for row in tensor]
    least = Fraction(2) ** -381
    for i in range(3):
        image = [sum(rows[k][n] * axes[i][n] for n in range(3)) for k in range(3)]
        for j in range(3):
            product = sum(x * y for x, y in zip(axes[i], axes[j], strict=True))
            assert abs(product - (i == j)) <= least
            moment = sum(x * y for x, y in zip(image, axes[j], strict=True))
            wanted = Fraction(values[i]) / one if i == j else 0
            assert abs(moment - wanted) <= 4 * least or values[0] == 0, (tensor, i, j)


def check_diagonal_tensors(truths):
    """Tensors without elements beside the diagonal, rods, and rates that are no numbers."""
    from attitude._solver.principal_axes import PrincipalAxes

    found = PrincipalAxes.of(np.array([np.diag([3.0, 1.0, 2.0]), np.diag([1.0, 2.0, 0.0])]))
    assert not found.words.any()
    assert found.moments[..., 0].tolist() == [[3.0, 1.0, 2.0], [1.0, 2.0, 0.0]]
    assert found.axes[0, ..., 0].tolist() == np.eye(3).tolist()
    assert not found.moments[..., 1].any() and not found.axes[..., 1].any()
    assert found.wxyz.tolist() == [[1.0, 0.0, 0.0, 0.0]] * 2
    omega = np.array([[1e-300, 2.0, 1e300], [math.nan, 1.0, 1.0]])
    rates, differences = found.over_axes(omega)
    assert rates[0].tolist() == [[1e-300, 0.0], [2.0, 0.0], [1e300, 0.0]]
    assert np.isnan(differences).all() and np.isnan(rates[1, 0, 0])
    # one element beside the diagonal is enough, anywhere
    for i, j in ((0, 1), (0, 2), (1, 2)):
        tensor = np.diag([3.0, 1.0, 2.0])
        tensor[i, j] = tensor[j, i] = 1e-3
        assert PrincipalAxes.of(tensor[None]).moments[0, 0, 0] < 1.1
    # of a tensor with axes of its own, rates that are no numbers or endless are left as they are
    turned = PrincipalAxes.of(np.array([truths.tensors[2][0]] * 3))
    for bad in (math.nan, math.inf):
        given = [[1.0, bad, 2.0], [1.0, 2.0, bad], [bad, 1.0, 2.0]]
        rates, differences = turned.over_axes(np.array(given))
        assert np.array_equal(rates[..., 0], given, equal_nan=True)
        assert not rates[..., 1].any() and np.isnan(differences).all()
    # two of two bodies
    both = PrincipalAxes.of(np.array([truths.tensors[0][0], truths.tensors[2][0]]))
    rows = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]])
    second = PrincipalAxes(both.words[1:], *both[1:])
    assert np.array_equal(both.over_axes(rows)[0][1], second.over_axes(rows[:1])[0][0])
    _check_asymmetry()
    _check_rods(PrincipalAxes)


def _check_asymmetry():
    """Tensors are symmetric to 1e-13 of their largest entry."""
    from attitude import AttitudeError, propagate

    for off, sound in ((0.9e-13, True), (1.1e-13, False), (0.5, False)):
        tensor = np.array([[2.0, 0.1, 0.2], [0.1, 2.5, 0.5], [0.2, 0.5, 2.9]])
        tensor[0, 1] += off * 2.9
        try:
            propagate(None, (1, 0, 0, 0), (0.1, 0.2, 0.3), [0.0], tensors=tensor)
        except AttitudeError as err:
            assert not sound and "symmetric" in str(err), off
        else:
            assert sound, off


def _check_rods(PrincipalAxes):
    """A least moment between -1e-15 of the largest and 0 is that of a rod."""
    limit = -1e-15 * 3.0
    below = math.nextafter(limit, -1.0)
    for least, is_rod in ((0.0, True), (limit, True), (below, False), (1e-300, False)):
        tensor = np.array([[least, 0.0, 0.0], [0.0, 2.0, 1.0], [0.0, 1.0, 2.0]])
        found = PrincipalAxes.of(tensor[None])
        moments = found.moments[0, :, 0].tolist()
        if least == 1e-300:  # below the last bit that is kept
            assert abs(moments[0]) < 1e-100
            continue
        assert moments == ([0.0, 2.0, 2.0] if is_rod else [least, 1.0, 3.0]), least
        rates, differences = found.over_axes(np.array([[1.0, 2.0, 3.0]]))
        assert np.isnan(differences).all() == is_rod
        assert abs(abs(rates[0, 0, 0]) - 1.0) < 1e-15
    tensor = np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.1], [0.0, 0.1, 0.7]])
    moments = PrincipalAxes.of(tensor[None]).moments[0]
    assert moments[0].tolist() == [0.0, 0.0] and moments[1].tolist() == moments[2].tolist()
    half = (Fraction(0.3) + Fraction(0.7)) / 2
    assert abs(Fraction(moments[1, 0]) + Fraction(moments[1, 1]) - half) < Fraction(2) ** -53


def check_wide_numbers(truths):
    """Parts of the rotations of whole numbers."""
    from attitude._compilation import wide
    from attitude._solver import principal_axes as axes

    one = 1 << _BITS
    assert axes.one() == one
    for x, root in truths.roots:
        assert abs(axes._root_reciprocal(x) - root) <= 1 << 5, x
    for n in (5, -5, (1 << 61) + 1, -(1 << 100) - 1, 0):
        assert axes.magnitude(n) == abs(n) and axes._half(n, 3) == n >> 3
        assert axes.shifted_by(n, 7) == n << 7 and axes.length_of(n) == n.bit_length()
    unit = 1 << (_BITS - _KEPT)
    for n, wanted in ((unit // 2, unit), (unit // 2 - 1, 0), (-unit // 2, 0), (3 * unit, 3 * unit)):
        assert axes.rounded(n) == wanted
    for x in (1.0, -0.75, 1.0 / 3.0, 1e-100, 3.3e-117, -7.1e-124, 1e-150, 0.0, -1e-134):
        for exponent in (0, 1, -3):
            exact = Fraction(x) / Fraction(2) ** exponent * one
            found = axes.integer_of(x, exponent)
            # the nearest integer, halves upwards; nothing below 2**-60 of the last bit
            assert found == math.floor(exact + Fraction(1, 2)), (x, exponent)
    row = [0.0, 0.0]
    axes.put_pair(row, (one // 3) * 7, 5)
    assert row[0] == 7.0 / 3.0 * 32.0 and abs(row[1]) <= 0.5 * math.ulp(row[0])
    assert abs(Fraction(row[0]) + Fraction(row[1]) - Fraction(224, 3)) < Fraction(2) ** -98
    assert axes.largest_of(1.0, -3.0, 2.0) == 3.0 == axes.largest_of(-3.0, 1.0, 1.0)
    assert axes.largest_of(0.0, 2.0, -3.0) == 3.0
    _check_handedness(wide, axes)
    _check_approach(truths, wide, axes)


def _check_handedness(wide, axes):
    """Rotations, and the same with the third axis reversed."""
    random = np.random.default_rng(8)
    for _ in range(60):
        turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
        kept = np.zeros(wide.WORDS * axes.KEPT, dtype=np.int64)
        for k in range(3):
            for i in range(3):
                n = int(turn[i, k] * 2.0**53) << (_BITS - 53)
                wide.store(kept, axes.COLUMNS + 3 * k + i, n)
        assert axes._left_handed(kept) == (np.linalg.det(turn) < 0.0)


def _check_approach(truths, wide, axes):
    """The start in doubles leaves 1e-15 beside the diagonal, of exactly turned tensors."""
    one = Fraction(2) ** _BITS
    started = 0
    for tensor, exact in truths.tensors:
        w = np.zeros(wide.WORDS * axes.NEEDED, dtype=np.int64)
        given, exponent = np.array(tensor), exact["exponent"]
        axes.put_tensor(given, exponent, w)
        memory = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(4)
        axes.approach(given, exponent, *memory, w)
        matrix = [
            [Fraction(wide.load(w, axes.MATRIX + 3 * i + j)) / one for j in range(3)]
            for i in range(3)
        ]
        turn = [
            [Fraction(wide.load(w, axes.AXES + 3 * i + j)) / one for j in range(3)]
            for i in range(3)
        ]
        beside = max(abs(math.ldexp(tensor[i][j], -exponent)) for i, j in ((0, 1), (0, 2), (1, 2)))
        values = sorted(float(Fraction(x) / one) for x in exact["values"])
        gap = min(values[1] - values[0], values[2] - values[1])
        is_turned = [row[:] for row in turn] != [[int(i == j) for j in range(3)] for i in range(3)]
        assert is_turned == (beside >= 2.0**-12 and gap > 2.0**-20), tensor
        started += is_turned
        rows = [[Fraction(x) / Fraction(2) ** exponent for x in row] for row in tensor]
        for i in range(3):
            for j in range(i, 3):
                dot = sum(turn[n][i] * turn[n][j] for n in range(3))
                assert abs(dot - (i == j)) < Fraction(2) ** -430
                image = sum(
                    turn[n][i] * rows[n][k] * turn[k][j] for n in range(3) for k in range(3)
                )
                assert abs(image - matrix[i][j]) < Fraction(2) ** -430
                if is_turned and i != j:
                    assert abs(matrix[i][j]) < 2.0**-49, tensor
    assert started > 8
