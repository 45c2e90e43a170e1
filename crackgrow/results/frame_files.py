"""Frames read back from a run's folder, for pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyvista
from numpy.typing import NDArray

from crackgrow.results.folder import FolderError
from crackgrow.results.leftovers import SERIES
from crackgrow.results.units import LENGTHS, STRESSES, Unit, unit_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

COMPONENTS = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")  # as they come in a frame's stress


@dataclass(frozen=True, slots=True, eq=False)
class DrawnFrame:
    """The specimen's mesh with one field on it. Cells: triangles first, then quads."""

    step: int
    points: Floats  # (n, 2) m
    triangles: Ints  # (t, 3)
    quads: Ints  # (q, 4)
    displacement: Floats  # (n, 2) m
    values: Floats  # (t + q,) by cell, or (n,) by point; SI units

    @property
    def by_point(self) -> bool:
        """Whether the values are those of points."""
        return len(self.values) == len(self.points) != len(self.triangles) + len(self.quads)


def frame_files(folder: Path) -> dict[int, Path]:
    """Frames of a run by step; raises FolderError where there are none."""
    matches = [(SERIES["frames"].fullmatch(path.name), path) for path in sorted((folder / "frames").glob("step_*.vtu"))]
    found = {int(match[1]): path for match, path in matches if match and ".tmp" not in path.name}
    if not found:
        raise FolderError(f"{folder} has no frames to draw: run the case with output.frames=every_step")
    return found


def chosen_files(folder: Path, steps: Sequence[int] | None) -> dict[int, Path]:
    """The frames of these steps, of all where none are named; raises FolderError for a step without one."""
    found = frame_files(folder)
    missing = sorted(set(steps or ()) - set(found))
    if missing:
        raise FolderError(
            f"{folder} has no frame of step {', '.join(map(str, missing))}; it has those of {_spans(sorted(found))}"
        )
    return found if steps is None else {step: found[step] for step in sorted(set(steps))}


def read_frame(step: int, path: Path, field: str) -> DrawnFrame:
    """Read a frame with one of its fields; raises FolderError where it has no such field."""
    grid = pyvista.read(path)
    if not isinstance(grid, pyvista.UnstructuredGrid) or "displacement" not in grid.point_data:
        raise FolderError(f"{path} has no displacement to draw: run the case with it among output.fields")
    return DrawnFrame(
        step=step,
        points=np.asarray(grid.points[:, :2], dtype=float),
        triangles=_cells(grid, pyvista.CellType.TRIANGLE, 3),
        quads=_cells(grid, pyvista.CellType.QUAD, 4),
        displacement=np.asarray(grid.point_data["displacement"][:, :2], dtype=float),
        values=_values(grid, field, path),
    )


def field_unit(field: str, values: Floats) -> Unit:
    """The unit in which values of a field are read easily; without a name for pure numbers."""
    if field == "displacement":
        return unit_of(values.tolist(), LENGTHS)
    return unit_of(values.tolist(), STRESSES) if field.startswith(("sigma_", "stress_")) else (1.0, "")


def _cells(grid: pyvista.UnstructuredGrid, kind: pyvista.CellType, n_corners: int) -> Ints:
    """Corners (n, n_corners) of the cells of a kind."""
    return np.asarray(dict(grid.cells_dict).get(np.uint8(kind), []), dtype=np.int64).reshape(-1, n_corners)


def _values(grid: pyvista.UnstructuredGrid, field: str, path: Path) -> Floats:
    """Values of a field: the size of vectors, the components of stress one by one."""
    if field == "displacement":
        return np.asarray(np.linalg.norm(grid.point_data["displacement"], axis=1), dtype=float)
    if field in COMPONENTS and "stress" in grid.cell_data:
        return np.asarray(grid.cell_data["stress"][:, ("xx", "yy", "zz", "xy").index(field[-2:])], dtype=float)
    if field in grid.cell_data and grid.cell_data[field].ndim == 1:
        return np.asarray(grid.cell_data[field], dtype=float)
    known = ["displacement", *(COMPONENTS if "stress" in grid.cell_data else ())]
    known += [name for name in grid.cell_data if grid.cell_data[name].ndim == 1]
    raise FolderError(f"{path} has no field {field!r}; it has {', '.join(known)}")


def _spans(steps: Sequence[int]) -> str:
    """Steps in words: 0 to 5, 7."""
    parts: list[list[int]] = []
    for step in steps:
        if parts and step == parts[-1][-1] + 1:
            parts[-1][1:] = [step]
        else:
            parts.append([step])
    return ", ".join(" to ".join(map(str, part)) for part in parts)
