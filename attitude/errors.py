"""The one exception type of the package."""


class AttitudeError(ValueError):
    """Input that the package refuses; the message is a sentence: given, allowed, what to do."""
