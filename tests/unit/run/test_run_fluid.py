"""Fluids in cracks; what is told of joints that none enters, and of edges at which in-situ stress relaxes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
from crackgrow.run.checkpoint import beginning
from crackgrow.run.layout import cover_of
from crackgrow.run.scene import make_scene
from crackgrow.run.scene_warnings import dry_joints, free_edges
from tests.scenes import specimen

JOINT = {"path": [[-10, -8], [10, -8]], "contact": {"friction": 0.3}}
FLAW = {"path": [[0, -8], [0, 6]], "contact": {"friction": 0.3}, "tips": "end"}
PRESSED = {"far_field": [-2, -1, 0], "held": True}


def tee(fluid: dict[str, Any], factors: tuple[float, ...] = (1.0,)) -> Case:
    """A crack that ends on a joint, with a fluid in it."""
    scene = specimen({"joint": JOINT, "flaw": FLAW}, (60.0, 60.0), numerics={"spacing": 2})
    loads = [PRESSED, {"crack": "flaw", **fluid}]
    return Case.from_dict({**scene, "supports": "minimal", "loads": loads, "loading": {"history": list(factors)}})


def K_of(case: Case) -> np.ndarray:
    """K of all tips at the last load."""
    return np.array([(tip.K_I, tip.K_II) for tip in crackgrow.solve(case).result.tips])


@pytest.mark.parametrize("connected", [False, True])
@pytest.mark.parametrize("volume", [0.02, 0.2])
def test_a_volume_is_as_the_pressure_that_it_takes(volume: float, connected: bool) -> None:
    """K and the pressure of closed and of opened faces; the joint takes part where the fluid enters it."""
    found = crackgrow.solve(tee({"volume": volume, "connected": connected}))
    (pressure,) = (one.pressure for one in found.result.reactions if one.where == "loads.1")
    K = np.array([(tip.K_I, tip.K_II) for tip in found.result.tips])
    exact = K_of(tee({"pressure": f"{pressure!r} Pa", "connected": connected}))
    np.testing.assert_allclose(K, exact, atol=1e-6 * np.abs(exact).max())
    dry = K_of(tee({"pressure": f"{pressure!r} Pa", "connected": not connected}))
    assert np.abs(K - dry).max() > 0.05 * np.abs(exact).max()


def test_a_fluid_without_room_has_the_pressure_that_parts_the_faces() -> None:
    """Next to no volume: all of the pressure across the crack; it comes back as the volume does."""
    alone = tee({"volume": 0.2}, (1e-6, 1.0, 1e-6))
    at = [step.reactions[-1].pressure for step in crackgrow.grow(alone)]
    assert 0.9e6 < at[0] < 3e6  # between both stresses, beside the joint
    assert at[1] > 2.0 * at[0]
    assert at[2] == pytest.approx(at[0], rel=1e-3)


@pytest.mark.parametrize("connected", [False, True])
def test_a_fluid_enters_the_joint_that_its_crack_grows_into(connected: bool) -> None:
    """The joint opens once it is reached, where the fluid is connected."""
    cracks = {
        "flaw": {"path": [[-6, 0], [6, 0]], "contact": {"friction": 0.3}},
        "joint": {"path": [[10, -10], [10, 10]], "contact": {"friction": 0.3}, "tips": "none"},
    }
    growth = {"steps": 2, "increment": 3, "criterion": "max_hoop_stress", "advance": "all"}
    scene = specimen(cracks, (60.0, 60.0), numerics={"spacing": 2.5}, growth=growth, supports="minimal")
    scene["bodies"]["rock"]["strength"]["toughness"] = "1 MPa sqrt(m)"
    scene["loads"] = [
        {"far_field": [-3, -2, 0], "held": True},
        {"crack": "flaw", "pressure": 12, "connected": connected},
    ]
    steps = list(crackgrow.grow(Case.from_dict(scene)))
    assert any(event.kind == "coalescence" for event in steps[-1].events)
    opening = [max(side.opening.max() for side in step.faces if side.crack == "joint") for step in steps]
    assert opening[0] < 1e-6
    assert (opening[-1] > 5e-6) == connected


def test_the_first_of_two_fluids_that_reach_a_joint_fills_it() -> None:
    """Two cracks on one joint, all under the same pressure: it is not counted twice."""
    other = {**FLAW, "path": [[4, -8], [4, -16]]}
    scene = specimen({"joint": JOINT, "flaw": FLAW, "other": other}, (60.0, 60.0), numerics={"spacing": 2})

    def K(*loads: dict[str, Any]) -> np.ndarray:
        return K_of(Case.from_dict({**scene, "supports": "minimal", "loads": [PRESSED, *loads]}))

    fluid = {"pressure": 5, "connected": True}
    connected = K({"crack": "flaw", **fluid}, {"crack": "other", **fluid})
    given = K(*({"crack": name, "pressure": 5} for name in ("flaw", "other", "joint")))
    np.testing.assert_allclose(connected, given, atol=1e-9 * np.abs(given).max())


def test_a_fluid_that_would_pull_is_told() -> None:
    """Faces that are pulled apart farther than the volume lets them."""
    scene = specimen({"flaw": {"path": [[-6, 0], [6, 0]], "contact": "none"}}, (60.0, 60.0), numerics={"spacing": 3})
    pulled = {**scene, "loads": [*scene["loads"], {"crack": "flaw", "volume": 1e-6}]}
    assert any("would pull" in text for text in crackgrow.solve(Case.from_dict(pulled)).result.warnings)


def test_a_volume_beside_a_loose_piece_is_refused() -> None:
    """A crack from edge to edge: what lies beyond it is held by contact alone, and moves against the fluid."""
    cracks = {"through": {"path": [[-30, 0], [30, 0]], "contact": {"friction": 0.5}, "tips": "none"}}
    scene = specimen(cracks, (60.0, 60.0), numerics={"spacing": 5})
    held = [{"on": {"edge": "bottom"}, "displacement": {"x": 0, "y": 0}}]
    loads = [{"on": {"edge": "top"}, "traction": [0, -2]}, {"crack": "through", "volume": 0.1}]
    with pytest.raises(SolveError, match="is held by a volume of fluid; it needs supports"):
        crackgrow.solve(Case.from_dict({**scene, "supports": held, "loads": loads}))


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
