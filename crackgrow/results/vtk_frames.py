"""Frames that ParaView opens: the specimen and its cracks at each step, and the time series that list them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pyvista
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from crackgrow.results.atomic import write_atomically, write_text
from crackgrow.results.stress import principal_stresses
from crackgrow.run.result import CrackFaces, Frame, StepResult

STRESS_COMPONENTS = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")  # the order that VTK expects of a symmetric tensor


def specimen_grid(frame: Frame, fields: Sequence[str]) -> pyvista.UnstructuredGrid:
    """The specimen's mesh with the `fields` asked for ("displacement", "stress"); m and Pa.

    Point data: displacement (n, 3). Cell data: body; energy_error where it was estimated, the root of the energy
    density of the stress' error over the mean energy density of the rock (1: as large as the stress is on average);
    with stress also stress (cells, 6) and the principal stresses in the plane, sigma_1 (most tensile) and sigma_3.
    """
    cells = {pyvista.CellType.TRIANGLE: frame.triangles, pyvista.CellType.QUAD: frame.quads}
    grid = pyvista.UnstructuredGrid({kind: ids for kind, ids in cells.items() if len(ids)}, _spatial(frame.points))
    grid.cell_data["body"] = np.asarray(frame.body, dtype=np.int32)
    if frame.energy_error is not None:
        grid.cell_data["energy_error"] = frame.energy_error
    if "displacement" in fields:
        grid.point_data["displacement"] = _spatial(frame.displacement)
    if "stress" in fields:
        xx, yy, xy = frame.stress.T
        zero = np.zeros_like(xx)
        grid.cell_data["stress"] = np.column_stack([xx, yy, frame.stress_zz, xy, zero, zero])
        array = grid.GetCellData().GetArray("stress")
        for component, name in enumerate(STRESS_COMPONENTS):
            array.SetComponentName(component, name)
        grid.cell_data["sigma_1"], grid.cell_data["sigma_3"] = principal_stresses(frame.stress)
    return grid


def crack_lines(faces: Sequence[CrackFaces]) -> pyvista.PolyData:
    """One polyline a crack, interface or foundation; m and Pa.

    Point data: s, opening, slip, normal_traction, tangential_traction, state (0 open, 1 stick, 2 slip).
    Cell data: crack, the index into the field data crack_names.
    """
    sizes = [len(face.s) for face in faces]
    starts = np.cumsum([0, *sizes[:-1]])
    mesh = pyvista.PolyData()
    mesh.points = _spatial(np.concatenate([face.points for face in faces]))
    lines = [[size, *range(start, start + size)] for start, size in zip(starts, sizes, strict=True)]
    mesh.lines = np.concatenate(lines)
    for name in ("s", "opening", "slip", "normal_traction", "tangential_traction"):
        mesh.point_data[name] = np.concatenate([getattr(face, name) for face in faces])
    mesh.point_data["state"] = np.concatenate([face.state for face in faces]).astype(np.int8)
    mesh.cell_data["crack"] = np.arange(len(faces), dtype=np.int32)
    names = vtkStringArray()  # itself: pyvista takes no letters beyond ASCII
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
    lines = [f'    <DataSet timestep="{step}" part="0" file={quoteattr(name)}/>\n' for step, name in files]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
        f"  <Collection>\n{''.join(lines)}  </Collection>\n</VTKFile>\n"
    )
    write_text(path, text)


def _write(path: Path, mesh: pyvista.DataSet, writer: vtkXMLUnstructuredGridWriter | vtkXMLPolyDataWriter) -> None:
    """Write raw appended data, compressed; VTK says by its return value alone that the disk refused."""

    def write(temporary: Path) -> None:
        writer.SetFileName(str(temporary))
        writer.SetInputData(mesh)
        writer.SetDataModeToAppended()
        writer.EncodeAppendedDataOff()
        writer.SetCompressorTypeToZLib()
        loud = writer.GetGlobalWarningDisplay()
        writer.SetGlobalWarningDisplay(0)  # else a full disk is told in VTK's own words first
        done = writer.Write() == 1 and writer.GetErrorCode() == 0
        writer.SetGlobalWarningDisplay(loud)
        if not done:
            raise OSError(f"VTK's writer failed (code {writer.GetErrorCode()}), perhaps the disk is full")

    write_atomically(path, write)


def _spatial(plane: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) from (n, 2), z = 0."""
    return np.column_stack([plane, np.zeros(len(plane))])
