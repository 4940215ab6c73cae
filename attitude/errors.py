"""The one exception type of the package."""


class AttitudeError(ValueError):
    """What was given, what is allowed and what to do, in a sentence."""
