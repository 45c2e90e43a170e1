"""The multifrontal factorization against SuperLU: prints a table, CPU seconds beside residuals.

Plates with many flaws, with one and with none: factorizing the held stiffness, once with all that goes with it, and
solving for the tractions of contact points, as many as are used at most; from nothing, after a tip has grown by one
spacing, and by SuperLU. Medians.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import block_array, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.linear import ConstrainedSystem, SymmetricMatrix
from crackgrow.run.configuration import Configuration, assemble
from crackgrow.run.load_level import LoadLevel
from crackgrow.run.scene import make_scene
from crackgrow.solid.places import boxes_of_functions

Floats = NDArray[np.float64]

ROOT = Path(__file__).parents[2]
RIGHT_HAND_SIDES = 220
LARGEST = "compression30, 0.1 mm"
APART = 3.0  # mm, flaws from each other and from the outline
PLATE = """
title: A plate with flaws under uniaxial compression
units: {{length: mm, stress: MPa}}
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: {size}, height: {size}}}}}
    material: {{young: 10000, poisson: 0.25}}
    strength: {{tension: 0.5, cohesion: 10, friction_angle: 40}}
supports:
  - {{at: [-{half}, -{half}], displacement: {{y: 0}}}}
  - {{at: [{half}, -{half}], displacement: {{y: 0}}}}
  - {{at: [0, -{half}], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: rock, edge: top}}, traction: [0, -100]}}
  - {{on: {{body: rock, edge: bottom}}, traction: [0, 100]}}
numerics: {{spacing: {spacing}}}
"""
FLAW = """
  flaw{number}:
    path: {{points: [[{a[0]}, {a[1]}], [{b[0]}, {b[1]}]]}}
    tips: both
    contact: {{friction: 0.3, cohesion: 0}}"""


def flaws(n: int, size: float, seed: int = 1) -> list[shapely.LineString]:
    """Flaws of 8 to 14 mm in any direction that keep clear of each other and of the outline."""
    rng = np.random.default_rng(seed)
    kept: list[shapely.LineString] = []
    while len(kept) < n:
        length, angle = rng.uniform(8.0, 14.0), rng.uniform(0.0, np.pi)
        middle = rng.uniform(-0.5 * size, 0.5 * size, 2)
        half = 0.5 * length * np.array([np.cos(angle), np.sin(angle)])
        flaw = shapely.LineString([middle - half, middle + half])
        inside = np.abs(shapely.get_coordinates(flaw)).max() <= 0.5 * size - APART
        if inside and all(flaw.distance(other) >= APART for other in kept):
            kept.append(flaw)
    return kept


def plate(n_flaws: int, size: float, spacing: float) -> Case:
    text = PLATE.format(size=size, half=0.5 * size, spacing=spacing)
    for number, flaw in enumerate(flaws(n_flaws, size)):
        a, b = shapely.get_coordinates(flaw).tolist()
        text += ("cracks:" if number == 0 else "") + FLAW.format(number=number, a=a, b=b)
    if n_flaws:
        text += "\n"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plate.yaml"
        path.write_text(text)
        return load_case(path)


def timed(run: Callable[[], object], repetitions: int) -> float:
    """Median CPU seconds."""
    seconds = []
    for _ in range(repetitions):
        start = time.process_time()
        run()
        seconds.append(time.process_time() - start)
    return float(np.median(seconds))


class BySuperLU:
    """The yardstick: K u + C' m = f, C u = 0 with constraints that give way by 1e-7, by SuperLU, unrefined."""

    def __init__(self, matrix: SymmetricMatrix, held: csr_array) -> None:
        size = abs(held) @ matrix.diagonal() / abs(held).sum(axis=1)
        stiffer = matrix.tocsc() + held.T @ diags_array(size) @ held
        whole = csc_array(block_array([[stiffer, held.T], [held, -diags_array(1e-7 / size)]]))
        self._n, self._m = matrix.shape[0], held.shape[0]
        options = {"SymmetricMode": True}
        self._factors = splu(whole, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)

    def solve(self, loads: Floats) -> tuple[Floats, Floats]:
        """Displacements and multipliers."""
        solution = self._factors.solve(np.concatenate([loads, np.zeros((self._m, *loads.shape[1:]))]))
        return solution[: self._n], solution[self._n :]


