"""A frame as a mesh file of other programs, written by meshio; crack paths as lines of maps and drawings."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import meshio
import numpy as np
import pyvista

from crackgrow.arrays import Floats
from crackgrow.results.atomic import OutputError, write_atomically
from crackgrow.results.drawn_frame import COMPONENTS, cells_of
from crackgrow.results.export_paths import FORMATS as PATHS
from crackgrow.results.export_paths import export_paths
from crackgrow.results.folder import FolderError, open_run
from crackgrow.results.units import spans_text

FORMATS: Final = ("msh", "inp", "vtk", "xdmf", *PATHS)
CORNERS: Final = {"triangle": 3, "quad": 4}
ABAQUS: Final = {"triangle": "CPS3", "quad": "CPS4"}
"""Elements of the plane that meshio reads; what it would write by itself are rigid and axisymmetric ones."""


def export(folder: Path, to: str, step: int | None = None, out: Path | None = None) -> Path:
    """Write a step, the last one where none is named, in one of FORMATS: its frame or its crack paths; return the path.

    Without `out` it is export/step_NNNN.FORMAT in the run's folder.
    Raises FolderError where there is no such frame or step, CaseError where case.yaml is not of this version,
    OutputError, also where `out` ends as another of the formats does: programs go by that.
    """
    ending = "" if out is None else out.suffix.lower().removeprefix(".")
    if ending != to and ending in FORMATS:
        raise OutputError(f"{out}: the name ends in .{ending}, and the format that is asked for is {to}")
    run = open_run(folder)
    if to not in PATHS:
        number = run.frames_of(None if step is None else [step])[-1]
    elif run.solved and (step is None or step in run.solved):
        number = run.solved[-1] if step is None else step
    else:
        there = spans_text(range(solved, solved + 1) for solved in run.solved) or "none"
        raise FolderError(f"{folder} has no solved step{'' if step is None else f' {step}'}; it has {there}")
    path = folder / "export" / f"step_{number:04d}.{to}" if out is None else out
    if to in PATHS:
        export_paths(run, to, step, path)
    else:
        mesh = frame_mesh(run.mesh(number), [body.name for body in run.case.bodies])
        write_atomically(path, lambda temporary: _write(temporary, mesh, to))
    return path


def frame_mesh(grid: pyvista.UnstructuredGrid, bodies: list[str]) -> meshio.Mesh:
    """A frame with a block and a set of cells for each body and kind of cell, and bodies as groups of Gmsh; m, Pa.

    Point and cell data are those of the frame, but for stress: each component is a field of its own, since formats
    order those of tensors in different ways. Groups are numbered from 1 in the order of the bodies.
    """
    body, cells = np.asarray(grid.cell_data["body"]), cells_of(grid)
    n_corners = np.where(cells[:, 2] == cells[:, 3], 3, 4)
    blocks = [
        (f"{name}_{kind}", kind, numbers)
        for index, name in enumerate(bodies)
        for kind, n in CORNERS.items()
        if len(numbers := np.flatnonzero((body == index) & (n_corners == n)))
    ]
    sets = {name: [np.arange(len(other) * (other is numbers)) for *_, other in blocks] for name, _, numbers in blocks}
    return meshio.Mesh(
        np.asarray(grid.points, dtype=float),
        [(kind, cells[numbers, : CORNERS[kind]]) for _, kind, numbers in blocks],
        _fields(grid.point_data),
        {name: [values[numbers] for *_, numbers in blocks] for name, values in _fields(grid.cell_data).items()},
        field_data={name: np.array([number, 2]) for number, name in enumerate(bodies, 1)},  # 2: surfaces
        cell_sets=sets,
    )


def _fields(data: pyvista.DataSetAttributes) -> dict[str, Floats]:
    """Numbers (n,) or vectors (n, 3) by name, those of stress component by component."""
    fields: dict[str, Any] = {name: np.asarray(data[name], dtype=float) for name in data}
    stress = fields.pop("stress", np.empty((0, 0)))
    return dict(zip(COMPONENTS, np.ascontiguousarray(stress.T), strict=False)) | fields


def _write(path: Path, mesh: meshio.Mesh, to: str) -> None:
    """Write a mesh in one of FORMATS to a file of any name."""
    plain = meshio.Mesh(mesh.points, mesh.cells, mesh.point_data, mesh.cell_data)  # of formats that have no sets
    if to == "msh":
        meshio.gmsh.write(path, _tagged(mesh), fmt_version="4.1")
    elif to == "inp":
        for block in mesh.cells:
            block.type = ABAQUS[block.type]
        meshio.abaqus.write(path, mesh, translate_cell_names=False)
    elif to == "vtk":
        meshio.vtk.write(path, plain)
    else:  # the numbers in the file itself: one file, that is whole or missing
        meshio.xdmf.write(path, plain, data_format="XML")


def _tagged(mesh: meshio.Mesh) -> meshio.Mesh:
    """A mesh whose blocks are surfaces of Gmsh, each with the group of its body, and each point in one of them.

    A surface without a point would be missing in the file: where two blocks share all, the earlier one keeps one.
    Points come surface by surface, as they do in the file: meshio gives data of points back by their numbers.
    """
    home = np.ones(len(mesh.points), dtype=np.int64)
    for surface, block in enumerate(mesh.cells, 1):
        home[block.data] = surface
    for surface, block in enumerate(mesh.cells, 1):
        if not (home[block.data] == surface).any():
            home[block.data[0, 0]] = surface
    order = np.argsort(home, kind="stable")
    place = np.argsort(order)
    point_data = {name: values[order] for name, values in mesh.point_data.items()}
    point_data["gmsh:dim_tags"] = np.column_stack([np.full_like(home, 2), home[order]])
    surfaces = [np.full(len(block.data), surface) for surface, block in enumerate(mesh.cells, 1)]
    groups = [body.astype(np.int64) + 1 for body in mesh.cell_data["body"]]
    cell_data = mesh.cell_data | {"gmsh:geometrical": surfaces, "gmsh:physical": groups}
    cells = [(block.type, place[block.data]) for block in mesh.cells]
    return meshio.Mesh(mesh.points[order], cells, point_data, cell_data, mesh.field_data)
