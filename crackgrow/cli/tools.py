"""The commands for other programs: `crackgrow schema` for editors, `crackgrow completion` for shells, by shtab."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from crackgrow.cli.command_line import command_line, commands_of
from crackgrow.cli.console import hand_out
from crackgrow.results.atomic import write_text

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


def do_schema(out: Path | None) -> None:
    """`crackgrow schema`: print or write the JSON Schema of case files."""
    from crackgrow.case.json_schema import case_schema  # only now: it loads numpy

    if out is None:
        hand_out(case_schema())
    else:
        write_text(out, case_schema())


def completion_script(shell: str) -> str:
    """`crackgrow completion`: what a shell needs to complete a command line."""
    import shtab  # only now: no other command needs it

    parser = command_line()
    commands = commands_of(parser)
    commands.help = None  # what is suppressed in the help would be so here
    for command in commands.choices.values():
        for action in command._actions:
            if not action.choices and (getattr(action.type, "__name__", "") == "path" or not action.option_strings):
                wants_yaml = "yaml" in str(action.metavar).lower()
                action.complete = YAML_FILES if wants_yaml else shtab.FILE
    return str(shtab.complete(parser, shell, preamble=PREAMBLE.get(shell, "")))
