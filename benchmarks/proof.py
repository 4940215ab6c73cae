"""What do proofs cost, how tight are they, and what do they prove?

python benchmarks/proof.py                    all of the following, 3 minutes
python benchmarks/proof.py cost               a certificate, an epoch, a bound for all epochs
python benchmarks/proof.py witnesses 1000     certificates against the mpmath oracle
python benchmarks/proof.py bodies 200         bounds for all epochs, and certificates below them
python benchmarks/proof.py hunt 100000 1      certified errors of random states
python benchmarks/proof.py loops              the theorem of the loops, and other arrangements
python benchmarks/proof.py figure             docs/figures/proof.png
"""

from __future__ import annotations

import math
import random
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from attitude import AttitudeError, Body, FreeRotation, Spin
from benchmarks.doc_tables import Table, markdown
from benchmarks.record import FIGURES, ROOT
from tests.support import loop_bounds, rounding_bounds, states, traced
from tests.support.hunting import hunted
from tests.support.measure import motion_of
from tests.support.oracle import Oracle, rotation_error

MAKES = ("proof",)

_BODIES = {
    "short-axis mode": ((3.0, 4.0, 6.0), (0.004, 0.002, 0.1)),
    "long-axis mode": ((3.0, 4.0, 6.0), (0.1, 0.002, 0.004)),
    "near the separatrix": ((10.0, 20.0, 26.0), (0.086, -0.015, 0.0688)),
    "symmetric body": ((2.0, 2.0, 3.0), (0.05, 0.02, 0.08)),
    "on the separatrix": ((2.0, 5.0, 6.0), (0.0625, 0.02, 0.0625)),
    "uniform rotation": ((3.0, 4.0, 6.0), (0.0, 0.0, 0.1)),
}


def motion(name):
    """The motion of a row of _BODIES."""
    moments, rates = _BODIES[name]
    return FreeRotation(Body(moments=moments), Spin("2026-01-01", (1, 0, 0, 0), rates))


def tables(quick):
    """The table of docs/proof.md."""
    body, epoch, bound = cost()
    count = 100 if quick else 1000
    compared, gap = witnesses(count)
    constants = bodies(40 if quick else 200)
    errors = hunted(2000 if quick else 25_000, 11)
    rows = [
        ("a certificate: a body", f"{body:.2g} ms"),
        ("a certificate: each epoch", f"{epoch:.2g} ms"),
        ("a bound for all epochs", f"{bound:.2g} ms"),
        (
            f"{compared} attitudes against mpmath: certificate less error, at most",
            f"{gap:.1g} rad",
        ),
        (
            f"bounds for all epochs of {len(constants)} bodies: median, largest",
            f"{np.median(constants):.2e}, {max(constants):.2e} rad",
        ),
        (
            f"certified errors of {len(errors)} random states: median, largest",
            f"{np.median(errors):.1e}, {errors.max():.2e} rad",
        ),
        ("theorem: uniform loop", f"{loop_bounds.uniform():.3g} rad"),
        ("theorem: trigonometric loop", f"{loop_bounds.trigonometric():.3g} rad"),
        ("theorem: hyperbolic loop", f"{loop_bounds.hyperbolic():.3g} rad"),
    ]
    costs = {"certificate": epoch * 1e6, "error bound": bound * 1e6}
    yield Table("proof", markdown(("what", "measured"), rows), costs=costs)


def _least(call, count=15):
    """Seconds of the processor of a call: the least of some runs of twenty calls."""
    times = []
    for _ in range(count):
        start = time.process_time()
        for _ in range(20):
            call()
        times.append((time.process_time() - start) / 20)
    return min(times)


def cost():
    """Milliseconds of the processor of a body, an epoch and a bound for all epochs."""
    moved = motion("short-axis mode")
    few, many = np.linspace(0.0, 1e4, 1), np.linspace(0.0, 1e4, 1001)
    first = _least(lambda: moved.certificate(few))
    all_of_them = _least(lambda: moved.certificate(many), 3)
    epoch = (all_of_them - first) / 1000
    return (first - epoch) * 1e3, epoch * 1e3, _least(moved.error_bound) * 1e3


