"""Bodies: disks and holes, the outline as a whole, what holds and loads them, and names of materials and laws."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow import solve
from crackgrow.case import Case, dump_case
from crackgrow.case.load import read_case
from crackgrow.case.model import FarField
from crackgrow.errors import CaseError
from tests.unit.case.scenes import EVERYTHING, MATERIAL, fault, joint, load, plate, rectangle, with_body


def test_disks_run_counter_clockwise_and_as_holes_clockwise(tmp_path: Path):
    shape = {"disk": {"center": [1, 2], "radius": 3}, "holes": [{"disk": {"center": [1, 2.5], "radius": 0.25}}]}
    outline, hole = load(tmp_path, {**with_body(shape), "supports": "minimal"}).bodies[0].rings
    for ring, name, middle, radius, way in ((outline, "arc", [1, 2], 3.0, 1), (hole, "hole0", [1, 2.5], 0.25, -1)):
        rays = np.deg2rad(way * np.arange(360))
        expected = middle + radius * np.stack([np.cos(rays), np.sin(rays)], axis=1)
        np.testing.assert_allclose(ring.points, expected, atol=1e-15 * 6)  # cos, product and sum round
        assert set(ring.edge_names) == {name}


def test_names_of_what_is_no_file_of_an_outline(tmp_path: Path):
    (tmp_path / "rock.wkt").write_bytes(b"POLYGON \xff")
    (tmp_path / "folder.wkt").mkdir()
    long = "a" * 5000 + ".wkt"
    told = {"rock.wkt": "not a text in UTF-8", "folder.wkt": "is no file", long: "wanted: the name of a"}
    for name, words in told.items():
        assert words in fault(tmp_path, with_body({"file": name}))[1]


# --- the outline as a whole: `outline` of supports and `far_field` of loads ------------------------------------------

BLOCK = {"rock": rectangle(-5, -5, 10, 10)}
PLACES = {"big": (-5, -5, 10, 10), "small": (5, -1, 2, 4)}
SIDE_BY_SIDE = {name: rectangle(*place) for name, place in PLACES.items()}


def outlined(shapes: dict[str, Any], supports: Any, loads: Any = (), **more: Any) -> Case:
    material = {"young": "30 GPa", "poisson": 0.2}
    bodies = {name: {"shape": shape, "material": material} for name, shape in shapes.items()}
    scene = {"title": "outline", "units": {"stress": "MPa"}, "plane": "strain", "bodies": bodies}
    return Case.from_dict({**scene, "supports": supports, "loads": list(loads), **more})


def test_far_field_is_stress_times_normal_on_all_that_bodies_do_not_share():
    glued = joint("big small", contact="bonded")
    case = outlined(SIDE_BY_SIDE, "minimal", [{"far_field": [-2, -10, 1]}], interfaces=glued)
    loads = {load.body: load for load in case.loads if isinstance(load, FarField)}
    assert set(loads) == {"big", "small"}
    normals = np.array([[1.0, 0.0], [0.6, 0.8]])
    traction = loads["big"].traction_at(np.zeros((2, 2)), normals)
    np.testing.assert_allclose(traction, normals @ (1e6 * np.array([[-2.0, 1.0], [1.0, -10.0]])))
    assert loads["big"].region.sides.tolist() == [0, 1, 3, 4, 5]
    assert case.bodies[0].outline[1:5].tolist() == [[5, -5], [5, -1], [5, 3], [5, 5]]
    assert [load["far_field"] for load in case.to_dict()["loads"]] == [[-2e6, -1e7, 1e6]] * 2
    assert Case.from_dict(case.to_dict()).to_dict() == case.to_dict()


def test_parts_of_an_outline_are_held_on_a_map_as_elsewhere():
    on_map = {name: rectangle(x + 5000, y + 8000, w, h) for name, (x, y, w, h) in PLACES.items()}
    units = {"stress": "MPa", "origin": [5000, 8000]}
    glued = joint("big small", contact="bonded")
    here = outlined(SIDE_BY_SIDE, [{"outline": "fixed"}], interfaces=glued)
    there = outlined(on_map, [{"outline": "fixed"}], interfaces=glued, units=units)
    told = [[(its.region.edge, its.region.sides.tolist()) for its in case.supports] for case in (here, there)]
    assert told[0] == told[1]
    assert {tuple(sides) for edge, sides in told[0][:5] if edge == "right"} == {(1,), (3,)}
    begins = [its["on"].get("from") for its in there.to_dict()["supports"] if its["on"]["edge"] == "right"]
    assert begins == [7995.0, 8003.0, None]


def test_a_far_field_may_vary_if_what_it_leaves_over_is_held():
    lithostatic = {"far_field": ["0.01*(y - 5)", "0.026*(y - 5)", 0]}
    case = outlined(BLOCK, [{"outline": "rollers"}], [lithostatic])
    places, up = np.array([[3.0, 5.0], [3.0, -5.0]]), np.array([[0.0, 1.0], [0.0, -1.0]])
    np.testing.assert_allclose(case.loads[0].traction_at(places, up), [[0.0, 0.0], [0.0, 260000.0]], atol=1e-9)
    with pytest.raises(CaseError, match="'minimal' takes no force"):
        outlined(BLOCK, "minimal", [lithostatic])


def test_minimal_supports_are_three_constraints_off_the_loads_and_cracks(tmp_path: Path):
    crack = {"path": {"points": [[-2, 0], [-1, 0]]}, "contact": "none", "tips": "end"}
    case = load(tmp_path, plate(*PULL, cracks={"flaw": crack}))
    components = [part for support in case.supports for part in support.displacement if part is not None]
    assert components == [0.0, 0.0, 0.0]
    for support in case.supports:
        assert abs(support.point[0]) == 2 or abs(support.point[1]) == 3
        assert np.hypot(*(support.point - (-2, 0))) > case.numerics.spacing
    assert dump_case(read_case(dump_case(case), "again", case.name)) == dump_case(case)


PULL = [{"on": {"edge": "top"}, "traction": [0, 3]}, {"on": {"edge": "bottom"}, "traction": [0, -3]}]
TURN = {"top": [1, 0], "bottom": [-1, 0], "right": [0, 1], "left": [0, -1]}
SHEAR = [{"on": {"edge": edge}, "traction": traction} for edge, traction in TURN.items()]
PRESSURE = [
    *({"on": {"edge": edge}, "pressure": "2 + x**2"} for edge in ("top", "bottom")),
    *({"on": {"edge": edge}, "pressure": 3} for edge in ("left", "right")),
]


@pytest.mark.physics
@pytest.mark.parametrize(
    ("loads", "stress"), [(PULL, [0, 3, 0]), (SHEAR, [0, 0, 1]), (PRESSURE, None)], ids=["pull", "shear", "pressure"]
)
def test_minimal_supports_take_no_force_of_loads_that_balance(
    loads: list[dict[str, Any]], stress: list[float] | None, tmp_path: Path
):
    solution = solve(load(tmp_path, plate(*loads, numerics={"spacing": 1})))
    assert np.abs(solution.reactions[["force_x", "force_y"]]).to_numpy().max() < 1e-9
    if stress is not None:
        found = solution.stress_at(np.array([[0.3, 0.2], [-1.4, 2.1], [0.5, 0.7]]))
        np.testing.assert_allclose(found, [stress] * 3, atol=1e-9)


ROUGH = {"friction": 0.5, "cohesion": 1, "residual_friction": 0.4}


def named() -> dict[str, Any]:
    """The scene with every form, its materials and laws under names."""
    scene = copy.deepcopy(EVERYTHING)
    scene["materials"] = {"rock": MATERIAL, "heavy": {**MATERIAL, "density": "2500 kg/m^3"}}
    scene["laws"] = {"rough": ROUGH}
    for name, body in scene["bodies"].items():
        body["material"] = "heavy" if name == "block" else "rock"
    for part in (scene["cracks"]["flaw"], scene["interfaces"][0], scene["supports"][0]):
        part["contact"] = "rough"
    return scene


def test_names_of_materials_and_laws_mean_what_they_name(tmp_path: Path):
    written = copy.deepcopy(EVERYTHING)
    for part in (written["cracks"]["flaw"], written["interfaces"][0], written["supports"][0]):
        part["contact"] = ROUGH
    assert dump_case(load(tmp_path, named())) == dump_case(load(tmp_path, written))
    case = load(tmp_path, named(), "materials.rock.poisson=0.1", "laws.rough.cohesion=2")
    assert [body.material.poisson for body in case.bodies] == [0.1, 0.25, 0.1]
    assert case.cracks[0].contact.cohesion == case.supports[0].contact.cohesion == 2e6
