"""Small bodies and covers that several tests build, handed out as the fixture `build`; symmetric matrices."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import ArrayLike
from scipy.sparse import bsr_array, csc_array, csr_array, tril

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Body, EdgeRegion, EdgeSupport, EdgeTraction, Material, PointSupport, Ring
from crackgrow.case.surface import crack_name
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.refinement import SizeField, refined
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.linear import ConstrainedSystem, SymmetricMatrix
from crackgrow.solid.elasticity import PlaneElasticity, plane_elasticity
from crackgrow.solid.loads import load_vector
from crackgrow.solid.places import boxes_of_functions
from crackgrow.solid.rigid_modes import check_held, free_motions
from crackgrow.solid.stiffness import stiffness
from crackgrow.solid.supports import constraints

Support = PointSupport | EdgeSupport
EDGES = ("bottom", "right", "top", "left")


TESTS = Path(__file__).parent
SOLVING = ("properties", "regression", "stability", "verification", "unit/run")
"""Folders whose tests solve scenes: they are marked `physics`, as others beside them that take more than a second."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of these folders."""
    for item in items:
        if any(item.path.is_relative_to(TESTS / folder) for folder in SOLVING):
            item.add_marker(pytest.mark.physics)


def pytest_configure() -> None:
    """Ctrl-C reaches programs that tests start, also where a script has started the tests in the background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@dataclass(frozen=True, slots=True, eq=False)
class Sample:
    """A rectangular body with cracks, covered: ready to be integrated and solved."""

    lattice: Lattice
    body: Body
    cover: Cover
    material: PlaneElasticity

    @property
    def region(self) -> shapely.Polygon:
        """The body in lattice coordinates."""
        return shapely.Polygon(self.lattice.to_lattice(self.body.outline))

    def stiffness(self, quadrature: int = 3) -> csc_array:
        return whole(stiffness(self.cover, [self.material], quadrature))

    def system(self, supports: Sequence[Support], quadrature: int = 3) -> tuple[ConstrainedSystem, Floats]:
        held = constraints(self.cover, tuple(supports))
        check_held(free_motions(self.cover, held.matrix), np.empty(0, dtype=np.int64))
        matrix = stiffness(self.cover, [self.material], quadrature)
        return ConstrainedSystem(matrix, held.matrix, boxes_of_functions(self.cover)), held.given

    def solve(
        self, supports: Sequence[Support], tractions: dict[str, tuple[float, float]], quadrature: int = 3
    ) -> Floats:
        """Displacement unknowns under tractions by edge name."""
        system, given = self.system(supports, quadrature)
        loads = tuple(EdgeTraction(Build.edge(edge), t) for edge, t in tractions.items())
        return system.solve(load_vector(self.cover, (self.body,), loads, quadrature), given)[0]


class Build:
    """Builders; a crack's points are in metres, or in whole spacings with `cover`."""

    @staticmethod
    def body(lower: ArrayLike, upper: ArrayLike, young: float = 1.0, poisson: float = 0.25) -> Body:
        (x0, y0), (x1, y1) = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
        outline = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        return Body("rock", (Ring(outline, EDGES),), Material(young, poisson), None)

    @staticmethod
    def edge(name: str, low: float = 0.0, high: float = 1.0) -> EdgeRegion:
        """An edge of a rectangle, or the part of it between two fractions of its length, counter-clockwise."""
        return EdgeRegion("rock", name, np.array([EDGES.index(name)]), np.array([[low, high]]))

    @staticmethod
    def crack(
        points: ArrayLike, tips: tuple[bool, bool] = (True, True), name: str = "crack", gathered: bool = False
    ) -> CrackGeometry:
        return CrackGeometry(crack_name(name), np.asarray(points, dtype=float), *tips, gathered=gathered)

    @staticmethod
    def graded(lattice: Lattice, places: ArrayLike, levels: int, rings: float = 2.0) -> Lattice:
        """The lattice with cells of 2^-levels round places (n, 2), lattice coordinates."""
        points = shapely.points(np.asarray(places, dtype=float).reshape(-1, 2))
        sizes, widths = np.full((2, len(points)), [[0.5**levels], [max(rings, lattice.support)]])
        return refined(lattice, SizeField(points, sizes, widths))

    @classmethod
    def sample(
        cls,
        lower: ArrayLike,
        upper: ArrayLike,
        cracks: Sequence[CrackGeometry] = (),
        *,
        spacing: float = 1.0,
        support: float = 1.5,
        young: float = 1.0,
        levels: int = 0,
        places: ArrayLike = (),
        rings: float = 2.0,
    ) -> Sample:
        """A body between two corners (m), with cracks in metres and cells of 2^-levels spacings round `places` (m)."""
        lattice = place_lattice(np.asarray(lower, dtype=float), np.asarray(upper, dtype=float), spacing, support)
        lattice = cls.graded(lattice, lattice.to_lattice(np.asarray(places, dtype=float).reshape(-1, 2)), levels, rings)
        body = cls.body(lower, upper, young)
        inside = [replace(crack, points=lattice.to_lattice(crack.points)) for crack in cracks]
        cover = build_cover(lattice, [BodyGeometry((lattice.to_lattice(body.outline),), body.name)], inside)
        return Sample(lattice, body, cover, plane_elasticity(young, 0.25, "strain"))

    @classmethod
    def block(
        cls,
        size: tuple[int, int],
        cracks: Sequence[CrackGeometry] = (),
        support: float = 1.5,
        levels: int = 0,
        places: ArrayLike = (),
    ) -> Sample:
        """A body of whole spacings from (0.5, 0.5) on, on a lattice whose nodes have whole coordinates.

        Holds for every support: lattice coordinates are those of the block plus the lattice's `reach`.
        """
        upper = (size[0] + 0.5, size[1] + 0.5)
        return cls.sample((0.5, 0.5), upper, cracks, support=support, levels=levels, places=places)

    @classmethod
    def field_of_cracks(cls, n: int, support: float = 2.0) -> Sample:
        """n x n cracks in a square, of random directions: 2 n^2 tips, few of which act on any one place."""
        rng = np.random.default_rng(n)
        cracks = []
        for k, angle in enumerate(rng.uniform(0.0, np.pi, n * n)):
            middle = 4.0 * np.array(divmod(k, n)) + 3.0 + rng.uniform(-0.2, 0.2, 2)
            half = rng.uniform(1.0, 1.3) * np.array([np.cos(angle), np.sin(angle)])
            cracks.append(cls.crack([middle - half, middle + half], name=f"crack {k}"))
        return cls.block((4 * n + 1, 4 * n + 1), cracks, support)


