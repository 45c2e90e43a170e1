"""A fit: up to three keys of a case, by least squares of its runs against a measured curve or path.

Keys are searched for by Gauss-Newton steps in a trust region within their ranges (Branch, Coleman, Li 1999: scipy's
least_squares), with derivatives by differences of runs. Where residuals are independent and normal with one variance
s^2, the covariance of the keys is s^2 (J' J)^-1, and the region that holds them all with 95 % is

    (k - k_fit)' C^-1 (k - k_fit) <= p F(p, n - p; 95 %)    of p keys and n measured points (Seber, Wild 1989).
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.errors import CaseError, Fault, SolveError
from crackgrow.results.atomic import write_text
from crackgrow.results.declarations import FILES
from crackgrow.results.folder import RunFolder
from crackgrow.results.lock import locked
from crackgrow.results.units import counted
from crackgrow.run.loop import for_each
from crackgrow.study.path_files import read_paths, read_points
from crackgrow.study.plan import Run, Study, folder_names
from crackgrow.study.runs import Row, Values, run_study
from crackgrow.study.sweep import short_names
from crackgrow.study.sweep_file import FitFile, Measured, placed, read_fit_file
from crackgrow.study.workers import Workers

STEP: Final = 0.02  # of the range of a key: over less than that what cells and events leave of runs counts
NEAR: Final = 1e-3  # of its range: a key that is found to this is found, and one so near to an end of it is at the end
MOST_ROUNDS: Final = 20
CONFIDENCE: Final = 0.95
TABLES: Final = ("steps.csv", "history.csv")  # that a curve may be measured in
ALIKE: Final = 1e-6  # singular values of the Jacobian in this ratio: it does not tell keys apart


@dataclass(frozen=True, slots=True, eq=False)
class FitPlan:
    """What is fitted to what, checked before anything runs."""

    file: FitFile
    title: str
    folder: Path
    names: tuple[str, ...]  # short ones of the keys
    points: Floats  # (n, 2) measured x and y


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """What was found; lists in the order of the keys, values in the units of the file."""

    keys: tuple[str, ...]
    units: tuple[str, ...]
    values: list[float]
    standard_errors: list[float]
    half_widths: list[float]  # of the interval of each key by itself, with 95 %
    covariance: list[list[float]]
    region: float  # (k - values)' covariance^-1 (k - values) is at most that with 95 %
    rms: float  # of the residuals
    n_points: int
    n_runs: int
    at_end: tuple[str, ...]  # keys that were found at an end of their range
    converged: bool

    def __str__(self) -> str:
        lines = [
            f"{key} = {value:.5g} +- {half:.2g}{f' {unit}' if unit else ''} (95 %)"
            for key, value, half, unit in zip(self.keys, self.values, self.half_widths, self.units, strict=True)
        ]
        errors = np.array(self.standard_errors)
        pairs = zip(*np.triu_indices(len(self.keys), 1), strict=True)
        for i, j in pairs if errors.all() else ():  # errors are 0 where nothing is missed
            correlation = self.covariance[i][j] / (errors[i] * errors[j])
            lines.append(f"correlation of {self.keys[i]} and {self.keys[j]}: {correlation:.2f}")
        lines += [f"{key} is at an end of its range: give it a wider one" for key in self.at_end]
        if not self.converged:
            lines.append(f"not converged in {counted(MOST_ROUNDS, 'round')}: narrow the ranges, or fit fewer keys")
        return "\n".join([*lines, f"residuals of {self.rms:.3g}, {counted(self.n_runs, 'run')}"])


def plan_fit(path: str | Path, folder: str | Path | None = None) -> FitPlan:
    """Read a fit file, its case in the middle of the ranges, and what was measured; raises CaseError.

    folder: of the results; default outputs/<name of the file>
    """
    path = Path(path)
    file = read_fit_file(path)
    case = _case_in_middle(file)
    _check_measured(file, case)
    measured = path.parent / file.measured.file
    points = _measured(measured, file.measured)
    n_keys = len(file.parameters)
    if len(points) <= n_keys:
        has, wanted = counted(len(points), "measured point"), f"{n_keys + 1} or more, of {counted(n_keys, 'key')}"
        raise CaseError.at(measured, f"has {has}; wanted: {wanted}")
    folder = Path("outputs") / path.stem if folder is None else Path(folder)
    return FitPlan(file, case.title, folder, short_names(tuple(file.parameters)), points)


def _case_in_middle(file: FitFile) -> Case:
    """The case in the middle of all ranges, if it is one at their ends too; else raises CaseError."""
    case, wrong = file.case_file(_texts(file, np.full(len(file.parameters), 0.5))).tried()
    faults: dict[str, Fault] = {}  # the first one of each range
    for index, key in enumerate(file.parameters):
        for part in (0.0, 1.0, 0.5):
            texts = _texts(file, np.where(np.arange(len(file.parameters)) == index, part, 0.5))
            for fault in file.case_file(texts).tried()[1]:
                own = fault.of_override == key
                if own or not wrong:
                    message = f"at {texts[index]}: {fault.message if own else fault}"
                    faults.setdefault(key, Fault(str(file.path), None, f"parameters.{key}", message))
    if faults or case is None:
        others = (fault for fault in wrong if fault.of_override not in file.parameters)
        raise CaseError([*faults.values(), *placed(file, others)])
    return case


def _check_measured(file: FitFile, case: Case) -> None:
    """Refuse a crack that the case lacks and columns that none of its tables has together; raises CaseError."""
    measured, parted = file.measured, ("/".join(one.bodies) for one in case.interfaces if one.toughness is not None)
    cracks = [*(crack.name for crack in case.cracks), *parted]
    if measured.crack is not None:
        starts = case.growth is not None and case.growth.initiation.at != "tips"
        if measured.crack not in cracks and not starts:  # a run gives those that start their names
            what = f"the case has no crack {quoted(measured.crack)}{did_you_mean(measured.crack, cracks)}"
            raise CaseError.at(file.path, f"{what}; it has {', '.join(cracks) or 'none'}", "measured.crack")
        return
    asked = {re.sub("^.*[.]", "*.", name) for name in (measured.x, measured.y) if name is not None}
    tables = TABLES if case.output.points else TABLES[:1]
    columns = {
        name: [re.sub("^[A-Z]+[.]", "*.", column.name) for column in FILES[name].columns if column.kind is not str]
        for name in tables
    }
    if not any(asked <= set(names) for names in columns.values()):
        there = "; ".join(f"{name} has {', '.join(names)}" for name, names in columns.items())
        raise CaseError.at(file.path, f"no table has numbers of {measured.x} and {measured.y}; {there}", "measured")


def fit(
    plan: FitPlan,
    show: Callable[[Row], object] = lambda row: None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    memory: str | None = None,
    timeout: float | None = None,
    resume: bool = False,
) -> Fit:
    """Find the keys, handing each run to `show` as it ends, and write fit.csv, fit.json, fit.png.

    The rest is as for `sweep`. Raises what `sweep` raises, and SolveError where a run has not come to its end or not as
    far as what was measured, or where that does not tell the keys apart.
    """
    runs = _Runs(plan, Workers(workers, scheduler, memory, timeout), resume, show)
    with locked(plan.folder, runs.study(()).words):
        place, residual, jacobian, converged = least_squares_of(runs.residuals, len(plan.names), _scale(plan))
        found = _fit_of(plan, place, residual, jacobian, len(runs.runs), converged)
        write_text(plan.folder / "fit.json", json.dumps(asdict(found), indent=2) + "\n")
        from crackgrow.study.pictures import draw_fit  # here: it loads matplotlib

        best = next(run for run in runs.runs if run.values == _texts(plan.file, place))
        lines = {f"the run with {run.name}": run_line(run.folder, plan.file.measured) for run in (runs.runs[0], best)}
        draw_fit(plan.folder / "fit.png", plan.points, lines, plan.file.measured)
    return found


def least_squares_of(
    residuals: Callable[[Floats], list[Floats]], n: int, scale: float
) -> tuple[Floats, Floats, Floats, bool]:
    """The place (n,) in the unit cube of the least squares, residuals (m,), derivatives (m, n), and if it converged.

    `residuals` are those of several places (k, n) at once; scale: of what was measured, in their unit.
    """
    from scipy.optimize import least_squares  # here: other studies need none of it

    def jacobian(place: Floats) -> Floats:
        steps = np.diag(np.where(place + STEP > 1.0, -STEP, STEP))
        here, *there = residuals(np.vstack([place, place + steps]))
        return np.stack([(other - here) / step for other, step in zip(there, np.diag(steps), strict=True)], axis=1)

    found = least_squares(
        lambda place: residuals(place[None])[0] / scale, np.full(n, 0.5), lambda place: jacobian(place) / scale,
        bounds=(0.0, 1.0), xtol=NEAR, ftol=NEAR**2, gtol=NEAR**4, max_nfev=MOST_ROUNDS,
    )  # fmt: skip
    return found.x, found.fun * scale, found.jac * scale, found.status > 0


def _scale(plan: FitPlan) -> float:
    """The range of the measured y, or its size where that is constant; the size of a measured path."""
    points = plan.points[:, int(plan.file.measured.crack is None) :]
    return float(np.ptp(points, axis=0).max() or np.abs(points).max() or 1.0)


def _fit_of(plan: FitPlan, place: Floats, residual: Floats, jacobian: Floats, n_runs: int, converged: bool) -> Fit:
    """What least squares tell of the keys; raises SolveError where they do not tell them apart."""
    from scipy.special import fdtri, stdtrit

    singular = np.linalg.svd(jacobian, compute_uv=False)
    if singular[-1] <= ALIKE * singular[0]:
        what = "does not depend on the key" if len(place) == 1 else "does not tell the keys apart"
        raise SolveError(f"what was measured {what} {', '.join(plan.file.parameters)}; fit fewer, or others")
    n, p, ranges = len(plan.points), len(place), tuple(plan.file.parameters.values())
    numbers = np.array([values.numbers(part) for values, part in zip(ranges, place, strict=True)])
    slopes = [values.high - values.low if not values.log else at * np.log(values.high / values.low)
              for values, at in zip(ranges, numbers, strict=True)]  # fmt: skip
    own = jacobian / np.array(slopes)
    covariance = float(residual @ residual) / (n - p) * np.linalg.inv(own.T @ own)
    errors = np.sqrt(np.diag(covariance))
    ends = np.minimum(place, 1.0 - place) < NEAR
    return Fit(
        keys=tuple(plan.file.parameters),
        units=tuple(values.unit for values in ranges),
        values=numbers.tolist(),
        standard_errors=errors.tolist(),
        half_widths=(float(stdtrit(n - p, 0.5 + 0.5 * CONFIDENCE)) * errors).tolist(),
        covariance=covariance.tolist(),
        region=p * float(fdtri(p, n - p, CONFIDENCE)),
        rms=float(np.sqrt(residual @ residual / n)),
        n_points=n,
        n_runs=n_runs,
        at_end=tuple(key for key, is_at in zip(plan.file.parameters, ends.tolist(), strict=True) if is_at),
        converged=converged,
    )


@dataclass(slots=True, eq=False)
class _Runs:
    """The runs of a fit, made as they are asked for, and what they miss."""

    plan: FitPlan
    workers: Workers
    resume: bool
    show: Callable[[Row], object]
    runs: list[Run] = field(default_factory=list)
    found: dict[int, Values] = field(default_factory=dict)
    known: dict[tuple[str, ...], Floats] = field(default_factory=dict)  # residuals by the values of the keys

    def study(self, runs: Sequence[Run]) -> Study:
        """The study of some runs."""
        plan = self.plan
        return Study("fit", plan.file.path.stem, plan.title, plan.folder, plan.names, tuple(runs))

    def residuals(self, places: Floats) -> list[Floats]:
        """What the runs at places (k, keys) in the unit cube miss; those that are not known go on at a time."""
        asked = [_texts(self.plan.file, place) for place in places]
        new = [values for values in dict.fromkeys(asked) if values not in self.known]
        if new:
            first = len(self.runs)
            for values in new:
                self.runs.append(self._run(values))
            table = for_each(run_study(self.study(self.runs), self.workers, self.resume, self.found), self.show)
            self.found = table.found
            for run in self.runs[first:]:
                if not table.done(run):
                    row = table.row(run)
                    raise SolveError(f"the run '{run.name}' is {row['status']}: {row['reason']}; narrow the ranges")
                self.known[run.values] = missed(run.folder, self.plan.points, self.plan.file.measured)
        return [self.known[values] for values in asked]

    def _run(self, values: tuple[str, ...]) -> Run:
        """The next run."""
        name = " ".join(f"{name}={value}" for name, value in zip(self.plan.names, values, strict=True))
        file, folder = self.plan.file.case_file(values), self.plan.folder / folder_names([name])[0]
        return Run(len(self.runs), name, folder, values, file, *file.tried())


def run_line(folder: Path, measured: Measured) -> Floats:
    """What a run has in place of the measured points: its curve or its path (n, 2); raises SolveError where x falls."""
    if measured.crack is not None:
        cracks = read_paths(folder).cracks
        if measured.crack not in cracks:
            raise SolveError(f"the run in {folder} has no crack {measured.crack}; it has {', '.join(cracks)}")
        return cracks[measured.crack].points
    assert measured.x is not None  # the file was checked
    assert measured.y is not None
    run = RunFolder(folder)
    in_steps = {measured.x, measured.y} <= set(run.table("steps"))
    table = run.table("steps" if in_steps or not run.has("history.csv") else "history")
    for name in sorted({measured.x, measured.y} - set(table)):
        raise SolveError(f"the run in {folder} has no column {name}; {table.path.name} has {', '.join(table)}")
    line = np.stack([table[name] for name in (measured.x, measured.y)], axis=1)
    if not (np.diff(line[:, 0]) >= 0.0).all():
        raise SolveError(f"{measured.x} of the run in {folder} does not rise; measure over what does")
    return line


def missed(folder: Path, points: Floats, measured: Measured) -> Floats:
    """What a run misses of measured points (n, 2): the difference of y at x, or both components to the nearest point.

    Raises SolveError where the run does not go as far as these.
    """
    line = run_line(folder, measured)
    if measured.crack is not None:
        import shapely  # here: curves need none of it

        path, places = shapely.LineString(line), shapely.points(points)
        nearest = shapely.line_interpolate_point(path, shapely.line_locate_point(path, places))
        return np.asarray((shapely.get_coordinates(nearest) - points).ravel())
    (least, most), (first, last) = ((x.min(), x.max()) for x in (points[:, 0], line[:, 0]))
    if least < first - NEAR * (most - least) or most > last + NEAR * (most - least):
        what = f"{measured.x} of the run in {folder} goes from {first:g} to {last:g}"
        raise SolveError(f"{what}, and was measured from {least:g} to {most:g}; let the run go as far")
    there = np.interp(points[:, 0], *line.T)
    for x in points[~np.isfinite(there), 0]:
        raise SolveError(
            f"{measured.y} of the run in {folder} is nan at {measured.x} = {x:g}; measure what has numbers"
        )
    return np.asarray(there - points[:, 1])


def _measured(path: Path, measured: Measured) -> Floats:
    """The measured points (n, 2); raises CaseError."""
    if measured.crack is None:
        assert measured.x is not None
        assert measured.y is not None
        return read_points(path, measured.columns or (measured.x, measured.y))
    cracks = read_paths(path, measured.columns).cracks
    line = cracks.get(measured.crack, cracks.get("") if len(cracks) == 1 else None)
    if line is None:
        names = ", ".join(map(quoted, cracks))
        raise CaseError.at(
            path, f"has no crack {quoted(measured.crack)}{did_you_mean(measured.crack, cracks)}; it has {names}"
        )
    return line.points


def _texts(file: FitFile, place: Floats) -> tuple[str, ...]:
    """The values of the keys at a place in the unit cube, as an override takes them."""
    return tuple(values.at(part)[0] for values, part in zip(file.parameters.values(), place[:, None], strict=True))
