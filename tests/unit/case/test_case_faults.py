"""Every kind of fault in a case: the right line, key and words."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from crackgrow.case import load_case
from crackgrow.case.load import read_case
from crackgrow.errors import CaseError, Fault
from tests.unit.case.scenes import rectangle, text_of, with_body

COMPRESSION = (Path(__file__).parent / "compression30.yaml").read_text(encoding="utf-8")


def faults_after(tmp_path: Path, *edits: tuple[str, str]) -> tuple[tuple[Fault, ...], list[str]]:
    """Return the faults of compression30 with texts replaced, and its lines."""
    text = COMPRESSION
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(path)
    assert {fault.source for fault in caught.value.faults} == {str(path)}
    return caught.value.faults, text.splitlines()


# text replaced, new text, key of the fault, words of its message, text of the line it names
FORMAT_FAULTS = [
    ("young: 10000 ", "yuong: 10000 ", "bodies.rock.material.yuong", "did you mean 'young'?", "yuong"),
    ("numerics:", "surprise: 3\nnumerics:", "surprise", "unknown key; allowed: title, source", "surprise"),
    ("young: 10000 ", "young: -10000 ", "bodies.rock.material.young", "wanted: a stress > 0", "young"),
    ("young: 10000 ", "young: 0 ", "bodies.rock.material.young", "out of range", "young"),
    ("young: 10000 ", "young: 10 mm ", "bodies.rock.material.young", "unit of length; wanted: a stress", "young"),
    ("young: 10000 ", "young: 10 Gpa ", "bodies.rock.material.young", "unknown unit; wanted", "young"),
    ("young: 10000 ", "young: '10000' ", "bodies.rock.material.young", "in quotes is a text", "young"),
    ("young: 10000 ", "young: .inf ", "bodies.rock.material.young", "not finite", "young"),
    ("young: 10000 ", "young: NaN ", "bodies.rock.material.young", "not finite", "young"),
    ("young: 10000 ", "young: 1e999 ", "bodies.rock.material.young", "too large", "young"),
    ("young: 10000 ", "young: 1e57 GPa ", "bodies.rock.material.young", "too large", "young"),
    ("young: 10000 ", "young: 1e-99 ", "bodies.rock.material.young", "too small", "young"),
    ("young: 10000 ", "young: 1e-999999999 ", "bodies.rock.material.young", "out of range", "young"),
    ("young: 10000 ", "young: true ", "bodies.rock.material.young", "neither a number nor", "young"),
    ("young: 10000 ", "young: [1] ", "bodies.rock.material.young", "a list given", "young"),
    ("young: 10000 ", "young: ", "bodies.rock.material.young", "no value given", "young"),
    ("young: 10000 ", "young: 0x2710 ", "bodies.rock.material.young", "unknown unit", "young"),
    ("poisson: 0.25", "poisson: 0.5", "bodies.rock.material.poisson", "plane strain", "poisson"),
    ("poisson: 0.25", "poisson: -1", "bodies.rock.material.poisson", "> -1", "poisson"),
    ("poisson: 0.25", "poisson: 0.25 mm", "bodies.rock.material.poisson", "not a number", "poisson"),
    ("friction_angle: 40", "friction_angle: 90", "bodies.rock.strength.friction_angle", "< 90", "friction_angle"),
    ("tension: 0.5", "tension: 0", "bodies.rock.strength.tension", "> 0", "tension: 0"),
    ("plane: strain ", "plane: strian ", "plane", "did you mean 'strain'?", "plane"),
    ("length: mm", "length: inch", "units.length", "not one of m | cm", "units"),
    ("[0, -100]", "[0, -100, 0]", "loads.0.traction", "a list of 3 given", "[0, -100, 0]"),
    ("[0, -100]", "[0, -1oo]", "loads.0.traction.1", "'-1oo'", "-1oo"),
    ("[0, -100]", "-100", "loads.0.traction", "a list of 2", "traction: -100"),
    ("{x: 0}", "{}", "supports.2.displacement", "at least one of x, y", "displacement: {}"),
    ("friction: 0.0", "friction: -0.1", "cracks.flaw.contact.friction", ">= 0", "friction: -0.1"),
    ("angle: 30 ", "angle: 30\n      points: [[0, 0]] ", "cracks.flaw.path.points", "give either", "points:"),
    ("tips: both", "tips: bothe", "cracks.flaw.tips", "did you mean 'both'?", "tips"),
    ("flaw:", "a.b:", "cracks.a.b", "is not a name", "a.b:"),
    ("steps: 22", "steps: 2.5", "growth.steps", "a whole number", "steps: 2.5"),
    ("steps: 22", "steps: 10001", "growth.steps", "<= 10000", "steps: 10001"),
    ("radius: 1 ", "radius: 0 ", "growth.tip_stress.radius", "> 0", "radius: 0"),
    ("directional_strength  #", "hoop_stress  #", "growth.criterion", "did you mean 'max_hoop_stress'?", "criterion:"),
    ("increment: 2 ", "direction: implict\n  increment: 2 ", "growth.direction", "did you mean 'implicit'?", "implict"),
    ("increment: 2 ", "direction: implicit\n  increment: 2 ", "growth.direction", "max_hoop_stress", "implicit"),
    ("increment: 2 ", "unload_between_steps: no\n  increment: 2 ", "growth.unload_between_steps", "true | false", "no"),
    ("steps: 22", "steps: -1", "growth.steps", "a whole number >= 0", "steps: -1"),
    ("spacing: 1.5", "spacing: 1.5\n  support: 2.1", "numerics.support", "steps of 0.25", "support: 2.1"),
    ("spacing: 1.5", "spacing: 1.5\n  quadrature: 1", "numerics.quadrature", ">= 2", "quadrature"),
    ("spacing: 1.5", "spacing: 1.5\n  accuracy: fin", "numerics.accuracy", "did you mean 'fine'?", "accuracy"),
    ("spacing: 1.5", "spacing: 1.5\n  accuracy: 50 %", "numerics.accuracy", "<= 0.2", "accuracy"),
    ("spacing: 1.5", "spacing: 1.5\n  accuracy: 1e-6", "numerics.accuracy", ">= 0.001", "accuracy"),
    ("spacing: 1.5", "spacing: 1.5\n  accuracy: 1 mm", "numerics.accuracy", "1 %", "accuracy"),
    ("spacing: 1.5", "spacing: atuo", "numerics.spacing", "did you mean 'auto'?", "atuo"),
    ("spacing: 1.5", "spacing: 1.5\n  contact: {stiffness: rgid}", "numerics.contact.stiffness", "'rigid'?", "rgid"),
    ("spacing: 1.5", "spacing: 1.5\n  contact: {stiffness: 0}", "numerics.contact.stiffness", "> 0", "stiffness"),
    ("spacing: 1.5", "spacing: 1.5\n  contact: {spacing: 5}", "numerics.contact.spacing", "<= 4", "{spacing"),
    (
        "numerics:",
        "loading: {history: []}\nnumerics:",
        "loading.history",
        "no factor given; wanted: at least",
        "loading",
    ),
    ("numerics:", "loading: {history: 1}\nnumerics:", "loading.history", "wanted: a list: each item a num", "loading"),
    ("numerics:", "loading: {history: [1, .inf]}\nnumerics:", "loading.history.1", "not finite", "loading"),
    ("numerics:", "loading: {histry: [1]}\nnumerics:", "loading.histry", "did you mean 'history'?", "loading"),
    (
        "numerics:",
        "loading: critcal\nnumerics:",
        "loading",
        "a mapping of history, stages, follow; did you mean 'critical'?",
        "loading",
    ),
    ("numerics:", "title: again\nnumerics:", "title", "given twice; the first is in line 3", "title: again"),
    ("poisson: 0.25", "poisson: 0.25\n      young: 3", "bodies.rock.material.young", "given twice", "young: 3"),
    ("poisson: 0.25", "poisson: *nu", "bodies.rock.material.poisson", "no value before it has the anchor", "*nu"),
    ("poisson: 0.25", "poisson: 0.25\n      <<: {a: 1}", "bodies.rock.material.<<", "merge keys", "<<"),
    ("poisson: 0.25", "poisson: !!python/name:os.system x", "bodies.rock.material.poisson", "tag", "poisson"),
    ("poisson: 0.25", "poisson: !mine 0.25", "bodies.rock.material.poisson", "tag '!mine'", "poisson"),
    ("poisson: 0.25", "poisson: 0.25\n      [1]: 2", "bodies.rock.material", "single word", "[1]"),
]


@pytest.mark.parametrize(("old", "new", "key", "words", "at"), FORMAT_FAULTS)
def test_fault_of_the_format(old: str, new: str, key: str, words: str, at: str, tmp_path: Path):
    (fault,), lines = faults_after(tmp_path, (old, new))
    assert fault.key == key
    assert words in fault.message
    assert fault.line is not None
    assert at in lines[fault.line - 1]


# as above, for what only a look at several parts can tell
SCENE_FAULTS = [
    (
        "center: [0, 0]               # midpoint",
        "center: [40, 0]",
        "cracks.flaw.path",
        "lies outside the outline of body 'rock'",
        "path:",
    ),
    ("length: 10 ", "length: 0.0001 ", "cracks.flaw.path", "less than 0.0001 of the lattice spacing", "path:"),
    (
        "0.0                # cohesion",
        "0\n  low: {path: {points: [[0, 5], [0, 0]]}, contact: none} #",
        "cracks.low.path",
        "the tip at the end (0 mm, 0 mm) lies on crack 'flaw'",
        "low",
    ),
    ("increment: 2 ", "increment: 0.00014 ", "growth.increment", "0.00015 mm", "increment"),
    ("spacing: 1.5", "spacing: 16", "numerics.spacing", "too coarse; at most half the smaller side", "spacing: 16"),
    ("spacing: 1.5", "spacing: 0.02", "numerics.spacing", "lattice nodes", "spacing: 0.02"),
    ("at: [-15.5, -27.5] ", "at: [-15.6, -27.5] ", "supports.0.at", "neither in nor on body 'rock'", "-15.6"),
    (
        "at: [-15.5, -27.5] ",
        "at: [15.5, -27.5] ",
        "supports.1.displacement",
        "prescribed already by supports.0",
        "y: 0",
    ),
    ("at: [-15.5, -27.5] ", "at: [0, 0] ", "supports.0.at", "lies on crack 'flaw'", "[0, 0]"),
    ("tension: 0.5 ", "tension: 12 ", "bodies.rock.strength.tension", "11.9175 MPa; wanted", "tension: 12"),
    ("edge: top}", "edge: topp}", "loads.0.on.edge", "bottom, right, top, left; did you mean 'top'?", "topp"),
    ("rock, edge: top}", "rok, edge: top}", "loads.0.on.body", "did you mean 'rock'?", "rok,"),
    ("edge: top}", "edge: top, from: -15.6}", "loads.0.on.from", "x from -15.5 mm to 15.5 mm", "from"),
    ("edge: top}", "edge: left, to: 27.6}", "loads.0.on.to", "y from -27.5 mm to 27.5 mm", "to: 27.6"),
    ("edge: top}", "edge: top, from: 1, to: 1}", "loads.0.on.from", "no length", "from"),
    ("edge: top}", "edge: top, from: 2, to: 1}", "loads.0.on.from", "must be less than", "from"),
    ("{x: 0}", "{y: 0}", "supports", "free to move: translation in x;", "supports:"),
    (
        "spacing: 1.5",
        "spacing: 1.5\n  contact: {discretization: gauss}",
        "numerics.contact.discretization",
        "no unique traction",
        "gauss",
    ),
]


@pytest.mark.parametrize(("old", "new", "key", "words", "at"), SCENE_FAULTS)
def test_fault_of_the_scene(old: str, new: str, key: str, words: str, at: str, tmp_path: Path):
    (fault,), lines = faults_after(tmp_path, (old, new))
    assert fault.key == key
    assert words in fault.message
    assert fault.line is not None
    assert at in lines[fault.line - 1]


def test_a_misspelt_required_key_is_one_fault(tmp_path: Path):
    (fault,), _ = faults_after(tmp_path, ("    material:", "    materials:"))
    assert fault.message.endswith("did you mean 'material'?")


def test_all_faults_at_once_in_file_order(tmp_path: Path):
    faults, lines = faults_after(
        tmp_path,
        ("plane: strain ", "plain: strain "),
        ("width: 31 ", "width: 31 MPa "),
        ("young: 10000 ", "young: -1 "),
        ("friction: 0.0", "friction: no"),
        ("steps: 22", "step: 22"),
        ("increment: 2 ", "increment: 0.0001 "),
        ("edge: top}", "edge: topp}"),
        ("numerics:", "nonsense: 1\nnumerics:"),
    )
    assert [fault.key for fault in faults] == [
        "plain",
        "bodies.rock.shape.rectangle.width",
        "bodies.rock.material.young",
        "cracks.flaw.contact.friction",
        "growth.step",
        "growth.increment",
        "nonsense",
    ]  # the edge is not known without the shape
    for fault in faults:
        assert fault.line is not None
        assert fault.key.rpartition(".")[2] + ":" in lines[fault.line - 1]


def test_message_is_one_line_per_fault(tmp_path: Path):
    text = COMPRESSION.replace("young: 10000 ", 'young: "1\\n\\x1b[31m 2" ').replace("tips: both", '"ti\\nps": both')
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(path)
    assert len(str(caught.value).splitlines()) == len(caught.value.faults) == 2
    assert str(caught.value).isprintable() is False  # only for the line break between the two
    assert all(str(fault).isprintable() for fault in caught.value.faults)


def keys_in(value: Any, before: str = "") -> Iterator[str]:
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
        yield f"{before}{key}"
        if isinstance(inner, dict | list):
            yield from keys_in(inner, f"{before}{key}.")


@pytest.mark.parametrize("value", ["5", "[[1]]", "{a: 1}"])
def test_a_value_of_the_wrong_kind_is_a_fault_wherever_it_stands(value: str):
    scene = {
        **with_body(rectangle(0, 0, 4, 4)),
        "loads": [{"on": {"edge": "top"}, "traction": [0, 1], "name": "push"}],
        "loading": {"stages": [{"factor": 1, "loads": {"push": 1}}, {"factor": 2}]},
        "numerics": {"refine": {"tips": 1}, "spacing": "auto", "contact": {"stiffness": 2}},
        "output": {"fields": ["stress"], "points": {"middle": {"at": [1, 2]}}},
    }
    text, refused = text_of(scene), 0
    for key in keys_in(scene):
        try:
            read_case(text, "scene.yaml", "scene", [f"{key}={value}"])
        except CaseError:
            refused += 1
    assert refused > 30
