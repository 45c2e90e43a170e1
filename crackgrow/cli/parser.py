"""The parser of the command line: commands in groups, arguments that they share, and hints for what is mistyped."""

from __future__ import annotations

import argparse
import difflib
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeAlias

import crackgrow
from crackgrow.errors import CaseError

if TYPE_CHECKING:
    from crackgrow.case.model import Case

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

GROUPS: Final = {
    "start": ("list", "new", "check", "explain"),
    "run": ("run",),
    "look": ("report", "render", "view", "export"),
    "study": ("compare", "sweep", "trade"),
    "tools": ("schema", "completion"),
}
"""Commands by what one wants: those of a group are in the module of its name, each with the function `add_COMMAND`."""

GONE: Final = {
    "converge": "`crackgrow trade` tells whether a setting is good enough",
    "--axis": "`crackgrow sweep` varies the keys of a case",
    "--reference": "`reference` of a sweep file holds runs against finer ones",
    "--repeat": "run `crackgrow trade` again",
    "--no-increments": "--increments none",
}
"""Words of earlier versions, and what does their work."""


class Parser(argparse.ArgumentParser):
    """A parser that says what may have been meant; those of its commands are such, too. Its help keeps its lines."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{"formatter_class": argparse.RawDescriptionHelpFormatter, **settings})
        self._words: list[str] = []  # what it parses
        self._negative_number_matcher = re.compile(r"-\.?\d")  # argparse's own takes -1e3 and -20MPa for options

    def parse_args(  # type: ignore[override]  # argparse has it overloaded for namespaces of other types
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        """Parse the words; what is left of them is a fault of the command, not of the program."""
        words = list(sys.argv[1:] if args is None else args)
        found, rest = self.parse_known_args(words, namespace)
        if rest:
            parser: Parser = getattr(found, "parser", self)
            parser.error(f"unknown: {shlex.join(rest)}{parser.hint(rest, words)}")
        return found

    def parse_known_args(  # type: ignore[override]  # as above
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse the words, and keep them for what may be wrong."""
        self._words = list(sys.argv[1:] if args is None else args)
        return super().parse_known_args(self._words, namespace)

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and where the examples are; exit code 2."""
        unknown = [word for word in self._words if word.startswith("--") and not self._takes(word)]
        if message.startswith("the following arguments are required") and unknown:
            message += f"; unknown: {shlex.join(unknown)}{self.hint(unknown, self._words)}"
        self.print_usage(sys.stderr)
        self.exit(2, f"{self.prog}: {message}\n`{self.prog} --help` has all options, and examples\n")

    def _takes(self, word: str) -> bool:
        """Whether a word is an option, or the beginning of one."""
        return any(option.startswith(word.partition("=")[0]) for option in self._option_string_actions)

    def hint(self, rest: Sequence[str], words: Sequence[str]) -> str:
        """What may have been meant by words that a command does not take."""
        option, given, value = rest[0].partition("=")
        if option in GONE and self.prog.endswith(" trade"):
            return f"; it is gone: {GONE[option]}"
        known = list(self._option_string_actions)
        if not option.startswith("--"):
            triples = zip(words, words[1:], words[2:], strict=False)
            parted = [key for word, key, after in triples if (word, after) == ("--set", rest[0])]
            return f"; did you mean --set {parted[0]}={rest[0]}?" if parted and "=" not in parted[0] else ""
        keys = keys_of(option.removeprefix("--")) if "--set" in known else []
        if keys:
            following = value if given else rest[1] if len(rest) > 1 else "VALUE"
            return f"; did you mean --set {keys[0]}={following}?"
        near = difflib.get_close_matches(option, known, n=1)
        return f"; did you mean {near[0]}?" if near else ""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a word that is none of a few; argparse's own way lists them and says no more."""
        if action.choices is None or value in action.choices:
            return
        if value in GONE:
            raise argparse.ArgumentError(action, f"{value!r} is gone: {GONE[value]}")
        near = difflib.get_close_matches(str(value), [str(choice) for choice in action.choices], n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        allowed = ", ".join(str(choice) for choice in action.choices)
        raise argparse.ArgumentError(action, f"{str(value)!r} is none of {allowed}{hint}")


def keys_of(name: str) -> list[str]:
    """Keys of a case that end in a name, the shortest first."""
    from crackgrow.case.keys import case_keys  # only now: it loads numpy

    found = {key.name for key in case_keys() if key.name.rpartition(".")[2] == name.replace("-", "_")}
    return sorted(found, key=len)


def add_command(
    commands: Commands, function: Callable[[argparse.Namespace], int], name: str, what: str, texts: tuple[str, str]
) -> argparse.ArgumentParser:
    """Add a command: what it does in a line, and the texts before and behind its arguments in its help."""
    command = commands.add_parser(name, help=what, description=texts[0], epilog=texts[1])
    command.set_defaults(command=function, parser=command)
    return command


def path(text: str) -> Path:
    """The path that a text names. No text names none: it is mostly a variable of the shell that is not set."""
    if not text:
        raise argparse.ArgumentTypeError("an empty name; the current folder is '.'")
    return Path(text)


def takes_case(command: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """The command, with a case file and settings for arguments."""
    command.add_argument("case", type=path, metavar="CASE.yaml", help="the case file")
    command.add_argument(
        "--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE", help="override a key; repeatable"
    )
    return command


def load_case_file(arguments: argparse.Namespace) -> Case:
    """The case of the arguments `case` and `overrides`; raises CaseError."""
    path: Path = arguments.case
    if not os.path.isfile(path):  # noqa: PTH113  (Path's fails on a long name)
        raise CaseError.at(path, _missing_message(path))
    return crackgrow.load_case(path, arguments.overrides)


def _missing_message(path: Path) -> str:
    if os.path.isdir(path):  # noqa: PTH112  (as above)
        return "is a folder, not a case file"
    names = sorted(file.name for file in path.parent.glob("*.yaml"))
    near = [path.parent / name for name in difflib.get_close_matches(path.name, names, n=1)]
    of_that_name = Path("cases") / f"{path.stem}.yaml"  # where `crackgrow new` writes
    if path.parent == Path() and os.path.isfile(of_that_name):  # noqa: PTH113
        near = [of_that_name]
    if near:
        return f"no such case file; did you mean {near[0]}?"
    return f"no such case file; {path.parent} has {', '.join(names) or 'no case files'}"


def takes_results(command: argparse.ArgumentParser) -> argparse.ArgumentParser:
    """The command, with the folder of a run for an argument."""
    command.add_argument("folder", type=path, metavar="DIR", help="the folder that `crackgrow run` wrote")
    return command


def commands_of(parser: argparse.ArgumentParser) -> Commands:
    """The commands of a parser."""
    return next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction))


def grouped(commands: Commands) -> str:
    """The commands and what they do, by group."""
    helps = helps_of(commands)
    parts = []
    for group, names in GROUPS.items():
        parts.append(f"{group}:")
        parts += [f"  {name:<11} {helps[name]}" for name in names]
    return "\n".join(parts)


def helps_of(commands: Commands) -> dict[str, str]:
    """What each command does, in a line."""
    choices: Iterable[argparse.Action] = commands._choices_actions
    return {choice.dest: choice.help or "" for choice in choices}
