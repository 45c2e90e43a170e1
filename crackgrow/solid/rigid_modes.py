"""Rigid motions: which pieces of rock the supports leave free, and loose springs that hold those until contact does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crackgrow.cover.cover import Cover
from crackgrow.errors import FreePieceError
from crackgrow.geometry.arrangement import connected
from crackgrow.solid.matrix import SymmetricMatrix

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HOLDS_NOTHING = 1e-8
"""Singular values below this, of constraints on the three rigid motions scaled by the piece's size, hold nothing."""

SPRING_STIFFNESS = 1e-3
"""Stiffness of a loose spring, relative to the geometric mean of its piece's and the softest rock's: loose against what
holds the piece, not so loose that it is lost in round-off. The spring ends up without force."""

FULL_PATCH = 0.5
"""Springs hang on patches whose stiffness is at least this part of the piece's median: on no sliver."""


@dataclass(frozen=True, slots=True, eq=False)
class FreePiece:
    """A piece of rock that the supports leave free to move."""

    functions: Ints  # physical patches
    motions: (
        Floats  # (k, 3) orthonormal, its free motions: translation x, y and rotation (1 at `reach` from the centre)
    )
    centre: Floats  # (2,) m
    reach: float  # m

    def __str__(self) -> str:
        """Say which piece it is."""
        return f"the piece of rock round ({self.centre[0]:.3g}, {self.centre[1]:.3g}) m"

    @property
    def motion(self) -> str:
        """Its free motions in words."""
        translations = _null_space(self.motions[:, 2:].T) @ self.motions
        words = (
            ["translation in x", "translation in y"] if len(translations) == 2 else [_along(t) for t in translations]
        )
        if len(translations) < len(self.motions):
            turning = self.motions - self.motions @ translations.T @ translations
            a, b, w = turning[np.argmax(np.abs(turning[:, 2]))]
            x, y = self.centre + self.reach * np.array([-b, a]) / w
            words.append("rotation" if len(translations) else f"rotation about ({x:.3g}, {y:.3g}) m")
        return " and ".join(words)


@dataclass(frozen=True, slots=True, eq=False)
class Springs:
    """Springs to the ground on the coefficients of a few physical patches."""

    dofs: Ints  # (k,)
    stiffness: Floats  # (k,) Pa
    piece: Ints  # (k,) index into the free pieces

    def added_to(self, matrix: SymmetricMatrix) -> SymmetricMatrix:
        """A stiffness matrix (n_dofs, n_dofs) with the springs."""
        return matrix.with_diagonal(self.dofs, self.stiffness)


def free_pieces(cover: Cover, constraints: csr_array) -> tuple[FreePiece, ...]:
    """Pieces that take part in a rigid motion which `constraints` (m, n_dofs) do not see."""
    found = all_pieces(cover)
    free = _free_directions(constraints @ _motions_of(cover, found)).reshape(-1, len(found), 3)
    moving = np.abs(free).max(axis=(0, 2), initial=0.0) > HOLDS_NOTHING
    result = []
    for index in np.flatnonzero(moving).tolist():
        _, sizes, rows = np.linalg.svd(free[:, index], full_matrices=False)
        nodes = cover.patch_nodes[found[index]]
        centre, reach = cover.lattice.to_metres(nodes.mean(axis=0)), cover.lattice.spacing * _reach(nodes)
        result.append(FreePiece(found[index], rows[sizes > HOLDS_NOTHING], centre, reach))
    return tuple(result)


def free_motions(cover: Cover, constraints: csr_array) -> Floats:
    """Unknowns (n_dofs, k) of the rigid motions of pieces that `constraints` (m, n_dofs) do not see."""
    motions = _motions_of(cover, all_pieces(cover))
    return np.asarray(motions @ _free_directions(constraints @ motions).T)


def _motions_of(cover: Cover, pieces: list[Ints]) -> Floats:
    """Unknowns (n_dofs, 3 p) of the rigid motions of p pieces."""
    return np.concatenate([rigid_motions(cover, functions) for functions in pieces], axis=1)


