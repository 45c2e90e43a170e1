"""Frames that ParaView opens: the specimen and its cracks at each step, and the time series that list them.

By VTK alone: pyvista, which pictures need, takes several times as long to load.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkPoints, vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    VTK_QUAD,
    VTK_TRIANGLE,
    vtkCellArray,
    vtkDataSetAttributes,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from crackgrow.results.atomic import write_atomically, write_text
from crackgrow.results.drawn_frame import principal_stresses
from crackgrow.run.result import CrackFaces, Frame, StepResult

if TYPE_CHECKING:
    import pyvista

STRESS_COMPONENTS = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")  # the order that VTK expects of a symmetric tensor


def as_pyvista(grid: vtkUnstructuredGrid) -> pyvista.UnstructuredGrid:
    """The same mesh with pyvista's methods."""
    import pyvista  # here: a run that writes frames needs none of it

    return pyvista.UnstructuredGrid(grid)


def specimen_grid(frame: Frame, fields: Sequence[str]) -> vtkUnstructuredGrid:
    """The specimen's mesh with the `fields` asked for, of `case.model.FIELDS`; m and Pa.

    Point data: displacement (n, 3); with stress also stress (n, 6) and the principal stresses in the plane, sigma_1
    (most tensile) and sigma_3. Cell data: body; energy_error, the root of the energy density of the stress' error over
    the mean energy density of the rock (1: as large as the stress is on average); and under the names of the point data
    stress, sigma_1 and sigma_3 in the middles of cells.
    """
    grid = vtkUnstructuredGrid()
    grid.SetPoints(_points(frame.points))
    kinds = np.repeat([VTK_TRIANGLE, VTK_QUAD], [len(frame.triangles), len(frame.quads)]).astype(np.uint8)
    corners = np.concatenate([frame.triangles.ravel(), frame.quads.ravel()])
    sizes = np.repeat([3, 4], [len(frame.triangles), len(frame.quads)])
    grid.SetCells(numpy_to_vtk(kinds, deep=True), _cells(sizes, corners))
    _add(grid.GetCellData(), "body", np.asarray(frame.body, dtype=np.int32))
    if "energy_error" in fields and frame.error_density is not None:
        _add(grid.GetCellData(), "energy_error", frame.error_density)
    if "displacement" in fields:
        _add(grid.GetPointData(), "displacement", _spatial(frame.displacement))
    if "stress" in fields:
        _add_stress(grid.GetPointData(), frame.point_stress, frame.point_stress_zz)
        _add_stress(grid.GetCellData(), frame.stress, frame.stress_zz)
    return grid


def crack_lines(faces: Sequence[CrackFaces]) -> vtkPolyData:
    """One polyline a crack, interface or foundation; m and Pa.

    Point data: s, opening, slip, normal_traction, tangential_traction, state (0 open, 1 stick, 2 slip).
    Cell data: crack, the index into the field data crack_names.
    """
    sizes = np.array([len(face.s) for face in faces])
    mesh = vtkPolyData()
    mesh.SetPoints(_points(np.concatenate([face.points for face in faces])))
    mesh.SetLines(_cells(sizes, np.arange(sizes.sum())))
    for name in ("s", "opening", "slip", "normal_traction", "tangential_traction"):
        _add(mesh.GetPointData(), name, np.concatenate([getattr(face, name) for face in faces]))
    _add(mesh.GetPointData(), "state", np.concatenate([face.state for face in faces]).astype(np.int8))
    _add(mesh.GetCellData(), "crack", np.arange(len(faces), dtype=np.int32))
    names = vtkStringArray()
    names.SetName("crack_names")
    for face in faces:
        names.InsertNextValue(face.crack)
    mesh.GetFieldData().AddArray(names)
    return mesh


def write_frame(path: Path, frame: Frame, fields: Sequence[str]) -> None:
    """Write the specimen to `path` (.vtu); raises OutputError."""
    _write(path, specimen_grid(frame, fields), vtkXMLUnstructuredGridWriter())


def write_cracks(path: Path, result: StepResult) -> None:
    """Write the step's crack faces to `path` (.vtp); raises OutputError."""
    _write(path, crack_lines(result.faces), vtkXMLPolyDataWriter())


def write_series(path: Path, files: Sequence[tuple[int, str]]) -> None:
    """Write the time series `path` (.pvd) of (step, file name relative to it); raises OutputError."""
    lines = [f'    <DataSet timestep="{step}" part="0" file="{escape(name)}"/>\n' for step, name in files]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
        f"  <Collection>\n{''.join(lines)}  </Collection>\n</VTKFile>\n"
    )
    write_text(path, text)


def _write(
    path: Path, mesh: vtkUnstructuredGrid | vtkPolyData, writer: vtkXMLUnstructuredGridWriter | vtkXMLPolyDataWriter
) -> None:
    """Write raw appended data, compressed; VTK says by its return value alone that the disk refused."""

    def write(temporary: Path) -> None:
        writer.SetFileName(str(temporary))
        writer.SetInputData(mesh)
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        writer.SetCompressorTypeToLZ4()  # zlib takes seven times as long for files that are a fifth smaller
        loud = writer.GetGlobalWarningDisplay()
        writer.SetGlobalWarningDisplay(0)  # else a full disk is told in VTK's own words first
        done = writer.Write() == 1 and writer.GetErrorCode() == 0
        writer.SetGlobalWarningDisplay(loud)
        if not done:
            raise OSError(f"VTK's writer failed (code {writer.GetErrorCode()}), perhaps the disk is full")

    write_atomically(path, write)


def _points(plane: NDArray[np.float64]) -> vtkPoints:
    """Points (n, 2) m of the plane z = 0."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(_spatial(plane), deep=True))
    return points


def _cells(sizes: NDArray[np.int64], corners: NDArray[np.int64]) -> vtkCellArray:
    """Cells of `sizes` (c,) corners each, whose points are `corners` (sum of sizes,)."""
    starts = np.concatenate([[0], np.cumsum(sizes)])
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtk(starts, deep=True), numpy_to_vtk(corners, deep=True))
    return cells


def _add(data: vtkDataSetAttributes, name: str, values: ArrayLike, components: Sequence[str] = ()) -> None:
    """Add values (n,) or (n, k) under a name; the first ones are those a viewer shows by itself."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    for number, component in enumerate(components):
        array.SetComponentName(number, component)
    data.AddArray(array)
    if data.GetScalars() is None:
        data.SetActiveScalars(name)


def _add_stress(data: vtkDataSetAttributes, stress: NDArray[np.float64], zz: NDArray[np.float64]) -> None:
    """Add stress (n, 3) Pa: xx, yy, xy with its component zz (n,) as a tensor, and the principal ones in the plane."""
    xx, yy, xy = stress.T
    zero = np.zeros_like(xx)
    sigma_1, sigma_3 = principal_stresses(stress)
    _add(data, "stress", np.column_stack([xx, yy, zz, xy, zero, zero]), STRESS_COMPONENTS)
    _add(data, "sigma_1", sigma_1)
    _add(data, "sigma_3", sigma_3)


def _spatial(plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) from (n, 2), z = 0."""
    return np.column_stack([plane, np.zeros(len(plane))])
