"""Reading whole case files: the model in SI, round trips, overrides, faults with their lines."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.model import EdgeSupport, PointSupport
from crackgrow.errors import CaseError, Fault

FILE = Path(__file__).parent / "compression30.yaml"
COMPRESSION = FILE.read_text(encoding="utf-8")


def faults_of(path: Path, overrides: Sequence[str] = ()) -> tuple[Fault, ...]:
    with pytest.raises(CaseError) as caught:
        load_case(path, overrides)
    return caught.value.faults


def edited(tmp_path: Path, old: str, new: str) -> Path:
    """Write compression30 with one text replaced, which must be there once."""
    assert COMPRESSION.count(old) == 1
    path = tmp_path / "scene.yaml"
    path.write_text(COMPRESSION.replace(old, new), encoding="utf-8")
    return path


def line_of(path: Path, text: str) -> int:
    """Return the number of the first line that holds a text."""
    return next(n for n, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1) if text in line)


def same(a: object, b: object) -> bool:
    """Whether two values of a model agree to the last bit."""
    if dataclasses.is_dataclass(a):
        names = [field.name for field in dataclasses.fields(a)]
        return type(a) is type(b) and all(same(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, dict):
        return isinstance(b, dict) and list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and repr(a) == repr(b)


def reread(case: Case, tmp_path: Path) -> Case:
    path = tmp_path / f"{case.name}.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    return load_case(path)


def test_compression30_in_si():
    case = load_case(FILE)
    (body,) = case.bodies
    (crack,) = case.cracks
    assert (case.name, case.plane, case.loading.factors) == ("compression30", "strain", (1.0,))
    assert body.outline.tolist() == [[-0.0155, -0.0275], [0.0155, -0.0275], [0.0155, 0.0275], [-0.0155, 0.0275]]
    assert body.rings[0].edge_names == ("bottom", "right", "top", "left")
    assert (body.material.young, body.material.poisson, body.material.density) == (1e10, 0.25, None)
    assert body.strength is not None
    assert (body.strength.tension, body.strength.cohesion, body.strength.friction_angle) == (5e5, 1e7, 40.0)
    half = 0.005 * np.array([np.sqrt(3) / 2, 0.5])
    np.testing.assert_allclose(crack.points, [-half, half], rtol=1e-15)  # one rounding of cos, one of the product
    assert (crack.tip_at_start, crack.tip_at_end) == (True, True)
    assert crack.contact is not None
    assert (crack.contact.friction, crack.contact.cohesion) == (0.0, 0.0)
    assert (crack.body, case.interfaces) == ("rock", ())
    assert [support.body for support in case.supports] == ["rock"] * 3
    assert all(isinstance(support, PointSupport) for support in case.supports)
    assert [support.displacement for support in case.supports] == [(None, 0.0), (None, 0.0), (0.0, None)]
    assert [(load.region.edge, load.traction) for load in case.loads] == [("top", (0.0, -1e8)), ("bottom", (0.0, 1e8))]
    assert case.growth is not None
    assert (case.growth.steps, case.growth.increment, case.growth.tip_radius) == (22, 0.002, 0.001)
    assert (case.growth.criterion, case.growth.direction) == ("directional_strength", "explicit")
    assert case.growth.unload_between_steps is True


def test_defaults_are_filled_in():
    case = load_case(FILE)
    numerics = case.numerics
    assert (numerics.spacing, numerics.support, numerics.quadrature) == (0.0015, 2.0, 3)
    contact = numerics.contact
    assert (contact.stiffness, contact.discretization, contact.solver) == (None, "mortar", "newton")
    assert contact.spacing == 1.25
    assert (case.output.frames, case.output.fields, case.output.figures) == (
        "every_step",
        ("displacement", "stress"),
        True,
    )
    assert case.resolved["units"] == {"length": "m", "stress": "Pa"}


def test_tips_and_cohesion_of_a_case_that_is_silent_about_them(tmp_path: Path):
    assert load_case(without(tmp_path, "growth.advance")).growth.advance == "all"
    contact = load_case(without(tmp_path, "cracks.flaw.contact.cohesion")).cracks[0].contact
    assert contact is not None
    assert contact.cohesion == 0.0


def test_a_case_is_not_changed_from_outside():
    case = load_case(FILE)
    resolved: Any = case.resolved
    text = dump_case(case)
    changes = [
        lambda: resolved.clear(),
        lambda: resolved.update(title="another"),
        lambda: resolved["cracks"]["flaw"]["path"].__setitem__("angle", 60.0),
        lambda: resolved["output"]["fields"].clear(),
        lambda: resolved["loads"].append({}),
        lambda: resolved["loads"][0]["traction"].sort(),
        lambda: resolved["supports"].__delitem__(0),
        lambda: resolved.__ior__({"title": "another"}),
    ]
    for change in changes:
        with pytest.raises(TypeError, match="a case cannot be changed; load it with overrides"):
            change()
    assert dump_case(case) == text


def test_the_mapping_of_a_case_can_be_copied_and_sent_to_another_process():
    case = load_case(FILE)
    copied: Any = copy.deepcopy(case.resolved)
    copied["loads"][0]["traction"][1] = 0.0
    assert copied != case.resolved
    sent = pickle.loads(pickle.dumps(case))
    assert sent.resolved == case.resolved
    with pytest.raises(TypeError, match="cannot be changed"):
        sent.resolved["loads"].clear()


def test_arrays_are_read_only():
    case = load_case(FILE)
    region = case.loads[0].region
    for array in (case.bodies[0].outline, case.cracks[0].points, case.supports[0].point, region.sides, region.limits):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


AWKWARD = [
    "units={length: cm, stress: kPa}",
    'bodies.rock.shape.rectangle.width="0.1234567890123456789 km"',
    "bodies.rock.shape.rectangle.height=33.3",
    "bodies.rock.shape.rectangle.center=[0.1, 0.7]",
    "bodies.rock.material={young: 70.1 GPa, poisson: 1e-1, density: 2.7 g/cm^3}",
    "cracks.flaw.path={center: [0.3, 0.7], length: 1.1, angle: 77.7}",
    "cracks.far={path: {points: [[3, 3], [3, 3], [4.1, 5.3], [6, 6]]}, tips: start, contact: none}",
    "supports=[{on: {body: rock, edge: bottom, from: -1.7, to: 3.3 mm}, displacement: {x: 0.1 um, y: -0.3}}]",
    "loads.0.on={body: rock, edge: left, from: 1 mm}",
    "numerics={spacing: 0.7, contact: {stiffness: 1.e+2, discretization: gauss, solver: lemke}}",
    "output={frames: none, fields: [], figures: false}",
    "title='on: #1 \"äöü\" \\ 10'",
]


STARTING = [
    "growth.initiation={at: outlines, spacing: 3}",
    "output.points={head: {at: [0, 20]}, mouth: {crack: flaw, at: [0, 0]}, width: {between: [[-9, 0], [9, 0]]}}",
    "cracks.flaw.contact={friction: 0.6, cohesion: 1, tension: 0.1, residual_friction: 0.3, cohesion_after_slip: kept}",
]
SLOW = [
    "growth={steps: 2, increment: 1, advance: all, criterion: max_hoop_stress, law: subcritical,"
    " subcritical: {velocity: 1 mm/day, exponent: 20, threshold: 0.2}}",
    "bodies.rock.strength={tension: 0.5, cohesion: 10, friction_angle: 40, toughness: 0.04 MPa sqrt(m)}",
]


@pytest.mark.parametrize("overrides", [[], AWKWARD, STARTING, SLOW])
def test_resolved_case_reads_back_bit_for_bit(overrides: list[str], tmp_path: Path):
    case = load_case(FILE, overrides)
    again = reread(case, tmp_path)
    assert same(case, again)
    assert dump_case(again) == dump_case(case)
    assert yaml.safe_load(dump_case(case)) == case.resolved


def test_round_trip_of_random_quantities(tmp_path: Path):
    rng = np.random.default_rng(5)
    for _ in range(20):
        width, height, young = (repr(float(v)) for v in 10 ** rng.uniform(0, 3, 3))
        unit = rng.choice(["m", "cm", "mm", "km"])
        overrides = [
            f"units.length={unit}",
            f"bodies.rock.shape.rectangle={{center: [0, 0], width: {width}, height: {height}}}",
            f"bodies.rock.material.young={young} GPa",
            "cracks={}",
            f"numerics.spacing={float(width) / 7 if float(width) < float(height) else float(height) / 7}",
            f"supports=[{{on: {{body: rock, edge: left}}, displacement: {{x: {rng.normal()}, y: {rng.normal()} um}}}}]",
        ]
        case = load_case(FILE, overrides)
        assert same(case, reread(case, tmp_path))


def test_vertices_within_a_thousandth_of_a_spacing_are_one_and_the_end_stays():
    points = "[[0, 0], [0, 0.0014], [3, 1], [4.9988, 5], [5, 5]]"  # mm, at a spacing of 1.5 mm
    case = load_case(FILE, [f"cracks.flaw.path={{points: {points}}}"])
    assert case.cracks[0].points.tolist() == [[0.0, 0.0], [0.003, 0.001], [0.005, 0.005]]
    finer = load_case(FILE, [f"cracks.flaw.path={{points: {points}}}", "numerics.spacing=1"])
    assert len(finer.cracks[0].points) == 5


@pytest.mark.parametrize(
    ("override", "read", "value"),
    [
        ("numerics.spacing=1.25", lambda c: c.numerics.spacing, 0.00125),
        ("numerics.spacing=2.5 mm", lambda c: c.numerics.spacing, 0.0025),
        ("cracks.flaw.contact.friction=0.3", lambda c: c.cracks[0].contact.friction, 0.3),
        ("cracks.flaw.contact=none", lambda c: c.cracks[0].contact, None),
        ("loads.1.traction.0=5", lambda c: c.loads[1].traction, (5e6, 1e8)),
        ("numerics.contact.stiffness=1e2", lambda c: c.numerics.contact.stiffness, 100.0),
        ("bodies.rock.material.density=2500", lambda c: c.bodies[0].material.density, 2500.0),
        ("units.length=cm", lambda c: c.numerics.spacing, 0.015),
        ("cracks.flaw.tips=end", lambda c: (c.cracks[0].tip_at_start, c.cracks[0].tip_at_end), (False, True)),
        ("growth.steps=1e1", lambda c: c.growth.steps, 10),
        ("growth.criterion=max_hoop_stress", lambda c: c.growth.criterion, "max_hoop_stress"),
    ],
)
def test_overrides(override, read, value):
    assert read(load_case(FILE, [override])) == value


def test_edge_support_with_part(tmp_path: Path):
    path = edited(tmp_path, "at: [0, -27.5] ", "on: {body: rock, edge: bottom, from: -5, to: 5} ")
    support = load_case(path).supports[2]
    assert isinstance(support, EdgeSupport)
    assert (support.region.body, support.region.edge, support.region.sides.tolist()) == ("rock", "bottom", [0])
    np.testing.assert_allclose(support.region.limits, [[10.5 / 31, 20.5 / 31]], rtol=1e-14)  # a few roundings


def without(tmp_path: Path, *keys: str) -> Path:
    """Write the resolved compression30 without some keys, such as "bodies.rock.strength"."""
    resolved = copy.deepcopy(load_case(FILE).resolved)
    for key in keys:
        *parents, last = key.split(".")
        mapping: dict = resolved
        for parent in parents:
            mapping = mapping[parent]
        del mapping[last]
    path = tmp_path / "without.yaml"
    path.write_text(yaml.safe_dump(resolved, sort_keys=False), encoding="utf-8")
    return path


def test_static_case_needs_no_strength(tmp_path: Path):
    case = load_case(without(tmp_path, "growth", "bodies.rock.strength"))
    assert case.growth is None
    assert case.bodies[0].strength is None
    assert same(case, reread(case, tmp_path))


def test_growth_needs_strength(tmp_path: Path):
    path = without(tmp_path, "bodies.rock.strength")
    (fault,) = faults_of(path)
    assert (fault.key, fault.line) == ("bodies.rock.strength", line_of(path, "rock:"))


REQUIRED = [
    "title",
    "plane",
    "bodies",
    "bodies.rock.shape",
    "bodies.rock.shape.rectangle.width",
    "bodies.rock.material",
    "bodies.rock.material.young",
    "bodies.rock.material.poisson",
    "bodies.rock.strength.cohesion",
    "cracks.flaw.path",
    "cracks.flaw.contact",
    "cracks.flaw.contact.friction",
    "growth.steps",
    "growth.increment",
    "growth.criterion",
    "growth.tip_stress",
    "growth.tip_stress.radius",
]


@pytest.mark.parametrize("key", REQUIRED)
def test_missing_key(key: str, tmp_path: Path):
    path = without(tmp_path, key)
    (fault,) = faults_of(path)
    assert fault.key == key
    assert fault.message.startswith("missing")
    parent = key.split(".")[-2] if "." in key else None
    expected = 1 if parent is None else line_of(path, f"{parent}:")
    assert fault.line == expected


OPTIONAL = ["source", "units", "loads", "loading", "growth", "growth.unload_between_steps", "numerics.contact"]
OPTIONAL += ["growth.direction", "interfaces", "numerics", "numerics.accuracy"]


@pytest.mark.parametrize("key", [*OPTIONAL, "output", "output.frames", "cracks.flaw.tips", "numerics.support"])
def test_key_that_may_be_missing(key: str, tmp_path: Path):
    load_case(without(tmp_path, key))
