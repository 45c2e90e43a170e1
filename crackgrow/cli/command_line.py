"""The parser of the command line, made of `commands.toml`, with hints for what is mistyped; and the exit code."""

from __future__ import annotations

import argparse
import difflib
import math
import re
import shlex
import sys
import tomllib
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NoReturn

import crackgrow
from crackgrow.blas import one_thread
from crackgrow.cli.console import (
    EXIT_BUG,
    EXIT_DONE,
    EXIT_INTERRUPTED,
    EXIT_UNSOLVED,
    complain,
    hand_out,
    say,
    spelled,
    write_any_character,
)
from crackgrow.errors import CaseError, CrackgrowError, is_out_of_memory, reason_of
from crackgrow.results.style import pass_over_settings
from crackgrow.results.units import aligned

NO_COMMANDS: Final = ("shared", "words")  # tables of commands.toml that are no groups of commands
MOST_PIXELS: Final = 8000  # of a side


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process) and return the exit code."""
    one_thread()
    pass_over_settings()
    write_any_character()
    group, name, given = parsed(sys.argv[1:] if argv is None else argv)
    try:
        module, function = groups()[group][name].get("calls", f"cli.{group}:do_{name}").split(":")
        found = getattr(import_module(f"crackgrow.{module}"), function)(**given)
        if isinstance(found, str):
            hand_out(found.removesuffix("\n"), end="\n")
        elif isinstance(found, Path | Iterator):  # of what was written
            for path in [found] if isinstance(found, Path) else found:
                say(str(path))
        return found if isinstance(found, int) else EXIT_DONE
    except CrackgrowError as error:
        for fault in error.faults if isinstance(error, CaseError) else [f"crackgrow: {error}"]:
            complain(str(fault))
        return error.exit_code
    except KeyboardInterrupt:
        complain("crackgrow: interrupted")
        return EXIT_INTERRUPTED
    except Exception as error:
        if is_out_of_memory(error) or isinstance(error, OSError):
            complain(f"crackgrow: {reason_of(error)}")
            return EXIT_UNSOLVED
        complain(f"crackgrow: internal error, a bug in the program:\n{traceback.format_exc()}")
        return EXIT_BUG


@cache
def declared() -> dict[str, Any]:
    """What `commands.toml` says."""
    return tomllib.loads(Path(__file__).with_name("commands.toml").read_text(encoding="utf-8"))


def groups() -> dict[str, dict[str, Any]]:
    """What is declared of each command, by group and name."""
    return {group: commands for group, commands in declared().items() if group not in NO_COMMANDS}


def parsed(words: Sequence[str]) -> tuple[str, str, dict[str, Any]]:
    """The group, the name and the arguments of the command that is asked for; exit code 2 where there is none."""
    parser = command_line(words)
    found, rest = parser.parse_known_args(words)
    given = vars(found)
    name: str = given.pop("command")
    if rest:
        command: Parser = commands_of(parser).choices[name]
        command.error(f"unknown: {shlex.join(rest)}{command.hint(rest)}")
    if "resume" in given:
        given["again"] = spelled(*words, *([] if given["resume"] else ["--resume"]))
    return next(group for group, commands in groups().items() if name in commands), name, given


def command_line(words: Sequence[str] = ()) -> Parser:
    """Return the parser of the whole command line; it uses the `words` given there to word its errors alone."""
    parser = Parser(
        words,
        prog="crackgrow",
        usage="crackgrow [-h] [--version] COMMAND ...",
        description="Friction, slip and growth of closed cracks in rock, in two dimensions.",
    )
    parser.add_argument("--version", action="version", version=f"crackgrow {crackgrow.__version__}")
    commands = parser.add_subparsers(
        prog="crackgrow", dest="command", required=True, metavar="COMMAND", help=argparse.SUPPRESS
    )
    lines = []
    for group, of_group in groups().items():
        lines.append(f"{group}:")
        for name, told in of_group.items():
            lines.append(f"  {name:<11} {told['what']}")
            command = commands.add_parser(name, words=words, help=told["what"], description=told["about"])
            command.epilog = "\n".join([*_add_arguments(command, told), told["more"]])
    listed = "\n".join(lines)
    parser.epilog = f"{listed}\n\n`crackgrow COMMAND --help` has the options of a command, and examples."
    return parser


def _add_arguments(command: Parser, told: dict[str, Any]) -> list[str]:
    """Add what is declared of the arguments of a command; returns lines for its help on words that they take."""
    shared = [declared()["shared"][name] for name in told.get("shares", ())]
    arguments = {name: of for table in (*shared, told.get("arguments", {})) for name, of in table.items()}
    one_of: dict[str, Any] = {}
    lines = []
    for name, declaration in arguments.items():
        settings = dict(declaration)
        if "type" in settings:
            settings["type"] = reader_of(settings["type"])
        if isinstance(settings.get("metavar"), list):
            settings["metavar"] = tuple(settings["metavar"])
        if isinstance(words := settings.get("choices"), str):
            settings["choices"] = tuple(declared()["words"][words])
            lines += [f"{words}:", *aligned(declared()["words"][words].items(), 2, "  "), ""]
        choice = settings.pop("one_of", None)
        if choice is not None and choice not in one_of:
            one_of[choice] = command.add_mutually_exclusive_group()
        one_of.get(choice, command).add_argument(name, **settings)
    return lines


class Parser(argparse.ArgumentParser):
    """A parser that says what may have been meant by words; those of its commands are such, too."""

    def __init__(self, words: Sequence[str] = (), **settings: Any) -> None:
        """`words` are those that it is going to parse; its help keeps its lines."""
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **settings)
        self._words = list(words)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # argparse's own takes -1e3 and -20MPa for options

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and where the examples are; exit code 2."""
        options = self._option_string_actions
        begun = {word: word.partition("=")[0] for word in self._words if word.startswith("--")}
        unknown = [word for word, begin in begun.items() if not any(option.startswith(begin) for option in options)]
        if message.startswith("the following arguments are required") and unknown:
            message += f"; unknown: {shlex.join(unknown)}{self.hint(unknown)}"
        self.print_usage(sys.stderr)
        self.exit(2, f"{self.prog}: {message}\n`{self.prog} --help` has all options, and examples\n")

    def hint(self, rest: Sequence[str]) -> str:
        """What may have been meant by words that a command does not take."""
        option, given, value = rest[0].partition("=")
        known = list(self._option_string_actions)
        if not option.startswith("--"):
            triples = zip(self._words, self._words[1:], self._words[2:], strict=False)
            parted = [key for word, key, after in triples if (word, after) == ("--set", rest[0])]
            return f"; did you mean --set {parted[0]}={rest[0]}?" if parted and "=" not in parted[0] else ""
        keys = _keys_of(option.removeprefix("--")) if "--set" in known else []
        if keys:
            following = value if given else rest[1] if len(rest) > 1 else "VALUE"
            return f"; did you mean --set {keys[0]}={following}?"
        return _did_you_mean(option, known)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a word that is none of a few; argparse's own way lists them and says no more."""
        if action.choices is not None and value not in action.choices:
            allowed = [str(choice) for choice in action.choices]
            message = f"{str(value)!r} is none of {', '.join(allowed)}{_did_you_mean(str(value), allowed)}"
            raise argparse.ArgumentError(action, message)


