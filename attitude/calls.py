"""Calls that fail: of arguments that do not exist, and of packages that are not installed."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# What pip installs, and where: no package index has the package before its release.  From then on
# "attitude-propagation" and "" (CONTRIBUTING.md); a test compares README and docs.
SOURCE: str = "."
WHERE: str = ", in a checkout of this project"


def installing(extra: str) -> str:
    """The command that installs the packages of an extra, for the end of a sentence.

    >>> installing("jax")
    'pip install ".[jax]", in a checkout of this project'
    """
    return f'pip install "{SOURCE}[{extra}]"{WHERE}'


def check_call(
    name: str,
    given: Sequence[Any],
    named: Mapping[str, Any],
    *,
    allowed: Sequence[str],
    hints: Mapping[str, str],
    example: str,
) -> None:
    """AttitudeError for too many arguments, and for names that the call does not have.

    Parameters
    ----------
    name : str
        Of the function or class.
    given, named
        The arguments of the call.
    allowed : sequence of str
        All arguments in order.
    hints : mapping of str to str
        What to give instead of a name that others use.
    example : str
        A right call.
    """
    if len(given) <= len(allowed) and (not named or named.keys() <= set(allowed)):
        return
    if len(given) > len(allowed):
        raise AttitudeError(
            f"{name} is called with {len(given)} arguments; it takes {', '.join(allowed)}, as in "
            f"{example}."
        )
    wrong = next(each for each in named if each not in allowed)
    advice = hints.get(wrong, f"it takes {', '.join(allowed)}")
    raise AttitudeError(f"{name} has no argument {wrong}; {advice}, as in {example}.")


def show_arguments(cls: type) -> None:
    """Let `inspect.signature` find the arguments of ``__init__`` where ``__new__`` takes any."""
    known = inspect.signature(vars(cls)["__init__"])
    arguments = list(known.parameters.values())[1:]
    cls.__signature__ = known.replace(  # type: ignore[attr-defined]
        parameters=arguments, return_annotation=inspect.Signature.empty
    )