def _free_directions(held: Floats) -> Floats:
    """The combinations (k, n) of n motions that constraints do not see; `held` (m, n) is what they see of each."""
    n = held.shape[1]
    _, values, directions = np.linalg.svd(np.vstack([held, np.zeros((n, n))]), full_matrices=False)
    return np.asarray(directions[values <= HOLDS_NOTHING])


def check_held(pieces: tuple[FreePiece, ...], touching: Ints) -> None:
    """Raise FreePieceError, naming the motion, for free pieces none of whose patches is among `touching` (k,)."""
    for piece in pieces:
        if not np.isin(piece.functions, touching).any():
            raise FreePieceError(f"{piece} is free to move: {piece.motion}", "it needs supports of its own")


def loose_springs(cover: Cover, stiffness: SymmetricMatrix, pieces: tuple[FreePiece, ...]) -> Springs:
    """Two springs in x and two in y on each free piece, on patches far apart."""
    diagonal = stiffness.diagonal()
    softest = min(float(np.median(diagonal[2 * functions])) for functions in all_pieces(cover))
    dofs, piece, strength = [], [], []
    for index, free in enumerate(pieces):
        full = diagonal[2 * free.functions]
        solid = free.functions[full >= FULL_PATCH * np.median(full)]
        nodes = cover.patch_nodes[solid]
        first = int(np.argmax(np.abs(nodes - nodes.mean(axis=0)).sum(axis=1)))
        last = int(np.argmax(np.abs(nodes - nodes[first]).sum(axis=1)))
        ends = solid[np.unique([first, last])]
        dofs.append((2 * ends[:, None] + np.arange(2)).ravel())
        piece.append(np.full(2 * len(ends), index))
        strength.append(np.full(2 * len(ends), SPRING_STIFFNESS * np.sqrt(softest * np.median(full))))
    return Springs(np.concatenate(dofs), np.concatenate(strength), np.concatenate(piece))


def all_pieces(cover: Cover) -> list[Ints]:
    """Physical patches of each piece of rock that no way inside the rock joins to the others."""
    edges, passable = cover.elements.edges, cover.elements.passable
    label = connected(cover.elements.n, edges.left[passable], edges.right[passable])
    found = (np.unique(cover.functions[label == number]) for number in range(label.max(initial=-1) + 1))
    return [patches[patches >= 0] for patches in found]


def rigid_motions(cover: Cover, functions: Ints) -> Floats:
    """Unknowns (n_dofs, 3) of unit translations in x and y and of a rotation (1 at the rim) of physical patches."""
    nodes = cover.patch_nodes[functions]
    arm = (nodes - nodes.mean(axis=0)) / _reach(nodes)
    motions = np.zeros((cover.n_dofs, 3))
    motions[2 * functions, 0] = 1.0
    motions[2 * functions + 1, 1] = 1.0
    motions[2 * functions, 2], motions[2 * functions + 1, 2] = -arm[:, 1], arm[:, 0]
    return motions


def _reach(nodes: Floats) -> float:
    """Spacings from the middle of nodes (n, 2) to the furthest, along an axis."""
    return float(max(np.abs(nodes - nodes.mean(axis=0)).max(), 1.0))


def _along(translation: Floats) -> str:
    """A translation (3,) in words."""
    angle = np.round(np.rad2deg(np.arctan2(translation[1], translation[0])), 6) % 180.0
    if angle in (0.0, 90.0):
        return "translation in y" if angle else "translation in x"
    return f"translation at {angle:.3g} degrees from x"


def _null_space(row: Floats) -> Floats:
    """Orthonormal combinations (n - 1 or n, n) that make a row (1, n) vanish."""
    _, sizes, rows = np.linalg.svd(row, full_matrices=True)
    return np.asarray(rows[int(np.sum(sizes > HOLDS_NOTHING)) :])
