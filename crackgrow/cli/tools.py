"""The commands for other programs: `crackgrow schema` for editors, `crackgrow completion` for shells, by shtab."""

from __future__ import annotations

import argparse
from typing import Final

from crackgrow.cli.console import EXIT_DONE, hand_out
from crackgrow.cli.parser import Commands, add_command, commands_of, path
from crackgrow.results.atomic import write_text

SCHEMA_HELP = """\
Print the JSON Schema (draft 7) of case files: with it an editor completes keys and words, shows what a key means and
in which units, and marks mistakes as they are typed. It is made from what the reader itself checks with.
"""
SCHEMA_EXAMPLES = """\
examples:
  crackgrow schema --out cases/case.schema.json

VS Code with the YAML plugin, and any editor with yaml-language-server, then follow a comment at the top of a case,
  # yaml-language-server: $schema=case.schema.json
which names the schema relative to the case. What it cannot tell, such as names and geometry, `crackgrow check` does.
"""


def schema(arguments: argparse.Namespace) -> int:
    """`crackgrow schema`: print or write the JSON Schema of case files."""
    from crackgrow.case.json_schema import case_schema  # only now: it loads numpy

    text = case_schema()
    if arguments.out is None:
        hand_out(text)
    else:
        write_text(arguments.out, text)
    return EXIT_DONE


def add_schema(commands: Commands) -> None:
    what = "print the JSON Schema of case files, for editors"
    command = add_command(commands, schema, "schema", what, (SCHEMA_HELP, SCHEMA_EXAMPLES))
    command.add_argument("--out", type=path, metavar="FILE", help="write it to a file")


COMPLETION_HELP = """\
Print a script that completes commands, options, their values, and case files. It is made from this version's options.
"""
COMPLETION_EXAMPLES = """\
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


def completion(arguments: argparse.Namespace) -> int:
    """`crackgrow completion`: print what a shell needs to complete a command line."""
    from crackgrow.cli.command_line import command_line  # only now: it adds the commands of this module

    hand_out(completion_script(command_line(), arguments.shell))
    return EXIT_DONE


def add_completion(commands: Commands) -> None:
    what = "print a script that completes command lines in a shell"
    command = add_command(commands, completion, "completion", what, (COMPLETION_HELP, COMPLETION_EXAMPLES))
    command.add_argument("shell", choices=SHELLS, help="the shell")
