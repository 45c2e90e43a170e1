"""Small hand-made cases and step results: a block with a closed crack across its middle."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

import crackgrow
from crackgrow.case import Case
from crackgrow.run.result import (
    SLIP,
    STICK,
    ContactPoints,
    CrackFaces,
    CrackPath,
    Energy,
    Event,
    Frame,
    RunEnd,
    StepResult,
    TipResult,
)

WIDTH, HEIGHT = 0.03, 0.05
CRACK = np.array([[-0.01, 0.0], [0.01, 0.0]])
INCREMENT = 0.002


def make_case(**output: Any) -> Case:
    """A block of 30 x 50 mm with a horizontal crack of 20 mm that grows by two steps."""
    growth = {"steps": 2, "increment": INCREMENT, "advance": "most_critical", "criterion": "strength"}
    rock = {
        "shape": {"rectangle": {"center": [0, 0], "width": WIDTH, "height": HEIGHT}},
        "material": {"young": 1e10, "poisson": 0.25},
        "strength": {"tension": 5e5, "cohesion": 1e7, "friction_angle": 40},
    }
    scene = {
        "title": "A block with a crack",
        "plane": "strain",
        "bodies": {"rock": rock},
        "cracks": {"flaw": {"path": CRACK.tolist(), "contact": {"friction": 0.3}}},
        "supports": "minimal",
        "loads": [{"far_field": [5e7, -1e8, 6e7]}],
        "growth": {**growth, "tip_stress": {"radius": 0.002}},
        "numerics": {"spacing": 0.005},
        "output": {"frames": "every_step", "figures": False, "report": False, **output},
    }
    return Case.from_dict(scene, "block")


@cache
def solved() -> Frame:
    """The block pressed along y, pulled along x and sheared: its crack slips."""
    return crackgrow.solve(make_case()).frame


def make_frame(scale: float = 1.0) -> Frame:
    """That of the block under so many times the load."""
    scaled = ("displacement", "point_stress", "point_stress_zz", "stress", "stress_zz")
    return replace(solved(), **{name: scale * getattr(solved(), name) for name in scaled})


def make_paths(n_advances: int) -> tuple[CrackPath, ...]:
    """The crack after so many advances of its end."""
    grown = [[0.01 + INCREMENT * k, INCREMENT * k] for k in range(1, n_advances + 1)]
    points = np.concatenate([CRACK, np.array(grown).reshape(-1, 2)])
    return (CrackPath("flaw", points, np.array([0, 0, *range(1, n_advances + 1)])),)


def make_result(step: int, **changes: Any) -> StepResult:
    """The result of a step, before its advance."""
    paths = make_paths(step)
    points = paths[0].points
    n = len(points)
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    opening, slip = np.zeros(n), np.linspace(0, 1e-5, n)
    normal, tangential = np.full(n, -1e6 / 3), np.full(n, 0.1 + 0.2)
    state = np.where(np.arange(n) % 2 == 0, SLIP, STICK)
    end = TipResult(
        crack="flaw", tip="end", point=points[-1], K_I=2.0e6, K_II=-1e-300, sigma_1=6e5, sigma_3=-2e6,
        criterion="tension", criticality=1.2, kink_deg=70.5, advanced=True, K_I_error=1e4, K_II_error=2e4,
        K_radius=0.005, K_note="", K_I_faces=1.9e6, K_II_faces=1e3, K_I_spread=2e3, K_II_spread=1e3,
        cell_size=1.5e-3, K_growth=2e6 / 1.2,
    )  # fmt: skip
    unknown = dict.fromkeys(("K_I", "K_I_error", "K_II_error", "K_radius", "K_I_spread", "K_II_spread"), np.nan)
    start = replace(
        end, tip="start", point=points[0], K_II=1e6 / 3, sigma_1=1e5, criterion="none", criticality=0.2, kink_deg=0.0,
        advanced=False, K_note="no room", K_I_faces=1e6, K_II_faces=-1e6, cell_size=3e-3, K_growth=np.nan, **unknown,
    )  # fmt: skip
    result = StepResult(
        step=step,
        load_factor=1.0,
        cracks=paths,
        events=(),
        tips=(start, end),
        interface_tips=(),
        contact=ContactPoints(("flaw",) * n, s, points, normal, tangential, opening, slip, state, opening, slip),
        faces=(CrackFaces("flaw", s, points, opening, slip, normal, tangential, state, np.full(n, 1.5e-3)),),
        reactions=(),
        mesh=partial(make_frame, 1.0 + step),
        n_dofs=400 + 8 * step,
        n_contact=2 * n,
        contact_iterations=3 + step,
        contact_status="solved",
        factorizations=1,
        residual=1e-12,
        penetration=1e-15 * (2 if step == 1 else 1),
        complementarity=1e-10,
        overlap=2e-9,
        overlap_share=0.04,
        energy=Energy(work=4.0 + step, strain=3.0, dissipated=0.5, released=0.25 * step, error=1e-6 / (1 + step)),
        load_displacement=1e-5 * (1 + step),
        mean_stress=(1e6, -2e6 - 1e5 * step, 5e5),
        mean_strain=(1e-4, -4e-4, 2e-5),
        crack_length=float(s[-1]),
        seconds={"cover": 0.1, "assembly": 0.2, "factorize": 0.3, "contact": 0.4, "criterion": 0.5, "output": 0.0625},
        step_warnings=(),
    )
    return replace(result, **changes)


def make_event(step: int, **changes: Any) -> Event:
    """The crack's end runs into another crack in the advance of a step."""
    point = make_paths(step)[0].points[-1]
    return replace(Event(step, "coalescence", "flaw", "end", point, "crack 'b, the second'"), **changes)


def make_end(n_advances: int) -> RunEnd:
    """A run that did all it was asked to."""
    return RunEnd("completed", "2 growth steps done", make_paths(n_advances))