def witnesses(count):
    """How many attitudes were compared, and the most by which a certificate exceeds the error."""
    generator, compared, gap = random.Random(5), 0, 0.0
    families = list(states.FAMILIES)
    for k in range(count):
        state = states.sample(1, k, [families[k % len(families)]])[0]
        try:
            moved = motion_of(state)
        except AttitudeError:
            continue  # rates that the solution refuses to drop
        t = generator.choice((-1, 1)) * 10.0 ** generator.uniform(-1, 9) * states.revolution(state)
        exact, _ = Oracle(state.moments, state.wxyz0, state.omega0, digits=30).at(t)
        error = abs(rotation_error(moved.at(t).wxyz, exact, signed=True))
        difference = float(moved.certificate(t).error) - error
        assert difference >= -1e-24, (state, t)
        compared, gap = compared + 1, max(gap, difference)
    return compared, gap


def bodies(count):
    """Bounds at the epoch of some bodies, which certificates do not exceed."""
    generator, constants = random.Random(6), []
    families = list(states.FAMILIES)
    for k in range(count):
        state = states.sample(1, 1000 + k, [families[k % len(families)]])[0]
        try:
            moved = motion_of(state)
        except AttitudeError:
            continue
        constant, rate = moved.error_bound()
        t = np.array([0.0, *(10.0 ** generator.uniform(-1, 12) for _ in range(5))])
        t *= states.revolution(state)
        assert np.all(moved.certificate(t).error <= constant + rate * t), state
        constants.append(constant)
    return constants


# Another order of the operations: the second double of a phase enters sine and cosine before their
# last rounding (two operations more), and the division by the norm goes into sine and cosine of the
# precession (two products less).
_REARRANGED = {
    "series": [
        (
            "    sine, cosine = sincos_of_eighth(s - 0.25 * quarters)\n"
            "    # first order in lo\n"
            "    small = _SIN_1 * lo\n"
            "    sine, cosine = loop_fma(cosine, small, sine), loop_fma(-sine, small, cosine)\n",
            "    sine, cosine = sincos_of_eighth(s - 0.25 * quarters, _SIN_1 * lo)\n",
        ),
        ("def sincos_of_eighth(r):", "def sincos_of_eighth(r, small):"),
        (
            "    return loop_fma(r, _SIN_1, r * loop_fma(a, z, _SIN_1_LOW)), "
            "descending_fma(b, z, 1.0)\n",
            "    cosine = descending_fma(b, z, 1.0)\n"
            "    rest = loop_fma(cosine, small, r * loop_fma(a, z, _SIN_1_LOW))\n"
            "    sine = loop_fma(r, _SIN_1, rest)\n"
            "    return sine, 1.0 + loop_fma(b, z, -(sine * small))\n",
        ),
    ],
    "kernel": [
        ("attitude._solver.series import", "rearranged_series import"),
        (
            "_store_attitude(frame, turned(pair, sine, cosine), rows, i)",
            "_store_attitude(frame, pair, sine, cosine, rows, i)",
        ),
        (
            "def _store_attitude(frame, pair, rows, i):",
            "def _store_attitude(frame, pair, sine, cosine, rows, i):",
        ),
        (
            "    w, x, y, z = ar * scale, br * scale, bi * scale, ai * scale\n",
            "    w, z, x, y = turned(pair, sine * scale, cosine * scale)\n",
        ),
    ],
}


def _sources(module, changes):
    """The source of a module of the solution with some of its text replaced."""
    text = (ROOT / "attitude" / "_solver" / f"{module}.py").read_text(encoding="utf-8")
    for before, after in changes:
        assert before in text, before
        text = text.replace(before, after)
    return text


def _loops(changed):
    """The loops as compiled functions, by name: those of the package, or rearranged."""
    import types

    from attitude._compilation import lowering

    if changed:
        for module, changes in _REARRANGED.items():
            made = types.ModuleType(f"rearranged_{module}")
            sys.modules[made.__name__] = made
            exec(_sources(module, changes), made.__dict__)
        kernel = sys.modules["rearranged_kernel"]
    else:
        from attitude._solver import kernel
    names = ("trigonometric", "hyperbolic")
    entries = [getattr(kernel, name) for name in names]
    return {
        name: lowering.dispatcher(entry.py_func, entry.targetoptions, False)
        for name, entry in zip(names, entries, strict=True)
    }


