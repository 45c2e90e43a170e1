"""The command line: the only place that prints.

Exit codes: 0 done, 2 the case is wrong, 3 it can't be solved or written as asked, 130 interrupted, 1 a bug (which
shows its traceback), paths that `compare` finds further apart than the tolerance, or a NO of `stability`.
"""

from __future__ import annotations

import argparse
import contextlib
import difflib
import os
import shutil
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.errors import CaseError, CrackgrowError, Fault
from crackgrow.results.atomic import OutputError, write_text
from crackgrow.results.log import event_line, step_label, step_line

if TYPE_CHECKING:
    from crackgrow.case.model import Case
    from crackgrow.results.writer import RunWriter
    from crackgrow.run.result import Event, RunEnd, StepResult

EXIT_DONE, EXIT_BUG, EXIT_UNSOLVED, EXIT_INTERRUPTED = 0, 1, 3, 130
EXIT_DIFFERENT = 1  # of compare and stability, as of diff and cmp
THREAD_SETTINGS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
BAR_WIDTH = 20
MOST_WARNINGS = 5  # printed at the end; run.log has all
COMPARE_HELP = """\
Compare the crack paths of two result folders, or of a folder and a CSV file, crack by crack and tip by tip:
Hausdorff and Frechet distance of what has grown, distance of the tips, the place of the largest deviation.
"""
COMPARE_EXAMPLES = """\
A CSV has columns x and y in m, or x_mm and y_mm, and may have crack, vertex and step. Without step it may hold a
part of a path, such as one wing: then the part that both have is compared. Exit code 1: beyond the tolerance.

examples:
  crackgrow compare outputs/before outputs/after --tolerance "0.15 mm"
  crackgrow compare outputs/compression30 paper.csv --crack flaw --tip end --columns x_mm_fem,y_mm
"""


STABILITY_HELP = """\
Take a scene to extremes, one axis at a time and some pairs, and hold the results against references and invariants:
stability.csv, stability.md and stability.png. Without a case: the scenes of the folder `cases`, and all axes. With one:
what holds for any scene, that is balance, units, where the lattice lies, the scene turned, mirrored and moved.
"""
STABILITY_EXAMPLES = """\
verdicts: yes: within the tolerance; said: no good, or refused, and the program says so; NO: neither. Exit code 1: a NO.

examples:
  crackgrow stability --short
  crackgrow stability --axis poisson contrast
  crackgrow stability my_case.yaml --out outputs/my_stability
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line `argv` (default: that of the process) and return the exit code."""
    for name in THREAD_SETTINGS:  # before numpy loads: its and scipy's own copies of BLAS would fight for the cores
        os.environ.setdefault(name, "1")
    arguments = _parser().parse_args(argv)
    command: Callable[[argparse.Namespace], int] = arguments.command
    try:
        return command(arguments)
    except CaseError as error:
        for fault in error.faults:
            _complain(str(fault))
        return error.exit_code
    except CrackgrowError as error:
        _complain(f"crackgrow: {error}")
        return error.exit_code
    except KeyboardInterrupt:
        _complain("crackgrow: interrupted")
        return EXIT_INTERRUPTED
    except Exception:
        _complain("crackgrow: internal error, a bug in the program:")
        _complain(traceback.format_exc())
        return EXIT_BUG


def run(arguments: argparse.Namespace) -> int:
    """`crackgrow run`: load, grow, write; what was solved is kept whatever ends the run."""
    case = _load(arguments)
    folder = arguments.out or Path("outputs") / case.name
    steps = crackgrow.grow(case)  # starts with its first step
    writer = crackgrow.RunWriter(case, folder)
    progress = Progress(case, quiet=arguments.quiet)
    writer.begin()
    try:
        end = _write_steps(steps, writer, progress)
    except OutputError as error:
        with contextlib.suppress(OutputError):  # a small file may still fit
            writer.fail(str(error))
        raise
    except KeyboardInterrupt:
        _fail(writer, "interrupted")
        raise
    except CrackgrowError as error:
        _fail(writer, str(error))
        raise
    except Exception as error:
        _fail(writer, f"internal error: {type(error).__name__}: {error}")
        raise
    finally:
        progress.close()
    if writer.error_line and not arguments.quiet:
        _say(writer.error_line)
    if end.status == "failed":
        _complain(f"crackgrow: {end.reason}")
        return EXIT_UNSOLVED
    if not arguments.quiet:
        _say(f"{end.status}: {end.reason}\nresults in {folder}")
    return EXIT_DONE


