"""Mesh files that meshio reads: outlines of regions, names of edges, and cracks, in the length unit of the case."""

from __future__ import annotations

import contextlib
import io
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, pairwise
from pathlib import Path as FilePath
from typing import Any, Final

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from crackgrow.arrays import Floats, Ints
from crackgrow.case.report import clean, did_you_mean, listed, quoted

ENDINGS: Final = (".msh", ".vtu", ".vtk", ".inp", ".xdmf", ".med", ".mesh", ".bdf", ".nas", ".su2")
MAX_BYTES: Final = 200 * 2**20
SAME: Final = 1e-9  # points nearer than this part of the mesh's extent are one, and lie on the line that they are near
MOST_TAGS: Final = 100  # of cell data with more different values none is a group
LONGEST_NAME: Final = 58  # letters of a name that may get a number: with that it has 64 at most

SAVE: Final = "save it without Mesh.SaveAll (-save_all)"
OF_GMSH_4_0: Final = re.compile(rb"\s*\$MeshFormat\s+4(\.0)?\s")

SURFACES: Final = {  # nodes round a cell
    "triangle": (0, 1, 2), "triangle6": (0, 3, 1, 4, 2, 5), "quad": (0, 1, 2, 3), "quad8": (0, 4, 1, 5, 2, 6, 3, 7),
    "quad9": (0, 4, 1, 5, 2, 6, 3, 7),
}  # fmt: skip
CURVES: Final = {"line": (0, 1), "line3": (0, 2, 1)}  # nodes along a cell
Side = frozenset[int]  # the two nodes of a side, or all of a cell


