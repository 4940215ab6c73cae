"""Run the suite with every interpreter of this machine, and with the lowest versions together.

    python tests/matrix.py                        the whole suite in every environment: hours
    python tests/matrix.py --list                 the interpreters found and the lowest versions
    python tests/matrix.py --only 3.13 -- tests/epochs/test_epochs.py
    python tests/matrix.py --lowest --keep /tmp/environments

The interpreters are those that pyproject.toml names as tested, and the free-threaded builds of the
same versions from 3.13 (3.13t). They are looked for on PATH, in pyenv and among those of uv; what
is not found has a row that says so. Each gets an environment of the newest versions that
pyproject.toml allows, and the lowest interpreter a second one of the lowest versions, every
`name>=version` taken as `name==version`. Only wheels are installed: a package without one for an
interpreter is a row too. The table is in Markdown, as CONTRIBUTING.md has it; its last column
says what happened. The exit code is 1 if anything failed or nothing ran.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRA = "test"
SHOWN = ("numpy", "scipy", "astropy", "skyfield", "numba", "matplotlib")
COUNTS = ("passed", "failed", "skipped", "minutes")
_ASK = """
import json, platform, sys, sysconfig
free = "t" if sysconfig.get_config_var("Py_GIL_DISABLED") else ""
name = "%d.%d" % sys.version_info[:2] + free
print(json.dumps([name, sys.executable, platform.python_version() + free]))
"""


@dataclass
class Interpreter:
    """An interpreter that pyproject.toml names, and where it is on this machine.

    `name` is 3.13, or 3.13t for a free-threaded build; `path` and `version` are None and "" for one
    that is not found.
    """

    name: str
    path: Path | None = None
    version: str = ""


@dataclass
class Row:
    """What happened in one environment: versions and counts by name, a sentence if it failed."""

    interpreter: str
    kind: str
    versions: dict[str, str]
    counts: dict[str, int]
    outcome: str
    failed: bool = False
    ran: bool = False


def wanted():
    """Names of interpreters: the classifiers of pyproject.toml, and free-threaded builds."""
    found = [
        match[1]
        for line in PROJECT["classifiers"]
        if (match := re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", line))
    ]
    return found + [f"{name}t" for name in found if int(name.split(".")[1]) >= 13]


def floors():
    """The lowest version of each dependency, and of each package of the tests, that has one."""
    required = PROJECT["dependencies"] + PROJECT["optional-dependencies"][EXTRA]
    split = (re.match(r"([\w.-]+)(?:\[.*?\])?>=([\w.]+)", line) for line in required)
    return {match[1]: match[2] for match in split if match}


def interpreters():
    """Each wanted interpreter; of several of one name the first on PATH, in pyenv, among uv's."""
    found = {name: Interpreter(name) for name in wanted()}
    for path in _candidates(tuple(found)):
        try:
            done = subprocess.run([path, "-c", _ASK], capture_output=True, timeout=30, check=True)
            name, executable, version = json.loads(done.stdout)
        except (OSError, subprocess.SubprocessError, ValueError):
            continue  # a shim of pyenv for a version that is not active, or what is no Python
        if name in found and found[name].path is None:
            found[name] = Interpreter(name, Path(executable), version)
    return list(found.values())


def _candidates(names):
    home = Path.home()
    for folder in os.environ.get("PATH", "").split(os.pathsep):
        for name in names:
            if executable := shutil.which(f"python{name}", path=folder or os.curdir):
                yield Path(executable)
    pyenv = Path(os.environ.get("PYENV_ROOT", home / ".pyenv")) / "versions"
    data = Path(os.environ.get("XDG_DATA_HOME", home / ".local" / "share"))
    managed = Path(os.environ.get("UV_PYTHON_INSTALL_DIR", data / "uv" / "python"))
    for folder in (pyenv, managed):
        for pattern in ("*/bin/python3", "*/python.exe"):
            yield from sorted(folder.glob(pattern), reverse=True)
    yield Path(sys.executable)


class NotAvailable(Exception):
    """An environment that cannot be made, with the reason."""


def _run(command, doing):
    try:
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    except OSError as err:
        raise NotAvailable(f"{doing}: {err}") from err
    if done.returncode:
        lines = (done.stderr + done.stdout).strip().splitlines() or ["no message"]
        errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
        raise NotAvailable(f"{doing}: {(errors or lines)[-1]}")
    return done.stdout


