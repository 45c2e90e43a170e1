"""Short forms of supports and loads: they mean what the long forms mean."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from crackgrow import solve
from crackgrow.case import Case, dump_case
from crackgrow.case.load import read_case
from tests.unit.case.scenes import MATERIAL, fault, held, load, rectangle, with_body

PULL = [
    {"on": {"edge": "top"}, "traction": [0, 3]},
    {"on": {"edge": "bottom"}, "traction": [0, -3]},
]


def plate(*loads: dict[str, Any], **parts: Any) -> dict[str, Any]:
    """A plate of 4 x 6 m with minimal supports."""
    scene = with_body(rectangle(-2, -3, 4, 6))
    return {**scene, "supports": "minimal", "loads": list(loads), **parts}


def whole() -> dict[str, Any]:
    """The same, held at its bottom."""
    return {**plate(), "supports": held("rock")}


def two_plates(contact: object) -> dict[str, Any]:
    scene = plate()
    scene["bodies"]["cap"] = {"shape": rectangle(-2, 3, 4, 2), "material": MATERIAL}
    scene["interfaces"] = [{"between": ["rock", "cap"], "contact": contact}]
    return scene


def dumped(case: Case) -> Any:
    return yaml.safe_load(dump_case(case))


def test_vectors_as_lists_and_as_mappings_are_the_same(tmp_path: Path):
    one, other = whole(), whole()
    one["supports"] = [{"on": {"body": "rock", "edge": "bottom"}, "displacement": {"x": 0, "y": "0.1*x"}}]
    other["supports"] = [{"on": {"edge": "bottom"}, "displacement": [0, "0.1*x"]}]
    one["loads"] = [{"on": {"body": "rock", "edge": "top"}, "traction": ["2*x", -1]}]
    other["loads"] = [{"on": {"edge": "top"}, "traction": {"y": -1, "x": "2*x"}}]
    assert dumped(load(tmp_path, one)) == dumped(load(tmp_path, other))


def test_loads_of_the_only_body_need_not_name_it(tmp_path: Path):
    scene = whole()
    scene["bodies"]["rock"]["material"] = {**MATERIAL, "density": 2500}
    scene["loads"] = [{"gravity": [0, -9.81]}, {"stress": [-1, -2, 0]}]
    assert [item.body for item in load(tmp_path, scene).loads] == ["rock", "rock"]


def test_minimal_supports_take_no_force_of_loads_that_balance(tmp_path: Path):
    solution = solve(load(tmp_path, plate(*PULL, numerics={"spacing": 1})))
    assert np.abs(solution.reactions[["force_x", "force_y"]]).to_numpy().max() < 1e-9
    stress = solution.stress_at(np.array([[0.3, 0.2], [-1.4, 2.1]]))
    np.testing.assert_allclose(stress, [[0, 3, 0]] * 2, atol=1e-9)


def test_minimal_supports_are_three_constraints_off_the_loads_and_cracks(tmp_path: Path):
    crack = {"path": {"points": [[-2, 0], [-1, 0]]}, "contact": "none", "tips": "end"}
    case = load(tmp_path, plate(*PULL, cracks={"flaw": crack}))
    components = [part for support in case.supports for part in support.displacement if part is not None]
    assert components == [0.0, 0.0, 0.0]
    for support in case.supports:
        assert abs(support.point[0]) == 2 or abs(support.point[1]) == 3
        assert np.hypot(*(support.point - (-2, 0))) > case.numerics.spacing
    again = read_case(dump_case(case), "again", case.name)
    assert dump_case(again) == dump_case(case)


def test_pressure_all_round_balances(tmp_path: Path):
    loads = [{"on": {"edge": edge}, "pressure": "2 + x**2"} for edge in ("top", "bottom")]
    loads += [{"on": {"edge": edge}, "pressure": 3} for edge in ("left", "right")]
    solution = solve(load(tmp_path, plate(*loads, numerics={"spacing": 1})))
    assert np.abs(solution.reactions[["force_x", "force_y"]]).to_numpy().max() < 1e-9


def test_shear_all_round_balances(tmp_path: Path):
    turn = {"top": [1, 0], "bottom": [-1, 0], "right": [0, 1], "left": [0, -1]}
    loads = [{"on": {"edge": edge}, "traction": traction} for edge, traction in turn.items()]
    solution = solve(load(tmp_path, plate(*loads, numerics={"spacing": 1})))
    np.testing.assert_allclose(solution.stress_at(np.array([[0.5, 0.7]])), [[0, 0, 1]], atol=1e-9)


def test_minimal_supports_hold_bonded_bodies_and_no_loose_ones(tmp_path: Path):
    assert len(load(tmp_path, two_plates("bonded")).supports) == 2
    key, message = fault(tmp_path, two_plates({"friction": 0.5, "cohesion": 0}))
    assert key == "supports"
    assert "rock and cap" in message
