"""Every kind of fault in a case: the right line, key and words."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.case.load import read_case
from crackgrow.errors import CaseError, Fault
from tests.unit.case.scenes import rectangle, text_of, with_body

ROOT = Path(__file__).parents[3]
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


GROUPS = yaml.safe_load(Path(__file__).with_name("faults.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("group", "row"),
    [
        pytest.param(group, row, id=f"{group['about']}: {row['key']}: {row['words']}")
        for group in GROUPS
        for row in group["faults"]
    ],
)
def test_fault(group: dict[str, Any], row: dict[str, Any], tmp_path: Path):
    """A case of faults.yaml is refused for its key, with these words, where they are looked for."""
    text = row.get("text", group.get("text"))
    if text is None:
        text = text_of(group["scene"]) if "scene" in group else (ROOT / group["file"]).read_text(encoding="utf-8")
    for old, new in (*group.get("edit", ()), *row.get("edit", ())):
        assert text.count(old) == 1
        text = text.replace(old, new)
    for name, content in {"scene.yaml": text, **group.get("files", {}), **row.get("files", {})}.items():
        (tmp_path / name).write_text(content, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(tmp_path / "scene.yaml", [*group.get("set", ()), *row.get("set", ())])
    told = caught.value.faults
    assert len(told) == row.get("faults", 1)
    (fault,) = (fault for fault in told if row["words"] in str(fault) and fault.key == row["key"])
    assert (fault.line is None) == fault.source.startswith("--set")
    assert str(fault).isprintable()
    if "edit" in row:
        assert fault.line is not None
        assert row.get("at", "") in text.splitlines()[fault.line - 1]


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
