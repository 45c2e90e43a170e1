"""The multifrontal factorization against SuperLU: prints a table, CPU seconds beside residuals.

Plates with many flaws, with one and with none: factorizing the held stiffness, once with all that goes with it, and
solving for the tractions of contact points, as many as are used at most. Medians; the second row of a scene is SuperLU.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import shapely

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import assemble
from crackgrow.run.scene import make_scene
from crackgrow.solid.dissection import places_of_unknowns
from crackgrow.solid.linear_solver import ConstrainedSystem

ROOT = Path(__file__).parents[2]
RIGHT_HAND_SIDES = 220
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


def measure(name: str, case: Case, repetitions: int) -> None:
    """Two rows of the table."""
    growing = tuple(GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks)
    configuration = assemble(make_scene(case), growing)
    matrix, held = configuration.matrix, configuration.held.matrix
    contact = configuration.contact
    operators = [np.arange(min(RIGHT_HAND_SIDES // 2, op.shape[0])) for op in (contact.gap_of, contact.slip_of)]
    columns = [
        (op[rows].T * contact.weights[rows]).toarray()
        for op, rows in zip((contact.gap_of, contact.slip_of), operators, strict=True)
    ]
    loads = np.concatenate(columns, axis=1)
    if not loads.shape[1]:
        loads = np.random.default_rng(0).normal(size=(len(loads), RIGHT_HAND_SIDES))
    for places in (places_of_unknowns(configuration.cover), None):
        factorize = timed(lambda places=places: ConstrainedSystem(matrix, held, places), repetitions)
        system = ConstrainedSystem(matrix, held, places)
        one = timed(lambda system=system: system.solve(configuration.loads(1.0)), repetitions)
        many = timed(lambda system=system: system.solve(loads), repetitions)
        u, multipliers = system.solve(loads)
        residual = np.abs(matrix @ u + held.T @ multipliers - loads).max() / np.abs(loads).max()
        cells = [name, len(loads), f"{matrix.nnz / 1e6:.1f}", "SuperLU" if places is None else "fronts"]
        cells += [f"{factorize:.3f}", f"{one:.3f}", loads.shape[1], f"{many:.3f}", f"{residual:.0e}"]
        print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def main() -> None:
    """Print the table of the scenes named on the command line, or of all."""
    print(
        "| scene | unknowns | entries (1e6) | by | factorize (s) | one load (s) | loads | their solve (s) | residual |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    scenes: dict[str, tuple[Callable[[], Case], int]] = {
        "interface_friction01": (lambda: load_case(ROOT / "cases" / "interface_friction01.yaml"), 15),
        "compression30": (lambda: load_case(ROOT / "cases" / "compression30.yaml"), 15),
        "50 flaws": (lambda: plate(50, 100.0, 2.0), 3),
        "200 x 200": (lambda: plate(0, 400.0, 2.0), 1),
    }
    for name, (make, repetitions) in scenes.items():
        if name in (sys.argv[1:] or scenes):
            measure(name, make(), repetitions)


if __name__ == "__main__":
    main()