def check(arguments: argparse.Namespace) -> int:
    """`crackgrow check`: validate a case and say what it models."""
    _say(crackgrow.overview(_load(arguments)))
    return EXIT_DONE


def compare(arguments: argparse.Namespace) -> int:
    """`crackgrow compare`: how far apart the crack paths of two runs are."""
    comparison = crackgrow.compare_paths(
        arguments.a,
        arguments.b,
        tolerance=arguments.tolerance,
        crack=arguments.crack,
        tip=arguments.tip,
        columns=arguments.columns,
    )
    _say(crackgrow.comparison_text(comparison))
    if arguments.csv is not None:
        write_text(arguments.csv, crackgrow.comparison_csv(comparison))
    return EXIT_DONE if comparison.agrees else EXIT_DIFFERENT


def stability(arguments: argparse.Namespace) -> int:
    """`crackgrow stability`: a scene at the extremes."""
    case = None if arguments.case is None else _load(arguments)
    rows = []
    for row in crackgrow.stability(case, arguments.axis, short=arguments.short):
        rows.append(row)
        _say(crackgrow.stability_line(row))
    crackgrow.write_stability(arguments.out, rows)
    good = all(row.verdict != "NO" for row in rows)
    _say(f"{len(rows)} rows, {sum(row.verdict == 'NO' for row in rows)} NO\nresults in {arguments.out}")
    return EXIT_DONE if good else EXIT_DIFFERENT


