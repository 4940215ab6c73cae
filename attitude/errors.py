"""The one exception type of the package, and its warnings."""

from __future__ import annotations


class AttitudeError(ValueError):
    """Input that the package refuses; the message is a sentence: given, allowed, what to do."""


class AttitudeWarning(UserWarning):
    """A result that is computed as requested but less certain than it looks; one sentence."""


class CovarianceWarning(AttitudeWarning):
    """Errors so large that a covariance does not describe them; once for each motion."""
