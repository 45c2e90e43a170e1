"""A body without enough supports: which motion is free is named, wherever its lattice lies."""

from __future__ import annotations

import re

import numpy as np
import pytest

from crackgrow.case.model import EdgeSupport, EdgeTraction, PointSupport
from crackgrow.errors import FreePieceError
from crackgrow.solid.loads import load_vector
from crackgrow.solid.rigid_modes import free_motions
from crackgrow.solid.supports import constraints
from tests.conftest import Build, Sample

LOWER, UPPER = (2.0, 1.0), (8.0, 6.0)
FREE, HELD = None, 0.0


def body(build: type[Build], size: float = 1.0) -> Sample:
    return build.sample(np.multiply(LOWER, size), np.multiply(UPPER, size), spacing=size)


def at(x: float, y: float, displacement: tuple[float | None, float | None]) -> PointSupport:
    return PointSupport("rock", np.array([x, y]), displacement)


@pytest.mark.parametrize(
    ("supports", "motion"),
    [
        ([], "translation in x and translation in y and rotation"),
        ([at(3.0, 2.0, (HELD, FREE)), at(3.0, 5.0, (HELD, FREE))], "translation in y"),
        ([at(3.0, 2.0, (FREE, HELD)), at(7.0, 2.0, (FREE, HELD))], "translation in x"),
        ([at(3.0, 2.0, (HELD, HELD))], r"rotation about \(3 m, 2 m\)"),
        ([at(3.0, 2.0, (HELD, FREE)), at(7.0, 5.5, (FREE, HELD))], r"rotation about \(7 m, 2 m\)"),
        ([at(3.0, 2.0, (HELD, FREE))], "translation in y and rotation"),
    ],
)
def test_free_motions_are_named(build: type[Build], supports: list[PointSupport], motion: str) -> None:
    with pytest.raises(FreePieceError, match=f"is free to move: {motion}; it needs supports of its own"):
        body(build).system(supports)


@pytest.mark.parametrize(("size", "place"), [(1e-6, "(3 um, 2 um)"), (1.0, "(3 m, 2 m)"), (1e4, "(3e+04 m, 2e+04 m)")])
def test_free_motion_does_not_depend_on_the_unit_of_length(build: type[Build], size: float, place: str) -> None:
    with pytest.raises(FreePieceError, match=re.escape(f"rotation about {place}")):
        body(build, size).system([at(3.0 * size, 2.0 * size, (HELD, HELD))])


def test_held_body_has_no_free_motion(build: type[Build]) -> None:
    body(build).system([EdgeSupport(build.edge("bottom"), (0.0, 0.0))])
    body(build).system([at(3.0, 2.0, (HELD, HELD)), at(7.0, 2.0, (FREE, HELD))])


def test_piece_that_cracks_cut_off_is_named_with_its_place(build: type[Build]) -> None:
    """A crack right through leaves the upper part without supports."""
    cut = build.crack([(LOWER[0], 4.2), (UPPER[0], 4.2)], tips=(False, False))
    sample = build.sample(LOWER, UPPER, [cut])
    piece = r"the piece of body 'rock' round \(5 m, 5.* m\)"
    with pytest.raises(FreePieceError, match=f"{piece} is free to move: translation in x and translation in y and rot"):
        sample.system([EdgeSupport(build.edge("bottom"), (0.0, 0.0))])


def test_loads_that_balance_by_themselves_pull_at_no_motion(build: type[Build]) -> None:
    """Tractions of a uniform stress sum to nothing but for round-off, whose sign would press a piece on its contact."""
    sample = body(build)
    free = free_motions(sample.cover, constraints(sample.cover, ()).matrix)
    tractions = {"bottom": (-0.3, 1.0), "top": (0.3, -1.0), "left": (2.0, -0.3), "right": (-2.0, 0.3)}

    def pull(some: dict[str, tuple[float, float]]) -> np.ndarray:
        loads = tuple(EdgeTraction(build.edge(edge), traction) for edge, traction in some.items())
        return free.along(load_vector(sample.cover, (sample.body,), loads, 3))

    assert not pull(tractions).any()
    tractions["top"] = (0.3, -1.0 - 1e-9)
    assert pull(tractions).any()
