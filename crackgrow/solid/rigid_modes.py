"""Rigid motions: which pieces of rock the supports leave free, and supports that hold these just once.

A piece with just enough supports to keep it where it is (statically determinate ones) is not stressed by them: they
carry what pulls at its rigid motions, and nothing where all that acts on it balances.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr
from scipy.sparse import coo_array, csc_array, csr_array, hstack

from crackgrow.arrays import Floats, Ints
from crackgrow.case.units import place_text
from crackgrow.cover.cover import Cover
from crackgrow.errors import FreePieceError
from crackgrow.geometry.arrangement import connected
from crackgrow.geometry.tolerance import ROUND_OFF
from crackgrow.linear import SymmetricMatrix
from crackgrow.ragged import distinct

HOLDS_NOTHING = 1e-8
"""Singular values below this, of constraints on the three rigid motions scaled by the piece's size, hold nothing."""

FULL_PATCH = 0.5
"""Patches whose stiffness is at least this part of the piece's median are no slivers."""

CORNERS = 8
"""Directions in which supports of a piece are looked for."""


@dataclass(frozen=True, slots=True, eq=False)
class FreePiece:
    """A piece of rock that the supports leave free to move."""

    number: int  # among all pieces
    functions: Ints  # physical patches
    body: str  # name of the body that it is a part of
    whole: bool  # whether it is all of it
    motions: Floats  # (k, 3) orthonormal, free: translation x, y and rotation (1 at `reach` from the centre)
    centre: Floats  # (2,) m, on the map
    reach: float  # m

    def __str__(self) -> str:
        """Say which piece it is."""
        body = f"body '{self.body}'"
        return body if self.whole else f"the piece of {body} round {place_text(self.centre, 3)}"

    @property
    def motion(self) -> str:
        """Its free motions in words."""
        translations = _free_directions(self.motions[:, 2:].T) @ self.motions
        words = (
            ["translation in x", "translation in y"] if len(translations) == 2 else [_along(t) for t in translations]
        )
        if len(translations) < len(self.motions):
            turning = self.motions - self.motions @ translations.T @ translations
            about = self.about(turning[np.argmax(np.abs(turning[:, 2]))])
            words.append("rotation" if len(translations) else f"rotation about {about}")
        return " and ".join(words)

    def about(self, motion: Floats) -> str:
        """The point that stays where it is in a motion (3,) that turns the piece."""
        a, b, w = motion
        still = self.centre + self.reach * np.array([-b, a]) / w
        return place_text(self.reach * np.round(still / self.reach, 6), 3)


