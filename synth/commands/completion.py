"""``synth completion``: shell scripts that complete commands, options and their choices.

  synth completion bash > ~/.local/share/bash-completion/completions/synth
  synth completion zsh > ~/.zfunc/_synth          (with ~/.zfunc in fpath)
  synth completion fish > ~/.config/fish/completions/synth.fish

Each is a plain script generated from the commands' own options; it does not run synth.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from synth.commands.arguments import one_of

if TYPE_CHECKING:
    from synth.commands.progress import Progress

SHELLS = ("bash", "zsh", "fish")


@dataclass(frozen=True)
class Option:
    """An option of a command: names, help text, choices, and whether a value follows."""

    names: tuple[str, ...]
    text: str
    choices: tuple[str, ...]
    takes_value: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "shell", type=one_of(SHELLS), metavar="|".join(SHELLS), help="the shell to write the script for"
    )


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Print the script."""
    from synth.cli import COMMANDS, parser_of

    options = {name: options_of(parser_of(name)) for name in COMMANDS}
    words = {name: words_of(parser_of(name)) for name in COMMANDS}
    progress.result(_WRITERS[arguments.shell](COMMANDS, options, words))
    return 0


def options_of(parser: argparse.ArgumentParser) -> list[Option]:
    """The options of a parser, in order."""
    found = []
    for action in parser._actions:
        if action.option_strings:
            text = (action.help or "").replace("%%", "%")
            found.append(Option(tuple(action.option_strings), text, _choices(action), action.nargs != 0))
    return found


def words_of(parser: argparse.ArgumentParser) -> tuple[str, ...]:
    """The allowed words of a command's first argument, if it has a choice."""
    first = next((action for action in parser._actions if not action.option_strings), None)
    return () if first is None else _choices(first)


def _choices(action: argparse.Action) -> tuple[str, ...]:
    """The words that ``one_of`` allows."""
    return tuple(getattr(action.type, "words", ()))


def _bash(
    commands: Mapping[str, str], options: Mapping[str, Sequence[Option]], words: Mapping[str, tuple[str, ...]]
) -> str:
    cases = []
    for name in commands:
        names = " ".join(each for option in options[name] for each in option.names)
        values = [
            f"            {'|'.join(option.names)}) "
            f"COMPREPLY=($(compgen -W '{' '.join(option.choices)}' -- \"$current\")); return;;"
            for option in options[name]
            if option.choices
        ]
        chosen = [f'        case "$before" in\n{chr(10).join(values)}\n        esac'] if values else []
        first = f" {' '.join(words[name])}" if words[name] else ""
        cases.append("\n".join([f"    {name})", *chosen, f"        choices='{names}{first}';;"]))
    listed = " ".join(commands)
    return "\n".join(
        [
            "# bash completion of synth",
            "_synth() {",
            '    local current="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" choices=""',
            "    COMPREPLY=()",
            '    if [ "$COMP_CWORD" -eq 1 ]; then',
            f"        COMPREPLY=($(compgen -W '{listed} --help --version --quiet' -- \"$current\")); return",
            "    fi",
            '    case "${COMP_WORDS[1]}" in',
            *cases,
            "    esac",
            "    # Words of the command where they fit, else files.",
            '    COMPREPLY=($(compgen -W "$choices" -- "$current"))',
            '    case "$current" in -*) ;; *) COMPREPLY+=($(compgen -f -- "$current"));; esac',
            "}",
            "complete -o filenames -F _synth synth",
        ]
    )


def _zsh(
    commands: Mapping[str, str], options: Mapping[str, Sequence[Option]], words: Mapping[str, tuple[str, ...]]
) -> str:
    lines = ["#compdef synth", "_synth() {", "  local -a commands", "  commands=("]
    lines += [f"    {_quote(f'{name}:{summary}')}" for name, summary in commands.items()]
    lines += ["  )", "  if (( CURRENT == 2 )); then", "    _describe command commands", "    return", "  fi"]
    lines += ["  local command=$words[2]", "  shift words", "  (( CURRENT-- ))", "  case $command in"]
    for name in commands:
        specs = []
        for option in options[name]:
            text = option.text.replace("[", "(").replace("]", ")").replace(":", " ")
            value = (
                ""
                if not option.takes_value
                else f":value:({' '.join(option.choices)})"
                if option.choices
                else ":value:_files"
            )
            specs += [_quote(f"{each}[{text}]{value}") for each in option.names]
        first = f"1:what:({' '.join(words[name])})" if words[name] else "1:file:_files"
        lines.append(f"    {name}) _arguments {' '.join([*specs, _quote(first), _quote('*:file:_files')])} ;;")
    return "\n".join([*lines, "  esac", "}", '_synth "$@"'])


def _fish(
    commands: Mapping[str, str], options: Mapping[str, Sequence[Option]], words: Mapping[str, tuple[str, ...]]
) -> str:
    lines = ["# fish completion of synth"]
    for name, summary in commands.items():
        lines.append(f"complete -c synth -f -n __fish_use_subcommand -a {name} -d {_quote(summary)}")
        seen = f"-n '__fish_seen_subcommand_from {name}'"
        if words[name]:
            lines.append(f"complete -c synth {seen} -a {_quote(' '.join(words[name]))}")
        for option in options[name]:
            names = " ".join(f"-l {each[2:]}" if each.startswith("--") else f"-s {each[1:]}" for each in option.names)
            value = (
                f" -x -a {_quote(' '.join(option.choices))}" if option.choices else " -r" if option.takes_value else ""
            )
            lines.append(f"complete -c synth {seen} {names}{value} -d {_quote(option.text)}")
    return "\n".join(lines)


def _quote(text: str) -> str:
    """Text in single quotes for any shell."""
    return "'" + text.replace("'", "’") + "'"


_WRITERS = {"bash": _bash, "zsh": _zsh, "fish": _fish}
