"""What a command line asks for, and the exit code of what comes of it."""

from __future__ import annotations

import argparse
import traceback
from collections.abc import Callable, Sequence

import crackgrow
from crackgrow.blas import one_thread
from crackgrow.cli.check import add_check
from crackgrow.cli.compare import add_compare
from crackgrow.cli.completion import add_completion
from crackgrow.cli.console import EXIT_BUG, EXIT_INTERRUPTED, EXIT_UNSOLVED, complain, write_any_character
from crackgrow.cli.converge import add_converge
from crackgrow.cli.explain import add_explain
from crackgrow.cli.export import add_export
from crackgrow.cli.list_cases import add_list
from crackgrow.cli.new import add_new
from crackgrow.cli.parser import Parser, grouped
from crackgrow.cli.render import add_render
from crackgrow.cli.report import add_report
from crackgrow.cli.run import add_run
from crackgrow.cli.schema import add_schema
from crackgrow.cli.sweep import add_sweep
from crackgrow.cli.trade import add_trade
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
    for add in (add_list, add_new, add_check, add_explain, add_run, add_report, add_render, add_export, add_compare,
                add_sweep, add_converge, add_trade, add_schema):  # fmt: skip
        add(commands)
    add_completion(commands, parser)
    parser.epilog = f"{grouped(commands)}\n\n`crackgrow COMMAND --help` has the options of a command, and examples."
    return parser
