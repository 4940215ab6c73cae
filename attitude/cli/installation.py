"""``attitude warm-up``: compile ahead of use; ``attitude completion``: for the shell."""

from __future__ import annotations

import argparse
import os
import shlex
import time

HELP: dict[str, str] = {
    "warm-up": "compile ahead of use, as a step of an installation or of a container image",
    "completion": "print a script by which bash, zsh or fish complete commands and options",
}
EPILOG: dict[str, str] = {
    "warm-up": """\
Machine code is kept in the folder of NUMBA_CACHE_DIR, else in folders __pycache__ of the package,
else in the user's cache folder. It serves all users who may read that folder, on the same kind of
processor.
""",
    "completion": """\
examples:
  attitude completion bash >> ~/.bashrc
  attitude completion zsh >> ~/.zshrc
  attitude completion fish > ~/.config/fish/completions/attitude.fish
""",
}
SHELLS: tuple[str, ...] = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser, command: str) -> None:
    """Add the options of one of both commands."""
    if command == "warm-up":
        parser.add_argument(
            "--all",
            action="store_true",
            help="events, impulses, torques, derivatives, scenes and light curves too (a minute)",
        )
    else:
        parser.add_argument("shell", choices=SHELLS, help="bash, zsh or fish")


def run(arguments: argparse.Namespace, command: str) -> None:
    """Compile, or print the script."""
    if command == "warm-up":
        _warm_up(everything=arguments.all)
    else:
        print(script(arguments.shell), end="")


def _warm_up(*, everything: bool) -> None:
    """Compile, and print what was compiled and where it is kept."""
    from attitude._compilation.decorators import compilation_status
    from attitude.cli import _warm_up

    begin = time.perf_counter()
    for feature in _warm_up.features(everything=everything):
        start = time.perf_counter()
        feature()
        print(f"{feature.__name__.replace('_', ' '):<24} {time.perf_counter() - start:6.1f} s")
    status = compilation_status()
    where = "" if os.access(status.cache, os.W_OK) else "in your cache folder (numba), not "
    print(
        f"{len(status.compiled)} entry points in {time.perf_counter() - begin:.1f} s; "
        f"kept {where}below {status.cache}."
    )


def script(shell: str) -> str:
    """The script of a shell: commands, names of the catalogue, and the options of each command."""
    options = _options_of_commands()
    if shell == "fish":
        return _fish(options)
    first = "" if shell == "bash" else "autoload -Uz bashcompinit && bashcompinit\n"
    return first + _bash(options)


def _options_of_commands() -> dict[str, dict[str, str]]:
    """Options by command, each with its help."""
    from attitude import cli

    commands = {}
    for name in cli.COMMANDS:
        parser = argparse.ArgumentParser()
        cli.command_of(name).add_arguments(parser)
        commands[name] = {
            text: (action.help or "").replace("%%", "%")
            for action in parser._actions
            for text in action.option_strings
            if text.startswith("--")
        }
    return commands


def _bodies() -> list[str]:
    """A word for each body of the catalogue, with which commands find it."""
    from attitude import catalog

    words = {word.lower() for name in catalog.names() for word in name.replace("/", " ").split()}
    return sorted(word for word in words if word.isalpha() and catalog.has(word))


def _bash(options: dict[str, dict[str, str]]) -> str:
    """A function of bash, which zsh takes too."""
    cases = "\n".join(
        f"    {name}) words={shlex.quote(' '.join(words))} ;;" for name, words in options.items()
    )
    return f"""\
_attitude() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" words=
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W {shlex.quote(" ".join(options))} -- "$current"))
    return
  fi
  case "${{COMP_WORDS[1]}}" in
{cases}
  esac
  if [ "${{current#-}}" = "$current" ]; then
    words={shlex.quote(" ".join(_bodies()))}
    COMPREPLY=($(compgen -W "$words" -- "$current") $(compgen -f -- "$current"))
  else
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  fi
}}
complete -o filenames -F _attitude attitude
"""


def _fish(options: dict[str, dict[str, str]]) -> str:
    """Lines of complete for fish."""
    from attitude import cli

    quoted = "'{}'".format
    lines = []
    for name, texts in options.items():
        about = cli.command_of(name).help.replace("'", "\\'")
        lines.append(f"complete -c attitude -n __fish_use_subcommand -a {name} -d {quoted(about)}")
        for option, text in texts.items():
            said = text.replace("'", "\\'")
            seen = quoted(f"__fish_seen_subcommand_from {name}")
            lines.append(f"complete -c attitude -n {seen} -l {option[2:]} -d {quoted(said)}")
    words = " ".join(_bodies())
    lines.append(f"complete -c attitude -n 'not __fish_use_subcommand' -a {quoted(words)}")
    return "\n".join(lines) + "\n"