def rearranged(count=1500, epochs=20_000, rounds=15):
    """For each form and both orders: ns of the processor an epoch, rms and largest error, rad.

    Errors are those of whole attitudes of random bodies at random epochs, by certificates.
    """
    from attitude._solver import codes
    from attitude.motions._free_rotation import chain_of

    generator = random.Random(9)
    moved = {"trigonometric": [], "hyperbolic": []}
    forms = {codes.TRIGONOMETRIC: "trigonometric", codes.HYPERBOLIC: "hyperbolic"}
    while min(map(len, moved.values())) < count:
        family = generator.choice(("tumbling", "near_separatrix", "middle_axis_wobble"))
        state = states.sample(1, generator.randrange(10**9), [family])[0]
        made = motion_of(state)
        turns = generator.choice((-1.0, 1.0)) * 10.0 ** generator.uniform(-1, 9)
        name = forms[int(made._constants["form"][0])]
        moved[name].append((made, turns * states.revolution(state)))
    rows = []
    loops = {"now": _loops(False), "rearranged": _loops(True)}
    for name, cases in moved.items():
        errors = {order: [] for order in loops}
        for made, t in cases[:count]:
            chain = chain_of(made.body, made.spin)
            for order, compiled in loops.items():
                out = np.empty((1, 4, 1))
                compiled[name](made._constants, _read_only([[t]]), None, out, None, 0, 1, 0)
                errors[order].append(chain.certificate(np.array([t]), None, out[:, :, 0]).error[0])
        t = _read_only(np.linspace(0.0, 1e6, epochs)[None])
        out, spent = np.empty((1, 4, epochs)), {order: math.inf for order in loops}
        for _ in range(rounds):
            for order, compiled in loops.items():
                start = time.process_time()
                for _ in range(10):
                    compiled[name](cases[0][0]._constants, t, None, out, None, 0, epochs, 0)
                spent[order] = min(spent[order], (time.process_time() - start) / (10 * epochs))
        for order, found in errors.items():
            rms = math.sqrt(np.mean(np.square(found)))
            rows.append((name, order, 1e9 * spent[order], rms, max(found)))
    return rows


def _read_only(t):
    t = np.array(t, float)
    t.flags.writeable = False
    return t


def sines():
    """Bound, and measured root mean square and largest error, of sine and cosine, in both orders.

    "now" is the source; in "before" the second double of the phase enters before the last rounding.
    """
    from flint import arb, ctx

    from attitude._solver import series

    fma = series.loop_fma

    def before(r, lo):
        z = r * r
        a = series._SIN_13
        for n in (11, 9, 7, 5, 3):
            a = fma(a, z, getattr(series, f"_SIN_{n}"))
        b = series._COS_14
        for n in (12, 10, 8, 6, 4, 2):
            b = fma(b, z, getattr(series, f"_COS_{n}"))
        small = series._SIN_1 * lo
        cosine = fma(b, z, 1.0)
        sine = fma(r, series._SIN_1, fma(cosine, small, r * fma(a, z, series._SIN_1_LOW)))
        return sine, 1.0 + fma(b, z, -(sine * small))

    def now(r, lo):
        sine, cosine = series.sincos_of_eighth(r)
        small = series._SIN_1 * lo
        return fma(cosine, small, sine), fma(-sine, small, cosine)

    rows = []
    for function in (now, before):
        trace = traced.Trace()
        outputs = traced.rebound(function, traced.replacements())(*trace.inputs("r", "lo"))
        ends = np.linspace(0.0, 0.125, 513)
        inputs = {
            "r": rounding_bounds.Intervals(ends[:-1], ends[1:]),
            "lo": rounding_bounds.Intervals(np.full(512, -(2.0**-53)), np.full(512, 2.0**-53)),
        }
        bound = float(rounding_bounds.turn(trace.nodes, traced.flat(outputs), inputs).max())
        generator, squares, worst = random.Random(1), 0.0, 0.0
        ctx.prec = 120
        for _ in range(20_000):
            r, lo = generator.uniform(-0.125, 0.125), generator.uniform(-1, 1) * 2.0**-55
            sine, cosine = (arb(float(x)) for x in function(r, lo))
            x = 2 * arb.pi() * (arb(r) + arb(lo))
            error = 2 * abs(float(sine * x.cos() - cosine * x.sin()))
            worst, squares = max(worst, error), squares + error * error
        rows.append((function.__name__, bound, math.sqrt(squares / 20_000), worst))
    return rows


