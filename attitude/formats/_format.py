"""The contract of a file format, and the registry of formats that files, commands and docs read."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from attitude._textfiles.lines import path_text
from attitude.errors import AttitudeError

if TYPE_CHECKING:
    from attitude.motions._motion import Motion

_by_name: dict[str, Format] = {}


class OpenedFile(NamedTuple):
    """The content of a file in any format.

    Attributes
    ----------
    motion : AttitudeTable, FreeRotation or KernelAttitude
    said : dict
        Names, comments, source and note, under the names of the keyword arguments of writers; of
        an ACM "left_out", the names of what it holds beside the attitudes.
    """

    motion: Motion
    said: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Option:
    """An option of `attitude convert` that a format needs.

    Attributes
    ----------
    name : str
        Without dashes in front; "time-system" for --time-system.
    help : str
        What the help of the command says of it.
    settings : mapping
        Further keyword arguments of argparse's `add_argument`.
    of_reading : bool
        Whether the option is a keyword of `detect.opened` (without -in at its end).  Others belong
        to writers, and are refused for formats that do not name them in `Format.writing`.
    refusal : str
        What the option of a writer says of other formats; {noun} is `Format.noun`.
    """

    name: str
    help: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    of_reading: bool = False
    refusal: str = "has no meaning for {noun}; leave it out."

    @property
    def attribute(self) -> str:
        """The name of the option in parsed arguments."""
        return self.name.replace("-", "_")


def no_labels(motion: Motion, said: Mapping[str, Any]) -> dict[str, Any]:
    """`Format.labels` of a format that has no place for names and comments."""
    return {}


@dataclass(frozen=True, eq=False)
class Format:
    """How files of one format are recognized, read and written, and what commands say of them.

    What a new format defines
    -------------------------
    A module that calls ``register(Format(...))`` below its `read` and `write`.  Then
    `detect.read`, `detect.write`, `Motion.write` and `attitude convert` know the format.

    Attributes
    ----------
    name : str
        The format in `detect.of_file` and `detect.to_write`.
    module : str
        ``__name__`` of the file that registers it.
    title : str
        What the help of the command calls files of this format.
    endings : tuple of str
        In lower case; the longest that a name has decides.
    beside : mapping
        Endings of further files of that name that `write` makes, each with the option of the
        command, as an attribute, in whose presence it makes none.
    read : function
        ``read(path, **keywords)`` returns an `OpenedFile`.
    reading : tuple of str
        The keywords of `detect.opened` that `read` takes.
    write : function
        ``write(path, source, t=None, **settings)`` for records; ``write(path, motion,
        **settings)`` for a motion; ``write(path, motion, start, stop, **settings)`` for a span.
    writing : tuple of str
        Options that `write` takes, as attributes of parsed arguments.
    renamed : mapping
        The keywords of `write` for options of another name.
    holds : "records", "motion" or "span"
        Attitudes at epochs, a free rotation, or attitudes at any epoch of a span.
    marks : tuple of bytes
        With one of these a file begins, whatever its ending.
    element : str or None
        The name of the element of the message, for XML.
    resembles : function or None
        ``resembles(line)``: whether the first line, bytes, of a file of no known mark or ending
        looks like this format.
    noun : str
        The format in errors of the command; {output} is the name of the file.
    options : tuple of Option
        What this format adds to the command; other formats may name them in `writing`.
    fulfilled : mapping
        Options and the value that is what `write` does anyway, such as --for stk.
    is_sampled : bool
        Whether `write` of records takes start=, stop= and tolerance=.
    read_message : function or None
        ``read_message(path)`` has ``motion`` and ``meta``, of a format whose messages may state the
        inertia and so a motion beside their attitudes.
    labels : function
        ``labels(motion, said)`` are settings of `write` that follow from what was read.
    """

    name: str
    module: str
    title: str
    endings: tuple[str, ...]
    read: Callable[..., OpenedFile]
    reading: tuple[str, ...]
    write: Callable[..., Any]
    writing: tuple[str, ...] = ()
    renamed: Mapping[str, str] = field(default_factory=dict)
    holds: str = "records"
    marks: tuple[bytes, ...] = ()
    element: str | None = None
    resembles: Callable[[bytes], bool] | None = None
    noun: str = "a file like {output}"
    options: tuple[Option, ...] = ()
    fulfilled: Mapping[str, str] = field(default_factory=dict)
    is_sampled: bool = True
    read_message: Callable[..., Any] | None = None
    labels: Callable[[Motion, Mapping[str, Any]], dict[str, Any]] = no_labels
    beside: Mapping[str, str] = field(default_factory=dict)


def register(new: Format) -> None:
    """Add a format to those that files and commands know.

    Parameters
    ----------
    new : Format
        One registered again from the same module replaces the former.

    Raises
    ------
    AttitudeError
        For a name or an ending of another format.
    """
    for other in _by_name.values():
        if (other.name, other.module) == (new.name, new.module):
            continue
        shared = {other.name} & {new.name} or {*other.endings} & {*new.endings}
        if shared:
            raise AttitudeError(
                f"the format {new.name!r} of {new.module} and {other.name!r} of {other.module} "
                f"share {min(shared)!r}; give one of them another."
            )
    _by_name[new.name] = new


def register_message(
    name: str, title: str, write: Callable[..., Any], options: tuple[Option, ...] = (), **both: Any
) -> None:
    """Add a CCSDS message as two formats: in KVN, and in XML with `write` under xml=True."""
    ending = ".xml" if name == "aem" else f".{name}.xml"
    mark = f"CCSDS_{name.upper()}_VERS".encode()
    kvn: dict[str, Any] = {
        "endings": (f".{name}",),
        "marks": (mark,),
        "write": write,
        "options": options,
    }
    xml: dict[str, Any] = {"endings": (ending,), "element": name, "write": partial(write, xml=True)}
    register(Format(name, title=title, **kvn, **both))
    register(Format(f"{name}-xml", title=f"{title}, XML", **xml, **both))


def forget(name: str) -> None:
    """Remove a format, as at the end of a test that registers one.

    Parameters
    ----------
    name : str

    Raises
    ------
    AttitudeError
        For a name that is not registered.
    """
    if name not in formats():
        raise AttitudeError(f"no format is called {name!r}; known are {', '.join(formats())}.")
    del _by_name[name]


def formats() -> dict[str, Format]:
    """All registered formats.

    Returns
    -------
    dict
        Each `Format` by its name: those of the package first.

    >>> formats()["stk"].endings
    ('.a',)
    """
    modules = [f"{__package__}.{module}" for module in sys.modules["attitude"].FORMAT_MODULES]
    for module in modules:
        import_module(module)
    place = {module: k for k, module in enumerate(modules)}
    return dict(sorted(_by_name.items(), key=lambda item: place.get(item[1].module, len(place))))


def endings() -> dict[str, Format]:
    """All endings of files with their formats."""
    return {ending: form for form in formats().values() for ending in form.endings}


# Endings of files that hold no attitudes, with what writes them.
_FOREIGN = {
    **dict.fromkeys((".obj", ".stl", ".ply"), "a shape, which shape.Mesh.write writes"),
    **dict.fromkeys((".html", ".glb", ".czml"), "a page or scene, which attitude.viewer writes"),
    **dict.fromkeys((".png", ".svg", ".pdf", ".jpg"), "a picture, which attitude.plots draws"),
    **dict.fromkeys((".gif", ".webp", ".mp4"), "an animation, by attitude.viewer.animate"),
}


def refuse_foreign(path: object, name: str) -> None:
    """Raise the AttitudeError for a file to write in a format whose ending is that of another."""
    if not isinstance(path, (str, os.PathLike)):
        return
    ending, form = ending_of(path), formats()[name]
    other = endings().get(ending)
    # Messages in XML are often named .xml, whatever they are, and other packages build on writers.
    is_foreign = (
        other is not None
        and other.module != form.module
        and other.module.startswith("attitude.formats.")
        and ending != ".xml"
    )
    if is_foreign or ending in _FOREIGN:
        holds = other.title if other is not None else _FOREIGN[ending]
        raise AttitudeError(
            f"{os.fspath(path)!r} is to be written as {form.title}, but {ending} is the ending of "
            f"{holds}; give a name that ends in {form.endings[0]}."
        )


def ending_of(path: str | os.PathLike[str]) -> str:
    """The ending of the name of a file, in lower case; of several that are known the longest."""
    name = os.path.basename(path_text(path)).lower()
    longer = (ending for ending in endings() if ending.count(".") > 1 and name.endswith(ending))
    return next(longer, os.path.splitext(name)[1])


def table_reader(read: Callable[..., Any]) -> Callable[..., OpenedFile]:
    """`Format.read` from a reader of tables."""

    def opened(path, **keywords):
        return of_table(read(path, **keywords))

    return opened


def of_table(table: Motion, said: Mapping[str, Any] | None = None) -> OpenedFile:
    """A table, with the names and comments of its meta data, and what else is said."""
    names = ("object_name", "object_id", "center", "comments")
    of_meta = {name: table.meta[name] for name in names if table.meta.get(name)}
    return OpenedFile(table, {**of_meta, **(said or {})})


def message_labels(motion: Motion, said: Mapping[str, Any]) -> dict[str, Any]:
    """The names and comments of messages and tables, from those of the file that was read."""
    names = {key: said[key] for key in ("object_name", "object_id", "center") if said.get(key)}
    if said.get("name"):
        names["object_name"] = said["name"]
    lines = [line for key in ("source", "note") for line in (said.get(key) or "").splitlines()]
    lines = [" ".join(line.split()) for line in lines if line.strip()]
    comments = [*said.get("comments", ()), *lines]
    return names | ({"comments": tuple(comments)} if comments else {})
