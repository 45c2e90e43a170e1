"""`crackgrow completion`: what bash, zsh and fish need to complete a command line, made from the parser itself."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from crackgrow.cli.console import EXIT_DONE, hand_out

HELP = """\
Print a script that completes commands, options, their values, and case files. It is made from this version's options.
"""
EXAMPLES = """\
examples:
  crackgrow completion bash > ~/.local/share/bash-completion/completions/crackgrow
  crackgrow completion zsh > ~/.zfunc/_crackgrow          # with ~/.zfunc in $fpath before compinit
  crackgrow completion fish > ~/.config/fish/completions/crackgrow.fish
"""

SHELLS: Final = ("bash", "zsh", "fish")
PROGRAM: Final = "crackgrow"


@dataclass(frozen=True, slots=True)
class Option:
    """One option of a command."""

    names: tuple[str, ...]
    help: str
    choices: tuple[str, ...]
    takes_value: bool


@dataclass(frozen=True, slots=True)
class Command:
    """A command, or the program before one."""

    help: str
    options: tuple[Option, ...]
    words: tuple[str, ...]  # that a positional argument can be
    wants_case: bool  # whether one is a case file


def completion_script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script for a shell, one of SHELLS."""
    commands = dict(_commands(parser))
    return {"bash": _bash, "zsh": _zsh, "fish": _fish}[shell](commands, _command(parser, ""))


def _commands(parser: argparse.ArgumentParser) -> Iterator[tuple[str, Command]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
            for name, command in action.choices.items():
                yield name, _command(command, helps.get(name, ""))


def _command(parser: argparse.ArgumentParser, words: str) -> Command:
    actions = [action for action in parser._actions if not isinstance(action, argparse._SubParsersAction)]
    options = [action for action in actions if action.option_strings]
    positional = [action for action in actions if not action.option_strings]
    return Command(
        words,
        tuple(Option(tuple(a.option_strings), _plain(a.help), _choices(a), a.nargs != 0) for a in options),
        tuple(word for action in positional for word in _choices(action)),
        any("yaml" in str(action.metavar).lower() for action in positional),
    )


def _choices(action: argparse.Action) -> tuple[str, ...]:
    return tuple(str(choice) for choice in action.choices or ())


def _plain(text: str | None) -> str:
    """Help without what shells would take for more than letters."""
    return re.sub(r"[^\w ,.;()/=<>+-]", "", (text or "").replace("%%", "%"))


def _bash(commands: Mapping[str, Command], top: Command) -> str:
    cases = []
    for name, command in commands.items():
        values = [
            f"        {'|'.join(option.names)}) {_offer(option.choices)}; return;;"
            for option in command.options
            if option.choices
        ]
        files = [option for option in command.options if option.takes_value and not option.choices]
        if files:
            names = "|".join(name for option in files for name in option.names)
            values.append(f"        {names}) _crackgrow_files; return;;")
        words = " ".join([*(n for option in command.options for n in option.names), *command.words])
        rest = "_crackgrow_files '*.y?(a)ml'" if command.wants_case else "_crackgrow_files"
        chosen = "\n".join(['      case "$before" in', *values, "      esac"]) if values else "      :"
        cases.append(
            f'    {name})\n{chosen}\n      COMPREPLY=($(compgen -W {shlex.quote(words)} -- "$word"))\n      {rest};;'
        )
    first = " ".join([*commands, *(n for option in top.options for n in option.names)])
    body = "\n".join(cases)
    return f"""# bash completion of {PROGRAM}
_crackgrow_files() {{  # folders and, of the files, those of a pattern
  local file
  compopt -o filenames 2> /dev/null  # escapes spaces in names, ends folders with a slash
  while IFS= read -r file; do
    if [[ -d $file || $file == ${{1:-*}} ]]; then COMPREPLY+=("$file"); fi
  done < <(compgen -f -- "$word")
}}
_crackgrow() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  COMPREPLY=()
  if (( COMP_CWORD == 1 )); then
    COMPREPLY=($(compgen -W {shlex.quote(first)} -- "$word")); return
  fi
  case "${{COMP_WORDS[1]}}" in
{body}
  esac
}}
complete -F _crackgrow {PROGRAM}
"""


def _offer(words: Iterable[str]) -> str:
    """Bash that offers those of the words that begin as the one on the line."""
    return f'COMPREPLY=($(compgen -W {shlex.quote(" ".join(words))} -- "$word"))'


def _zsh(commands: Mapping[str, Command], top: Command) -> str:
    listed = "\n".join(f"    {shlex.quote(f'{name}:{_plain(command.help)}')}" for name, command in commands.items())
    cases = []
    for name, command in commands.items():
        specs = [_zsh_option(option) for option in command.options]
        if command.words:
            specs.append(f"'1:word:({' '.join(command.words)})'")
        specs.append("'*:case file:_files -g \"*.(yaml|yml)(-.)\"'" if command.wants_case else "'*:file:_files'")
        cases.append(f"    {name}) _arguments {' '.join(specs)};;")
    body = "\n".join(cases)
    options = " ".join(name for option in top.options for name in option.names)
    return f"""#compdef {PROGRAM}
_crackgrow() {{
  local -a commands
  commands=(
{listed}
  )
  if (( CURRENT == 2 )); then
    _describe command commands
    compadd -- {options}
    return
  fi
  local command=$words[2]
  shift words
  (( CURRENT -= 1 ))
  case $command in
{body}
  esac
}}
compdef _crackgrow {PROGRAM}
"""


def _zsh_option(option: Option) -> str:
    value = f":value:({' '.join(option.choices)})" if option.choices else ":value:_files" if option.takes_value else ""
    return " ".join(shlex.quote(f"*{name}[{option.help}]{value}") for name in option.names)


def _fish(commands: Mapping[str, Command], top: Command) -> str:
    lines = [f"# fish completion of {PROGRAM}", f"complete -c {PROGRAM} -f"]
    lines += [_fish_option(option, "__fish_use_subcommand") for option in top.options]
    for name, command in commands.items():
        lines.append(f"complete -c {PROGRAM} -n __fish_use_subcommand -a {name} -d {shlex.quote(_plain(command.help))}")
        seen = f"__fish_seen_subcommand_from {name}"
        lines += [_fish_option(option, seen) for option in command.options]
        if command.words:
            lines.append(f"complete -c {PROGRAM} -n {shlex.quote(seen)} -a {shlex.quote(' '.join(command.words))}")
        elif command.wants_case:
            lines.append(f"complete -c {PROGRAM} -n {shlex.quote(seen)} -a '(__fish_complete_suffix .yaml)'")
        else:
            lines.append(f"complete -c {PROGRAM} -n {shlex.quote(seen)} -F")
    return "\n".join(lines) + "\n"


def _fish_option(option: Option, condition: str) -> str:
    names = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names)
    value = (
        f" -x -a {shlex.quote(' '.join(option.choices))}" if option.choices else " -r -F" if option.takes_value else ""
    )
    return f"complete -c {PROGRAM} -n {shlex.quote(condition)} {names}{value} -d {shlex.quote(option.help)}"


def add_completion(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], parser: argparse.ArgumentParser
) -> None:
    """Add the command; `parser` is the whole one, of which the scripts are made."""

    def completion(arguments: argparse.Namespace) -> int:
        hand_out(completion_script(parser, arguments.shell))
        return EXIT_DONE

    command = commands.add_parser(
        "completion", help="print a script that completes command lines in a shell", description=HELP, epilog=EXAMPLES
    )
    command.add_argument("shell", choices=SHELLS, help="the shell")
    command.set_defaults(command=completion)
