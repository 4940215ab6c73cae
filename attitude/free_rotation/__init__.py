"""Torque-free rotation in closed form, and what follows from it.

free_rotation    `FreeRotation`
polhode          Poinsot's curves of the angular velocity in the body and in space
predictability   how long errors of the input leave the attitude known
description      the motion as text: `print(motion)`
"""

from attitude.free_rotation.free_rotation import FreeRotation

__all__ = ["FreeRotation"]