@dataclass(frozen=True, slots=True, eq=False)
class RigidMotions:
    """The l rigid motions, of one piece or of several together, that constraints do not see."""

    pieces: tuple[FreePiece, ...]  # that take part
    nodes: Floats  # (n_patches, 2) of all physical patches
    of_pieces: csr_array  # (n_dofs, 3 p) unknowns of the motions of all pieces, each by itself
    free: Floats  # (l, 3 p) orthonormal: those that are free
    dofs: Ints  # (l,) unknowns that supports hold
    stiffness: Floats  # (l,) Pa, of these supports

    def together(self) -> Ints:
        """Which of `pieces` move together: for each (k,) the number of its group.

        The projection on all free motions couples two pieces only where some constraint ties them.
        """
        own = 3 * np.array([piece.number for piece in self.pieces], dtype=np.int64)[:, None] + np.arange(3)
        mine = self.free[:, own.ravel()]
        shared = np.abs(mine.T @ mine).reshape(len(own), 3, len(own), 3).max(axis=(1, 3), initial=0.0)
        return connected(len(own), *np.nonzero(shared > HOLDS_NOTHING))

    def displacements(self, amplitudes: Floats) -> Floats:
        """Unknowns (n_dofs,) or (n_dofs, k) of motions by `amplitudes` (l,) or (l, k) m."""
        return np.asarray(self.of_pieces @ (self.free.T @ amplitudes))

    def along(self, loads: Floats) -> Floats:
        """What `loads` (n_dofs,) do on each motion, (l,) N/m.

        It is nothing where it is the round-off of its terms: the sign of that, for loads that balance by themselves,
        would press a piece on its contact, or pull it off.
        """
        along = self.free @ (self.of_pieces.T @ loads)
        terms = np.abs(self.free) @ (abs(self.of_pieces).T @ np.abs(loads))
        return np.where(np.abs(along) > ROUND_OFF * terms, along, 0.0)

    def of_piece(self, piece: FreePiece, amplitudes: Floats) -> Floats:
        """Translation in x and y and rotation (3,) of one piece in motions by `amplitudes` (l,)."""
        return np.asarray((amplitudes @ self.free)[3 * piece.number : 3 * piece.number + 3])

    def seen_by(self, operator: csr_array) -> Floats:
        """What an operator (m, n_dofs) makes of each motion, (m, l)."""
        return np.asarray((operator @ self.of_pieces).toarray() @ self.free.T)

    def carrying(self, amplitudes: Floats) -> Floats:
        """Loads (n_dofs,) or (n_dofs, k) that move the supports with motions by `amplitudes` (l,) or (l, k) m."""
        moved = self.displacements(amplitudes)
        loads = np.zeros(moved.shape)
        loads[self.dofs] = (self.stiffness * moved[self.dofs].T).T
        return loads

    def held_once(self, stiffness: SymmetricMatrix) -> RigidMotions:
        """The motions with as many supports as there are of them.

        They are as stiff as the patches that they hold: those that tell the motions best from each other, by a QR
        factorization with pivots, stiff patches before slivers.
        """
        diagonal = stiffness.diagonal()
        angles = 2.0 * np.pi / CORNERS * np.arange(CORNERS)
        directions = np.stack([np.cos(angles), np.sin(angles)])
        candidates, share = [], []
        for piece in self.pieces:
            functions = piece.functions
            full = np.minimum(diagonal[2 * functions] / np.median(diagonal[2 * functions]), 1.0)
            solid = functions[full >= FULL_PATCH]
            farthest = [some[np.argmax(self.nodes[some] @ directions, axis=0)] for some in (solid, functions)]
            ends = np.unique(np.concatenate(farthest))
            candidates.append((2 * ends[:, None] + np.arange(2)).ravel())
            share.append(np.repeat(np.sqrt(full[np.searchsorted(functions, ends)]), 2))
        dofs = np.concatenate(candidates)
        motions = (self.of_pieces[dofs] @ self.free.T) * np.concatenate(share)[:, None]
        _, pivots = qr(motions.T, mode="r", pivoting=True)
        chosen = dofs[np.sort(pivots[: len(self.free)])]
        return replace(self, dofs=chosen, stiffness=diagonal[chosen])


def free_motions(cover: Cover, constraints: csr_array) -> RigidMotions:
    """The rigid motions of pieces that `constraints` (m, n_dofs) do not see."""
    found, elements = _pieces(cover)
    of_pieces = csr_array(hstack([rigid_motions(cover, functions) for functions in found], format="csr"))
    free = _free_directions((constraints @ of_pieces).toarray())
    by_piece = free.reshape(-1, len(found), 3)
    moving = np.abs(by_piece).max(axis=(0, 2), initial=0.0) > HOLDS_NOTHING
    body = cover.elements.body[[some[0] for some in elements]]
    pieces = []
    for index in np.flatnonzero(moving).tolist():
        _, sizes, rows = np.linalg.svd(by_piece[:, index], full_matrices=False)
        nodes = cover.patches.nodes[found[index]]
        centre, reach = cover.lattice.to_map(nodes.mean(axis=0)), cover.lattice.spacing * _reach(nodes)
        name, whole = cover.bodies[body[index]].name, int(np.sum(body == body[index])) == 1
        pieces.append(FreePiece(index, found[index], name, whole, rows[sizes > HOLDS_NOTHING], centre, reach))
    return RigidMotions(tuple(pieces), cover.patches.nodes, of_pieces, free, np.empty(0, dtype=np.int64), np.empty(0))


