"""The exact free rotation in arbitrary precision: the witness that the tests measure against.

Given doubles are taken as exact numbers and every result is right to `digits` decimals. The route
is deliberately not the one of the package, which evaluates a quotient of theta functions. Here:

1. the angular momentum in body axes follows Jacobi's elliptic functions, found from the amplitude
   am(u|m) by the descending Landen transformation (DLMF 22.20(ii));
2. the angle phi by which the body precesses about the momentum is Legendre's incomplete integral
   of the third kind, a secular part times the count of half periods plus Carlson's R_J for the
   rest (DLMF 19.25.14; van Zon & Schofield 2006, section 3);
3. the attitude is composed of half angles from z-x-z Euler angles about the momentum:
   phi about L, theta the tilt of the circulating axis, psi the angle about that axis.

Conventions: wxyz carries body to inertial components, scalar first; angular velocity omega is in
body axes, rad/s; moments in kg m2 (any unit); t in seconds.

Cancellation is met by precision alone. The invariants are exact (enough bits for sums and products
of the given doubles), the rest carries as many digits as the state and the epoch can lose.

Sign of the quaternion: am(u) = k pi + phi, |phi| <= pi/2, counts the half periods k; psi is a
continuous, monotonic function of am, phi is an integral, and theta stays in [0, pi/2]. With both
angles unwrapped, the product of half-angle rotations is continuous in t and starts at wxyz0.
"""

from mpmath import libmp, mp, mpf

try:
    import flint
except ImportError:
    flint = None

_PHASE_BITS = 50  # the constants serve epochs up to 2^50 radians, and are then rebuilt with more


