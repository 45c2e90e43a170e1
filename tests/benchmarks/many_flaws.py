"""Cost of a configuration with many flaws, and of the next one after a tip has grown: prints a table.

CPU seconds of one core in one process. The factorization is left out: the tips are judged under a made-up displacement.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.fracture.advance import GrowingCrack, Way, advanced
from crackgrow.fracture.face_displacements import from_face_displacements
from crackgrow.fracture.sites import tip_site
from crackgrow.run.layout import crack_geometry
from crackgrow.run.scene import Scene, make_scene
from crackgrow.solid.stiffness import stiffness_after
from tests.benchmarks.flaw_field import kept_apart
from tests.near_tips import interaction_integrals, site_fields

SIDE = 100.0  # mm
APART = 3.0  # mm


def flaws(n: int) -> list[dict[str, Any]]:
    """Random flaws of 8 to 14 mm that keep apart from each other and from the outline."""
    rng = np.random.default_rng(0)

    def draw() -> dict[str, Any]:
        length, angle, centre = rng.uniform(8, 14), rng.uniform(0, 180), rng.uniform(-SIDE / 2, SIDE / 2, 2)
        return {"center": centre.tolist(), "length": length, "angle": angle}

    return kept_apart(draw, n, SIDE / 2 - APART, APART)


def plate(n: int) -> Case:
    """A plate with n flaws under uniaxial compression."""
    half = SIDE / 2
    document = {
        "title": f"{n} flaws",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": SIDE, "height": SIDE}},
                "material": {"young": 10000, "poisson": 0.25},
                "strength": {"tension": 0.5, "cohesion": 10, "friction_angle": 40},
            }
        },
        "cracks": {
            f"flaw{k}": {"path": path, "contact": {"friction": 0.3, "cohesion": 0}} for k, path in enumerate(flaws(n))
        },
        "supports": [
            {"at": [-half, -half], "displacement": {"y": 0}},
            {"at": [half, -half], "displacement": {"y": 0}},
            {"at": [0, -half], "displacement": {"x": 0}},
        ],
        "loads": [{"on": {"body": "rock", "edge": "top"}, "traction": [0, -100]}],
        "growth": {
            "steps": 1,
            "increment": 2,
            "advance": "most_critical",
            "criterion": "directional_strength",
            "tip_stress": {"radius": 1},
        },
        "numerics": {"spacing": 2},
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "plate.yaml"
        file.write_text(yaml.safe_dump(document))
        return load_case(file)


def covered(scene: Scene, cracks: Sequence[GrowingCrack]) -> Cover:
    """The cover of a configuration."""
    lines = [crack_geometry(scene, crack, body) for crack, body in zip(cracks, scene.crack_bodies, strict=True)]
    return build_cover(scene.lattice, scene.bodies, lines)


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """CPU seconds, and what came of it."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def judged(scene: Scene, cover: Cover) -> None:
    """What a criterion needs of all tips, under a made-up displacement of open cracks."""
    u = np.random.default_rng(1).normal(size=cover.n_dofs)
    tips = range(len(cover.tips))
    nothing = [lambda s: (np.zeros(len(s)), np.zeros(len(s)))] * len(tips)
    from_face_displacements(cover, [scene.materials[0].young_prime] * len(tips), u, tips)
    interaction_integrals(cover, scene.materials, u, tips, nothing)
    site_fields(cover, scene.materials, u, [tip_site(cover.tips[tip]) for tip in tips], 1e-3)


def main() -> None:
    """Measure and print."""
    print("| flaws | unknowns | cover | stiffness | after one tip | integrated again | criterion, per tip (ms) |")
    print("|---|---|---|---|---|---|---|")
    for n in (10, 25, 50):
        scene = make_scene(plate(n))
        cracks = [GrowingCrack(crack, np.zeros(2, dtype=np.int64)) for crack in scene.case.cracks]
        cover_seconds, cover = timed(lambda: covered(scene, cracks))  # noqa: B023
        first_seconds, first = timed(lambda: stiffness_after(cover, scene.materials, 4))  # noqa: B023
        judged_seconds, _ = timed(lambda: judged(scene, cover))  # noqa: B023
        others = cracks[1:]
        cracks[0], _ = advanced(cracks[0], True, Way(0.6, 2e-3), 1, scene.regions[0], others)
        grown = covered(scene, cracks)
        later_seconds, later = timed(
            lambda: stiffness_after(grown, scene.materials, 4, first)  # noqa: B023
        )
        print(
            f"| {n} | {cover.n_dofs} | {cover_seconds:.2f} | {first_seconds:.2f} | {later_seconds:.2f} "
            f"| {later.n_integrated} of {len(later.clusters)} clusters | {1e3 * judged_seconds / (2 * n):.1f} |"
        )


if __name__ == "__main__":
    main()
