"""The exact attitude by rigorous quadrature: no quotient of theta functions, no third kind.

The momentum follows from sn, cn and dn; the one angle chi about it is the integral, enclosed by
`acb.integral`, of (w3 + 2 E / L) / (2 (1 + l3)) over whole periods and a rest (the first display of
section 4 of docs/derivation.md).  alpha = sqrt((1 + l3) / 2) e^(i chi), and
beta = (l2 - i l1) / (2 sqrt((1 + l3) / 2)) e^(i chi).
"""

from flint import acb, arb

from attitude.proof._exact import ball, conjugate, product, unit


def attitude(solution, t):
    """Four balls at t seconds (a fraction), for a `Solution` of the form "theta" and moments."""
    decided = solution.decided
    i1, i2, i3 = (ball(decided.moments[k]) for k in solution.order)
    w1, w2, w3 = (
        ball(s * decided.rates[k]) for s, k in zip(solution.signs, solution.order, strict=True)
    )
    length = ((i1 * w1) ** 2 + (i2 * w2) ** 2 + (i3 * w3) ** 2).sqrt()
    double_energy = i1 * w1 * w1 + i2 * w2 * w2 + i3 * w3 * w3
    quarter, start, wp = solution.quarter, solution.phase, solution.wp
    tau = solution.tau / 2
    zero = acb(0).modular_theta(tau)
    a1 = (w1 * w1 + w2 * w2 * i2 * abs(i2 - i3) / (i1 * abs(i1 - i3))).sqrt()
    a2 = (w2 * w2 + w1 * w1 * i1 * abs(i1 - i3) / (i2 * abs(i2 - i3))).sqrt()
    # the amplitude of w3, from the momentum at t = 0
    m1, m2 = i1 * w1 / length, i2 * w2 / length

    def jacobi(u):
        theta = (u / (2 * quarter)).modular_theta(tau)
        sn = zero[2] / zero[1] * theta[0] / theta[3]
        cn = zero[3] / zero[1] * theta[1] / theta[3]
        return sn, cn, zero[3] / zero[2] * theta[2] / theta[3]

    largest = (1 - m1 * m1 - m2 * m2).sqrt() / jacobi(acb(start))[2].real

    def rate(u, _):
        dn = jacobi(u)[2]
        return (largest * length / i3 * dn + double_energy / length) / (2 * (1 + largest * dn)) / wp

    end = start + wp * ball(t)
    periods = int((wp * ball(t) / (2 * quarter)).mid().floor().unique_fmpz())
    chi = acb.integral(rate, acb(start), acb(end - 2 * quarter * periods)).real
    if periods:
        whole = acb.integral(rate, acb(start), acb(start + 2 * quarter)).real
        chi = chi + periods * whole

    def pair(u, turn):
        sn, cn, dn = (x.real for x in jacobi(acb(u)))
        l1, l2, l3 = i1 * a1 * cn / length, -i2 * a2 * sn / length, largest * dn
        root = ((1 + l3) / 2).sqrt()
        phase = acb(0, turn).exp()
        alpha, beta = root * phase, acb(l2, -l1) / (2 * root) * phase
        return unit([alpha.real, beta.real, beta.imag, alpha.imag])

    left = product(product(solution.start, solution.body), conjugate(pair(start, arb(0))))
    return product(product(left, pair(end, chi)), conjugate(solution.body))