class Oracle:
    """Exact attitude and rates of one freely rotating rigid body.

    moments (3,), wxyz0 (4,), omega0 (3,): floats or mpf, taken as exact; wxyz0 is normalised here.
    `digits` decimals of the attitude, and of each rate relative to its amplitude, are right.

    regime: "rest", "constant" (angular velocity fixed in the body), "separatrix" or "tumbling".
    mode: "LAM", "SAM" or None: whether L circulates about the axis of least or greatest inertia.
    distance: |L^2 - 2 E I2| over the sum of its terms' magnitudes, 0 on the separatrix; or None.
    """

    def __init__(self, moments, wxyz0, omega0, digits=40):
        axes = [[mpf(int(i == j)) for j in range(3)] for i in range(3)]
        moments, omega0 = _exact(moments, 3, "moments"), _exact(omega0, 3, "omega0")
        bits = 2 * _span(moments) + 2 * _span(omega0) + 64
        self._prepare(moments, axes, omega0, wxyz0, digits, bits, smallest=mpf(0))

    @classmethod
    def from_tensor(cls, tensor, wxyz0, omega0, digits=40):
        """The same for a symmetric inertia tensor (3, 3) and body axes that are not principal.

        The eigenvalues are irrational, so equalities among them cannot be read off exactly. But
        discriminant, det(L^2 - 2 E J) and det(w, J w, J J w) are integers when the entries are, so
        what does not vanish exceeds 2^-(6 x bits of the entries): anything smaller is set to zero.
        """
        rows = [_exact(row, 3, "tensor row") for row in tensor]
        if len(rows) != 3 or any(rows[i][j] != rows[j][i] for i in range(3) for j in range(i)):
            raise ValueError("tensor must be a symmetric 3 x 3 matrix")
        omega0 = _exact(omega0, 3, "omega0")
        span = _span([x for row in rows for x in row]) + _span(omega0)
        bits = 8 * span + 400
        with mp.workprec(bits):
            smallest = mp.ldexp(1, -(6 * span + 64))
            values, vectors = mp.eigsy(mp.matrix(rows))
            axes = [[vectors[i, j] for j in range(3)] for i in range(3)]
            if mp.det(vectors) < 0:
                axes = [[-x for x in row] for row in axes]
            omega = [sum(axes[i][j] * omega0[i] for i in range(3)) for j in range(3)]
            moments, omega = _snap_moments(list(values), smallest), _snap(omega, smallest)
        oracle = cls.__new__(cls)
        oracle._prepare(moments, axes, omega, wxyz0, digits, bits, smallest)
        return oracle

    def _prepare(self, moments, axes, omega, wxyz0, digits, bits, smallest):
        """Choose regime and Jacobi frame. Column j of axes is principal axis j in user axes."""
        if any(x < 0 for x in moments) or sum(x == 0 for x in moments) > 1:
            raise ValueError(f"moments {moments} are not those of a rigid body")
        if any(x == 0 and w != 0 for x, w in zip(moments, omega, strict=True)):
            raise ValueError("spin about an axis without inertia is undefined")
        self.digits = digits
        self.mode = self.distance = None
        self._wxyz0 = _exact(wxyz0, 4, "wxyz0")
        if not any(self._wxyz0):
            raise ValueError("wxyz0 has no direction")
        self._bits, self._prec, self._extra, self._motion = bits, bits, 0, None
        with mp.workprec(bits):
            pairs = ((0, 1), (0, 2), (1, 2))
            if not any(omega):
                self.regime = "rest"
            elif all(moments[i] == moments[j] or not (omega[i] and omega[j]) for i, j in pairs):
                self.regime = "constant"
            else:
                self._choose_jacobi_frame(moments, axes, omega, smallest)
                return
        self._moments, self._axes, self._omega = moments, axes, omega

    def _choose_jacobi_frame(self, moments, axes, omega, smallest):
        """Order the axes so that L circulates about the third (3.32) and w1, w3 >= 0 at t = 0.

        A pair of equal moments always ends on axes 1 and 2: the middle moment is then one of the
        pair, and D2 has the sign of its other term.
        """
        low, mid, high = order = sorted(range(3), key=lambda i: moments[i])
        terms = [moments[i] * (moments[i] - moments[mid]) * omega[i] ** 2 for i in (low, high)]
        size = abs(terms[0]) + abs(terms[1])
        d2 = mp.fsum(terms)
        if abs(d2) <= smallest * size:
            d2 = mpf(0)
        self.distance = abs(d2) / size
        self.regime = "tumbling" if d2 else "separatrix"
        if d2:
            self.mode = "SAM" if d2 > 0 else "LAM"
        if d2 < 0:
            order = order[::-1]
        parity = -1 if order in ([0, 2, 1], [1, 0, 2], [2, 1, 0]) else 1
        signs = [-1 if omega[i] < 0 else 1 for i in order]
        signs[1] = parity * signs[0] * signs[2]
        self._moments = [moments[i] for i in order]
        self._omega = [s * omega[i] for s, i in zip(signs, order, strict=True)]
        self._axes = [[s * row[i] for s, i in zip(signs, order, strict=True)] for row in axes]
        self._d2 = d2

    def at(self, t, t_low=0.0):
        """Attitude and rates at t + t_low: (wxyz of 4 mpf, omega of 3 mpf); t may be a pair."""
        if isinstance(t, (tuple, list)):
            t, t_low = t
        t = mp.fadd(mp.convert(t), mp.convert(t_low), exact=True)
        radians = max(0, _mag(t) + self._fastest_mag())
        if self._motion is None or radians > _PHASE_BITS + self._extra:
            self._extra = max(0, radians - _PHASE_BITS)
            self._build()
        with mp.workprec(self._prec):
            relative, omega = self._motion.at(t)
            vector = _rotate(self._turn, relative[1:])
            wxyz = multiply(self._unit, (relative[0], *vector))
            return wxyz, tuple(_rotate(self._turn, omega))

    def momentum(self, wxyz, omega):
        """Angular momentum in inertial axes of a state (wxyz, omega in body axes); it is fixed."""
        with mp.workprec(self._prec):
            inner = _rotate(zip(*self._axes, strict=True), omega)
            body = _rotate(self._axes, [i * w for i, w in zip(self._moments, inner, strict=True)])
            return multiply(multiply(wxyz, (mpf(0), *body)), conjugate(wxyz))[1:]

    def energy(self, omega):
        """Rotational energy of angular velocity omega (body axes)."""
        with mp.workprec(self._prec):
            inner = _rotate(zip(*self._axes, strict=True), omega)
            return mp.fsum(i * w * w for i, w in zip(self._moments, inner, strict=True)) / 2

    def _fastest_mag(self):
        """Binary exponent of the fastest phase rate: |w|, or L / I_min which bounds phi'."""
        rate = max(_mag(w) for w in self._omega)
        if self.regime in ("rest", "constant"):
            return rate + 2
        momentum = max(_mag(i) + _mag(w) for i, w in zip(self._moments, self._omega, strict=True))
        return max(rate, momentum - min(_mag(i) for i in self._moments)) + 3

    def _build(self):
        """Constants of the motion, with the digits asked for, those lost and those of the phase."""
        base = int(self.digits * 3.33) + 16 + _PHASE_BITS + self._extra
        if self.regime in ("rest", "constant"):
            self._prec = base
        else:
            with mp.workprec(self._bits + base):
                lost = _Tumbling(self._moments, self._omega, self._d2).bits_lost()
            self._prec = base + lost
            with mp.workprec(self._bits + self._prec):
                constants = _Tumbling(self._moments, self._omega, self._d2)
        with mp.workprec(self._prec):
            norm = mp.sqrt(mp.fsum(x * x for x in self._wxyz0))
            self._unit = [x / norm for x in self._wxyz0]
            self._turn = [[+x for x in row] for row in self._axes]
            if self.regime in ("rest", "constant"):
                self._motion = _Constant(self._omega)
            else:
                constants.add_integrals()
                self._motion = constants


