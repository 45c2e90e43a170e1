"""Integration with and without gradients that satisfy the divergence theorem: prints a table, errors beside seconds.

Patch tests: the largest error of displacement under a uniform stress. Closed crack: compression30 against its
references. The `mirror` column is what a mirrored scene, whose polygons fall into other triangles, differs by: the
error of the stiffness itself. Without the correction, rims are one point per element and cost nothing.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
TESTS = HERE.parent
sys.path[:0] = [str(TESTS), str(TESTS / "properties"), str(TESTS / "verification")]

import conftest  # noqa: E402
import test_closed_crack as closed  # noqa: E402
import test_properties_invariance as invariance  # noqa: E402
import test_properties_patch_test as patch  # noqa: E402

from crackgrow.case import load_case  # noqa: E402
from crackgrow.cover.elements import locate  # noqa: E402
from crackgrow.fracture.advance import GrowingCrack  # noqa: E402
from crackgrow.quadrature.rims import RimPoints  # noqa: E402
from crackgrow.run.judging import StepSolution  # noqa: E402
from crackgrow.run.scene import make_scene  # noqa: E402
from crackgrow.solid import clusters, element_products, stiffness  # noqa: E402
from crackgrow.solid.recovery import displacement_at  # noqa: E402
from tests.solving import solve_step  # noqa: E402

BUILD = conftest.Build
REPETITIONS = 5
ALONG = (1e-3, 0.0, 0.0)


@contextmanager
def correction(on: bool) -> Iterator[None]:
    """Integrate with the correction or without."""
    if on:
        yield
        return
    kept = element_products.consistent, clusters.rim_points
    element_products.consistent = stiffness.consistent = lambda gradients, *_: gradients
    clusters.rim_points = _no_rims
    try:
        yield
    finally:
        element_products.consistent, clusters.rim_points = kept
        stiffness.consistent = kept[0]


def _no_rims(cover) -> RimPoints:
    element = np.flatnonzero(~cover.plain)
    return RimPoints(cover.elements.reference[element], np.zeros((len(element), 2)), element)


def solved(spacing: float, n: int, friction: float, angle: float = 30.0) -> StepSolution:
    settings = (
        f"cracks.flaw.contact.friction={friction}",
        f"cracks.flaw.path.angle={angle}",
        f"numerics.spacing={spacing}",
        f"numerics.quadrature={n}",
    )
    case = load_case(closed.ROOT / "cases" / "compression30.yaml", settings)
    growing = tuple(GrowingCrack(crack, np.zeros(len(crack.points), dtype=np.int64)) for crack in case.cracks)
    return solve_step(make_scene(case), growing, 1.0)


def stuck(spacing: float, n: int) -> float:
    """Error of the displacement of the intact plate, through a crack that sticks."""
    solution = solved(spacing, n, 0.6)
    metres = np.random.default_rng(1).uniform((-15.4e-3, -27.4e-3), (15.4e-3, 27.4e-3), (800, 2))
    points = solution.cover.lattice.to_lattice(metres)
    elements = locate(solution.cover.lattice, solution.cover.elements, points)
    found = displacement_at(solution.cover, solution.outcome.u, points, elements)
    strain_yy, strain_xx = -100e6 / closed.YOUNG_PRIME, 100e6 * 0.25 * 1.25 / 1e10
    exact = np.stack([strain_xx * metres[:, 0], strain_yy * (metres[:, 1] + 27.5e-3)], axis=1)
    return float(np.abs(found - exact).max() / np.abs(exact).max())


def slip_and_pressure(spacing: float, n: int, friction: float) -> tuple[float, float]:
    """Relative errors of K_II from the slip at the middle, and of the pressure more than a spacing from the tips."""
    solution = solved(spacing, n, friction)
    slip = abs(closed.slip_at_middle(solution))
    K_II = slip * closed.YOUNG_PRIME / 4.0 * np.sqrt(np.pi / closed.HALF_LENGTH)
    name = "0" if friction == 0.0 else f"{friction}"
    table = np.genfromtxt(
        closed.REFERENCES / f"closed_crack_theta30_friction{name}.csv", delimiter=",", names=True, encoding="utf-8"
    )
    s = solution.faces.s * solution.cover.lattice.spacing - closed.HALF_LENGTH
    away = np.abs(s) < closed.HALF_LENGTH - solution.cover.lattice.spacing
    pressure = np.interp(s[away], table["s_mm"] * 1e-3, table["normal_pressure_MPa"] * 1e6)
    error = np.abs(-solution.outcome.points.normal[away] / pressure - 1.0).max()
    return K_II / closed.reference_K_II(friction) - 1.0, float(error)


def seconds(spacing: float, n: int) -> tuple[float, float]:
    """Median CPU seconds of the stiffness and of the whole step."""
    case = load_case(
        closed.ROOT / "cases" / "compression30.yaml", (f"numerics.spacing={spacing}", f"numerics.quadrature={n}")
    )
    scene = make_scene(case)
    growing = (GrowingCrack(case.cracks[0], np.zeros(2, dtype=np.int64)),)
    cover = solve_step(scene, growing, 1.0).cover

    def median(work: Callable[[], object]) -> float:
        taken = []
        for _ in range(REPETITIONS):
            start = time.process_time()
            work()
            taken.append(time.process_time() - start)
        return float(np.median(taken))

    return (
        median(lambda: stiffness.stiffness(cover, scene.materials, n)),
        median(lambda: solve_step(scene, growing, 1.0)),
    )


def mirror_error(n: int) -> float:
    """Largest difference of displacement between a cracked block and its mirror image."""
    kept = conftest.Sample.solve
    conftest.Sample.solve = lambda sample, supports, tractions: kept(sample, supports, tractions, n)
    try:
        reference = invariance.solution(BUILD)[0]
        mirrored = invariance.solution(BUILD, mirror=(-1.0, 1.0))[0]
    finally:
        conftest.Sample.solve = kept
    return float(np.abs(mirrored - reference).max() / np.abs(reference).max())


def patch_errors(n: int) -> list[float]:
    """Uncut block at support 2.5, long crack, and short crack at support 2."""
    uncut, long = BUILD.block((6, 5), support=2.5), BUILD.block((14, 9), [BUILD.crack(patch.LONG)], 2.0)
    short = BUILD.block((6, 5), [BUILD.crack(patch.SHORT)], 2.0)
    return [
        patch.errors(uncut, (6, 5), n, (1e-3, 5e-4, 7e-4))[0],
        patch.errors(long, (14, 9), n, ALONG)[0],
        patch.errors(short, (6, 5), n, ALONG)[0],
    ]


def main() -> None:
    """Print both tables in Markdown."""
    print("| n | corrected | uncut | long crack | short crack | mirror |\n|" + "---|" * 6)
    for n in (2, 3, 4, 5):
        for on in (False, True):
            with correction(on):
                errors = [*patch_errors(n), mirror_error(n)]
            print(f"| {n} | {'yes' if on else 'no'} | " + " | ".join(f"{e:.0e}" for e in errors) + " |", flush=True)
    print()
    names = ("stuck crack", "K_II", "K_II, 0.3", "pressure", "stiffness (ms)", "step (ms)")
    print("| spacing (mm) | n | corrected | " + " | ".join(names) + " |\n|" + "---|" * 9)
    for spacing in (3.0, 1.5, 0.75):
        for n in (2, 3, 4, 5):
            for on in (False, True):
                with correction(on):
                    slip, pressure = slip_and_pressure(spacing, n, 0.0)
                    rough, _ = slip_and_pressure(spacing, n, 0.3)
                    assembly, step = seconds(spacing, n)
                    through = stuck(spacing, n)
                row = (
                    f"{through:.0e} | {100 * slip:.3f} % | {100 * rough:.3f} % | {100 * pressure:.2f} % | "
                    f"{1e3 * assembly:.0f} | {1e3 * step:.0f}"
                )
                print(f"| {spacing:g} | {n} | {'yes' if on else 'no'} | {row} |", flush=True)


if __name__ == "__main__":
    main()
