"""Fields without a tip: patch tests, Kirsch's plate with a hole, Lame's ring, a block between platens."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

import numpy as np
import pytest

import crackgrow
from tests.verification.solutions import Floats, case_of, rate, solved_text
from tests.verification.table import Record, Row, parameters

SUPPORTS = (1.5, 2.0, 2.5)
HEAD = """
title: a field that is known
units: {length: mm, stress: MPa}
plane: strain
"""
ROCK = "material: {young: 10000, poisson: 0.25}"

HELD = '  - {{on: {{body: rock, edge: "{}"}}, displacement: {{x: "0.001*x+0.002*y+0.01", y: "-0.003*x+0.004*y"}}}}'
CUT = f"""{HEAD}
bodies: {{rock: {{shape: {{polygon: [[0, 0], [17.3, 1.1], [21.7, 13.9], [9.1, 19.3], [-3.7, 11.9]]}}, {ROCK}}}}}
supports:
""" + "\n".join(HELD.format(edge) for edge in range(5))


def linear(points: Floats) -> Floats:
    """The displacement (n, 2) m that the edges of the five-sided body are given."""
    return points @ np.array([[1e-3, -3e-3], [2e-3, 4e-3]]) + [1e-5, 0.0]


def patch() -> float:
    """Largest error of the displacement at the output mesh's nodes, relative to the largest displacement."""
    frame = solved_text(CUT, "numerics.spacing=2.3").result.frame
    assert frame is not None
    wanted = linear(frame.points)
    return float(np.abs(frame.displacement - wanted).max() / np.abs(wanted).max())


def _patches() -> Iterator[Row]:
    """Others, through joints and along cracks, are in tests/properties."""
    yield Row("five-sided body, cut tiles", "u of a patch test", patch, 0.0, "linear field", 1e-5)


SPACINGS = (6.0, 4.0, 3.0, 2.0)  # mm; from 1.5 mm on, the hole with 360 sides shows: 7e-6
HOLE, YOUNG, POISSON = 10.0, 1e4, 0.25  # mm, MPa
PLATE = f"""{HEAD}
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 60, height: 60}}, holes: [{{disk: {{center: [0, 0], radius: 10}}}}]}}
    {ROCK}
supports:
"""


def kirsch(poisson: float, plane: str) -> tuple[str, str]:
    """Formulas of u_x and u_y (mm) under a tension of 1 MPa along x, hole free of tractions (Kirsch 1898)."""
    kolosov = 3.0 - 4.0 * poisson if plane == "strain" else (3.0 - poisson) / (1.0 + poisson)
    r_sq, a_sq, factor = "(x**2+y**2)", HOLE**2, (1.0 + poisson) / (2.0 * YOUNG)
    cos, sin = f"((x**2-y**2)/{r_sq})", f"(2*x*y/{r_sq})"  # of the double angle
    hole, far = f"{a_sq}/{r_sq}", f"{a_sq**2}/{r_sq}**2"
    radial = f"({factor}*({(kolosov - 1) / 2}+{cos}+{hole}*(1+{1 + kolosov}*{cos})-{far}*{cos}))"  # over r
    around = f"({-factor}*(1+{kolosov - 1}*{hole}+{far})*{sin})"
    return f"{radial}*x-{around}*y", f"{radial}*y+{around}*x"


@cache
def samples() -> tuple[Floats, Floats]:
    """Places (n, 2) m all over the plate and the exact displacement there (n, 2) m."""
    points = np.random.default_rng(1).uniform(-0.03, 0.03, (20000, 2))
    points = points[np.hypot(*points.T) > 1e-3 * HOLE]
    x, y = 1e3 * points.T
    return points, 1e-3 * np.stack([eval(formula, {"x": x, "y": y}) for formula in kirsch(POISSON, "strain")], axis=1)


def hole_error(spacing: float, support: float) -> float:
    """Relative L2 error of the displacement of the plate, displacements of its outline prescribed."""
    x, y = kirsch(POISSON, "strain")
    line = '  - {{on: {{body: rock, edge: {}}}, displacement: {{x: "{}", y: "{}"}}}}\n'
    text = PLATE + "".join(line.format(edge, x, y) for edge in ("left", "right", "bottom", "top"))
    found = solved_text(text, f"numerics.spacing={spacing}", f"numerics.support={support}")
    points, exact = samples()
    return float(np.linalg.norm(found.displacement(points) - exact) / np.linalg.norm(exact))