class Progress:
    """How far a run is: one live line on a terminal, otherwise a line a step."""

    def __init__(self, case: Case, *, quiet: bool) -> None:
        self._n_steps = case.growth.steps if case.growth else None
        self._quiet = quiet
        self._live = not quiet and sys.stdout is not None and sys.stdout.isatty()
        self._n_advances = 0
        self._seconds = 0.0
        self._warnings: dict[str, None] = {}
        if not quiet:
            _say(f"{case.name}: {case.title}")

    def show(self, result: StepResult) -> None:
        """Tell of a solved step."""
        self._n_advances += sum(tip.advanced for tip in result.tips)
        self._seconds += sum(result.seconds.values())
        self._warnings.update(dict.fromkeys(result.warnings))
        if self._live:
            width = shutil.get_terminal_size().columns - 1
            _say(f"\r{self._bar(result)[:width]}\x1b[K", end="")
        elif not self._quiet:
            _say(step_line(result, self._n_steps))
        self.tell(result.events)

    def tell(self, events: Sequence[Event]) -> None:
        """Tell of tips that have met something."""
        if events and self._live:
            _say("")  # the bar stays above, and a new one follows
        for event in events if not self._quiet else ():
            _say(event_line(event))

    def close(self) -> None:
        """Leave the live line and print the warnings of the steps, each once."""
        if self._live:
            _say("")
        if not self._quiet:
            texts = list(self._warnings)
            for text in texts[:MOST_WARNINGS]:
                _say(f"warning: {text}")
            if len(texts) > MOST_WARNINGS:
                _say(f"and {len(texts) - MOST_WARNINGS} more warnings in run.log")

    def _bar(self, result: StepResult) -> str:
        done = result.step / self._n_steps if self._n_steps else 1.0
        filled = round(BAR_WIDTH * min(done, 1.0))
        return (
            f"[{'#' * filled}{'.' * (BAR_WIDTH - filled)}] {step_label(result.step, self._n_steps)}, "
            f"{self._n_advances} tip advances, {result.contact_iterations} contact iterations, {self._seconds:.1f} s"
        )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="crackgrow", description="Frictional crack growth in rock by MLS-NMM.")
    parser.add_argument("--version", action="version", version=f"crackgrow {crackgrow.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    case = argparse.ArgumentParser(add_help=False)
    case.add_argument("case", type=Path, metavar="CASE.yaml", help="the case file")
    case.add_argument(
        "--set", dest="overrides", action="append", default=[], metavar="KEY=VALUE", help="override a key; repeatable"
    )
    command = commands.add_parser("run", parents=[case], help="run a case and write its results")
    command.add_argument("--out", type=Path, metavar="DIR", help="folder of the results (default outputs/<case>)")
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.set_defaults(command=run)
    command = commands.add_parser("check", parents=[case], help="validate a case and say what it models")
    command.set_defaults(command=check)
    _add_compare(commands)
    _add_stability(commands)
    return parser


def _add_compare(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "compare",
        help="say how far apart the crack paths of two runs are",
        description=COMPARE_HELP,
        epilog=COMPARE_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    for name in ("a", "b"):
        command.add_argument(name, metavar=name.upper(), help="a result folder or a CSV file")
    command.add_argument(
        "--tolerance", metavar="LENGTH", help='largest distance allowed: "0.15 mm", or a bare number in m'
    )
    command.add_argument("--csv", type=Path, metavar="FILE", help="write the rows of the table, SI, to a file")
    command.add_argument("--crack", metavar="NAME", help="compare this crack alone")
    command.add_argument("--tip", choices=("start", "end"), help="compare what has grown at this tip alone")
    command.add_argument("--columns", type=_two_names, metavar="X,Y", help="columns of x and y of a CSV with several")
    command.set_defaults(command=compare)


def _add_stability(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    command = commands.add_parser(
        "stability",
        help="take a scene to extremes and hold the results against references and invariants",
        description=STABILITY_HELP,
        epilog=STABILITY_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.add_argument("case", type=Path, nargs="?", metavar="CASE.yaml", help="a case file of your own")
    command.add_argument("--axis", nargs="+", default=[], metavar="NAME", help="these axes alone")
    command.add_argument("--short", action="store_true", help="coarse scenes, and few values of every axis")
    command.add_argument(
        "--out", type=Path, default=Path("outputs/stability"), metavar="DIR", help="folder of the results"
    )
    command.set_defaults(command=stability, overrides=[])


def _two_names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if len(names) != 2 or not all(names):
        raise argparse.ArgumentTypeError(f"{text!r}: two column names are wanted, that of x and that of y: X,Y")
    return names


def _load(arguments: argparse.Namespace) -> Case:
    path: Path = arguments.case
    if not path.is_file():
        raise CaseError([Fault(str(path), None, "", _missing_message(path))])
    return crackgrow.load_case(path, arguments.overrides)


def _missing_message(path: Path) -> str:
    if path.is_dir():
        return "is a folder, not a case file"
    names = sorted(file.name for file in path.parent.glob("*.yaml"))
    near = difflib.get_close_matches(path.name, names, n=1)
    if near:
        return f"no such case file; did you mean {path.parent / near[0]}?"
    return f"no such case file; {path.parent} has {', '.join(names) or 'no case files'}"


def _write_steps(steps: Iterator[StepResult], writer: RunWriter, progress: Progress) -> RunEnd:
    """Write each step as it comes, then the end, and return it."""
    while True:
        try:
            result = next(steps)
        except StopIteration as stop:
            end: RunEnd = stop.value
            break
        writer.add(result)
        progress.show(result)
    progress.tell(end.events)
    writer.finish(end)
    return end


def _fail(writer: RunWriter, reason: str) -> None:
    """Keep what was solved; a disk that refuses now doesn't hide the first error."""
    try:
        writer.fail(reason)
    except CrackgrowError as error:
        _complain(f"crackgrow: {error}")


def _say(text: str, end: str = "\n") -> None:
    """Print at once; a reader that has gone away (`| head`) or a full or closed output doesn't end the run."""
    try:
        print(text, end=end, flush=True)
    except (OSError, ValueError):
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115  (until the process ends)


def _complain(text: str) -> None:
    with contextlib.suppress(OSError, ValueError):  # nobody listens: the exit code still tells
        print(text, file=sys.stderr, flush=True)
