"""What is told of edges at which in-situ stress relaxes, and of joints that a fluid does not enter."""

from __future__ import annotations

from typing import Any

import pytest

import crackgrow
from crackgrow.case.model import Case
from crackgrow.run.checkpoint import beginning
from crackgrow.run.layout import cover_of
from crackgrow.run.scene import make_scene
from crackgrow.run.scene_warnings import dry_joints, free_edges

HOLES = [{"disk": {"center": [0, 0], "radius": 10}}]
OPEN = {"friction": 0.3, "cohesion": 0}
ROCK = {"young": "30 GPa", "poisson": 0.2, "density": 2600}
STRESS, FAR, DRIVER = {"stress": [-2, -10, 0]}, {"far_field": [-2, -10, 0]}, {"far_field": [0, -3, 0]}


def scene(loads: list[dict[str, Any]], supports: Any = "minimal", holes: Any = (), **more: Any) -> Case:
    """A square of 100 mm."""
    shape = {"rectangle": {"center": [0, 0], "width": 100, "height": 100}, **({"holes": list(holes)} if holes else {})}
    fixed = {"title": "unsaid", "units": {"length": "mm", "stress": "MPa"}, "plane": "strain"}
    bodies = {"rock": {"shape": shape, "material": ROCK}}
    return Case.from_dict(
        {**fixed, "bodies": bodies, "supports": supports, "loads": loads, "numerics": {"accuracy": "draft"}, **more}
    )


def told(case: Case) -> list[str]:
    return [warning.words for warning in free_edges(make_scene(case))]


def all_round(part: float) -> list[dict[str, Any]]:
    """Tractions of a part of the stress."""
    sides = {"left": (2, 0), "right": (-2, 0), "top": (0, -10), "bottom": (0, 10)}
    return [{"on": {"edge": edge}, "traction": [part * x, part * y]} for edge, (x, y) in sides.items()]


def held(edge: str, *components: str) -> dict[str, Any]:
    return {"on": {"edge": edge}, "displacement": dict.fromkeys(components, 0)}


BALANCED = [
    ([STRESS], [{"outline": "rollers"}]),
    ([STRESS], [{"outline": "fixed"}]),
    ([STRESS, FAR], "minimal"),
    ([STRESS, *all_round(1.0)], "minimal"),
    ([{**STRESS, "held": True}, FAR], "minimal"),
    ([{**STRESS, "held": True}, {**FAR, "held": True}, DRIVER], "minimal"),
    ([{"stress": [0, "0.01*(y - 50)", 0]}], [held("left", "x"), held("right", "x"), held("bottom", "y")]),
]


@pytest.mark.parametrize(("loads", "supports"), BALANCED)
def test_where_all_of_the_stress_is_taken_nothing_is_told(loads: list[dict[str, Any]], supports: Any):
    for holes in ((), HOLES):
        assert told(scene(loads, supports, holes)) == []


def test_what_loads_leave_over_is_told_with_the_stress():
    """A load that drives the rock is taken for what balances its stress; the walls of holes are to give way."""
    all_edges = "edges bottom, right, top, left of body 'rock' are free: the in-situ stress of "
    points = [[x, 0] for x in range(0, 100, 5)] + [[x, 50] for x in range(100, 0, -5)]
    rough = {"rock": {"shape": {"polygon": points}, "material": ROCK}}
    cases = {
        all_edges + "10 MPa there": scene([STRESS]),
        all_edges + "10 MPa": scene([STRESS], holes=HOLES),
        all_edges + "9 MPa there relaxes": scene([STRESS, *all_round(0.1)]),
        "edge top of body 'rock' is free: the in-situ stress of 10 MPa": scene(
            [STRESS], [held("left", "x"), held("bottom", "y"), held("right", "x")]
        ),
        all_edges + "3 MPa": scene([{"stress": [0, 0, 3]}], [{"outline": "rollers"}]),
        "edges 0, 1, 2, 3, 4, 5 and 34 more of body 'rock' are free": scene([STRESS], bodies=rough),
    }
    for expected, case in cases.items():
        (words,) = told(case)
        assert words.startswith(expected)
        assert "{outline: rollers}" in words
        assert "far_field" in words
    flaw = {"flaw": {"path": {"center": [0, 0], "length": 20, "angle": 45}, "contact": OPEN}}
    run = crackgrow.run_case(scene([STRESS], cracks=flaw))
    assert [words for words in run.warnings if "the in-situ stress of 10 MPa there relaxes" in words]


def joints(**paths: list[list[float]]) -> dict[str, Any]:
    return {name: {"path": {"points": path}, "tips": "none", "contact": OPEN} for name, path in paths.items()}


def dry(case: Case) -> list[str]:
    made = make_scene(case)
    found = list(dry_joints(made, cover_of(made, beginning(case).cracks)))
    assert all(", where a fluid presses, and stays dry" in warning.words for warning in found)
    return [warning.place for warning in found]


WET = {"crack": "wet", "pressure": 2}


@pytest.mark.parametrize(
    ("path", "places"),
    [
        ([[0, 0], [0, 20]], ["crack 'joint' at crack 'wet'"]),
        ([[5, -20], [-5, 20]], ["crack 'joint' at crack 'wet'"]),
        ([[0, 1], [0, 20]], []),
    ],
)
def test_a_joint_that_a_pressurised_crack_meets_stays_dry(path: list[list[float]], places: list[str]):
    cracks = joints(wet=[[-20, 0], [20, 0]], joint=path)
    assert dry(scene([WET], cracks=cracks)) == places
    warnings = crackgrow.solve(scene([WET], cracks=cracks)).result.warnings
    assert any("stays dry" in words for words in warnings) == bool(places)
    for load in ({**WET, "crack": "joint"}, {"crack": "joint", "pressure": 0}):
        assert dry(scene([WET, load], cracks=cracks)) == []
    assert dry(scene([{**WET, "pressure": "abs(x)"}], cracks=cracks)) == []  # none where they meet


def test_a_crack_on_the_rim_of_a_pressurised_hole_stays_dry():
    cracks = joints(radial=[[10, 0], [30, 0]], elsewhere=[[-30, 0], [-20, 0]])
    rim = {"on": {"edge": "hole0"}, "pressure": 5}
    for loads, places in (
        ([rim], ["crack 'radial' at edge hole0 of body 'rock'"]),
        ([rim, {**WET, "crack": "radial"}], []),
    ):
        assert dry(scene(loads, holes=HOLES, cracks=cracks)) == places
