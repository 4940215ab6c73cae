"""Conditions: what is true or false at each epoch of a motion or of a scene.

A condition is a logical function of the signs of one or several channels, functions of time.
`attitude.events` makes conditions and searches the epochs at which they begin and cease.

_conditions   `Channel`, `Level`; `Condition`, which &, | and ~ combine; `Observable`
_moments      a motion or scene at a block of epochs, directions that are compared with body axes
_search       all sign changes of channels, by bounds of their derivatives
"""

from attitude.conditions._conditions import Channel, Condition, Level, Observable

__all__ = ["Channel", "Condition", "Level", "Observable"]