def cracked(case: Case, advance: float = 0.0) -> tuple[GrowingCrack, ...]:
    """The cracks of a case, the first one with its end moved straight on by `advance` (m)."""
    growing = [GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks]
    if advance:
        crack = case.cracks[0]
        step = np.diff(crack.points[-2:], axis=0)
        points = np.concatenate([crack.points, crack.points[-1:] + advance * step / np.hypot(*step[0])])
        growing[0] = GrowingCrack(replace(crack, points=points), np.append(growing[0].steps, 1))
    return tuple(growing)


def measure(name: str, case: Case, repetitions: int, by_superlu: bool) -> None:
    """Rows of the table: from nothing, after the first crack has grown by a spacing, and by SuperLU."""
    scene = make_scene(case)
    first = assemble(scene, cracked(case))
    rows: list[tuple[str, Configuration, ConstrainedSystem | None]] = [("fronts", first, None)]
    if case.cracks:
        grown = assemble(scene, cracked(case, case.numerics.spacing), first)
        rows.append(("fronts, one tip grown", grown, first.contact.system))
    if by_superlu:
        rows.append(("SuperLU", first, None))
    for how, configuration, known in rows:
        matrix, held = configuration.contact.system.stiffness, configuration.held.matrix
        n_fronts: tuple[object, object] = ("", "")
        make = partial(ConstrainedSystem, matrix, held, boxes_of_functions(configuration.cover), known)
        if how == "SuperLU":
            make = partial(BySuperLU, matrix, held)
        factorize, system = timed(make, repetitions), make()
        if isinstance(system, ConstrainedSystem):
            n_fronts = (system.factorization.n_fronts, system.factorization.n_eliminated)
        loads = tractions(configuration)
        one = timed(partial(system.solve, configuration.loads(LoadLevel(1.0))), repetitions)
        many = timed(partial(system.solve, loads), 1)
        u, multipliers = system.solve(loads)
        residual = np.abs(matrix @ u + held.T @ multipliers - loads).max() / np.abs(loads).max()
        cells = [name, len(loads), how, *n_fronts, f"{factorize:.3f}", f"{one:.3f}"]
        cells += [loads.shape[1], f"{many:.3f}", f"{residual:.0e}"]
        print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def tractions(configuration: Configuration) -> Floats:
    """Loads (n_dofs, k) of tractions at contact points; at random where there are none."""
    contact = configuration.contact
    operators = (contact.gap_of, contact.slip_of)
    some = [np.arange(min(RIGHT_HAND_SIDES // 2, op.shape[0])) for op in operators]
    columns = [(op[rows].T * contact.weights[rows]).toarray() for op, rows in zip(operators, some, strict=True)]
    loads = np.concatenate(columns, axis=1)
    return loads if loads.shape[1] else np.random.default_rng(0).normal(size=(len(loads), RIGHT_HAND_SIDES))


def main() -> None:
    """Print the table of the scenes named on the command line, or of all but the largest."""
    print(
        "| scene | unknowns | by | fronts | factorized | factorize (s) | one load (s) | loads | their solve (s) "
        "| residual |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|")
    compression30 = ROOT / "cases" / "compression30.yaml"
    scenes: dict[str, tuple[Callable[[], Case], int, bool]] = {
        "interface_friction01": (lambda: load_case(ROOT / "cases" / "interface_friction01.yaml"), 15, True),
        "compression30": (lambda: load_case(compression30), 15, True),
        "50 flaws": (lambda: plate(50, 100.0, 2.0), 3, True),
        "compression30, 0.43 mm": (lambda: load_case(compression30, ["numerics.spacing=0.43"]), 3, True),
        "200 x 200": (lambda: plate(0, 400.0, 2.0), 1, True),
        "compression30, 0.2 mm": (lambda: load_case(compression30, ["numerics.spacing=0.2"]), 3, True),
        LARGEST: (lambda: load_case(compression30, ["numerics.spacing=0.1"]), 1, False),
    }
    wanted = sys.argv[1:] or [name for name in scenes if name != LARGEST]
    for name, (make, repetitions, by_superlu) in scenes.items():
        if name in wanted:
            measure(name, make(), repetitions, by_superlu)


if __name__ == "__main__":
    main()
