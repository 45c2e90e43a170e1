"""A frame of a run with one of its fields, as arrays that pictures are drawn from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.results.folder import FolderError, RunFolder
from crackgrow.results.units import LENGTHS, STRESSES, Unit, unit_of
from crackgrow.run.result import Frame

if TYPE_CHECKING:
    import pyvista

VTK_TRIANGLE, VTK_QUAD = 5, 9  # kinds of cells
COMPONENTS = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")  # as they come in a frame's stress


def principal_stresses(stress: Floats) -> tuple[Floats, Floats]:
    """Major (most tensile) and minor principal stress in the plane, each (n,), of `stress` (n, 3): xx, yy, xy."""
    xx, yy, xy = stress.T
    centre = (xx + yy) / 2
    radius = np.hypot((xx - yy) / 2, xy)
    return centre + radius, centre - radius


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


def drawn_frame(run: RunFolder, step: int, field: str, mesh: pyvista.UnstructuredGrid | None = None) -> DrawnFrame:
    """The frame of a step, read unless its `mesh` is there, with a field; raises FolderError where it has none such."""
    grid = run.mesh(step) if mesh is None else mesh
    if "displacement" not in grid.point_data:
        raise FolderError(f"{run.frames[step]} has no displacement to draw: run the case with it among output.fields")
    fields = _fields(grid)
    if field not in fields:
        has = f"it has {', '.join(fields)}, by output.fields of its case"
        raise FolderError(f"{run.frames[step]} has no field {field!r}; {has}")
    by_point, values = fields[field]
    return DrawnFrame(
        step=step,
        points=np.asarray(grid.points[:, :2], dtype=float),
        triangles=_cells(grid, VTK_TRIANGLE, 3),
        quads=_cells(grid, VTK_QUAD, 4),
        displacement=np.asarray(grid.point_data["displacement"][:, :2], dtype=float),
        values=values,
        by_point=by_point,
    )


def frame_with_sigma_1(frame: Frame, step: int) -> DrawnFrame:
    """The frame of a run that goes on, with the major principal stress in the plane."""
    sigma_1, _ = principal_stresses(frame.point_stress)
    return DrawnFrame(step, frame.points, frame.triangles, frame.quads, frame.displacement, sigma_1, by_point=True)


def field_kind(field: str) -> Literal["length", "stress"] | None:
    """What a field is measured in; None for pure numbers."""
    return "length" if field == "displacement" else "stress" if field.startswith(("sigma_", "stress_")) else None


def field_unit(field: str, values: Floats) -> Unit:
    """The unit in which values of a field are read easily; without a name for pure numbers."""
    units = {"length": LENGTHS, "stress": STRESSES, None: ((1.0, ""),)}
    return unit_of(values.tolist(), units[field_kind(field)])


def _cells(grid: pyvista.UnstructuredGrid, kind: int, n_corners: int) -> Ints:
    """Corners (n, n_corners) of the cells of a kind."""
    return np.asarray(dict(grid.cells_dict).get(np.uint8(kind), []), dtype=np.int64).reshape(-1, n_corners)


def _fields(grid: pyvista.UnstructuredGrid) -> dict[str, tuple[bool, Floats]]:
    """Whether a field is one of points, and its values: the size of vectors, the components of stress one by one.

    What both points and cells have is taken from the points.
    """
    found: dict[str, tuple[bool, Floats]] = {}
    for by_point, data in ((True, grid.point_data), (False, grid.cell_data)):
        fields = {"displacement": np.linalg.norm(data["displacement"], axis=1)} if by_point else {}
        if "stress" in data:
            fields |= zip(COMPONENTS, data["stress"].T, strict=False)
        fields |= {name: data[name] for name in data if data[name].ndim == 1}
        for name, values in fields.items():
            found.setdefault(name, (by_point, np.asarray(values, dtype=float)))
    return found
