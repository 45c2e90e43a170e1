"""A frame of a run with one of its fields, as arrays that pictures are drawn from: displaced, with open faces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from crackgrow.arrays import Floats, Ints
from crackgrow.results.atomic import FolderError
from crackgrow.results.folder import RunFolder
from crackgrow.run.result import Frame

if TYPE_CHECKING:
    import pyvista

VTK_TRIANGLE, VTK_QUAD = 5, 9  # kinds of cells
COMPONENTS = ("stress_xx", "stress_yy", "stress_zz", "stress_xy")  # as they come in a frame's stress
INCHES = 6.5  # of the longer side of a picture whose size fits the specimen: text is in proportion to that
DISPLACED_SHARE = 0.04  # of the specimen's size: how far the most displaced point is drawn from its place
LARGEST_STRAIN = 0.15  # that is drawn: beyond it holes lose their shape
STRAIN_PERCENTILE = 98.0  # of the length of all sides of cells: what is left lies at tips
LINE = 0.8  # points, width of outlines and faces
TOGETHER = LINE / (72 * INCHES)  # of the size: faces that touch are drawn as far apart, or in each other, at most


def principal_stresses(stress: Floats) -> tuple[Floats, Floats]:
    """Major (most tensile) and minor principal stress in the plane, each (n,), of `stress` (n, 3): xx, yy, xy."""
    xx, yy, xy = stress.T
    centre = (xx + yy) / 2
    radius = np.hypot((xx - yy) / 2, xy)
    return centre + radius, centre - radius


@dataclass(frozen=True, eq=False)
class DrawnFrame:
    """The specimen's mesh with one field on it; what is cached is small beside it."""

    step: int
    points: Floats  # (n, 2) m
    cells: Ints  # (c, 4) corners; a triangle has its last one twice
    displacement: Floats  # (n, 2) m
    values: Floats  # (n,) by point, or (c,) by cell; SI units
    by_point: bool

    def magnification(self) -> float:
        """Factor, two digits, that draws the largest displacement off the mean as DISPLACED_SHARE of the size.

        It is less where LARGEST_STRAIN would be drawn, or faces that touch be parted, but 1 at least.
        """
        largest = np.linalg.norm(self.off_mean(), axis=1).max()
        size = np.ptp(self.points, axis=0).max()
        if not largest > 0:
            return 1.0
        strain = max(self._usual_strain(sides) for sides in (self._sides(), self.boundary_edges))
        together = self._magnification_together(TOGETHER * size)
        visible = min(DISPLACED_SHARE * size / largest, LARGEST_STRAIN / max(strain, 1e-300), together)
        return max(float(f"{visible:.1e}"), 1.0)

    def _magnification_together(self, apart: float) -> float:
        """The largest factor w of displacements with which faces that touch are drawn at most `apart` (m) from another.

        Drawn are a jump w d and a face that has turned with the displacements u along it, so that the opening is
        w d.n + w^2 d.n', n' = rot(du/ds): its second part is none of the rock's, and may be as large as the first.
        """
        upper, lower = self._face_pairs
        along, turned = (np.diff(field[upper], axis=1) for field in (self.points, self.displacement))
        jump = self.displacement[lower] - self.displacement[upper]
        length = np.linalg.norm(along, axis=2)
        opening, false = ((jump[..., 0] * t[..., 1] - jump[..., 1] * t[..., 0]) / length for t in (along, turned))
        real, false = np.maximum(opening, 0.0), np.maximum(np.abs(false), 1e-300)
        return float(np.min((real + np.sqrt(real**2 + 4.0 * false * apart)) / (2.0 * false), initial=np.inf))

    def _usual_strain(self, sides: Ints) -> float:
        """Size of the strain along sides of cells, given by their ends (n, 2), that little of their length exceeds."""
        x, u = (values[sides[:, 1]] - values[sides[:, 0]] for values in (self.points, self.displacement))
        squares = (x * x).sum(axis=1)
        kept = squares > 0.0
        strains = np.abs((x * u).sum(axis=1)[kept]) / squares[kept]
        return float(percentiles(strains, np.sqrt(squares[kept]), STRAIN_PERCENTILE)) if len(strains) else 0.0

    def _sides(self) -> Ints:
        """Ends (n, 2) of the sides of all cells, a side of two cells twice, with the cell on its left."""
        sides = np.stack([self.cells, np.roll(self.cells, -1, axis=1)], axis=2).reshape(-1, 2)
        return np.asarray(sides[sides[:, 0] != sides[:, 1]])

    @cached_property
    def boundary_edges(self) -> Ints:
        """Edges (n, 2) that one cell alone has, with rock on their left: the outline and both faces of the cracks."""
        sides = self._sides()
        keys = sides.min(axis=1) * len(self.points) + sides.max(axis=1)
        _, first, counts = np.unique(keys, return_index=True, return_counts=True)
        return np.asarray(sides[first[counts == 1]])

    @cached_property
    def _face_pairs(self) -> tuple[Ints, Ints]:
        """Edges (n, 2) of faces that have others at the same place: those of rock above, and those of rock below."""
        edges = self.boundary_edges
        x, y = np.diff(self.points[edges], axis=1)[:, 0].T
        above = (x > 0.0) | ((x == 0.0) & (y > 0.0))
        edges = np.where(above[:, None], edges, edges[:, ::-1])
        _, place = np.unique(self.points[edges].reshape(-1, 4), axis=0, return_inverse=True)
        _, upper, lower = np.intersect1d(place[above], place[~above], return_indices=True)
        return edges[above][upper], edges[~above][lower]

    def above(self) -> NDArray[np.bool_]:
        """Points (n,) that are nearer to an upper face than to a lower one, through the rock.

        Cells there are drawn last: where a picture has two faces in each other, one side covers the other.
        """
        n, sides = len(self.points), self._sides()
        lengths = np.linalg.norm(np.diff(self.points[sides], axis=1)[:, 0], axis=1)
        ways = csr_array((np.maximum(lengths, 1e-300), sides.T), shape=(n, n))
        upper, lower = map(np.unique, self._face_pairs)
        faces = np.setdiff1d(upper, lower), np.setdiff1d(lower, upper)
        if not (len(faces[0]) and len(faces[1])):
            return np.zeros(n, dtype=bool)
        to_upper, to_lower = (dijkstra(ways, directed=False, indices=face, min_only=True) for face in faces)
        return np.asarray(to_upper < to_lower)

    def off_mean(self) -> Floats:
        """Displacement (n, 2) m less its mean over the specimen."""
        return np.asarray(self.displacement - np.average(self.displacement, axis=0, weights=self.areas(by_point=True)))

    def areas(self, *, by_point: bool) -> Floats:
        """Area m^2 of each cell (c,), or that each point (n,) stands for: equal parts of those of its cells."""
        of_cells = areas_of(self.points, self.cells)
        if not by_point:
            return of_cells
        own = self.cells != np.roll(self.cells, -1, axis=1)  # corners of triangles once
        parts = np.broadcast_to((of_cells / own.sum(axis=1))[:, None], own.shape)
        return np.asarray(np.bincount(self.cells[own], parts[own], len(self.points)), dtype=float)


