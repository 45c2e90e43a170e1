"""Fluids in cracks: a volume takes the pressure that holds it, and a connected fluid is wherever its crack leads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.case.model import Case
from crackgrow.errors import SolveError
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
