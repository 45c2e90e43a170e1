"""The cover of a step: made from nothing, and from the cover before. Prints a table.

CPU milliseconds of one core, medians; run it with one thread. The flaw of `compression30` grows along a path with
kinks, 2 mm a step at both tips; of the 50 flaws of `random_flaws` one tip grows straight on.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from crackgrow.case import load_case
from crackgrow.case.surface import crack_name
from crackgrow.cover.cover import Cover, build_cover
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.run.scene import Scene, make_scene

CASES = Path(__file__).parents[2] / "cases"
TURNS = (60.0, 78.0, 84.0, 87.0, 86.0, 88.0)
"""Degrees from the x axis: directions of the steps of a wing, about those of the case itself."""
STEP = 2e-3  # m


def wings(scene: Scene) -> list[list[CrackGeometry]]:
    """The flaw of a scene, in lattice coordinates, after 0, 1, 2, ... steps."""
    points = scene.case.cracks[0].points
    sign = np.sign(points[-1, 0] - points[0, 0])
    found = []
    for n in range(len(TURNS) + 1):
        angles = np.deg2rad(TURNS[:n])
        wing = STEP * np.cumsum(np.stack([sign * np.cos(angles), np.sin(angles)], axis=1), axis=0)
        path = np.concatenate([(points[0] - wing)[::-1], points, points[-1] + wing])
        found.append([CrackGeometry(crack_name("flaw"), scene.lattice.to_lattice(path), True, True)])
    return found


def one_of_many(scene: Scene) -> list[list[CrackGeometry]]:
    """The flaws of a scene, of which the first grows by a quarter of a step at one tip."""
    paths = [scene.lattice.to_lattice(crack.points) for crack in scene.case.cracks]
    along = paths[0][-1] - paths[0][-2]
    along *= 0.25 * STEP / scene.lattice.spacing / np.hypot(*along)
    first = [np.vstack([paths[0], *(paths[0][-1] + (k + 1) * along for k in range(n))]) for n in range(5)]
    return [
        [CrackGeometry(crack_name(str(k)), path, True, True) for k, path in enumerate([grown, *paths[1:]])]
        for grown in first
    ]


def row(name: str, spacing: str, repeats: int) -> str:
    """Unknowns, elements, and the times of a scene."""
    scene = make_scene(load_case(CASES / f"{name}.yaml", [f"numerics.spacing={spacing}"]))
    cracks = one_of_many(scene) if len(scene.case.cracks) > 1 else wings(scene)
    alone, after = [], []
    for _ in range(repeats):
        before: Cover | None = None
        for configuration in cracks:
            for known, times in ((None, alone), (before, after)):
                start = time.process_time()
                cover = build_cover(scene.lattice, scene.bodies, configuration, scene.interfaces, before=known)
                if known is not None or times is alone:
                    times.append(1e3 * (time.process_time() - start))
            before = cover
    return (
        f"| {name} | {spacing} | {cover.n_dofs} | {cover.elements.n - cover.elements.n_whole} of {cover.elements.n} | "
        f"{np.median(alone):.1f} | {np.median(after):.1f} |"
    )


def main() -> None:
    """Print the table."""
    print("| scene | spacing (mm) | unknowns | polygons of elements | from nothing (ms) | from the one before (ms) |")
    print("|---|---|---|---|---|---|")
    for spacing, repeats in (("3", 20), ("1.5", 20), ("0.5", 10), ("0.2", 4)):
        print(row("compression30", spacing, repeats))
    print(row("random_flaws", "2", 5))


if __name__ == "__main__":
    main()
