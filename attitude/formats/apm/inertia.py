"""The sign of the products of inertia in an Attitude Parameter Message.

"tensor"    IXY (I12) is the entry of the inertia tensor, -integral of x y dm.  Version 1: "the
            inertia cross products used for this message assume a negative double integral", CCSDS
            504.0-B-1, 3.2.5.2.5.  Orekit reads both versions with this sign.
"integral"  IXY is the integral of x y dm, and the entry of the tensor is -IXY: the matrix of
            version 2, CCSDS 504.0-B-2, annex F6.  brahe reads version 2 with this sign.

>>> tensor((10.0, 20.0, 26.0, 0.5, 0.0, 0.0), "integral")
array([[10. , -0.5,  0. ],
       [-0.5, 20. ,  0. ],
       [ 0. ,  0. , 26. ]])
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from attitude.annotations import FloatArray

_SIGNS = {"tensor": 1.0, "integral": -1.0}
_OF_VERSION = {"1.0": "tensor", "2.0": "integral"}
_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def known_products(products: str | None, version: str) -> str:
    """The convention of the products of inertia, by default that of the version's book.

    Raises
    ------
    AttitudeError
        For an unknown convention.
    """
    if products is None:
        return _OF_VERSION[version]
    if products not in _SIGNS:
        raise AttitudeError(f'products is {products!r}; give "tensor" or "integral".')
    return products


def tensor(values: Sequence[float], products: str) -> FloatArray:
    """The inertia tensor (3, 3), kg m2, from IXX, IYY, IZZ, IXY, IXZ, IYZ in kg m2."""
    found = np.zeros((3, 3))
    for (i, j), value in zip(_PLACES, values, strict=True):
        found[i, j] = found[j, i] = value if i == j else _signed(value, products)
    return found


def values(tensor: FloatArray, products: str) -> list[float]:
    """IXX, IYY, IZZ, IXY, IXZ, IYZ in kg m2 from an inertia tensor (3, 3) in kg m2."""
    entries = [(i == j, float(tensor[i, j])) for i, j in _PLACES]
    return [value if diagonal else _signed(value, products) for diagonal, value in entries]


def _signed(value, products):
    return _SIGNS[products] * value + 0.0  # -0.0 becomes 0.0
