"""Crack paths as lines with attributes, for maps and drawings: GeoJSON, and DXF by ezdxf; m and Pa, as all results."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from crackgrow.arrays import Floats
from crackgrow.results.atomic import OutputError, write_atomically, write_text
from crackgrow.results.folder import RunFolder, series_file
from crackgrow.results.units import or_null

FORMATS: Final = ("geojson", "dxf")
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


def export_paths(run: RunFolder, to: str, step: int | None, path: Path) -> None:
    """Write the crack paths of a run at its end, or as they were in a step, in one of FORMATS; raises OutputError."""
    features = list(path_features(run, step))
    if to == "geojson":
        write_text(path, _geojson(run.case.title, features))
    else:
        _write_dxf(path, features)


def path_features(run: RunFolder, step: int | None = None) -> Iterator[Feature]:
    """The cracks as they began, what each step added to them, and their tips in the last solved step, or in `step`."""
    shown = run.solved[-1] if step is None else step
    K = {
        (crack, tip, int(number)): {name: or_null(float(row.numbers(name)[0])) for name in ("K_I", "K_II")}
        for (crack, tip, number), row in run.table("tips").by("crack", "tip", "step").items()
    }
    jumps = _jumps(run, shown)
    for (crack,), rows in run.table("paths").by("crack").items():
        there = rows if step is None else rows.where((rows.steps() <= step).tolist())
        made, points = there.steps(), np.column_stack([there.numbers("x"), there.numbers("y")])
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
    path = run.folder / series_file("cracks", step)
    if not path.is_file():
        contact = run.table("contact").of_steps([step]).by("crack")
        return {
            crack: (points.numbers("s"), points.numbers("slip"), points.numbers("opening"))
            for (crack,), points in contact.items()
        }
    import pyvista  # here: it takes long to load

    mesh: Any = pyvista.read(path)
    names = mesh.GetFieldData().GetAbstractArray("crack_names")
    of_cracks = [mesh.get_cell(number).point_ids for number in range(mesh.n_cells)]
    fields = [np.asarray(mesh.point_data[name]) for name in ("s", "slip", "opening")]
    return {names.GetValue(number): tuple(f[ids] for f in fields) for number, ids in enumerate(of_cracks)}


def _geojson(title: str, features: list[Feature]) -> str:
    found = [
        {
            "type": "Feature",
            "properties": attributes,
            "geometry": {"type": "LineString", "coordinates": points.tolist()}
            if len(points) > 1
            else {"type": "Point", "coordinates": points[0].tolist()},
        }
        for attributes, points in features
    ]
    record = {"type": "FeatureCollection", "name": title, "units": UNITS, "crs": None, "features": found}
    return json.dumps(record, ensure_ascii=False, allow_nan=False) + "\n"


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
