"""A case solved or run from Python: arrays, tables, and fields at points, all in SI units.

`solve` gives the first step of a case, `run_case` all of them. The examples are a session in the folder of `cases`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from crackgrow.arrays import Floats, Ints
from crackgrow.blas import single_threaded
from crackgrow.case.model import FIELDS, Case
from crackgrow.cover.elements import locate
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.results.gathered import Gathered
from crackgrow.results.log import load_words
from crackgrow.results.run import Columns, Run, Tables
from crackgrow.results.summary import Tally, peak_memory_mb, summarize
from crackgrow.results.tables import end_rows, table_of
from crackgrow.results.vtk_frames import as_pyvista
from crackgrow.results.writer import RunWriter
from crackgrow.run.evaluation import StepSolution
from crackgrow.run.loop import Steps, for_each, solved_steps
from crackgrow.run.report import estimate_maker, frame_maker
from crackgrow.run.result import Frame, RunEnd, StepResult
from crackgrow.solid import recovery

if TYPE_CHECKING:
    import pyvista


def solve(case: Case) -> Solution:
    """Solve step 0 of a case: the given cracks under their loads, as the first step of a run does.

    With growth that is the whole load history, without it the first of its load factors.

        >>> import crackgrow
        >>> case = crackgrow.load_case("cases/compression30.yaml", ["numerics.spacing=3"])
        >>> solution = crackgrow.solve(case)
        >>> solution.tips[["crack", "tip", "K_II"]].round(-4)
          crack    tip       K_II
        0  flaw  start -5750000.0
        1  flaw    end -5750000.0
        >>> solution.displacement_at([0.0, 0.02]).round(6)   # m, at x = 0, y = 20 mm
        array([-1.60e-05, -4.55e-04])
        >>> solution.stress_at([[0.0, 0.02], [0.1, 0.0]]).round(-5)   # Pa: xx, yy, xy; nan outside of the rock
        array([[ -1100000., -98800000.,   -500000.],
               [       nan,        nan,        nan]])

    Raises GeometryError or SolveError where the step can't be solved.
    """
    return _solution(case, solved_steps(_checked(case)))


def run_case(case: Case, out: str | Path | None = None) -> SolvedRun:
    """Run a case to its end, as `crackgrow run` does; with a folder `out` it leaves there what that leaves.

        >>> import crackgrow
        >>> case = crackgrow.load_case("cases/compression30.yaml", ["numerics.spacing=3", "growth.steps=2"])
        >>> run = crackgrow.run_case(case)
        >>> run.status, run.reason
        ('completed', 'all 2 growth steps are done')
        >>> run.steps[["step", "n_dofs", "crack_length"]]
           step  n_dofs  crack_length
        0     0     880         0.010
        1     1     880         0.012
        2     2     880         0.014
        >>> run.path("flaw").round(4)   # m
        array([[-0.0039, -0.0045],
               [-0.0043, -0.0025],
               [ 0.0043,  0.0025],
               [ 0.0039,  0.0045]])

    What was solved before an error or an interrupt is kept in the folder. Raises GeometryError or SolveError where
    step 0 (without growth: any) can't be solved, OutputError where the folder can't be written, OccupiedError where it
    has files of the same names that no run has written. A later step that fails ends the run, and `status` and
    `reason` tell.
    """
    steps = solved_steps(_checked(case))
    if out is None:
        return _collected(case, steps, lambda result: None)
    writer = RunWriter(case, Path(out))
    with writer.held():
        writer.begin()
        try:
            run = _collected(case, steps, writer.add)
            writer.finish(run.end)
        except BaseException as error:
            writer.break_off(error)
            raise
    return run


class Solution(Tables):
    """A solved step."""

    def __init__(self, case: Case, result: StepResult, solved: StepSolution) -> None:
        """`result` is the step as frozen NumPy arrays: contact points, crack faces, tips, reactions, energies."""
        self.case, self.result, self._solved = case, result, solved

    def read(self, name: str) -> Columns:
        return table_of(name, [self.result], self.result.cracks, ())

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is unsure in the step, and why, one sentence a cause; empty if nothing is."""
        gathered = Gathered()
        gathered.add(self.result.step, self.result.step_warnings)
        return tuple(gathered.sentences())

    @property
    def frame(self) -> Frame:
        """The specimen as a mesh, double along cracks: displacement (m) and stress (Pa) of nodes, stress of cells."""
        with single_threaded():
            return frame_maker(self._solved, estimate_maker(self._solved))()

    @property
    def mesh(self) -> pyvista.UnstructuredGrid:
        """The same for pyvista, as `open_run(...).mesh(step)` reads it from a frame, with `energy_error`; m, Pa.

        >>> import crackgrow
        >>> case = crackgrow.load_case("cases/compression30.yaml", ["numerics.spacing=3"])
        >>> mesh = crackgrow.solve(case).mesh
        >>> round(mesh.area * 1e6), float(round(mesh["displacement"][:, 1].min() * 1e3, 2))   # mm^2, mm
        (1705, -0.52)
        """
        return as_pyvista(self.frame, FIELDS)

    def displacement_at(self, points: ArrayLike) -> Floats:
        """Displacement (..., 2) m at points (..., 2) in m; nan outside of the rock.

        A point on a crack or between two bodies has the displacement of one of the sides.
        """
        cover, u = self._solved.cover, self._solved.outcome.u
        return self._read(points, 2, lambda *places: recovery.displacement_at(cover, u, *places))

    def stress_at(self, points: ArrayLike) -> Floats:
        """Stress (..., 3) Pa: xx, yy, xy, tension positive, at points (..., 2) in m; nan outside and at tips.

        In-situ stress is included. A point on a crack or between two bodies has the stress of one of the sides.
        """
        cover, u, materials = self._solved.cover, self._solved.outcome.u, self._solved.materials

        def stress(local: Floats, elements: Ints) -> Floats:
            found = recovery.stress_at(cover, materials, u, local, elements)
            for tip in cover.tips:
                found[np.hypot(*(local - tip.point).T) < ON_LINE] = np.nan
            return found

        return self._read(points, 3, stress)

    def _read(self, points: ArrayLike, n: int, values: Callable[[Floats, Ints], Floats]) -> Floats:
        """The n components of a field (..., n) at points (..., 2) m, from lattice coordinates and elements of these."""
        at = np.asarray(points, dtype=np.float64)
        if at.ndim == 0 or at.shape[-1] != 2:
            raise ValueError(f"points have the shape {at.shape}: wanted are x and y in m, (..., 2)")
        lattice = self._solved.cover.lattice
        places = at.reshape(-1, 2) - lattice.map_origin
        low, high = lattice.to_metres(np.array([[0, 0], lattice.shape]))
        near = np.flatnonzero(np.all((places >= low) & (places <= high), axis=1))
        local = lattice.to_lattice(places[near])
        elements = locate(lattice, self._solved.cover.elements, local)
        inside = elements >= 0
        found = np.full((len(places), n), np.nan)
        found[near[inside]] = values(local[inside], elements[inside])
        return found.reshape(*at.shape[:-1], n)

    def __repr__(self) -> str:
        return f"<Solution of {self.case.name}: {self._words()}>"

    def _repr_html_(self) -> str:
        return self._html(self._words(), self.warnings, self.result.step)

    def _words(self) -> str:
        result = self.result
        words = [f"step {result.step}", load_words(self.case, result.load_factor), f"{result.n_dofs} unknowns"]
        if np.isfinite(result.norm_error):
            words.append(f"estimated error {result.norm_error:.2g} % of the energy norm")
        return ", ".join(words)


