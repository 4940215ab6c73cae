"""The gallery: the figure of each example as it is stored, beside a hash of its source.

    python docs/make_gallery.py NAME ...    # run these examples and store what they draw
    python docs/make_gallery.py             # those whose source has changed since

It writes docs/figures/gallery/, with the hashes in hashes.txt, and docs/gallery.md; a test compares
the hashes with the examples.
"""

import ast
import hashlib
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parent
EXAMPLES = DOCS.parent / "examples"
FOLDER = DOCS / "figures" / "gallery"
HASHES = FOLDER / "hashes.txt"


def hash_of(name):
    """The hash of the source of an example."""
    return hashlib.sha256((EXAMPLES / f"{name}.py").read_bytes()).hexdigest()


def stored():
    """Hashes of the sources whose figures are stored, by the names of the examples."""
    lines = HASHES.read_text().splitlines() if HASHES.is_file() else []
    return dict(line.split() for line in lines)


def names():
    """All examples."""
    return sorted(file.stem for file in EXAMPLES.glob("*.py"))


def drawn(name):
    """Run an example in an empty folder and keep its picture, 700 pixels wide."""
    from PIL import Image

    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, EXAMPLES / f"{name}.py"], cwd=folder, check=True)
        (picture,) = Path(folder).glob("*.png")
        keep(name, picture, Image)


def keep(name, picture, image):
    """Store a picture as the figure of an example."""
    FOLDER.mkdir(exist_ok=True)
    with image.open(picture) as found:
        small = found.convert("RGB")
        small.thumbnail((700, 1000), image.Resampling.LANCZOS)
        small.save(FOLDER / f"{name}.webp", quality=80)


def page():
    """The text of docs/gallery.md."""
    parts = [
        "# Gallery\n\nEach figure is drawn by a script of `examples/`, which runs without a "
        "network; `python docs/make_gallery.py` draws those again whose source has changed.\n"
    ]
    for name in names():
        about = ast.get_docstring(ast.parse((EXAMPLES / f"{name}.py").read_text()))
        text = about.split("\n\n    python")[0]
        title, _, rest = text.partition("\n\n")
        drawing = FOLDER / f"{name}.webp"
        figure = f"![{name}](figures/gallery/{name}.webp)\n\n" if drawing.is_file() else ""
        source = f"[examples/{name}.py](../examples/{name}.py)"
        parts.append(f"## {title.rstrip('.')}\n\n{rest}\n\n{figure}{source}\n")
    return "\n".join(parts)


def main():
    """Draw, store the hashes, write the page."""
    hashes = stored()
    for name in sys.argv[1:] or [each for each in names() if hashes.get(each) != hash_of(each)]:
        drawn(name)
        hashes[name] = hash_of(name)
    HASHES.write_text("".join(f"{name} {hashes[name]}\n" for name in sorted(hashes)))
    (DOCS / "gallery.md").write_text(page())
    shutil.rmtree(DOCS / "_build" / "html" / "_images", ignore_errors=True)


if __name__ == "__main__":
    main()
