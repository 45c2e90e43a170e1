"""`crackgrow completion`: what bash, zsh and fish need to complete a command line, made from the parser by shtab."""

from __future__ import annotations

import argparse
from typing import Final

from crackgrow.cli.console import EXIT_DONE, hand_out
from crackgrow.cli.parser import Commands, add_command, commands_of, path

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
YAML_FILES: Final = {
    "bash": "_crackgrow_yaml_files",
    "zsh": "_files -g '*.(yaml|yml)(-.)'",
    "fish": "(__fish_complete_suffix .yaml)",
}
"""What offers case files and folders, by shell."""

PREAMBLE: Final = {
    "bash": """\
_crackgrow_yaml_files() {
  local file
  while IFS= read -r file; do
    if [[ -d $file || $file == *.y?(a)ml ]]; then echo "$file"; fi
  done < <(compgen -f -- "$1")
}
"""
}


def completion_script(parser: argparse.ArgumentParser, shell: str) -> str:
    """The script for a shell, one of SHELLS."""
    import shtab  # only now: no other command needs it

    commands = commands_of(parser)
    commands.help = None  # what is suppressed in the help would be so here
    for command in commands.choices.values():
        for action in command._actions:
            if not action.choices and (action.type is path or not action.option_strings):
                wants_yaml = "yaml" in str(action.metavar).lower()
                action.complete = YAML_FILES if wants_yaml else shtab.FILE  # type: ignore[attr-defined]
    return str(shtab.complete(parser, shell, preamble=PREAMBLE.get(shell, "")))


def add(commands: Commands, parser: argparse.ArgumentParser) -> None:
    """Add the command; `parser` is the whole one, of which the scripts are made."""

    def completion(arguments: argparse.Namespace) -> int:
        hand_out(completion_script(parser, arguments.shell))
        return EXIT_DONE

    what = "print a script that completes command lines in a shell"
    command = add_command(commands, completion, "completion", what, (HELP, EXAMPLES))
    command.add_argument("shell", choices=SHELLS, help="the shell")