def _did_you_mean(word: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(word, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""


def _keys_of(name: str) -> list[str]:
    """Keys of a case that end in a name, the shortest first."""
    from crackgrow.case.keys import case_keys  # only now: it loads numpy

    found = {key.name for key in case_keys() if key.name.rpartition(".")[2] == name.replace("-", "_")}
    return sorted(found, key=len)


def commands_of(parser: argparse.ArgumentParser) -> argparse._SubParsersAction[Any]:
    """The commands of a parser."""
    return next(action for action in parser._actions if isinstance(action, argparse._SubParsersAction))


def reader_of(kind: str) -> Callable[[str], Any]:
    """What reads an argument of a kind, for argparse: what it cannot read is told with what is wanted."""
    pattern, read, wanted = KINDS[kind]

    def reader(text: str) -> Any:
        try:
            if re.fullmatch(pattern, text):
                return read(text)
        except ValueError:
            pass
        raise argparse.ArgumentTypeError(f"{text!r}: {wanted}")

    reader.__name__ = kind
    return reader


def _warp(text: str) -> float | None:
    factor = None if text == "auto" else float(text)
    if factor is not None and not 0.0 <= factor < math.inf:
        raise ValueError(text)
    return factor


def _span(text: str) -> range:
    first, dash, last = text.partition("-")
    span = range(int(first), int(last if dash else first) + 1)
    if not span:
        raise ValueError(text)
    return span


def _size(text: str) -> tuple[int, int]:
    width, height = map(int, text.split("x"))
    if not all(100 <= side <= MOST_PIXELS for side in (width, height)):
        raise ValueError(text)
    return width, height


ANY: Final = "(?s).*"
KINDS: Final[dict[str, tuple[str, Callable[[str], Any], str]]] = {
    "path": ("(?s).+", Path, "an empty name; the current folder is '.'"),  # mostly a variable that is not set
    "picture": (r"(?si).+\.(png|svg)", Path, "a name that ends in .png or .svg is wanted"),
    "count": (r"0*[1-9]\d*", int, "a whole number from 1 on is wanted"),
    "step": (r"\d+", int, "the number of a step is wanted, from 0 on"),
    "number": (ANY, int, "a whole number is wanted"),
    "seconds": (ANY, float, "a number of seconds is wanted"),
    "warp": (ANY, _warp, "auto, or a number from 0 on is wanted"),
    "span": (r"\d+(-\d+)?", _span, "a step such as 4, or a span such as 4-10 is wanted"),
    "size": (r"\d+x\d+", _size, f"WIDTHxHEIGHT in pixels, each from 100 to {MOST_PIXELS}, is wanted"),
    "names": (
        r"[^,]*[^,\s][^,]*,[^,]*[^,\s][^,]*",
        lambda text: tuple(map(str.strip, text.split(","))),
        "two column names are wanted, that of x and that of y: X,Y",
    ),
}
"""What a text of a kind looks like, what reads it and may raise ValueError, and what is wanted."""