def hole_rate(support: float) -> float:
    """The order of that error."""
    return rate(SPACINGS, [hole_error(spacing, support) for spacing in SPACINGS])


def _holes() -> Iterator[Row]:
    for support, tolerance in zip(SUPPORTS, (1e-3, 5e-5, 5e-5), strict=True):
        name = f"plate with a hole, support {support}"
        value = partial(hole_error, 2.0, support)
        yield Row(f"{name}, 2 mm", "L2 error of u", value, 0.0, "Kirsch 1898", tolerance)
        value = partial(hole_rate, support)
        yield Row(f"{name}, 6 to 2 mm", "order of u", value, 2.0, "Kirsch 1898", 0.0, "at least")


RING = f"""{HEAD}
bodies:
  rock:
    shape: {{disk: {{center: [0, 0], radius: 30}}, holes: [{{disk: {{center: [0, 0], radius: 10}}}}]}}
    {ROCK}
supports: minimal
loads: [{{on: {{edge: hole0}}, pressure: INSIDE}}, {{on: {{edge: arc}}, pressure: OUTSIDE}}]
numerics: {{spacing: auto}}
"""


def ring_error(inside: float, outside: float) -> float:
    """Largest error of the radial stress and of the mean stress over the pressure: sigma_r, sigma_t = A -+ B / r^2."""
    solution = crackgrow.solve(case_of(RING, INSIDE=inside, OUTSIDE=outside))
    a, b = 0.01, 0.03
    A = 1e6 * (inside * a**2 - outside * b**2) / (b**2 - a**2)
    B = 1e6 * (inside - outside) * (a * b) ** 2 / (b**2 - a**2)
    angle, r = (each.ravel() for each in np.meshgrid(np.linspace(0.1, 2.0 * np.pi, 12), (1.002 * a, 0.015, 0.998 * b)))
    c, s = np.cos(angle), np.sin(angle)
    xx, yy, xy = solution.stress_at(np.stack([r * c, r * s], axis=1)).T
    radial = c * c * xx + s * s * yy + 2.0 * c * s * xy
    return float(max(np.abs(radial - (A - B / r**2)).max(), np.abs(xx + yy - 2.0 * A).max())) / (
        1e6 * max(inside, outside)
    )


def _rings() -> Iterator[Row]:
    for inside, outside in ((10.0, 0.0), (0.0, 5.0), (7.0, 7.0)):
        value, name = partial(ring_error, inside, outside), f"thick ring, {inside:g} MPa inside, {outside:g} outside"
        yield Row(name, "stress over pressure", value, 0.0, "Lame 1852; Timoshenko, Goodier 1970", 1e-2)


def between_platens(friction: float, accuracy: str) -> float:
    """Apparent modulus of a block of 40 x 80 mm that platens press, over Young's."""
    platens = f"contact: {{friction: {friction}, cohesion: 0}}"
    block = f"""{HEAD.replace("strain", "stress")}
bodies: {{rock: {{shape: {{rectangle: {{center: [0, 0], width: 40, height: 80}}}}, {ROCK}}}}}
supports: [{{on: {{edge: bottom}}, {platens}}}, {{on: {{edge: top}}, {platens}, moves: [0, -0.08]}}]
"""
    result = solved_text(block, f"numerics.accuracy={accuracy}").result
    return result.mean_stress[1] / result.mean_strain[1] / (YOUNG * 1e6)


def _platens() -> Iterator[Row]:
    """The value of friction without end is that of quadratic elements, graded to the corners, to 1e-6."""
    name = "block between platens, friction"
    yield Row(f"{name} 0", "modulus over E", partial(between_platens, 0.0, "standard"), 1.0, "Hooke's law", 1e-9)
    for accuracy, tolerance in (("standard", 2e-4), ("fine", 5e-5)):
        value = partial(between_platens, 9.0, accuracy)
        yield Row(f"{name} 9, {accuracy}", "modulus over E", value, 1.0086939, "finite elements", tolerance)


@pytest.mark.parametrize("row", parameters(_patches(), _holes(), _rings(), _platens()))
def test_value_is_within_its_tolerance(row: Row, record_property: Record) -> None:
    row.check(record_property)