def environment(interpreter, lowest, folder):
    """Make or update an environment in a folder; its interpreter, and the versions by name."""
    if interpreter.path is None:
        raise NotAvailable(
            f"no python{interpreter.name} on PATH, in pyenv or among the interpreters of uv"
        )
    # Debian's interpreters have no ensurepip without another package: pip of this one installs pip.
    _run([interpreter.path, "-m", "venv", "--without-pip", folder], "venv failed")
    scripts = "Scripts" if os.name == "nt" else "bin"
    python = folder / scripts / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "pip"]
    _run(pip, "pip cannot be installed")
    command = [python, "-m", "pip", "install", "--quiet", "--upgrade", "--only-binary", ":all:"]
    if lowest:
        constraints = folder / "lowest.txt"
        lines = (f"{name}=={version}\n" for name, version in floors().items())
        constraints.write_text("".join(lines))
        command += ["--constraint", constraints]
    _run([*command, "pytest-xdist", "--editable", f"{ROOT}[{EXTRA}]"], "pip")
    listed = json.loads(_run([python, "-m", "pip", "list", "--format", "json"], "pip list failed"))
    return python, {package["name"].lower(): package["version"] for package in listed}


def counts_of(output):
    """Passed, failed (with errors) and skipped tests by the last line that pytest printed, and
    minutes.
    """
    lines = output.strip().splitlines() or [""]
    found = {word: int(number) for number, word in re.findall(r"(\d+) (\w+)", lines[-1])}
    found["failed"] = found.get("failed", 0) + found.get("error", 0) + found.get("errors", 0)
    took = re.search(r" in ([\d.]+)s", lines[-1])
    found["minutes"] = round(float(took[1]) / 60.0) if took else 0
    return {name: found.get(name, 0) for name in COUNTS}


def tested(interpreter, lowest, folder, arguments):
    """The row of one environment."""
    row = Row(interpreter.version or interpreter.name, "lowest" if lowest else "newest", {}, {}, "")
    try:
        python, row.versions = environment(interpreter, lowest, folder)
    except NotAvailable as err:
        row.outcome = f"not available: {err}"
        return row
    log = folder / "pytest.log"
    command = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    # A cache for each: numba keeps one index for a function and a version of Python.
    settings = os.environ | {"NUMBA_CACHE_DIR": str(folder / "numba")}
    with open(log, "w") as output:
        done = subprocess.run(
            command, cwd=ROOT, env=settings, stdout=output, stderr=subprocess.STDOUT
        )
    text = log.read_text(errors="replace")
    row.ran, row.failed, row.counts = True, done.returncode != 0, counts_of(text)
    row.outcome = "passed"
    if row.failed:
        row.outcome = f"pytest ended with {done.returncode}"
        summary = [line for line in text.splitlines() if re.match(r"(FAILED|ERROR) ", line)]
        print("\n".join(summary or text.splitlines()[-20:]), flush=True)
    return row


def table(rows):
    """The rows as a table in Markdown, each column as wide as its longest cell."""
    cells = [("Python", "versions", *SHOWN, *COUNTS, "outcome")]
    for row in rows:
        versions = (row.versions.get(name, "-") for name in SHOWN)
        counts = (str(row.counts.get(name, "-")) for name in COUNTS)
        cells.append((row.interpreter, row.kind, *versions, *counts, row.outcome))
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    cells.insert(1, tuple("-" * width for width in widths))
    return "\n".join(f"| {' | '.join(map(str.ljust, line, widths))} |" for line in cells)


def _arguments(words):
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n", 1)[0],
        epilog="What follows -- is given to pytest in place of -n 2.",
    )
    parser.add_argument("--list", action="store_true", help="show what would be tested, and stop")
    parser.add_argument(
        "--only", nargs="+", choices=wanted(), metavar="VERSION", help="such as 3.12 3.14t"
    )
    parser.add_argument("--lowest", action="store_true", help="the lowest versions alone")
    parser.add_argument(
        "--keep",
        type=Path,
        metavar="FOLDER",
        help="keep the environments there, and use them again",
    )
    parser.add_argument("pytest", nargs="*", help="arguments of pytest, after --")
    return parser.parse_args(words)


def main(words=None):
    """The command; its exit code."""
    options = _arguments(words)
    chosen = interpreters()
    plan = [(chosen[0], True)]
    if not options.lowest:
        plan = [(each, False) for each in chosen] + plan
    plan = [(each, low) for each, low in plan if not options.only or each.name in options.only]
    if options.list:
        for each, low in plan:
            where = f"{each.version} at {each.path}" if each.path else "not found"
            print(f"{each.name:6} {'lowest' if low else 'newest'}  {where}")
        print("lowest versions:", ", ".join(f"{name} {low}" for name, low in floors().items()))
        return 0
    if options.keep is None:
        base = Path(tempfile.mkdtemp(prefix="attitude-matrix-"))
    else:
        base = options.keep.resolve()
    rows = []
    try:
        for each, low in plan:
            kind = "lowest" if low else "newest"
            print(f"Python {each.name} with the {kind} versions", flush=True)
            folder = base / f"{each.name}-{kind}"
            rows.append(tested(each, low, folder, options.pytest or ["-n", "2"]))
            print(table(rows), flush=True)
    finally:
        if options.keep is None:
            shutil.rmtree(base, ignore_errors=True)
    if not any(row.ran for row in rows):
        print("No environment could be made, and nothing was tested.")
        return 1
    return int(any(row.failed for row in rows))


if __name__ == "__main__":
    sys.exit(main())
