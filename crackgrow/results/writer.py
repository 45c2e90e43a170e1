"""Everything a run leaves in its folder, written as the run goes: what was solved is on disk after every step."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from crackgrow import __version__
from crackgrow.case import dump_case
from crackgrow.case.dump import changes_of
from crackgrow.case.model import Case
from crackgrow.errors import reason_of
from crackgrow.results import tables, vtk_frames
from crackgrow.results.atomic import remove_files, write_bytes, write_text
from crackgrow.results.folder import CASE, FACES, FRAME, LOG, REPORT, SUMMARY, RunFolder, of_step, own_files
from crackgrow.results.lock import earlier_files, locked
from crackgrow.results.log import RunLog, event_line, largest_K, step_line
from crackgrow.results.resume import CheckpointWriter, Resumption
from crackgrow.results.summary import Tally, error_line, peak_memory_mb, summarize
from crackgrow.run.result import CrackPath, Event, RunEnd, StepResult

RUNNING: Final = RunEnd("running", "the run goes on, or was broken off without a word", ())
SPARE: Final = 2**23  # bytes: what the last files of a run take, and more


def complete_output(case: Case, folder: Path) -> None:
    """Delete the half-written files of a finished run, and write its report where it is missing. Raises OutputError."""
    remove_files(own.path for own in own_files(folder, case.name) if not own.whole)
    if case.output.report and not (folder / REPORT).is_file():
        from crackgrow.results.report.page import write_report  # here: a run without it needs none of it

        write_report(folder)


class RunWriter:
    """Writes one run into `folder`: `begin` or `resume`, `add` for each step, then `finish` or `break_off`.

    All of that while the folder is `held`. Every method raises OutputError where the disk refuses. A checkpoint is
    written before the other files of its step, and tells how far they went until then:

        tables     by name: number of rows
        tally     what the summary needs of the steps, and which of them have frames
        seconds, cpu, memory     wall and CPU time since the run began and most memory, MB
    """

    def __init__(self, case: Case, folder: Path) -> None:
        self.case = case
        self.folder = folder
        self.error_line = ""  # what `finish` knows of the error of the run
        self._settings = dump_case(case)
        self._remark = ""  # what the user should know of the lock
        self._log = RunLog(folder / LOG)
        self._checkpoints = CheckpointWriter(folder, case.name, self._settings)
        self._tally = Tally()
        growing = [name for name in tables.GROWING if name != "history"]  # whose columns the first step knows
        self._tables = {name: tables.Table(folder, name) for name in growing}
        self._last: StepResult | None = None
        self._K_scale = 0.0  # Pa sqrt(m), largest K so far: its unit is that of run.log
        self._memory = 0.0  # MB, of the processes before
        self._cpu_began = time.process_time()  # less what the processes before have taken
        self._spare = bytes(SPARE)  # given back when the run breaks off: memory may have run out

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """No other run writes into the folder until the end of the block; what was found there stays true.

        Raises LockedError where another one does, OccupiedError and OutputError as `begin`; nothing is changed then.
        """
        earlier_files(self.folder, self.case.name)
        with locked(self.folder, f"case {self.case.name}") as self._remark:
            yield

    def begin(self) -> None:
        """Make the folder, remove what an earlier run left of these files, write case.yaml and empty tables.

        Raises OccupiedError where there are such files but nothing shows that a run wrote them.
        """
        earlier = earlier_files(self.folder, self.case.name)
        self._write_summary(RUNNING)  # first of all: it shows that the files are a run's, whatever comes now
        remove_files(path for path in earlier if path.name != SUMMARY)
        write_text(self.folder / CASE, self._settings)
        self._log.begin(f"crackgrow {__version__}, case {self.case.name}: {self.case.title}")
        self._warn(self._remark)
        for kind in changes_of(self.case):
            for text in kind:
                self._log.tell(f"changed when it was read: {text}")
        for table in self._tables.values():
            table.write()
        self._write_paths(())

    def resume(self, found: Resumption) -> None:
        """Go on where an earlier run was broken off: what it left of the checkpoint's step and behind is removed."""
        step, results = found.checkpoint.step, found.results
        self._tally = Tally.of(results["tally"])
        self._tally.resumed.append(step)
        self._memory = results["memory"]
        self._cpu_began -= results["cpu"]
        vtk_frames.write_series(self.folder, self.case.name, self._tally.frames, self._tally.cracks)
        for own in own_files(self.folder, self.case.name):
            stale = own.step >= step if own.name in (FRAME, FACES) else own.name.startswith((REPORT, "render/"))
            if stale or not own.whole:
                remove_files([own.path])
        write_text(self.folder / CASE, self._settings)
        if "history" in results["tables"]:
            self._tables["history"] = tables.Table(self.folder, "history")
        for table in self._tables.values():
            table.drop_from(step)
        self._log.go_on(f"crackgrow {__version__}, goes on with step {step}", results["seconds"])
        self._warn(*(f"resumed with step {step}: {text}" for text in found.remarks), self._remark)
        self._write_summary(RUNNING)

    def _warn(self, *remarks: str) -> None:
        """Tell how the run goes on, and where the folder could not be locked; empty remarks are none."""
        for text in filter(None, remarks):
            self._tally.remarks.append(text)
            self._log.tell(f"warning: {text}")

    def add(self, result: StepResult) -> None:
        """Write what a solved step gives; its frames' writing time goes into seconds_output."""
        if result.checkpoint is not None:
            n_rows = {name: len(table) for name, table in self._tables.items()}
            self._checkpoints.write(result.checkpoint, {"tables": n_rows, "tally": self._tally.record(), **self._cost})
        first = not self._tally.steps
        self._last = result
        policy = self.case.output.frames
        wanted = policy == "every_step" or (policy == "first_and_last" and first)
        seconds = self._write_frames(result) if wanted else 0.0
        news = self._tally.add(result)
        self._tally.add_seconds("output", seconds)
        if result.history is not None and "history" not in self._tables:
            columns = tables.history_columns(result.history)
            self._tables["history"] = tables.Table(self.folder, "history", columns)
        for name, rows in tables.GROWING.items():
            self._extend(name, [tables.step_row(result, seconds)] if name == "steps" else rows(result))
        self._write_paths(result.cracks)
        self._log_events(result.events)
        self._K_scale = max(self._K_scale, largest_K(result))
        self._log.tell(step_line(result, self.case, self._K_scale, logged=True))
        for text in news:
            self._log.tell(f"step {result.step}, warning: {text}")
        self._write_summary(RUNNING)
        if first and self.case.output.figures:
            from crackgrow.results import figures  # here: loading matplotlib takes half a second

            figures.draw_sigma_1(self.folder / "figures" / "sigma_1_first.png", self.case, result)

    def finish(self, end: RunEnd) -> None:
        """Write the final paths, what is left of frames, the figures, the summary, and last the report."""
        try:
            self._write_paths(end.cracks)
            self._extend("events", tables.end_rows(end))
            self._log_events(end.events)
            last, output = self._last, self.case.output
            if last is not None and output.frames == "first_and_last" and len(self._tally.steps) > 1:
                # only now is it known which step was the last; its row in steps.csv is written
                self._tally.add_seconds("output", self._write_frames(last))
            if last is not None and output.figures:
                self._draw(last, end.cracks)
        finally:  # a figure that fails doesn't take the summary with it
            self._write_summary(end)
            self.error_line = error_line(self._tally, end)
            warnings = [f"warning: {text}" for text in self._tally.warnings]
            for text in (*warnings, *filter(None, [self.error_line]), f"{end.status}: {end.reason}"):
                self._log.tell(text)
        if self.case.output.report:
            from crackgrow.results.report.page import write_report  # here: a run without it needs none of it

            write_report(self.folder, self.case)  # made from the files, so it comes last

    def break_off(self, error: BaseException, reason: str = "") -> str:
        """End a run that broke off: what was solved is kept, the status is `failed`, or `interrupted` by Ctrl-C.

        reason: in place of the words of the error

        Returns what goes wrong with that, which is a note to the error, too; empty if nothing does.
        """
        interrupted = isinstance(error, KeyboardInterrupt)
        when = f"after step {self._tally.steps[-1]}" if self._tally.steps else "before the first step was solved"
        reason = reason or (f"by Ctrl-C, {when}" if interrupted else reason_of(error))
        cracks = self._last.cracks if self._last is not None else ()
        end = RunEnd("interrupted" if interrupted else "failed", reason, cracks)
        self._spare = b""
        try:
            self._write_summary(end)  # before figures and frames, which may take all that is left
            self.finish(end)
        except Exception as second:
            error.add_note(f"then the results could not be completed: {reason_of(second)}")
            return reason_of(second)
        return ""

    def _write_summary(self, end: RunEnd) -> None:
        cost = self._cost
        summary = summarize(self.case, self._tally, end, cost["seconds"], cost["memory"], cost["cpu"])
        write_text(self.folder / SUMMARY, json.dumps(summary, indent=2, ensure_ascii=False, allow_nan=False) + "\n")

    @property
    def _cost(self) -> dict[str, float]:
        """What the run has taken so far: wall and CPU time (s), memory (MB)."""
        memory = max(self._memory, peak_memory_mb())
        return {"seconds": self._log.seconds, "cpu": time.process_time() - self._cpu_began, "memory": memory}

    def _extend(self, name: str, rows: Sequence[tables.Row]) -> None:
        if rows:
            self._tables[name].extend(rows)
            self._tables[name].write()

    def _write_paths(self, cracks: Sequence[CrackPath]) -> None:
        table = tables.Table(self.folder, "paths")
        table.extend(tables.path_rows(cracks))
        table.write()

    def _log_events(self, events: Sequence[Event]) -> None:
        for event in events:
            self._log.tell(event_line(event))

    def _write_frames(self, result: StepResult) -> float:
        """Write a step's frame and crack faces and the series that list them; return the seconds it took."""
        began = time.perf_counter()
        if result.frame is not None:
            path = self.folder / of_step(FRAME, result.step)
            vtk_frames.write_frame(path, result.frame, self.case.output.fields)
            self._tally.frames.append(result.step)
        if result.faces:
            vtk_frames.write_cracks(self.folder / of_step(FACES, result.step), result.faces)
            self._tally.cracks.append(result.step)
        vtk_frames.write_series(self.folder, self.case.name, self._tally.frames, self._tally.cracks)
        return time.perf_counter() - began

    def _draw(self, last: StepResult, cracks: Sequence[CrackPath]) -> None:
        from crackgrow.results import figures  # here: loading matplotlib takes half a second

        began, folder, run = time.perf_counter(), self.folder / "figures", RunFolder(self.folder)
        run.case = self.case
        figures.draw_paths(folder / "path.png", self.case, cracks)
        first = folder / "sigma_1_first.png"
        if len(self._tally.steps) == 1 and first.is_file():
            write_bytes(folder / "sigma_1_last.png", first.read_bytes())
        else:
            figures.draw_sigma_1(folder / "sigma_1_last.png", self.case, last)
        figures.draw_contact(folder / "contact.png", self.case, last)
        figures.draw_curves(folder, run)
        self._tally.add_seconds("output", time.perf_counter() - began)
