"""Frames read back from a run's folder, for pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyvista

from crackgrow.arrays import Floats, Ints
from crackgrow.results.folder import FolderError
from crackgrow.results.leftovers import SERIES
from crackgrow.results.units import LENGTHS, STRESSES, Unit, unit_of

COMPONENTS = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")  # as they come in a frame's stress


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFrame:
    """The specimen's mesh with one field on it. Cells: triangles first, then quads."""

    step: int
    points: Floats  # (n, 2) m
    triangles: Ints  # (t, 3)
    quads: Ints  # (q, 4)
    displacement: Floats  # (n, 2) m
    values: Floats  # (n,) by point, or (t + q,) by cell; SI units
    by_point: bool


def frame_files(folder: Path) -> dict[int, Path]:
    """Frames of a run by step, in order; raises FolderError where there are none."""
    matches = [(SERIES["frames"].fullmatch(path.name), path) for path in sorted((folder / "frames").glob("step_*.vtu"))]
    found = {int(match[1]): path for match, path in matches if match and ".tmp" not in path.name}
    if not found:
        raise FolderError(f"{folder} has no frames to draw: run the case with output.frames=every_step")
    return dict(sorted(found.items()))  # by number: step_10000 comes before step_9999 by name


def chosen_files(folder: Path, steps: Sequence[int | range] | None) -> dict[int, Path]:
    """The frames of these steps, or ranges of them, of all where none are named.

    Raises FolderError for a step without one.
    """
    found = frame_files(folder)
    if steps is None:
        return found
    spans = [step if isinstance(step, range) else range(step, step + 1) for step in steps]
    missing = [gap for span in spans for gap in _gaps(span, found)]
    if missing:
        there = _words(range(step, step + 1) for step in found)
        raise FolderError(f"{folder} has no frame of step {_words(missing)}; it has those of {there}")
    return {step: path for step, path in found.items() if any(step in span for span in spans)}


def _gaps(span: range, found: Iterable[int]) -> list[range]:
    """What of a range of steps is not among those found, which are in order."""
    edges = [span.start - 1, *(step for step in found if step in span), span.stop]
    return [range(before + 1, after) for before, after in pairwise(edges) if before + 1 < after]


def read_frame(step: int, path: Path, field: str) -> DrawnFrame:
    """Read a frame with one of its fields; raises FolderError where it has no such field."""
    grid = pyvista.read(path)
    if not isinstance(grid, pyvista.UnstructuredGrid) or "displacement" not in grid.point_data:
        raise FolderError(f"{path} has no displacement to draw: run the case with it among output.fields")
    by_point, values = _values(grid, field, path)
    return DrawnFrame(
        step=step,
        points=np.asarray(grid.points[:, :2], dtype=float),
        triangles=_cells(grid, pyvista.CellType.TRIANGLE, 3),
        quads=_cells(grid, pyvista.CellType.QUAD, 4),
        displacement=np.asarray(grid.point_data["displacement"][:, :2], dtype=float),
        values=values,
        by_point=by_point,
    )


def field_unit(field: str, values: Floats) -> Unit:
    """The unit in which values of a field are read easily; without a name for pure numbers."""
    if field == "displacement":
        return unit_of(values.tolist(), LENGTHS)
    return unit_of(values.tolist(), STRESSES) if field.startswith(("sigma_", "stress_")) else (1.0, "")


def _cells(grid: pyvista.UnstructuredGrid, kind: pyvista.CellType, n_corners: int) -> Ints:
    """Corners (n, n_corners) of the cells of a kind."""
    return np.asarray(dict(grid.cells_dict).get(np.uint8(kind), []), dtype=np.int64).reshape(-1, n_corners)


def _values(grid: pyvista.UnstructuredGrid, field: str, path: Path) -> tuple[bool, Floats]:
    """Whether a field is one of points, and its values: the size of vectors, the components of stress one by one.

    What both points and cells have is taken from the points; earlier versions wrote stress for cells alone.
    """
    known = []
    for by_point, data in ((True, grid.point_data), (False, grid.cell_data)):
        fields = {"displacement": np.linalg.norm(data["displacement"], axis=1)} if by_point else {}
        if "stress" in data:
            fields |= zip(COMPONENTS, data["stress"].T, strict=False)
        fields |= {name: data[name] for name in data if data[name].ndim == 1}
        if field in fields:
            return by_point, np.asarray(fields[field], dtype=float)
        known += [name for name in fields if name not in known]
    raise FolderError(f"{path} has no field {field!r}; it has {', '.join(known)}")


def _merged(spans: Iterable[range]) -> list[range]:
    """Ranges in order, as one where they touch or overlap."""
    merged: list[range] = []
    for span in sorted(spans, key=lambda span: span.start):
        if merged and span.start <= merged[-1].stop:
            merged[-1] = range(merged[-1].start, max(merged[-1].stop, span.stop))
        else:
            merged.append(span)
    return merged


def _words(spans: Iterable[range]) -> str:
    """Ranges in words: 0 to 5, 7."""
    return ", ".join(f"{span[0]} to {span[-1]}" if len(span) > 1 else str(span[0]) for span in _merged(spans))
