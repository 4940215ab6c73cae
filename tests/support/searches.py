"""Searches of the inversion that end in a second, for tests of commands."""

import inspect

from attitude import inversion
from attitude.inversion import _errors, _known


def make_small(monkeypatch):
    """A search of few pairs and starts: options are what is tested."""
    names = ("pairs", "deep_starts", "classes", "convex", "finals", "known_fitted")
    few = dict.fromkeys(names, 2)
    smaller = inversion.Settings(**few, short_classes=4, rounds=1)
    defaults = inspect.unwrap(inversion.spin_states).__kwdefaults__
    monkeypatch.setitem(defaults, "settings", smaller)
    monkeypatch.setattr(_errors, "_REFITS", 1)
    monkeypatch.setattr(_errors, "_SAMPLES", 20)
    counts = dict.fromkeys(("_KEPT", "_LEFT", "_LAST", "_ITERATIONS", "_SAMPLED"), 2)
    counts |= {"_ATTEMPTS": 1, "_FEWEST": 200, "_MOST": 200, "_REFINED": 20}
    for name, value in counts.items():
        monkeypatch.setattr(_known, name, value)
