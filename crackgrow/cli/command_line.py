"""What a command line asks for, and the exit code of what comes of it."""

from __future__ import annotations

import argparse
import traceback
from collections.abc import Callable, Sequence
from importlib import import_module

import crackgrow
from crackgrow.blas import one_thread
from crackgrow.cli.console import EXIT_BUG, EXIT_INTERRUPTED, EXIT_UNSOLVED, complain, write_any_character
from crackgrow.cli.parser import GROUPS, Parser, grouped
from crackgrow.errors import CaseError, CrackgrowError, is_out_of_memory, reason_of
from crackgrow.results.style import pass_over_settings


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process) and return the exit code."""
    one_thread()
    pass_over_settings()
    write_any_character()
    arguments = command_line().parse_args(argv)
    command: Callable[[argparse.Namespace], int] = arguments.command
    try:
        return command(arguments)
    except CaseError as error:
        for fault in error.faults:
            complain(str(fault))
        return error.exit_code
    except CrackgrowError as error:
        complain(f"crackgrow: {error}")
        return error.exit_code
    except KeyboardInterrupt:
        complain("crackgrow: interrupted")
        return EXIT_INTERRUPTED
    except Exception as error:
        if is_out_of_memory(error) or isinstance(error, OSError):
            complain(f"crackgrow: {reason_of(error)}")
            return EXIT_UNSOLVED
        complain("crackgrow: internal error, a bug in the program:")
        complain(traceback.format_exc())
        return EXIT_BUG


def command_line() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    parser: argparse.ArgumentParser = Parser(
        prog="crackgrow",
        usage="crackgrow [-h] [--version] COMMAND ...",
        description="Friction, slip and growth of closed cracks in rock, in two dimensions.",
    )
    parser.add_argument("--version", action="version", version=f"crackgrow {crackgrow.__version__}")
    commands = parser.add_subparsers(prog="crackgrow", required=True, metavar="COMMAND", help=argparse.SUPPRESS)
    for group, names in GROUPS.items():
        for name in names:
            getattr(import_module(f"crackgrow.cli.{group}"), f"add_{name}")(commands)
    parser.epilog = f"{grouped(commands)}\n\n`crackgrow COMMAND --help` has the options of a command, and examples."
    return parser
