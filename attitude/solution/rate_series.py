"""Coefficients of the angular velocity: made only where angular velocities are asked for."""

import math

from attitude.solution import codes
from attitude.solution.coefficients import COS_EVEN, COS_ODD, SIN_ODD
from attitude.solution.machine import compiled, inlined


@compiled
def trigonometric_rates_all(constants):
    """The series of cn, sn and dn, times the amplitudes, of those of B motions of this form."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.TRIGONOMETRIC:
            _trigonometric(math.sqrt(c.nome), c, c.rates)


@compiled
def hyperbolic_rates_all(constants):
    """The same of those whose form is hyperbolic."""
    for b in range(len(constants)):
        c = constants[b]
        if c.fault == codes.FINE and c.form == codes.HYPERBOLIC:
            _hyperbolic(c.nome, c)


@inlined
def _trigonometric(q, c, rates):
    """cn, sn, dn as theta quotients; theta1 and theta2 without their factor 2 q^(1/4)."""
    theta2 = theta3 = theta4 = 0.0
    sign = even = odd = step = 1.0
    for n in range(5):
        # even = 2 q^(n^2) (1 at n = 0), odd = q^(n(n+1)), step = q^n
        theta2 += odd
        theta3 += even
        theta4 += sign * even
        for k in range(5):
            rates[0, k] += odd * COS_ODD[n, k]
            rates[1, k] += sign * odd * SIN_ODD[n, k]
            rates[2, k] += even * COS_EVEN[n, k]
            rates[3, k] += sign * even * COS_EVEN[n, k]
        even = 2.0 * q if n == 0 else even * step * step * q
        odd *= step * step * q * q
        step *= q
        sign = -sign
    for k in range(5):
        rates[0, k] *= c.amplitudes[0] * theta4 / theta2
        rates[1, k] *= -c.amplitudes[1] * theta3 / theta2
        rates[2, k] *= c.amplitudes[2] * theta4 / theta3


@inlined
def _hyperbolic(nome, c):
    """The same after the modular transformation, nome Q'^2."""
    q = nome * nome
    qq = q * q
    theta2 = 1.0 + qq + qq * qq * qq
    theta3 = 1.0 + 2.0 * (q + qq * qq)
    theta4 = 1.0 - 2.0 * (q - qq * qq)
    cn = 2.0 * c.amplitudes[0] * theta2 / theta4
    sn = -c.amplitudes[1] * theta3 / theta4
    dn = 2.0 * c.amplitudes[2] * theta2 / theta3
    for n in range(3):
        sign = -1.0 if n == 1 else 1.0
        even = qq if n == 2 else 1.0  # q^(n(n-1))
        odd = 1.0 if n == 0 else (q if n == 1 else qq * qq)  # q^(n^2)
        c.rates[0, n] = cn * sign * even
        c.rates[1, n] = sn * sign * odd
        c.rates[2, n] = dn * even
        c.rates[3, n] = odd
