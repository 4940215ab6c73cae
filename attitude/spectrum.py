"""The spectrum of a tumbler's light curve: lines at sums of two frequencies, and series of them.

Under a Sun and an observer that stand still among the stars the brightness of a tumbling body is
a function of two angles, each of which turns uniformly but for periodic terms: its spectrum has
lines at |i / P_phi + j / P_psi| for whole i and j, and nowhere else.  In the other convention of
labelling the axes 1/P_phi differs by 1/P_psi, so that the same lines have other numbers.

Series: Pravec et al., Icarus 173, 108 (2005), eq. 11.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from attitude import validation
from attitude.errors import AttitudeError
from attitude.immutable import Immutable, frozen
from attitude.motion import Motion

# Singular values below this part of the greatest are those of lines that the span cannot tell
# apart, or that noise alone would fill.
_RANK = 1e-8
_ROUNDS = 60


class Line(NamedTuple):
    """One line: i and j of |i / P_phi + j / P_psi|, its frequency in Hz and period in s."""

    i: int
    j: int
    frequency: float
    period: float


def lines(motion, order=2, *, convention=None):
    """Where the light curve of a tumbler has its power.

    Parameters
    ----------
    motion : FreeRotation, or pair (P_psi, P_phi)
        s, or Quantities.
    order : int or pair (order of psi, order of phi)
        Lines with |j| and i up to these.
    convention : "L" or "S", optional
        Of P_phi, with a motion: whether the long or the short axis precesses; that about which
        the momentum circulates unless given.

    Returns
    -------
    list of Line
        In order of frequency; (i, j) and (-i, -j), being one line, are given with i >= 0.

    >>> hour = 3600.0
    >>> main = [line for line in lines((263.0 * hour, 27.38 * hour)) if (line.i, line.j) == (1, -1)]
    >>> round(main[0].period / hour, 2)              # of (99942) Apophis, Pravec et al. 2014
    30.56
    """
    psi, phi = _frequencies(motion, convention)
    found = []
    for i, j in _numbers(_orders(order)):
        frequency = abs(i * phi + j * psi)
        found.append(Line(i, j, frequency, 1.0 / frequency if frequency > 0.0 else np.inf))
    return sorted(found, key=lambda line: line.frequency)


@dataclass(frozen=True, eq=False, repr=False)
class SeriesFit(Immutable):
    """A series in two frequencies, fitted by least squares.

    Attributes
    ----------
    P_psi, P_phi : float
        s.
    order : (int, int)
        Of psi and of phi.
    offsets : (C,) array
        The constant term of each curve.
    cosines, sines : (K,) arrays
        Coefficients of cos and sin of 2 pi (i / P_phi + j / P_psi) (t - start).
    numbers : (K, 2) array of int
        i and j of each of them.
    start : float
        s; the middle of the data.
    residuals : (N,) array
        Data minus model, in the order of the data.
    rms : float
        sqrt(sum w r^2 / (N - parameters)), in the unit of the data (of the errors, if given).
    rank : int
        Of the equations: below `parameters` the span cannot tell some lines apart, and the
        smallest solution was taken.
    parameters : int
    """

    P_psi: float
    P_phi: float
    order: tuple
    offsets: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray
    numbers: np.ndarray
    start: float
    residuals: np.ndarray
    rms: float
    rank: int
    parameters: int

    def __call__(self, t, curve=0):
        """The model at seconds t, with the constant term of a curve (a number, or one per t)."""
        t = validation.real(t, "t", unit="s")
        curve = np.asarray(curve)
        if not (
            curve.dtype.kind in "iu"
            and curve.shape in ((), t.shape)
            and np.all((curve >= 0) & (curve < len(self.offsets)))
        ):
            raise AttitudeError(
                f"curve is {validation.shown(curve)}; give whole numbers from 0 to "
                f"{len(self.offsets) - 1}, one for all epochs or one for each."
            )
        angles = _angles(t.reshape(-1), self.start, self.P_psi, self.P_phi, self.numbers)
        wave = np.cos(angles) @ self.cosines + np.sin(angles) @ self.sines
        return wave.reshape(t.shape) + self.offsets[curve]

    @property
    def amplitudes(self):
        """(K,): of each line, half of its peak to peak."""
        return np.hypot(self.cosines, self.sines)

    def strongest(self, count=None):
        """(Line, amplitude) pairs, the greatest amplitude first."""
        amplitudes = self.amplitudes
        found = []
        for k in np.argsort(-amplitudes, kind="stable")[:count]:
            i, j = (int(n) for n in self.numbers[k])
            frequency = abs(i / self.P_phi + j / self.P_psi)
            period = 1.0 / frequency if frequency > 0.0 else np.inf
            found.append((Line(i, j, frequency, period), float(amplitudes[k])))
        return found

    def __repr__(self):
        return (
            f"<SeriesFit of order {self.order}: P_psi {self.P_psi:.9g} s, P_phi {self.P_phi:.9g} "
            f"s, rms {self.rms:.3g}>"
        )


def fit(t, values, P_psi, P_phi, *, order=2, errors=None, curve=None):
    """Fit a two-dimensional Fourier series to a light curve.

    Parameters
    ----------
    t : (N,) array_like
        s (or a Quantity), in any order.
    values : (N,) array_like
        Magnitudes or intensities.
    P_psi, P_phi : float or Quantity
        s; in either convention.
    order : int or pair (order of psi, order of phi)
        2 m (m + 1) lines for an order m.
    errors : (N,) array_like, optional
        One standard deviation of each value.
    curve : (N,) array_like of int, optional
        Number of the curve to which each value belongs, from 0: each has its own constant term.

    Returns
    -------
    SeriesFit

    Raises
    ------
    AttitudeError
        For fewer values than unknowns, and shapes that do not fit.

    >>> t = np.linspace(0, 1000, 400)
    >>> found = fit(t, 5 + 2 * np.cos(2 * np.pi * (1 / 17 - 1 / 90) * t), 90, 17)
    >>> line, amplitude = found.strongest(1)[0]
    >>> (line.i, line.j), round(amplitude, 9)
    ((1, -1), 2.0)
    """
    data = _Data(t, values, errors, curve)
    order = _orders(order)
    psi = 1.0 / validation.positive(P_psi, "P_psi", unit="s")
    phi = 1.0 / validation.positive(P_phi, "P_phi", unit="s")
    numbers = np.array(_numbers(order))
    data.refuse_few(numbers)
    solution, residuals, rank = data.solved(psi, phi, numbers)
    count, curves = len(numbers), data.curves
    free = max(1, len(data.t) - rank)
    return SeriesFit(
        1.0 / psi,
        1.0 / phi,
        order,
        frozen(solution[:curves]),
        frozen(solution[curves : curves + count]),
        frozen(solution[curves + count :]),
        frozen(numbers),
        data.start,
        frozen(residuals),
        float(np.sqrt(np.sum((residuals * data.weights) ** 2) / free)),
        rank,
        curves + 2 * count,
    )


def search(t, values, P_psi, P_phi, *, within=0.01, order=2, errors=None, curve=None):
    """The series with the least residuals for periods near given ones.

    Parameters
    ----------
    t, values, P_psi, P_phi, order, errors, curve : as of `fit`
    within : float or pair (of P_psi, of P_phi)
        How far, as a part of the period, to look to either side.

    Returns
    -------
    SeriesFit

    Notes
    -----
    The sum of squares is taken at frequencies a quarter of 1 / (span * order) apart, which is a
    sixth of the width of its valleys; from the three lowest, Levenberg-Marquardt descends in both
    frequencies (variable projection: the linear terms are fitted at each).

    Raises
    ------
    AttitudeError
        For more than 1e5 places to look at; narrow `within`, or thin the data.
    """
    from scipy.optimize import least_squares

    data = _Data(t, values, errors, curve)
    orders = _orders(order)
    numbers = np.array(_numbers(orders))
    data.refuse_few(numbers)
    centre = np.array(
        [
            1.0 / validation.positive(P_psi, "P_psi", unit="s"),
            1.0 / validation.positive(P_phi, "P_phi", unit="s"),
        ]
    )
    spread = validation.real(within, "within") * np.ones(2)
    if spread.shape != (2,) or not np.all((spread >= 0.0) & (spread < 1.0)):
        raise AttitudeError(f"within is {within!r}; give parts of the periods, from 0 to below 1.")
    span = np.ptp(data.t)
    if not span > 0.0:
        raise AttitudeError("all values are of one epoch; give a span of them.")
    steps = [0.25 / (span * max(1, n)) for n in orders]
    grids = [_grid(*each) for each in zip(centre, spread, steps, strict=True)]
    places = len(grids[0]) * len(grids[1])
    if places > 100_000:
        raise AttitudeError(
            f"{places} pairs of periods lie that near to the given ones; narrow within= (now "
            f"{within!r})."
        )
    pairs = np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1).reshape(-1, 2)
    sums = [data.roughly(*pair, numbers) for pair in pairs]
    unit = 1.0 / span
    best = None
    for k in np.argsort(sums)[:3]:
        found = least_squares(
            lambda x, pair=pairs[k]: data.weighted(*(pair + unit * x), numbers),
            np.zeros(2),
            method="lm",
            xtol=1e-13,
            ftol=1e-13,
            max_nfev=_ROUNDS,
        )
        if best is None or found.cost < best[0]:
            best = found.cost, pairs[k] + unit * found.x
    psi, phi = best[1]
    return fit(t, values, 1.0 / psi, 1.0 / phi, order=order, errors=errors, curve=curve)


class _Data:
    """Values, weights and numbers of curves, checked."""

    def __init__(self, t, values, errors, curve):
        self.t = validation.real(t, "t", unit="s")
        if self.t.ndim != 1 or not self.t.size:
            raise AttitudeError(f"t has shape {self.t.shape}; give a row of epochs, (N,).")
        shape = self.t.shape
        self.values = validation.real(values, "values", shape=shape)
        self.weights = np.ones(shape)
        if errors is not None:
            given = validation.real(errors, "errors", shape=shape)
            if not np.all(given > 0.0):
                raise AttitudeError("errors holds a number that is not above zero; leave it out.")
            self.weights = 1.0 / given
        self.curve = np.zeros(shape, int) if curve is None else np.asarray(curve)
        if self.curve.shape != shape or self.curve.dtype.kind not in "iu":
            raise AttitudeError(f"curve must be whole numbers of shape {shape}, from 0.")
        self.curves = int(self.curve.max()) + 1
        if set(np.unique(self.curve)) != set(range(self.curves)):
            raise AttitudeError("curve must hold every number from 0 to its greatest.")
        self.start = float(0.5 * (self.t.min() + self.t.max()))

    def refuse_few(self, numbers):
        wanted = self.curves + 2 * len(numbers)
        if len(self.t) < wanted:
            raise AttitudeError(
                f"{len(self.t)} values are given for {wanted} unknowns; give more, or lower order."
            )

    def solved(self, psi, phi, numbers):
        """Coefficients, residuals and rank."""
        matrix = self._matrix(psi, phi, numbers)
        solution, _, rank, _ = np.linalg.lstsq(
            matrix * self.weights[:, None], self.values * self.weights, rcond=_RANK
        )
        return solution, self.values - matrix @ solution, int(rank)

    def weighted(self, psi, phi, numbers):
        return self.solved(psi, phi, numbers)[1] * self.weights

    def roughly(self, psi, phi, numbers):
        """The sum of squares from the normal equations: faster, to 1e-6 of the data's."""
        matrix = self._matrix(psi, phi, numbers) * self.weights[:, None]
        values = self.values * self.weights
        normal, right = matrix.T @ matrix, matrix.T @ values
        normal.flat[:: len(normal) + 1] *= 1.0 + 1e-9
        return float(values @ values - right @ np.linalg.solve(normal, right))

    def _matrix(self, psi, phi, numbers):
        angles = _angles(self.t, self.start, 1.0 / psi, 1.0 / phi, numbers)
        own = self.curve[:, None] == np.arange(self.curves)
        return np.concatenate([own, np.cos(angles), np.sin(angles)], axis=1)