def _free_directions(held: Floats) -> Floats:
    """Orthonormal combinations (k, n) of n motions that constraints, which see `held` (m, n) of each, do not see."""
    n = held.shape[1]
    _, values, directions = np.linalg.svd(np.vstack([held, np.zeros((n, n))]), full_matrices=False)
    return np.asarray(directions[values <= HOLDS_NOTHING])


def check_held(motions: RigidMotions, touching: Ints) -> None:
    """Raise FreePieceError, naming the motion, for a free piece that nothing touches.

    `touching` (k,) are the patches at contact points. Pieces that only move together, as those that are bonded to each
    other do, are held by what touches any of them.
    """
    touched = np.array([np.isin(piece.functions, touching).any() for piece in motions.pieces], dtype=bool)
    group = motions.together()
    held = np.isin(group, group[touched])
    for piece in (piece for piece, is_held in zip(motions.pieces, held.tolist(), strict=True) if not is_held):
        raise FreePieceError(f"{piece} is free to move: {piece.motion}", "it needs supports of its own")


def check_not_seen(motions: RigidMotions, volumes: csr_array) -> None:
    """Raise FreePieceError for a free piece that moves against a volume of fluid: rows (k, n_dofs) of mean openings."""
    seen = np.abs(motions.seen_by(volumes)).max(axis=0, initial=0.0) > HOLDS_NOTHING
    for piece in motions.pieces:
        own = motions.free[:, 3 * piece.number : 3 * piece.number + 3]
        if np.abs(own[seen]).max(initial=0.0) > HOLDS_NOTHING:
            raise FreePieceError(f"{piece} is held by a volume of fluid", "it needs supports of its own, or a pressure")


def all_pieces(cover: Cover) -> list[Ints]:
    """Physical patches of each piece of rock that no way inside the rock joins to the others."""
    return _pieces(cover)[0]


def _pieces(cover: Cover) -> tuple[list[Ints], list[Ints]]:
    """Physical patches, and elements, of each piece."""
    edges, passable = cover.elements.edges, cover.elements.passable
    label = connected(cover.elements.n, edges.left[passable], edges.right[passable])
    order = np.argsort(label, kind="stable")
    elements = np.split(order, np.cumsum(np.bincount(label))[:-1])
    return [distinct(cover.patches.of_element.taken(some).values) for some in elements], elements


def rigid_motions(cover: Cover, functions: Ints) -> csc_array:
    """Unknowns (n_dofs, 3) of unit translations in x and y and of a rotation (1 at the rim) of physical patches."""
    nodes = cover.patches.nodes[functions]
    arm = (nodes - nodes.mean(axis=0)) / _reach(nodes)
    x, y, one = 2 * functions, 2 * functions + 1, np.ones(len(functions))
    motions = coo_array(
        (
            np.concatenate([one, one, -arm[:, 1], arm[:, 0]]),
            (np.concatenate([x, y, x, y]), np.repeat([0, 1, 2, 2], len(functions))),
        ),
        shape=(cover.n_dofs, 3),
    )
    return csc_array(motions)


def _reach(nodes: Floats) -> float:
    """Spacings from the middle of nodes (n, 2) to the furthest, along an axis."""
    return float(max(np.abs(nodes - nodes.mean(axis=0)).max(), 1.0))


def _along(translation: Floats) -> str:
    """A translation (3,) in words."""
    angle = np.round(np.rad2deg(np.arctan2(translation[1], translation[0])), 6) % 180.0
    if angle in (0.0, 90.0):
        return "translation in y" if angle else "translation in x"
    return f"translation at {angle:.3g} degrees from x"
