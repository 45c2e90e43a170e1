"""The outline as a whole: `outline` of supports and `far_field` of loads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from crackgrow.case.model import Case, EdgeSupport, FarField
from crackgrow.errors import CaseError

ROCK = {"young": "30 GPa", "poisson": 0.2}


def block(center: list[float], width: float, height: float) -> dict[str, Any]:
    return {"shape": {"rectangle": {"center": center, "width": width, "height": height}}, "material": ROCK}


def scene(bodies: dict[str, Any], supports: Any, loads: Any = (), **more: Any) -> Case:
    units = {"length": "m", "stress": "MPa"}
    given = {"title": "outline", "units": units, "plane": "strain", "bodies": bodies, "supports": supports}
    return Case.from_dict({**given, "loads": list(loads), **more})


def held(case: Case) -> list[tuple[Any, ...]]:
    """Body, edge, displacement and limits of supports of edges."""
    assert all(isinstance(support, EdgeSupport) for support in case.supports)
    return [(s.region.body, s.region.edge, s.displacement, s.region.limits.tolist()) for s in case.supports]


SIDE_BY_SIDE = {"big": block([0, 0], 10, 10), "small": block([6, 1], 2, 4)}
JOINT = [{"between": ["big", "small"], "contact": {"friction": 0.5, "cohesion": 0}}]
X, Y = (0.0, None), (None, 0.0)


def test_rollers_hold_each_side_across_but_for_what_bodies_share():
    case = scene(SIDE_BY_SIDE, [{"outline": "rollers"}], interfaces=JOINT)
    assert sorted(held(case), key=str) == sorted(
        [
            ("big", "left", X, [[0.0, 1.0]]),
            ("big", "right", X, [[0.0, 0.4]]),
            ("big", "right", X, [[0.8, 1.0]]),
            *(("big", edge, Y, [[0.0, 1.0]]) for edge in ("bottom", "top")),
            *(("small", edge, Y, [[0.0, 1.0]]) for edge in ("bottom", "top")),
            ("small", "right", X, [[0.0, 1.0]]),
        ],
        key=str,
    )
    assert held(Case.from_dict(case.to_dict())) == held(case)


def test_one_body_and_other_supports_stay_by_their_numbers():
    other = {"on": {"body": "big", "edge": "left"}, "displacement": {"y": 0}}
    case = scene(SIDE_BY_SIDE, [{"outline": "fixed", "body": "small"}, other], interfaces=JOINT)
    assert held(case)[1] == ("big", "left", Y, [[0.0, 1.0]])
    assert {of_it[:3] for number, of_it in enumerate(held(case)) if number != 1} == {
        ("small", edge, (0.0, 0.0)) for edge in ("bottom", "right", "top")
    }


def test_far_field_is_stress_times_normal_on_all_that_bodies_do_not_share():
    case = scene(SIDE_BY_SIDE, "minimal", [{"far_field": [-2, -10, 1]}], interfaces=[{**JOINT[0], "contact": "bonded"}])
    loads = {load.body: load for load in case.loads if isinstance(load, FarField)}
    assert set(loads) == {"big", "small"}
    normals = np.array([[1.0, 0.0], [0.6, 0.8]])
    traction = loads["big"].traction_at(np.zeros((2, 2)), normals)
    np.testing.assert_allclose(traction, normals @ (1e6 * np.array([[-2.0, 1.0], [1.0, -10.0]])))
    assert loads["big"].region.limits.tolist() == [[0.0, 1.0], [0.0, 0.4], [0.8, 1.0], [0.0, 1.0], [0.0, 1.0]]
    assert [load["far_field"] for load in case.to_dict()["loads"]] == [[-2e6, -1e7, 1e6]] * 2
    assert Case.from_dict(case.to_dict()).to_dict() == case.to_dict()


def test_a_far_field_may_vary_if_what_it_leaves_over_is_held():
    lithostatic = {"far_field": ["0.01*(y - 5)", "0.026*(y - 5)", 0]}
    case = scene({"rock": block([0, 0], 10, 10)}, [{"outline": "rollers"}], [lithostatic])
    places, up = np.array([[3.0, 5.0], [3.0, -5.0]]), np.array([[0.0, 1.0], [0.0, -1.0]])
    np.testing.assert_allclose(case.loads[0].traction_at(places, up), [[0.0, 0.0], [0.0, 260000.0]], atol=1e-9)
    with pytest.raises(CaseError, match="'minimal' takes no force"):
        scene({"rock": block([0, 0], 10, 10)}, "minimal", [lithostatic])


INSIDE = {
    "rock": {**block([0, 0], 10, 10)},
    "core": {"shape": {"disk": {"center": [0, 0], "radius": 1}}, "material": ROCK},
}
INSIDE["rock"]["shape"] = {**INSIDE["rock"]["shape"], "holes": [{"disk": {"center": [0, 0], "radius": 1}}]}
ROUND_THE_CORE = [{"between": ["rock", "core"], "contact": "bonded"}]


def test_bodies_inside_of_others_have_no_outline_of_their_own():
    case = scene(INSIDE, [{"outline": "fixed"}], interfaces=ROUND_THE_CORE)
    assert {of_it[:2] for of_it in held(case)} == {("rock", edge) for edge in ("left", "right", "bottom", "top")}