def areas_of(points: Floats, cells: Ints) -> Floats:
    """Areas (c,) of cells with corners (c, k) among points (n, 2)."""
    x, y = points[cells].transpose(2, 0, 1)
    return np.asarray(0.5 * np.abs(np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)))


def percentiles(values: Floats, weights: Floats, percentiles: float | tuple[float, float]) -> Floats:
    return np.asarray(np.percentile(values, percentiles, weights=weights, method="inverted_cdf"))


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
    points, displacement = (np.asarray(of[:, :2], dtype=float) for of in (grid.points, grid.point_data["displacement"]))
    return DrawnFrame(step, points, cells_of(grid), displacement, values, by_point)


def frame_with_sigma_1(frame: Frame, step: int) -> DrawnFrame:
    """The frame of a run that goes on, with the major principal stress in the plane."""
    sigma_1, _ = principal_stresses(frame.point_stress)
    cells = _cells(frame.triangles, frame.quads)
    return DrawnFrame(step, frame.points, cells, frame.displacement, sigma_1, by_point=True)


def cells_of(grid: pyvista.UnstructuredGrid) -> Ints:
    """Corners (c, 4) of the cells of a frame: triangles first, which have their last one twice, as it is written."""
    by_kind: Any = grid.cells_dict
    triangles, quads = (by_kind.get(kind, np.empty((0, n))) for kind, n in ((VTK_TRIANGLE, 3), (VTK_QUAD, 4)))
    return _cells(triangles, quads)


def _cells(triangles: NDArray[Any], quads: NDArray[Any]) -> Ints:
    return np.concatenate([triangles[:, [0, 1, 2, 2]], quads]).astype(np.int64)


def _fields(grid: pyvista.UnstructuredGrid) -> dict[str, tuple[bool, Floats]]:
    """Whether a field is one of points, and its values: the size of vectors, the components of stress one by one.

    What both points and cells have is taken from the points.
    """
    found: dict[str, tuple[bool, Floats]] = {}
    for by_point, data in ((True, grid.point_data), (False, grid.cell_data)):
        for name, values in by_component(data).items():
            found.setdefault(name, (by_point, values if values.ndim == 1 else np.linalg.norm(values, axis=1)))
    return found


def by_component(data: pyvista.DataSetAttributes) -> dict[str, Floats]:
    """Numbers (n,) or vectors (n, 3) by name, those of stress component by component."""
    fields: dict[str, Floats] = {}
    for name in data:
        values = np.asarray(data[name], dtype=float)
        parts = dict(zip(COMPONENTS, np.ascontiguousarray(values.T), strict=False))
        fields |= parts if name == "stress" else {name: values}
    return fields