class ContentError(ValueError):
    """A file that does not hold what is wanted; the message says why."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneMesh:
    """The cells of a mesh in the plane, and their groups by name: of Gmsh, of sets, and `DATA=VALUE` of cell data."""

    points: Floats  # (n, 2), in the unit of the case; points in the same place are one
    extent: float  # diagonal of the box round them
    surfaces: tuple[Ints, ...]  # nodes round each cell
    regions: dict[str, list[int]]  # numbers of surfaces
    curves: dict[str, list[tuple[int, int]]]  # sides, in the order of the file

    def outline(self, region: str | None) -> tuple[list[Floats], dict[str, list[int]]]:
        """The outline (n, 2) of a region, or of all, and its holes; and the numbers of sides by name of an edge.

        The outline runs counter-clockwise from its lowest corner, the leftmost of these. A curve that is several parts
        of it gives as many edges: NAME-1, NAME-2 and so on; of two on a side the one of fewer sides names it. Signs
        that a name of a case lacks become _. Raises ContentError.
        """
        cells = _group(self.regions, region, "region") if region is not None else range(len(self.surfaces))
        named = sorted(self.curves.items(), key=lambda curve: -len(curve[1]))
        names = {
            frozenset(side): re.sub(r"^-|[^\w-]", "_", name)[:LONGEST_NAME]
            for name, found in named
            for side in (found if "=" not in name else ())
        }
        outer, *holes = (self._corners(ring, names) for ring in self._rings(cells))
        low = min(range(len(outer)), key=lambda k: (self.points[outer[k][0], 1], self.points[outer[k][0], 0]))
        outer = outer[low:] + outer[:low]
        edges = _edges([name for _, name in outer])
        return [self.points[[node for node, _ in ring]] for ring in (outer, *holes)], edges

    def path(self, curve: str) -> Floats:
        """The vertices (n, 2) of a curve from end to end, in the direction of its first cell; raises ContentError."""
        sides = _group(self.curves, curve, "curve")
        pairs = np.array([sorted(side) for side in {*map(frozenset, sides)} if len(side) == 2], dtype=np.int64)
        lines = shapely.get_parts(shapely.line_merge(shapely.MultiLineString([*self.points[pairs.reshape(-1, 2)]])))
        if len(lines) != 1 or lines[0].is_closed:
            what = "branches, closes or is in several parts; a crack is a line"
            raise ContentError(f"has a curve {quoted(curve)} that {what}")
        node_at = {tuple(self.points[node]): node for node in pairs.ravel().tolist()}
        chain = [node_at[place] for place in lines[0].coords]
        chain = chain if chain.index(sides[0][0]) < chain.index(sides[0][1]) else chain[::-1]
        kept = [k for k in range(1, len(chain) - 1) if not self._straight(*chain[k - 1 : k + 2])]
        return np.asarray(self.points[[chain[0], *(chain[k] for k in kept), chain[-1]]], dtype=float)

    def _rings(self, cells: Iterable[int]) -> list[list[int]]:
        """The closed lines of nodes round cells: the outer one, counter-clockwise, and holes in the order of cells."""
        around = (self.surfaces[cell].tolist() for cell in cells)
        count = Counter(frozenset(side) for nodes in around for side in pairwise([*nodes, nodes[0]]))
        rim = [sorted(side) for side, number in count.items() if number == 1 and len(side) == 2]
        for node, number in Counter(node for side in rim for node in side).items():
            if number > 2:
                x, y = self.points[node]
                raise ContentError(f"has a region whose outline touches itself at ({x:.6g}, {y:.6g})")
        body = shapely.build_area(shapely.MultiLineString([*self.points[np.array(rim)]]))
        if body.geom_type != "Polygon":
            raise ContentError("is in several pieces; each body is one: give each piece a group of its own")
        body = orient(body)
        node_at = {tuple(self.points[node]): node for side in rim for node in side}
        outer, *holes = ([node_at[place] for place in ring.coords[:-1]] for ring in (body.exterior, *body.interiors))
        order = {node: number for number, side in reversed(list(enumerate(rim))) for node in side}
        begins = [min(hole, key=lambda node: (order[node], node)) for hole in holes]
        begun = [hole[hole.index(node) :] + hole[: hole.index(node)] for hole, node in zip(holes, begins, strict=True)]
        return [outer, *sorted(begun, key=lambda hole: order[hole[0]])]

    def _corners(self, ring: list[int], names: Mapping[Side, str]) -> list[tuple[int, str]]:
        """The nodes of a ring at which it turns, or its edge has another name; and the name of the edge after each."""
        after = [*ring[1:], ring[0]]
        sides = [names.get(frozenset(side), "") for side in zip(ring, after, strict=True)]
        return [
            (node, sides[k])
            for k, node in enumerate(ring)
            if sides[k - 1] != sides[k] or not self._straight(ring[k - 1], node, after[k])
        ]

    def _straight(self, before: int, node: int, after: int) -> bool:
        """Whether a node lies on the line from the one before it to the one after it."""
        start, end = self.points[before], self.points[after]
        along = end - start
        length = float(np.hypot(*along))
        x, y = self.points[node] - start
        off = abs(x * along[1] - y * along[0])
        return length > 0 and off <= SAME * self.extent * length and 0 < (x, y) @ along < length**2


def _edges(names: list[str]) -> dict[str, list[int]]:
    """Numbers of the sides of a ring by the name of the curve that each lies on; several parts of it have numbers."""
    n = len(names)
    start = next((k for k in range(n) if names[k - 1] != names[k]), 0)
    runs: dict[str, list[list[int]]] = {}
    for name, run in groupby(((start + k) % n for k in range(n)), key=names.__getitem__):
        if name:
            runs.setdefault(name, []).append(list(run))
    return {
        name if len(parts) == 1 else f"{name}-{k}": part
        for name, parts in runs.items()
        for k, part in enumerate(parts, 1)
    }


def checked_file(file: FilePath, most_bytes: int) -> os.stat_result:
    """The state of a file that can be read; raises ContentError."""
    try:
        is_file, exists = file.is_file(), file.exists()
        state = file.stat() if is_file else None
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise ContentError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if state is None:
        raise ContentError("is no file" if exists else f"does not exist in {file.parent}")
    if state.st_size > most_bytes:
        raise ContentError(f"is larger than {most_bytes // 2**20} MiB")
    return state


def read_mesh(file: FilePath) -> PlaneMesh:
    """Read a mesh file; raises ContentError."""
    state = checked_file(file, MAX_BYTES)
    return _read(file, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=4)
def _read(file: FilePath, changed: int, size: int) -> PlaneMesh:
    """The mesh of a file as it was at a time: bodies and cracks of a case come from the same one."""
    import meshio  # only now: few cases have a mesh

    told = io.StringIO()
    try:
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(told):
            mesh = meshio.read(file)
    except (Exception, SystemExit) as error:  # of a damaged file meshio may raise anything, or end the program
        if OF_GMSH_4_0.match(file.read_bytes()[:80]):
            raise ContentError(
                "is of Gmsh's format 4.0, which cannot be read: save it as 4.1 (-format msh41)"
            ) from None
        if "Incompatible cell data 'gmsh:physical'" in str(error):
            raise ContentError(f"has elements with and without a physical group: {SAVE}") from None
        words = "" if isinstance(error, SystemExit) else f": {clean(' '.join(str(error).split()))}"
        raise ContentError(f"cannot be read as {file.suffix.lower()[1:]}{words}") from None
    return _plane(mesh)


def _plane(mesh: Any) -> PlaneMesh:
    """What is of use of a mesh of meshio's."""
    places = np.asarray(mesh.points, dtype=float)
    if not len(places) or not np.isfinite(places).all():
        raise ContentError("has no points" if not len(places) else "has points that are not finite")
    if places.shape[1] == 3 and np.ptp(places[:, 2]) > SAME * _extent(places[:, :2]):
        raise ContentError(f"is not plane: z goes from {places[:, 2].min():g} to {places[:, 2].max():g}")
    solid = sorted({block.type for block in mesh.cells if block.dim == 3})
    if solid:
        raise ContentError(f"has cells of volumes ({', '.join(solid)}); wanted: a mesh in the plane")
    strange = sorted({b.type for b in mesh.cells if b.dim in (1, 2)} - SURFACES.keys() - CURVES.keys())
    if strange:
        raise ContentError(f"has cells of the kind {', '.join(strange)}; wanted: {', '.join((*SURFACES, *CURVES))}")
    points, one = _merged(places[:, :2])
    surfaces: dict[Side, Ints] = {}  # by their nodes: format 2.2 of Gmsh has a cell once for each group that it is in
    regions: dict[str, list[int]] = {}
    curves: dict[str, list[tuple[int, int]]] = {}
    for number, block in enumerate(mesh.cells):
        groups = list(_groups(mesh, number))
        if block.type in SURFACES:
            found = [(frozenset(cell.tolist()), cell) for cell in one[np.asarray(block.data)[:, SURFACES[block.type]]]]
            for nodes, cell in found:
                surfaces.setdefault(nodes, cell)
            place = {nodes: k for k, nodes in enumerate(surfaces)}
            for name, cells in groups:
                regions.setdefault(name, []).extend(place[found[cell][0]] for cell in cells)
        elif block.type in CURVES:
            nodes = one[np.asarray(block.data)[:, CURVES[block.type]]]
            for name, cells in groups:
                lines = nodes[cells].tolist()
                curves.setdefault(name, []).extend(side for line in lines for side in pairwise(line))
    if not surfaces:
        raise ContentError(f"has no cells of surfaces ({', '.join(SURFACES)})")
    physical = [name for name, (_, dimension) in mesh.field_data.items() if dimension in (1, 2)]
    if physical and not any(name in regions or name in curves for name in physical):
        raise ContentError(f"has no cells in its physical groups ({', '.join(map(clean, physical))}): {SAVE}")
    return PlaneMesh(points, _extent(points), tuple(surfaces.values()), regions, curves)


