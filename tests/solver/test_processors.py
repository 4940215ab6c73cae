"""Processors without fused products, of which numba is told by environment variables."""

import json
import os
import platform
import subprocess
import sys

import numpy as np
import pytest

from attitude import propagate
from attitude._compilation.instructions import fma, rint

# Short, long axis; near the separatrix; a principal axis; symmetric; at rest; slow and fast.
RATES = [
    (1.0, 15.0, 1.0),
    (5.0, 1.0, 0.2),
    (1.0, 2.0, 1.0000001),
    (0.0, 0.0, -3.0),
    (0.0, 0.0, 0.0),
    (1e-9, 2e-9, -3e-9),
    (1e6, -2e5, 3e5),
]
NO_FMA = "+avx,+sse4.2,+sse4.1,+ssse3,+sse3,+sse2,+cx16,+popcnt"
# Ties, cancellation, and products beyond the range of error-free transforms.
PRODUCTS = [
    (1.0 + 2**-30, 1.0 + 2**-23, -1.0),
    (1.0 + 2**-52, 1.0 + 2**-52, 2.0**53),
    (1e200, 1e-200, 1e-300),
    (1e-200, 1e-200, 1e-308),
    (1e200, 1e200, -1e300),
    (3.0, -0.0, -0.0),
    (0.1, 10.0, -1.0),
]
SCRIPT = """
import json, sys
import numpy as np
from attitude import propagate
from attitude._compilation.decorators import entry_point
from attitude._compilation.error_free import is_instruction
from attitude._compilation.instructions import fma, rint

@entry_point
def products(given, found):
    for i in range(len(given)):
        found[i] = fma(given[i, 0], given[i, 1], given[i, 2])

@entry_point
def rounded(given, found):
    for i in range(len(given)):
        found[i] = rint(given[i])

moments, rates, numbers, halves = json.loads(sys.argv[1])
t = np.concatenate([np.linspace(-1e4, 1e4, 5001), [0.0, 1e10]])
found = [propagate(moments, (1, 2, 3, 4), w, t, angular_velocity=True) for w in rates]
fused, whole = np.empty(len(numbers)), np.empty(len(halves))
products(np.array(numbers), fused)
rounded(np.array(halves), whole)
fused_here = str(is_instruction("llvm.fma", 3))
bits = [[np.ascontiguousarray(x).tobytes().hex() for x in each] for each in found]
print(json.dumps([fused_here, *bits, fused.tobytes().hex(), whole.tobytes().hex()]))
"""


@pytest.mark.parametrize(
    ("name", "features", "compiled"),
    [
        pytest.param("sandybridge", NO_FMA, "always", marks=pytest.mark.slow),
        pytest.param("generic", "", "always", marks=pytest.mark.slow),
        ("generic", "", "automatic"),
    ],
)
def test_the_bits_do_not_depend_on_fused_products(tmp_path, name, features, compiled):
    """The bits of loops over epochs and of fma() itself; with "always" also of the set-up."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        pytest.skip("the names of processors are those of x86")
    moments, halves = (10.0, 20.0, 26.0), [0.5, 1.5, -0.5, -0.2, 2.0**52 + 1, -3.5, 1e300, 0.0]
    given = json.dumps([moments, RATES, PRODUCTS, halves])
    environment = os.environ | {
        "NUMBA_CPU_NAME": name,
        "NUMBA_CPU_FEATURES": features,
        "NUMBA_CACHE_DIR": str(tmp_path),
        "ATTITUDE_COMPILE": compiled,
    }
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, given], env=environment, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    fused, *found, products, rounded = json.loads(run.stdout)
    assert fused == "False"
    t = np.concatenate([np.linspace(-1e4, 1e4, 5001), [0.0, 1e10]])
    for rates, (wxyz, omega) in zip(RATES, found, strict=True):
        expected = propagate(moments, (1, 2, 3, 4), rates, t, angular_velocity=True)
        for mine, bits in zip(expected, (wxyz, omega), strict=True):
            assert np.ascontiguousarray(mine).tobytes().hex() == bits, rates
    expected = np.array([fma(*map(float, each)) for each in PRODUCTS])
    assert expected.tobytes().hex() == products
    assert np.array([rint(each) for each in halves]).tobytes().hex() == rounded


LIGHT = """
import sys
import numpy as np
from attitude.light_curve import brightness
from attitude.scattering import Hapke
from attitude.shape import Ellipsoid

mesh = Ellipsoid((3.0, 2.0, 1.0)).facets(2000)
angles = np.linspace(0.0, 6.0, 50)
sun = np.stack([0.8 * np.cos(angles), 0.8 * np.sin(angles), 0.6 + 0.0 * angles], axis=-1)
curve = brightness(mesh, Hapke(), sun, np.roll(sun, 7, axis=0))
"""


def test_facets_are_gathered_where_no_instruction_packs_vectors(tmp_path):
    """LLVM 22 ended the process where it packed doubles without the instruction of AVX-512."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        pytest.skip("the names of processors are those of x86")
    environment = os.environ | {
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_CACHE_DIR": str(tmp_path),
        "ATTITUDE_COMPILE": "always",
    }
    command = [sys.executable, "-c", LIGHT + "sys.stdout.buffer.write(curve.tobytes())"]
    run = subprocess.run(command, env=environment, capture_output=True)
    assert run.returncode == 0, run.stderr
    here = {}
    exec(LIGHT, here)
    assert np.frombuffer(run.stdout) == pytest.approx(here["curve"], rel=1e-13)
