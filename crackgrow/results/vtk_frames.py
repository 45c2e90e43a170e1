"""Frames that ParaView opens: the specimen and its cracks at each step, and the time series that list them.

Files are VTK's XML with the arrays behind it as they lie in memory: loading VTK takes longer than writing many of them.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from crackgrow.arrays import Floats
from crackgrow.results.atomic import remove_files, write_bytes, write_text
from crackgrow.results.drawn_frame import VTK_QUAD, VTK_TRIANGLE, principal_stresses
from crackgrow.results.folder import FACES, FRAME, of_step, series_names
from crackgrow.run.result import CrackFaces, Frame

if TYPE_CHECKING:
    import pyvista

COMPONENTS: Final = {"stress": ("XX", "YY", "ZZ", "XY", "YZ", "XZ")}  # the order that VTK expects of a symmetric tensor
TYPES: Final = {"f8": "Float64", "i8": "Int64", "i4": "Int32", "i1": "Int8", "u1": "UInt8"}  # VTK's names of NumPy's

Data = Mapping[str, NDArray[Any]]
"""Values (n,) or (n, k) by name; a viewer shows the first ones by itself."""


def write_frame(path: Path, frame: Frame, fields: Sequence[str]) -> None:
    """Write the specimen with the `fields` asked for, of `case.model.FIELDS`, to `path` (.vtu); m and Pa.

    Point data: displacement (n, 3); with stress also stress (n, 6) and the principal stresses in the plane, sigma_1
    (most tensile) and sigma_3. Cell data: body; energy_error, the root of the energy density of the stress' error over
    the mean energy density of the rock (1: as large as the stress is on average); and under the names of the point data
    stress, sigma_1 and sigma_3 in the middles of cells.

    Raises OutputError.
    """
    points: dict[str, NDArray[Any]] = {}
    cells: dict[str, NDArray[Any]] = {"body": frame.body.astype(np.int32)}
    if "energy_error" in fields and frame.error_density is not None:
        cells["energy_error"] = frame.error_density
    if "displacement" in fields:
        points["displacement"] = _spatial(frame.displacement)
    if "stress" in fields:
        points |= _stresses(frame.point_stress, frame.point_stress_zz)
        cells |= _stresses(frame.stress, frame.stress_zz)
    sizes = np.repeat([3, 4], [len(frame.triangles), len(frame.quads)])
    corners = np.concatenate([frame.triangles.ravel(), frame.quads.ravel()])
    kinds = np.where(sizes == 3, VTK_TRIANGLE, VTK_QUAD).astype(np.uint8)
    parts = {
        "PointData": points,
        "CellData": cells,
        "Points": {"Points": _spatial(frame.points)},
        "Cells": {"connectivity": corners, "offsets": np.cumsum(sizes), "types": kinds},
    }
    _write(path, "UnstructuredGrid", {"Points": len(frame.points), "Cells": len(sizes)}, parts)


def write_cracks(path: Path, faces: Sequence[CrackFaces]) -> None:
    """Write one polyline a crack, interface or foundation to `path` (.vtp); m and Pa; raises OutputError.

    Point data: s, opening, slip, normal_traction, tangential_traction, state (0 open, 1 stick, 2 slip).
    Cell data: crack, the index into the field data crack_names.
    """
    sizes = np.array([len(face.s) for face in faces])
    names = ("s", "opening", "slip", "normal_traction", "tangential_traction", "state")
    values = {name: np.concatenate([getattr(face, name) for face in faces]) for name in names}
    parts = {
        "PointData": values | {"state": values["state"].astype(np.int8)},
        "CellData": {"crack": np.arange(len(faces), dtype=np.int32)},
        "Points": {"Points": _spatial(np.concatenate([face.points for face in faces]))},
        "Lines": {"connectivity": np.arange(sizes.sum()), "offsets": np.cumsum(sizes)},
    }
    letters = " ".join(str(byte) for face in faces for byte in (*face.crack.encode(), 0))
    told = f'<Array type="String" Name="crack_names" NumberOfTuples="{len(faces)}" format="ascii">{letters}</Array>'
    _write(path, "PolyData", {"Points": int(sizes.sum()), "Lines": len(faces)}, parts, f"<FieldData>{told}</FieldData>")


def write_series(folder: Path, case_name: str, frames: Sequence[int], cracks: Sequence[int]) -> None:
    """Write the time series of the steps with frames, and of those with crack faces, or remove one that has none.

    Raises OutputError.
    """
    for name, kind, steps in zip(series_names(case_name), (FRAME, FACES), (frames, cracks), strict=True):
        if steps:
            files = ((step, of_step(kind, step)) for step in steps)
            lines = [f'    <DataSet timestep="{step}" part="0" file="{file}"/>\n' for step, file in files]
            head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            write_text(folder / name, f"{head}  <Collection>\n{''.join(lines)}  </Collection>\n</VTKFile>\n")
        else:
            remove_files([folder / name])


def as_pyvista(frame: Frame, fields: Sequence[str]) -> pyvista.UnstructuredGrid:
    """The specimen as pyvista reads it from a frame."""
    import pyvista  # here: a run that writes frames needs none of it

    with tempfile.TemporaryDirectory() as folder:
        write_frame(path := Path(folder) / "frame.vtu", frame, fields)
        grid = pyvista.read(path)
    assert isinstance(grid, pyvista.UnstructuredGrid)
    return grid


def _write(path: Path, kind: str, sizes: Mapping[str, int], parts: Mapping[str, Data], before: str = "") -> None:
    """Write a file of one piece: XML that says where each array begins in the bytes behind it (raw appended data)."""
    told, blocks, offset = "", [], 0
    for part, data in parts.items():
        first = f' Scalars="{next(iter(data))}"' if part.endswith("Data") and data else ""
        told += f"<{part}{first}>\n"
        for name, values in data.items():
            block = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
            columns = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
            columns += "".join(f' ComponentName{k}="{word}"' for k, word in enumerate(COMPONENTS.get(name, ())))
            what = f'type="{TYPES[values.dtype.str[1:]]}" Name="{name}"{columns} format="appended" offset="{offset}"'
            told += f"<DataArray {what}/>\n"
            blocks += [np.array(block.nbytes, dtype="<u8").tobytes(), block.tobytes()]
            offset += 8 + block.nbytes
        told += f"</{part}>\n"
    piece = "".join(f' NumberOf{name}="{n}"' for name, n in sizes.items())
    head = (
        f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'<{kind}>{before}<Piece{piece}>\n{told}</Piece></{kind}>\n<AppendedData encoding="raw">\n_'
    )
    write_bytes(path, b"".join([head.encode(), *blocks, b"\n</AppendedData>\n</VTKFile>\n"]))


def _stresses(stress: Floats, zz: Floats) -> Data:
    """Stress (n, 3) Pa: xx, yy, xy with its component zz (n,) as a tensor (n, 6), and its principal stresses."""
    xx, yy, xy = stress.T
    zero = np.zeros_like(xx)
    sigma_1, sigma_3 = principal_stresses(stress)
    return {"stress": np.column_stack([xx, yy, zz, xy, zero, zero]), "sigma_1": sigma_1, "sigma_3": sigma_3}


def _spatial(plane: Floats) -> Floats:
    """(n, 3) from (n, 2), z = 0."""
    return np.column_stack([plane, np.zeros(len(plane))])