class _Constant:
    """Angular velocity that is fixed in the body: rest, sphere, principal axis, equatorial spin."""

    def __init__(self, omega):
        self.omega = [+w for w in omega]
        self.size = mp.sqrt(mp.fsum(w * w for w in omega))

    def at(self, t):
        if not self.size:
            return (mpf(1), mpf(0), mpf(0), mpf(0)), self.omega
        cosine, sine = mp.cos_sin(self.size * t / 2)
        return (cosine, *(w / self.size * sine for w in self.omega)), self.omega


class _Tumbling:
    """Constants and angles of a tumbling state in the Jacobi frame (axis 3 circulates).

    w1 = a1 cn u, w2 = -a2 sn u, w3 = a3 dn u, u = rate t + u0 (van Zon & Schofield, section 3).
    phi' = L/I3 + L (I3 - I1) / (I1 I3 (1 - n sn^2 u)) from L^2 = sum I^2 w^2 and 2 E = sum I w^2.
    """

    def __init__(self, moments, omega, d2):
        i1, i2, i3 = moments
        w1, w2, w3 = omega
        d1 = i2 * (i2 - i1) * w2**2 + i3 * (i3 - i1) * w3**2
        d3 = i1 * (i1 - i3) * w1**2 + i2 * (i2 - i3) * w2**2
        momentum2 = (i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2
        self.moments = moments
        self.mc = d2 * (i3 - i1) / (d1 * (i3 - i2))
        self.n = -(i3 * (i1 - i2)) / (i1 * (i2 - i3))
        self.one_minus_n = i2 * (i1 - i3) / (i1 * (i2 - i3))
        self.rate = mp.sign(i2 - i3) * mp.sqrt(abs(d1 * (i3 - i2)) / (i1 * i2 * i3))
        self.a1 = mp.sqrt(d3 / (i1 * (i1 - i3)))
        self.a2 = mp.sqrt(d3 / (i2 * (i2 - i3)))
        self.a3 = mp.sqrt(d1 / (i3 * (i3 - i1)))
        self.momentum = mp.sqrt(momentum2)
        self.l3_max = i3 * self.a3 / self.momentum
        self.tilt2_min = i1 * d3 / ((i1 - i3) * momentum2)  # 1 - l3^2 = tilt2_min (1 - n sn^2)
        self.steady = self.momentum / i3
        self.coupling = self.momentum * (i3 - i1) / (i1 * i3 * self.rate)
        self.am0 = mp.atan2(-w2 / self.a2, w1 / self.a1)  # in [-pi/2, pi/2], since w1 >= 0

    def bits_lost(self):
        """Bits that cancellation can take: each ratio far from 1 is paid for in full."""
        extremes = [_mag(i) for i in self.moments]
        lost = max(extremes) - min(extremes) + max(0, _mag(self.coupling))
        lost += 2 * max(0, _mag(self.one_minus_n))
        return lost + (max(0, -_mag(self.mc)) if self.mc else 0) + 8

    def add_integrals(self):
        """Quarter period, complete Pi, and the values at t = 0."""
        for name, value in vars(self).items():  # round the exact numbers: long ones cost time
            if isinstance(value, mpf):
                setattr(self, name, +value)
        sine, cosine = mp.sin(self.am0), mp.cos(self.am0)
        if self.mc:
            self.landen = _landen(self.mc)
            self.quarter = mp.pi / (2 * self.landen[0])
            self.complete = self.quarter
            if self.n:
                self.complete += self.n / 3 * carlson_rj(mpf(0), self.mc, self.one_minus_n)
            self.u0 = sine * mp.elliprf(cosine**2, cosine**2 + self.mc * sine**2, 1)
            self.pi0 = self._third_kind(self.u0, sine, cosine)
        else:
            self.u0 = mp.asinh(sine / cosine)
            self.pi0 = self._third_kind_at_one(self.u0)
        (_, theta, psi), _ = self.angles(mpf(0))
        self.start = conjugate(_euler_quaternion(mpf(0), theta, psi))

    def _third_kind(self, u, sine, cosine):
        """Pi(n; am u | m) for |am u| <= pi/2: F is u itself, so that only R_J is left."""
        if not self.n:
            return u
        c2, s2 = cosine**2, sine**2
        third = carlson_rj(c2, c2 + self.mc * s2, c2 + self.one_minus_n * s2)
        return u + self.n / 3 * sine * s2 * third

    def at(self, t):
        """Attitude relative to that at t = 0, and rates, in the Jacobi frame."""
        angles, omega = self.angles(t)
        return multiply(self.start, _euler_quaternion(*angles)), omega

    def angles(self, t):
        """(phi, theta, psi) unwrapped, radians, phi(0) = 0; and the rates, in the Jacobi frame."""
        u = self.rate * t + self.u0
        if self.mc:
            count = int(mp.nint(u / (2 * self.quarter)))
            rest = u - 2 * count * self.quarter
            amplitude = _amplitude(self.landen, rest)
            cosine, sine = mp.cos_sin(amplitude)
            third = 2 * count * self.complete + self._third_kind(rest, sine, cosine)
        else:  # m = 1: sn = tanh, cn = dn = sech
            count = 0
            cosine, sine = mp.sech(u), mp.tanh(u)
            third = self._third_kind_at_one(u)
        delta = mp.sqrt(cosine**2 + self.mc * sine**2)
        flip = -1 if count % 2 else 1
        omega = (self.a1 * cosine * flip, -self.a2 * sine * flip, self.a3 * delta)

        phi = self.steady * t + self.coupling * (third - self.pi0)
        psi = (count + mpf(1) / 2) * mp.pi + mp.atan2(mp.sqrt(self.one_minus_n) * sine, cosine)
        tilt = mp.sqrt(self.tilt2_min * (cosine**2 + self.one_minus_n * sine**2))
        theta = mp.atan2(tilt, self.l3_max * delta)
        return (phi, theta, psi), omega

    def _third_kind_at_one(self, u):
        """Integral of du / (1 - n tanh^2 u), elementary: R_J would cancel where cn -> 0.

        With r = sqrt(-n) it is (u + r atan(r tanh u)) / (1 + r^2), as differentiation shows.
        """
        root = mp.sqrt(-self.n)
        return (u + root * mp.atan(root * mp.tanh(u))) / self.one_minus_n


def carlson_rj(x, y, p):
    """R_J(x, y, 1, p), to half a unit in the last place of mpmath's precision where balls have it:
    python-flint takes a thirtieth of mpmath's time.
    """
    if flint is not None:
        with flint.ctx.workprec(mp.prec + 32):
            ball = flint.acb.elliptic_rj(*(flint.acb(flint.arb(a)) for a in (x, y, mpf(1), p))).real
            if ball.rel_accuracy_bits() > mp.prec + 2:
                man, exp = map(int, ball.mid().man_exp())
                return +mp.make_mpf(libmp.from_man_exp(man, exp))
    return mp.elliprj(x, y, 1, p)


def _landen(mc):
    """Limit of the AGM of (1, sqrt(mc)) and the ratios c/a of its steps (DLMF 22.20.1)."""
    a, b, ratios = mpf(1), mp.sqrt(mc), []
    while True:
        a, b, c = (a + b) / 2, mp.sqrt(a * b), (a - b) / 2
        if _mag(c) < _mag(a) - mp.prec + 8:  # rounding keeps a - b from reaching zero
            return a, ratios
        ratios.append(c / a)


def _amplitude(landen, u):
    """am(u|m) for |u| <= K by the descending Landen transformation (DLMF 22.20.3 to 22.20.5)."""
    limit, ratios = landen
    phi = mp.ldexp(limit * u, len(ratios))
    for ratio in reversed(ratios):
        phi = (phi + mp.asin(ratio * mp.sin(phi))) / 2
    return phi


def _euler_quaternion(phi, theta, psi):
    """Rz(phi) Rx(theta) Rz(psi) as a quaternion, from half angles (continuous in the angles)."""
    ct, st = mp.cos_sin(theta / 2)
    cs, ss = mp.cos_sin((phi + psi) / 2)
    cd, sd = mp.cos_sin((phi - psi) / 2)
    return ct * cs, st * cd, st * sd, ct * ss


def multiply(p, q):
    """Quaternion product p q, scalar first."""
    a, b, c, d = p
    e, f, g, h = q
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def rotation_error(wxyz, exact, signed=False):
    """Angle in radians between two rotations given by quaternions of any norm (floats or mpf).

    With signed=True the quaternions themselves are compared: the wrong overall sign is 2 pi.
    """
    with mp.workprec(400):
        wxyz = [mp.convert(x) for x in wxyz]
        w, *vector = multiply(conjugate(wxyz), exact)
        size = mp.sqrt(mp.fsum(x * x for x in vector))
        if not (mp.isfinite(w) and mp.isfinite(size)) or not (w or size):
            return float("inf")
        return float(2 * mp.atan2(size, w if signed else abs(w)))


def rate_error(omega, exact):
    """Largest error of a component of omega over the largest component of the exact one."""
    with mp.workprec(400):
        error = max(abs(mp.convert(x) - y) for x, y in zip(omega, exact, strict=True))
        size = max(abs(y) for y in exact)
        if not mp.isfinite(error) or (error and not size):
            return float("inf")
        return float(error / size) if error else 0.0


def two_floats(values):
    """Numbers as (high, low) lists of floats, high + low within 2^-106 of each."""
    high = [float(x) for x in values]
    with mp.workprec(400):
        return high, [float(x - h) for x, h in zip(values, high, strict=True)]


def _rotate(matrix, v):
    return [mp.fsum(x * y for x, y in zip(row, v, strict=True)) for row in matrix]


def _exact(values, count, name):
    """Numbers as mpf without rounding: mpf() would round a long mpf to the current precision."""
    values = [mp.convert(x) for x in values]
    if len(values) != count or not all(mp.isfinite(x) for x in values):
        raise ValueError(f"{name} must be {count} finite numbers, not {values}")
    return values


def _mag(x):
    """Binary exponent of a number; far below all others for zero."""
    return int(mp.mag(x)) if x else -(10**9)


def _span(values):
    """Bits from the highest to the lowest one set in any of the numbers."""
    parts = [x.man_exp for x in values if x]
    top = max((abs(man).bit_length() + exp for man, exp in parts), default=0)
    return top - min((exp for _, exp in parts), default=0)


def _snap(values, smallest):
    """Components that are zero but for rounding, set to zero."""
    size = max(abs(x) for x in values)
    return [mpf(0) if abs(x) <= smallest * size else x for x in values]


def _snap_moments(moments, smallest):
    """Moments that are equal or zero but for rounding, made so."""
    moments = _snap(moments, smallest)
    for i, j in ((0, 1), (1, 2), (0, 2)):
        if abs(moments[i] - moments[j]) <= smallest * max(moments):
            moments[j] = moments[i]
    return moments
