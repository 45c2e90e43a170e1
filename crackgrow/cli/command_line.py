"""What a command line asks for, and the exit code of what comes of it."""

from __future__ import annotations

import argparse
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path

import crackgrow
from crackgrow.blas import one_thread
from crackgrow.cli.check import add_check
from crackgrow.cli.compare import add_compare
from crackgrow.cli.completion import add_completion
from crackgrow.cli.console import EXIT_BUG, EXIT_INTERRUPTED, EXIT_UNSOLVED, complain, write_any_character
from crackgrow.cli.new import add_new
from crackgrow.cli.render import add_render
from crackgrow.cli.report import add_report
from crackgrow.cli.run import run
from crackgrow.cli.schema import add_schema
from crackgrow.cli.stability import add_stability
from crackgrow.cli.sweep import add_sweep
from crackgrow.cli.trade import add_trade
from crackgrow.errors import CaseError, CrackgrowError, is_out_of_memory, reason_of
from crackgrow.results.style import pass_over_settings

RUN_EXAMPLES = """\
examples:
  crackgrow run cases/compression30.yaml
  crackgrow run cases/compression30.yaml --set cracks.flaw.contact.friction=0.3 --out outputs/rough
  crackgrow run cases/random_flaws.yaml --resume
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process) and return the exit code."""
    one_thread()
    pass_over_settings()
    write_any_character()
    arguments = _parser().parse_args(argv)
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="crackgrow", description="Frictional crack growth in rock by MLS-NMM.")
    parser.add_argument("--version", action="version", version=f"crackgrow {crackgrow.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    case = argparse.ArgumentParser(add_help=False)
    case.add_argument("case", type=Path, metavar="CASE.yaml", help="the case file")
    case.add_argument(
        "--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE", help="override a key; repeatable"
    )
    command = commands.add_parser(
        "run",
        parents=[case],
        help="run a case and write its results",
        epilog=RUN_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("--out", type=Path, metavar="DIR", help="folder of the results (default outputs/<case>)")
    command.add_argument("--resume", action="store_true", help="go on where an earlier run was broken off, if any was")
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.set_defaults(command=run)
    add_check(commands, case)
    add_report(commands)
    add_render(commands)
    add_compare(commands)
    add_stability(commands)
    add_trade(commands, case)
    add_new(commands)
    add_schema(commands)
    add_sweep(commands)
    add_completion(commands, parser)
    return parser