def _merged(points: Floats) -> tuple[Floats, Ints]:
    """Points (m, 2), each place once, and the number of the place of each of the points (n, 2)."""
    grid = np.round((points - points.min(axis=0)) / (SAME * max(_extent(points), np.finfo(float).tiny)))
    _, first, one = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    return points[first], np.asarray(one, dtype=np.int64).reshape(-1)


def _groups(mesh: Any, number: int) -> Iterator[tuple[str, Ints]]:
    """Names of groups with the cells of a block in them: those that are not empty, each name once."""
    block, found = mesh.cells[number], {}
    for name, sets in mesh.cell_sets.items():
        if not name.startswith("gmsh:") and sets[number] is not None:
            found[name] = np.asarray(sets[number], dtype=np.int64)
    tags = mesh.cell_data.get("gmsh:physical")
    for name, (tag, dimension) in mesh.field_data.items() if tags is not None else ():
        if dimension == block.dim and name not in found:  # of several groups of an entity the tags are the first one
            found[name] = np.flatnonzero(np.asarray(tags[number]) == tag)
    for key, blocks in mesh.cell_data.items():
        values = np.asarray(blocks[number])
        if values.ndim == 1 and len(values) and np.array_equal(values, np.round(values)):
            kinds = np.unique(values)
            for value in kinds if len(kinds) <= MOST_TAGS else ():
                found[f"{key}={int(value)}"] = np.flatnonzero(values == value)
    yield from ((name, cells) for name, cells in found.items() if len(cells))


def _group(groups: Mapping[str, Any], name: str, kind: str) -> Any:
    """A group by its name, or by the number that Gmsh or another program gave it; raises ContentError."""
    tags = [known for known in groups if known.endswith(f"={name}") and known.startswith(("gmsh:physical", "medit:"))]
    chosen = [known for known in (name, *tags) if known in groups]
    if not chosen:
        raise ContentError(f"has no {kind} {quoted(name)}; it has {listed(groups)}{did_you_mean(name, groups)}")
    return groups[chosen[0]]


def _extent(points: Floats) -> float:
    """Diagonal of the bounding box."""
    return float(np.hypot(*np.ptp(points, axis=0)))
