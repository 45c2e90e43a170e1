"""The jump operator: gap and slip of contact points as linear functions of the unknowns, paper eq. (4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, hstack

from crackgrow.approximation.basis import value_matrix, values_at
from crackgrow.contact.faces import ContactFaces, FacePoints
from crackgrow.cover.cover import Cover

Floats = NDArray[np.float64]


def jump_matrix(cover: Cover, points: FacePoints) -> csr_array:
    """Scalar jump (n, n_functions): value on the plus face minus value on the minus face, zero on a foundation."""
    plus = value_matrix(values_at(cover, points.points, points.plus), cover.n_functions)
    rock = points.minus >= 0
    minus = value_matrix(values_at(cover, points.points[rock], points.minus[rock]), cover.n_functions)
    number = csr_array((np.ones(rock.sum()), (np.flatnonzero(rock), np.arange(rock.sum()))), (len(rock), rock.sum()))
    return csr_array(plus - number @ minus)


def gap_and_slip(cover: Cover, points: FacePoints, u: Floats) -> tuple[Floats, Floats]:
    """Gap (n,) and slip (n,), m, at points: the jump along the normal and along the surface; `u` (n_dofs,)."""
    jump = jump_matrix(cover, points) @ u.reshape(-1, 2)
    nx, ny = points.normal.T
    return jump[:, 0] * nx + jump[:, 1] * ny, jump[:, 0] * ny - jump[:, 1] * nx


def contact_operators(cover: Cover, faces: ContactFaces) -> tuple[csr_array, csr_array]:
    """Matrices (contact points, n_dofs) that give the average gap and the average slip, m, of every contact point."""
    jump = jump_matrix(cover, faces.points)
    average = csr_array(diags_array(1.0 / faces.weights) @ faces.functions @ diags_array(faces.lengths))
    nx, ny = faces.points.normal.T
    along_x, along_y = (csr_array(average @ diags_array(n) @ jump) for n in (nx, ny))
    return _interleaved(along_x, along_y), _interleaved(along_y, csr_array(-along_x))


def _interleaved(x: csr_array, y: csr_array) -> csr_array:
    """One matrix (m, 2 n) for displacements from those of the x and y components (m, n)."""
    n = x.shape[1]
    order = np.arange(2 * n).reshape(2, n).T.ravel()  # column k of x goes to 2 k, of y to 2 k + 1
    return csr_array(csr_array(hstack([x, y], format="csc")[:, order]))
