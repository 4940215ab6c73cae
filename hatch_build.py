"""Metadata of a release: links and pictures of the README as a package index shows them.

A package index knows neither the files nor the pictures of a repository.  Where the environment
variable ATTITUDE_REPOSITORY holds its address when a package is built, such as
https://github.com/name/attitude, relative links of the README lead there, and the metadata have the
links "Source", "Documentation" and "Changes"; without it both stay as they are.
"""

import os
import re
from pathlib import Path

from hatchling.metadata.plugin.interface import MetadataHookInterface

VARIABLE = "ATTITUDE_REPOSITORY"
PAPER = "https://doi.org/10.1016/j.jcp.2006.11.019"
# A link or a picture in Markdown whose target has no scheme and is no place of the page itself.
_RELATIVE = re.compile(r"(!?)(\[(?:!\[[^\]]*\]\([^)]*\)|[^\[\]])*\])\((?![a-z]+:|#)([^)\s]+)\)")


def absolute(text: str, repository: str) -> str:
    """The text with links and pictures that name files of a repository by their addresses."""

    def changed(found: re.Match[str]) -> str:
        mark, label, path = found.groups()
        kind = "raw" if mark else "blob"
        # a picture may be the label of a link
        inner = _RELATIVE.sub(changed, label[1:-1])
        return f"{mark}[{inner}]({repository}/{kind}/main/{path})"

    return _RELATIVE.sub(changed, text)


def links(repository: str) -> dict[str, str]:
    """The links of a package."""
    found = {"Paper": PAPER}
    if repository:
        found["Source"] = repository
        found["Documentation"] = f"{repository}/blob/main/docs/index.md"
        found["Changes"] = f"{repository}/blob/main/CHANGELOG.md"
    return found


class ReadmeAndLinks(MetadataHookInterface):
    """Fills `readme` and `urls`, which pyproject.toml declares as dynamic."""

    def update(self, metadata: dict) -> None:
        """Fill them."""
        repository = os.environ.get(VARIABLE, "").rstrip("/")
        text = (Path(self.root) / "README.md").read_text("utf-8")
        if repository:
            text = absolute(text, repository)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        metadata["urls"] = links(repository)
