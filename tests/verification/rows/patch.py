"""Patch tests: fields that the approximation holds exactly come out, whatever cuts the lattice."""

from __future__ import annotations

from functools import partial

import numpy as np

from tests.verification.row import Row
from tests.verification.solutions import Floats, Solved, solved, solved_text

BAR = 1e-5  # of the largest displacement
HEAD = "title: patch test\nunits: {length: mm, stress: MPa}\nplane: strain\n"
ROCK = "material: {young: 10000, poisson: 0.25}"
COMPLIANCE = np.array([[0.9375, -0.3125], [-0.3125, 0.9375]]) / 1e10  # 1/Pa, plane strain: xx, yy

HELD = '  - {{on: {{body: rock, edge: "{}"}}, displacement: {{x: "0.001*x+0.002*y+0.01", y: "-0.003*x+0.004*y"}}}}'
CUT = f"""{HEAD}
bodies:
  rock:
    shape: {{polygon: [[0, 0], [17.3, 1.1], [21.7, 13.9], [9.1, 19.3], [-3.7, 11.9]]}}
    {ROCK}
supports:
""" + "\n".join(HELD.format(edge) for edge in range(5))

ALONG = f"""{HEAD}
bodies:
  rock:
    shape: {{rectangle: {{center: [0, 0], width: 31, height: 19}}}}
    {ROCK}
cracks:
  flaw: {{path: {{points: [[-9.3, 1.7], [8.9, 1.7]]}}, contact: none}}
supports:
  - {{at: [-15.5, -9.5], displacement: {{x: 0, y: 0}}}}
  - {{at: [15.5, -9.5], displacement: {{y: 0}}}}
loads:
  - {{on: {{body: rock, edge: right}}, traction: [100, 0]}}
  - {{on: {{body: rock, edge: left}}, traction: [-100, 0]}}
"""

INTERFACE = f"""{HEAD}
bodies:
  upper:
    shape: {{polygon: [[0, 10], [30, 14], [30, 25], [0, 25]]}}
    {ROCK}
  lower:
    shape: {{polygon: [[0, 0], [30, 0], [30, 14], [0, 10]]}}
    {ROCK}
interfaces:
  - {{between: [upper, lower], contact: {{friction: 0.5, cohesion: 0}}}}
supports:
  - {{on: {{body: lower, edge: "0"}}, displacement: {{y: 0}}}}
  - {{at: [0, 0], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: upper, edge: "2"}}, traction: [0, -100]}}
"""


def linear(points: Floats) -> Floats:
    return points @ np.array([[1e-3, -3e-3], [2e-3, 4e-3]]) + [1e-5, 0.0]


def uniform(stress: tuple[float, float], low: tuple[float, float], points: Floats) -> Floats:
    """Displacement (n, 2) m under normal stresses xx and yy (Pa), zero at `low`, sides stay parallel to the axes."""
    return (points - low) * (COMPLIANCE @ stress)


def worst(solution: Solved, exact: object) -> float:
    """Largest error of the displacement at the output mesh's nodes, relative to the largest displacement."""
    frame = solution.result.frame
    wanted = exact(frame.points)
    return float(np.abs(frame.displacement - wanted).max() / np.abs(wanted).max())


def cut(support: float) -> float:
    return worst(solved_text(CUT, "numerics.spacing=2.3", f"numerics.support={support}"), linear)


def along(support: float) -> float:
    solution = solved_text(ALONG, "numerics.spacing=1.5", f"numerics.support={support}")
    return worst(solution, partial(uniform, (100e6, 0.0), (-15.5e-3, -9.5e-3)))


def stuck_crack() -> float:
    solution = solved("compression30", "cracks.flaw.contact.friction=0.6")
    return worst(solution, partial(uniform, (0.0, -100e6), (0.0, -27.5e-3)))


def stuck_interface(support: float) -> float:
    solution = solved_text(INTERFACE, "numerics.spacing=2.3", f"numerics.support={support}")
    return worst(solution, partial(uniform, (0.0, -100e6), (0.0, 0.0)))


def _row(case: str, quantity: str, value: object) -> Row:
    return Row(case, quantity + ": largest error of u", 0.0, "exact", "linear field", BAR, value, "at most")


ROWS = [
    *(_row("five-sided body", f"linear field through cut tiles, support {s}", partial(cut, s)) for s in (1.5, 2.0)),
    *(_row("plate with an open crack", f"tension along the crack, support {s}", partial(along, s)) for s in (1.5, 2.0)),
    _row("compression30", "compression through the stuck crack, friction 0.6", stuck_crack),
    *(
        _row(
            "two bodies",
            f"compression through a slanting interface that sticks, support {s}",
            partial(stuck_interface, s),
        )
        for s in (1.5, 2.0)
    ),
]
