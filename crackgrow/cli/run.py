"""`crackgrow run`."""

from __future__ import annotations

import contextlib
import gc
import os
import shutil
import signal
import sys
import threading
import traceback
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import crackgrow
from crackgrow.blas import warm_up
from crackgrow.cli.console import EXIT_DONE, EXIT_INTERRUPTED, EXIT_UNSOLVED, complain, load_case_file, say
from crackgrow.errors import GeometryError, SolveError, is_out_of_memory, reason_of
from crackgrow.results.atomic import OccupiedError, OutputError
from crackgrow.results.log import Progress

if TYPE_CHECKING:
    from crackgrow.case.model import Case
    from crackgrow.plan.cost import Cost
    from crackgrow.results.resume import Resumption
    from crackgrow.results.writer import RunWriter
    from crackgrow.run.result import RunEnd, StepResult


def do_run(case: Path, overrides: list[str], out: Path | None, resume: bool, quiet: bool, again: str) -> int:
    """`crackgrow run`: load, grow, write; what was solved is kept whatever ends the run, and can be gone on from."""
    from crackgrow.results.resume import find_resumption  # only now: they load numpy
    from crackgrow.results.writer import RunWriter, complete_output

    model = load_case_file(case, overrides)
    folder = out or Path("outputs") / model.name
    writer = RunWriter(model, folder)
    with writer.held(), _second_ends():
        found = find_resumption(model, folder) if resume else None
        if found is None:
            _spare_case_file(case, folder)
        if found is None or found.finished is None:
            return _run(writer, found, quiet, again)
        complete_output(model, folder)
    if not quiet:
        say(f"{found.finished}\nnothing is left to do, results in {folder}")
    return EXIT_DONE


def _run(writer: RunWriter, found: Resumption | None, quiet: bool, again: str) -> int:
    """Grow and write, from the beginning or from where an earlier run was broken off."""
    from crackgrow.compiled import before_compiling  # only now: it loads Numba

    case, folder = writer.case, writer.folder
    expected = _expected(case)
    steps = crackgrow.grow(case, None if found is None else found.checkpoint)  # starts with its first step
    for remark in (*(() if found is None else found.remarks), *filter(None, [expected and expected.warning])):
        complain(f"warning: {remark}")
    with _uninterrupted():
        writer.begin() if found is None else writer.resume(found)
    live = not quiet and sys.stdout is not None and sys.stdout.isatty()
    progress = Progress(
        case,
        (lambda text, end: None) if quiet else say,
        width=shutil.get_terminal_size().columns - 1 if live else None,
        first=0 if found is None else found.checkpoint.step,
        expected=expected.words if expected else "",
    )
    before_compiling(lambda: complain("compiling the kernels: once after installation, less than a minute"))
    gc.freeze()  # what modules hold is not looked through for garbage again and again
    try:
        end = _write_steps(steps, writer, progress)
    except OutputError as error:
        _break_off(writer, error)  # a small file may still fit
        raise OutputError(f"{error}; then go on with: {again}") from error
    except KeyboardInterrupt as error:
        _break_off(writer, error)
        complain(f"crackgrow: interrupted; go on with: {again}")
        return EXIT_INTERRUPTED
    except Exception as error:
        if is_out_of_memory(error):
            traceback.clear_frames(error.__traceback__)  # what they hold leaves no room for the last files
            reason = f"{reason_of(error)}{f' (the run takes {expected.needs})' if expected else ''}"
            _break_off(writer, error, reason)
            raise SolveError(reason) from None
        _break_off(writer, error)
        raise
    finally:
        gc.unfreeze()
        progress.close()
    if writer.error_line and not quiet:
        say(writer.error_line)
    if end.status == "failed":
        complain(f"crackgrow: {end.reason}")
        return EXIT_UNSOLVED
    if not quiet:
        say(f"{end.status}: {end.reason}\nresults in {folder}")
    return EXIT_DONE


def _spare_case_file(file: Path, folder: Path) -> None:
    """Raise OccupiedError where the run's case.yaml would replace the file that the case was read from."""
    written = folder / "case.yaml"
    if os.path.exists(written) and written.samefile(file):  # noqa: PTH110  (Path's fails on a long name)
        raise OccupiedError(
            f"{file} is the case itself, which the run would replace by its settings in SI units; choose another "
            "folder with --out, or rename the case"
        )


def _expected(case: Case) -> Cost | None:
    """What the run is about to take; None where no cover can be made, as its first step will say.

    From now on linear algebra has its work space, whatever memory is left.
    """
    from crackgrow.plan.cost import cost_of  # only now: it loads numpy

    warm_up()
    try:
        return cost_of(case)
    except Exception as error:
        if isinstance(error, GeometryError) or is_out_of_memory(error):
            return None
        raise


def _write_steps(steps: Generator[StepResult, None, RunEnd], writer: RunWriter, progress: Progress) -> RunEnd:
    """Write each step as it comes, then the end, and return it."""
    from crackgrow.run.loop import for_each  # only now: the room loads numpy

    def write(result: StepResult) -> None:
        with _uninterrupted():
            writer.add(result)
        progress.show(result)

    end = for_each(steps, write)
    progress.tell(end.events)
    with _uninterrupted(ends=True):
        writer.finish(end)
    return end


@contextlib.contextmanager
def _uninterrupted(ends: bool = False) -> Iterator[None]:
    """Ctrl-C waits until the block is done: what is written of a step is all of it.

    With `ends` the run is at its end with the block, and nothing is left to interrupt.
    """
    if not _interrupts():
        yield
        return
    pressed: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: pressed.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if pressed and not ends:
        raise KeyboardInterrupt


@contextlib.contextmanager
def _second_ends() -> Iterator[None]:
    """A second Ctrl-C in the block ends the process at once, as if it were killed; the first one says so.

    Python raises KeyboardInterrupt between two of its own lines alone, and one solve of many contact points by LAPACK
    can take minutes. A thread hears of the signal meanwhile, where the library lets other threads run (NumPy's solvers
    do): from a pipe, which the system's handler writes to. On Windows such a pipe would need Python 3.12.
    """
    if not _interrupts() or sys.platform == "win32":
        yield
        return
    heard, told = os.pipe()
    os.set_blocking(told, False)

    def listen() -> None:
        numbers = (number[0] for number in iter(lambda: os.read(heard, 1), b""))
        for pressed, _ in enumerate(number for number in numbers if number == signal.SIGINT):
            if pressed:
                os._exit(EXIT_INTERRUPTED)
            complain("crackgrow: Ctrl-C ends the run when what is being solved is done; once more ends it at once")

    listener = threading.Thread(target=listen, daemon=True)
    before = signal.set_wakeup_fd(told, warn_on_full_buffer=False)
    listener.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(told)
        listener.join()
        os.close(heard)


def _interrupts() -> bool:
    """Whether Ctrl-C raises KeyboardInterrupt here; else somebody else sees to it."""
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return ours and threading.current_thread() is threading.main_thread()


def _break_off(writer: RunWriter, error: BaseException, reason: str = "") -> None:
    """End a run and keep what was solved; what goes wrong now is told, and doesn't hide the first error."""
    with _uninterrupted(ends=True):
        second = writer.break_off(error, reason)
    if second:
        complain(f"crackgrow: {second}")
