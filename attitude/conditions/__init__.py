"""Conditions: what is true or false at each epoch of a motion or of a scene.

A condition is a logical function of the signs of one or several channels, functions of time.
`attitude.events` makes conditions and searches the epochs at which they begin and cease.

condition     `Condition`, which &, | and ~ combine; `logic`, how
observable    `Observable`, a number at every epoch, which >, >=, < and <= make a condition
channel       `Channel`, a function of time whose sign counts; `Level`, a threshold
moments       a motion or scene at a block of epochs; directions that are compared with body axes
"""

from attitude.conditions._conditions import Channel, Condition, Level, Observable

__all__ = ["Channel", "Condition", "Level", "Observable"]