class SolvedRun(Run):
    """A run in memory."""

    def __init__(self, case: Case, results: tuple[StepResult, ...], end: RunEnd, last: Solution) -> None:
        """`results` are those of the steps, frozen NumPy arrays; `last` is the last one of them."""
        self.case, self.results, self.end, self.last = case, results, end, last

    def read(self, name: str) -> Columns:
        return table_of(name, self.results, self.end.cracks, end_rows(self.end))

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What summary.json says: the factor of safety, error estimates, events, warnings; times are without files."""
        tally = Tally()
        for result in self.results:
            tally.add(result)
        return summarize(self.case, tally, self.end, sum(tally.seconds.values()), peak_memory_mb())

    def solution(self, step: int) -> Solution:
        """A step with its fields, for stress and displacement at points; raises IndexError if there is no such step.

        All but the last are solved again from their checkpoint, to the same bits: a run keeps no fields but its last.

            >>> import crackgrow
            >>> case = crackgrow.load_case("cases/compression30.yaml", ["numerics.spacing=3", "growth.steps=2"])
            >>> crackgrow.run_case(case).solution(1).stress_at([0.0, 0.02]).round(-5)   # Pa: xx, yy, xy
            array([ -1500000., -98300000.,   -500000.])
        """
        if step not in self.solved:
            raise IndexError(f"step {step}: the run has steps {self.solved[0]} to {self.solved[-1]}")
        if step == self.last.result.step:
            return self.last
        return _solution(self.case, solved_steps(self.case, self.results[self.solved.index(step)].checkpoint))

    def mesh(self, step: int) -> pyvista.UnstructuredGrid:
        """The specimen in a step for pyvista, as `Solution.mesh`; solved again but for the last one, as `solution`."""
        return self.solution(step).mesh

    def __repr__(self) -> str:
        return f"<Run of {self.case.name}: {self.status}: {self.reason}>"


def _checked(case: Case) -> Case:
    """The case itself; raises TypeError where it is something else, such as the path of one."""
    if not isinstance(case, Case):
        raise TypeError(f"a Case is wanted, as crackgrow.load_case(path) gives, not {case!r}")
    return case


def _solution(case: Case, steps: Steps) -> Solution:
    """The first of some steps."""
    result, solved = next(steps)
    return Solution(case, result, solved)


def _collected(case: Case, steps: Steps, add: Callable[[StepResult], None]) -> SolvedRun:
    """The run with all its steps, each handed to `add` as it comes."""
    results: list[StepResult] = []
    last: Solution | None = None

    def collect(step: tuple[StepResult, StepSolution]) -> None:
        nonlocal last
        result, solved = step
        add(result)
        results.append(replace(result, mesh=None))  # the mesh would keep the fields of every step
        last = Solution(case, result, solved)

    end = for_each(steps, collect)
    assert last is not None  # step 0 can be solved, or raises
    return SolvedRun(case, tuple(results), end, last)