def figure():
    """Bound for all epochs, certificate, and error by the oracle, against time, in each mode."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    drawn, axes = plt.subplots(
        2, 3, figsize=(9, 6.6), sharex=True, sharey=True, layout="constrained"
    )
    for axis, name in zip(axes.flat, _BODIES, strict=True):
        moved = motion(name)
        turn = 2 * np.pi / np.linalg.norm(moved.spin.angular_velocity)
        turns = np.logspace(-1, 16.5, 106)
        t = turns * turn
        constant, rate = moved.error_bound()
        inside = t <= moved.error_bound().span
        axis.loglog(turns[inside], constant + rate * t[inside], "C3", label="bound for all epochs")
        axis.loglog(turns, moved.certificate(t).error, "C0.", ms=3, label="certificate")
        oracle = Oracle(moved.body.moments, moved.spin.wxyz, moved.spin.angular_velocity, digits=30)
        some = slice(None, None, 7)
        wxyz = moved.at(t[some]).wxyz
        errors = [
            abs(rotation_error(q, oracle.at(x)[0], signed=True))
            for q, x in zip(wxyz, t[some], strict=True)
        ]
        axis.loglog(
            turns[some], errors, "ko", mfc="none", ms=6, lw=0, label="measured against mpmath"
        )
        axis.set_title(name)
        axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("turns since the epoch")
    for axis in axes[:, 0]:
        axis.set_ylabel("rotation angle / rad")
    axes[0, 0].set_ylim(1e-17, 1e-13)
    axes[0, 0].legend(loc="upper left", fontsize=9)
    drawn.savefig(FIGURES / "proof.png", dpi=110)


def main(arguments):
    part = arguments[0] if arguments else "all"
    if part in ("cost", "all"):
        print("ms: body {:.3g}, epoch {:.3g}, bound for all epochs {:.3g}".format(*cost()))
    if part in ("witnesses", "all"):
        compared, gap = witnesses(int(arguments[1]) if len(arguments) > 1 else 1000)
        print(f"{compared} attitudes against mpmath: certificate less error at most {gap:.2g} rad")
    if part in ("bodies", "all"):
        constants = bodies(int(arguments[1]) if len(arguments) > 1 else 200)
        print(
            f"{len(constants)} bodies: bound at the epoch, median {np.median(constants):.3g}, "
            f"largest {max(constants):.3g} rad"
        )
    if part in ("hunt", "all"):
        count, seed = map(int, arguments[1:3] if len(arguments) > 2 else (25_000, 1))
        start = time.perf_counter()
        errors = hunted(count, seed)
        print(
            f"{count} states certified in {time.perf_counter() - start:.0f} s: median "
            f"{np.median(errors):.3g}, 99.9 % below {np.quantile(errors, 0.999):.3g}, largest "
            f"{errors.max():.3g} rad"
        )
    if part in ("loops", "all"):
        print(f"uniform {loop_bounds.uniform():.3g} rad")
        print(f"trigonometric {loop_bounds.trigonometric():.3g} rad")
        print(f"hyperbolic {loop_bounds.hyperbolic():.3g} rad")
        for name, bound, rms, worst in sines():
            print(f"sine and cosine, {name}: bound {bound:.3g}, rms {rms:.3g}, largest {worst:.3g}")
        for name, order, spent, rms, worst in rearranged():
            print(f"{name}, {order}: {spent:.3g} ns, rms {rms:.3g}, largest {worst:.3g} rad")
    if part == "figure":
        figure()


if __name__ == "__main__":
    main(sys.argv[1:])
