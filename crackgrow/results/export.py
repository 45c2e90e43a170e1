"""A frame as a mesh file of other programs, written by meshio; crack paths as lines of maps and drawings."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import meshio
import numpy as np
import pyvista

from crackgrow.arrays import Floats
from crackgrow.results.atomic import FolderError, OutputError, write_atomically, write_text
from crackgrow.results.drawn_frame import by_component, cells_of
from crackgrow.results.folder import FACES, RunFolder, of_step, open_run
from crackgrow.results.units import or_null, spans_text

FORMATS: Final = ("msh", "inp", "vtk", "xdmf", "geojson", "dxf")
PATHS: Final = FORMATS[4:]  # formats of crack paths
CORNERS: Final = {"triangle": 3, "quad": 4}
ABAQUS: Final = {"triangle": "CPS3", "quad": "CPS4"}
"""Elements of the plane that meshio reads; what it would write by itself are rigid and axisymmetric ones."""

UNITS: Final = "metres, Pa sqrt(m); no geographic coordinates"
APPLICATION: Final = "CRACKGROW"  # under which DXF has the attributes of an entity
TEXT: Final = 1000  # code of a text among them


NOTHING: Final[dict[str, Any]] = dict.fromkeys(
    ("crack", "kind", "tip", "step", "length", "slip", "opening", "K_I", "K_II")
)
"""What is told of a line or of a tip, None where there is no number.

kind     given, grown or tip
tip     start or end; empty of the crack as it began
step     whose advance made the line, 0 of a given crack; of a tip the step that is shown
length     m
slip, opening     m, in the middle of the line, in the step that is shown
K_I, K_II     Pa sqrt(m), of the tip as it grew by the line; of a tip in the step that is shown
"""

Feature = tuple[dict[str, Any], Floats]
"""What is told, and the points (n, 2) m of a line; of a tip one."""


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
        by_component(grid.point_data),
        {name: [values[numbers] for *_, numbers in blocks] for name, values in by_component(grid.cell_data).items()},
        field_data={name: np.array([number, 2]) for number, name in enumerate(bodies, 1)},  # 2: surfaces
        cell_sets=sets,
    )


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


def export_paths(run: RunFolder, to: str, step: int | None, path: Path) -> None:
    """Write the crack paths of a run at its end, or as they were in a step, in one of FORMATS; raises OutputError."""
    features = list(path_features(run, step))
    if to == "dxf":
        _write_dxf(path, features)
        return
    found = []
    for told, points in features:
        kind, at = ("LineString", points.tolist()) if len(points) > 1 else ("Point", points[0].tolist())
        found.append({"type": "Feature", "properties": told, "geometry": {"type": kind, "coordinates": at}})
    record = {"type": "FeatureCollection", "name": run.case.title, "units": UNITS, "crs": None, "features": found}
    write_text(path, json.dumps(record, ensure_ascii=False, allow_nan=False) + "\n")


def path_features(run: RunFolder, step: int | None = None) -> Iterator[Feature]:
    """The cracks as they began, what each step added to them, and their tips in the last solved step, or in `step`."""
    shown = run.solved[-1] if step is None else step
    K = {
        place: {name: or_null(float(row[name][0])) for name in ("K_I", "K_II")}
        for place, row in run.table("tips").by("crack", "tip", "step").items()
    }
    jumps = _jumps(run, shown)
    for (crack,), rows in run.table("paths").by("crack").items():
        there = rows if step is None else rows.rows(rows["step"] <= step)
        made, points = there["step"], np.column_stack([there["x"], there["y"]])
        if len(points) < 2:  # a crack that starts later
            continue
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        solved = np.flatnonzero(made <= shown)
        first, *_, last = np.flatnonzero(made == made.min()).tolist()
        parts = [(first, last, ""), *((k - 1, k, "start") for k in range(first, 0, -1))]
        parts += [(k, k + 1, "end") for k in range(last, len(points) - 1)]
        for begin, end, tip in parts:
            number = int(max(made[begin], made[end])) if tip else int(made.min())
            told = NOTHING | {"crack": crack, "kind": "grown" if number else "given", "tip": tip, "step": number}
            told["length"] = float(along[end] - along[begin])
            if crack in jumps and number <= shown:
                s, *fields = jumps[crack]
                middle = 0.5 * (along[begin] + along[end]) - along[solved[0]]
                for name, field in zip(("slip", "opening"), fields, strict=True):
                    told[name] = or_null(float(np.interp(middle, s, field)))
            yield told | K.get((crack, tip, number - 1), {}), points[begin : end + 1]
        for tip, vertex in (("start", solved[0]), ("end", solved[-1])):
            if (crack, tip, shown) in K:
                told = NOTHING | {"crack": crack, "kind": "tip", "tip": tip, "step": shown}
                yield told | K[crack, tip, shown], points[vertex : vertex + 1]


def _jumps(run: RunFolder, step: int) -> dict[str, tuple[Floats, Floats, Floats]]:
    """Arc lengths, slip and opening (n,) m along each crack in a step: of all points if they were written for ParaView.

    Else of contact points alone, which cracks without a contact law have none of.
    """
    path = run.folder / of_step(FACES, step)
    if not path.is_file():
        contact = run.table("contact").of_steps([step]).by("crack")
        return {crack: (points["s"], points["slip"], points["opening"]) for (crack,), points in contact.items()}
    mesh: Any = pyvista.read(path)
    names = mesh.GetFieldData().GetAbstractArray("crack_names")
    of_cracks = [mesh.get_cell(number).point_ids for number in range(mesh.n_cells)]
    fields = [np.asarray(mesh.point_data[name]) for name in ("s", "slip", "opening")]
    return {names.GetValue(number): tuple(f[ids] for f in fields) for number, ids in enumerate(of_cracks)}


def _write_dxf(path: Path, features: list[Feature]) -> None:
    """Lines and points on a layer for each kind, their attributes as extended data; the unit is in the header."""
    try:
        from ezdxf.enums import InsertUnits  # here: ezdxf need not be there
        from ezdxf.filemanagement import new
    except ImportError as error:
        raise OutputError("DXF is written by ezdxf, which is not there: pip install 'crackgrow[maps]'") from error
    drawing = new("R2010")
    drawing.units = InsertUnits.Meters
    drawing.appids.add(APPLICATION)
    for kind, colour in (("given", 7), ("grown", 1), ("tip", 5)):  # black or white, red, blue
        drawing.layers.add(kind, color=colour)
    space = drawing.modelspace()
    for attributes, points in features:
        at = {"layer": attributes["kind"]}
        entity = space.add_lwpolyline(points, dxfattribs=at) if len(points) > 1 else space.add_point(points[0], at)
        known = [(name, value) for name, value in ({"units": UNITS} | attributes).items() if value is not None]
        entity.set_xdata(APPLICATION, [(TEXT, f"{name}: {value}") for name, value in known])
    write_atomically(path, drawing.saveas)