def _angles(t, start, P_psi, P_phi, numbers):
    """(N, K) rad; turns are reduced before they are multiplied by 2 pi."""
    turns = np.outer((t - start) / P_phi, numbers[:, 0]) + np.outer(
        (t - start) / P_psi, numbers[:, 1]
    )
    return 2.0 * np.pi * (turns - np.rint(turns))


def _numbers(orders):
    """All (i, j) but (0, 0), one of each pair of opposite ones."""
    of_psi, of_phi = orders
    found = [(0, j) for j in range(1, of_psi + 1)]
    return found + [(i, j) for i in range(1, of_phi + 1) for j in range(-of_psi, of_psi + 1)]


def _orders(order):
    pair = (order, order) if np.ndim(order) == 0 else tuple(order)
    whole = all(isinstance(n, (int, np.integer)) and not isinstance(n, bool) for n in pair)
    if len(pair) != 2 or not whole or min(pair) < 0 or max(pair) < 1:
        raise AttitudeError(
            f"order is {order!r}; give a whole number above zero, or two of them: of psi, of phi."
        )
    return int(pair[0]), int(pair[1])


def _frequencies(motion, convention):
    if isinstance(motion, Motion):
        found = motion.regime
        P_phi = motion.period_phi if convention is None else found.P_phi(convention)
        return 1.0 / motion.period_psi, 1.0 / P_phi
    if convention is not None:
        raise AttitudeError("convention goes with a motion; a pair of periods has its own.")
    try:
        P_psi, P_phi = motion
    except (TypeError, ValueError) as err:
        raise AttitudeError(
            f"motion is {motion!r}; give a FreeRotation, or the pair (P_psi, P_phi)."
        ) from err
    return (
        1.0 / validation.positive(P_psi, "P_psi", unit="s"),
        1.0 / validation.positive(P_phi, "P_phi", unit="s"),
    )


def _grid(frequency, part, step):
    reach = int(np.ceil(part * frequency / step))
    return frequency + step * np.arange(-reach, reach + 1)