@pytest.fixture(autouse=True)
def no_floating_point_faults() -> Iterator[None]:
    """Overflow, division by zero and invalid operations raise, also where a library would hide their warnings."""
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        yield


@pytest.fixture(scope="session")
def build() -> type[Build]:
    return Build


def symmetric(matrix: Any) -> SymmetricMatrix:
    """A symmetric matrix (2 n, 2 n), dense or sparse, by its lower blocks."""
    dense = matrix.toarray() if hasattr(matrix, "toarray") else np.asarray(matrix)
    n = len(dense) // 2
    row, column = np.tril_indices(n)
    block = dense.reshape(n, 2, n, 2).transpose(0, 2, 1, 3)[row, column]
    kept = (row == column) | (block != 0.0).any(axis=(1, 2))
    return SymmetricMatrix(np.searchsorted(row[kept], np.arange(n + 1)), column[kept], block[kept])


def whole(matrix: SymmetricMatrix) -> csc_array:
    lower = bsr_array((matrix.block, matrix.column, matrix.start), shape=matrix.shape).tocsr()
    total = csc_array(tril(lower) + tril(lower, -1).T)
    total.eliminate_zeros()
    return total


def one_front(n: int) -> tuple[Ints, Ints]:
    """Boxes of n functions that all overlap."""
    alike = np.zeros((n, 2), dtype=np.int64)
    return alike, alike + 1


def dense_system(matrix: Any, constraints: csr_array) -> ConstrainedSystem:
    """A matrix with constraints, factorized in one dense front."""
    return ConstrainedSystem(symmetric(matrix), constraints, one_front(matrix.shape[0] // 2))
