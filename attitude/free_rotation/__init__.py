"""Torque-free rotation in closed form.

free_rotation    `FreeRotation`
normal_form      its elements, and the motion that has given ones
differentiable   derivatives, covariances and samples of a motion from a body and a spin
sensitivity      derivatives and covariances of one motion as arrays
polhode          Poinsot's curves of the angular velocity in the body and in space
predictability   time until errors of the input reach a tolerance of the attitude
rate_bounds      upper bounds of the derivatives of a body-fixed direction
description      the motion as text: `print(motion)`
"""

from attitude.free_rotation.free_rotation import FreeRotation

__all__ = ["FreeRotation"]
