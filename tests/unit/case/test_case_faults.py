"""Every kind of fault in a case: the right line, key and words."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.errors import CaseError
from tests.unit.case.scenes import COMPRESSION, EVERYTHING, edited, faults_of, text_of

ROOT = Path(__file__).parents[3]
TABLE = yaml.safe_load(Path(__file__).with_name("faults.yaml").read_text(encoding="utf-8"))
SCENES = {name: text_of(scene) for name, scene in {"everything": EVERYTHING, **TABLE["cases"]}.items()}
SCENES |= {"compression30": COMPRESSION, "none": "# no case"}


def written(group: dict[str, Any], change: Any, folder: Path) -> tuple[list[str], set[int]]:
    """The settings of a row of faults.yaml, whose files are written, and the numbers of the lines that it changes."""
    case = group["case"]
    text = SCENES.get(case) or (ROOT / case).read_text(encoding="utf-8")
    edits, settings, files = dict(group.get("edit", ())), list(group.get("set", ())), dict(group.get("files", {}))
    if "write" in group:
        files[group["write"]] = change
    elif "replace" in group and not isinstance(change, Mapping):
        edits[group["replace"]] = change
    elif isinstance(change, Mapping):
        edits |= change
    else:
        one = f"{group['of']}={change}" if "of" in group and isinstance(change, str) else change
        settings += [one] if isinstance(one, str) else one
    lines: set[int] = set()
    for old, new in edits.items():
        assert text.count(old) == 1
        first = text[: text.index(old)].count("\n") + 1
        lines |= set(range(first, first + new.count("\n") + 1))
        text = text.replace(old, new)
    for name, content in {"scene.yaml": text, **files}.items():
        (folder / name).write_text(content, encoding="utf-8")
    return settings, lines


@pytest.mark.parametrize(("group", "row"), [
    pytest.param(group, row, id=f"{group['about']}: {row[0]}".encode("ascii", "replace").decode()[:150])
    for group in TABLE["groups"]
    for row in group["rows"]
])  # fmt: skip
def test_fault(group: dict[str, Any], row: list[Any], tmp_path: Path):
    """A case of faults.yaml is refused for its key, with these words, where they are looked for."""
    change, *keys, words, at = row if len(row) == 4 else [*row, None]
    common = group.get("key", group.get("of", ""))
    key = keys[0] if keys and keys[0] is not None else common
    key = f"{common}{key}" if key.startswith(".") else key
    settings, lines = written(group, change, tmp_path)
    with pytest.raises(CaseError) as caught:
        load_case(tmp_path / "scene.yaml", settings)
    told = caught.value.faults
    assert len(told) == group.get("faults", 1), told
    assert [fault.key for fault in told if words in str(fault)] == [key], told
    (fault,) = (fault for fault in told if fault.key == key and words in str(fault))
    assert (fault.line is None) == fault.source.startswith("--set")
    assert str(fault).isprintable()
    if at is not None:
        assert at in (tmp_path / "scene.yaml").read_text(encoding="utf-8").splitlines()[(fault.line or 0) - 1]
    elif lines and not settings:
        assert fault.line in lines


def test_all_faults_at_once_in_file_order(tmp_path: Path):
    """One of each that is misspelt, also of a key that is required; edges are not known without the shape."""
    path = edited(
        tmp_path,
        ("plane: strain ", "plain: strain "),
        ("width: 31 ", "width: 31 MPa "),
        ("friction: 0.0", "friction: no"),
        ("steps: 22", "step: 22"),
        ("edge: top}", "edge: topp}"),
        ("numerics:", "nonsense: 1\nnumerics:"),
    )
    faults, lines = faults_of(path), path.read_text(encoding="utf-8").splitlines()
    keys = ["plain", "bodies.rock.shape.rectangle.width", "cracks.flaw.contact.friction", "growth.step", "nonsense"]
    assert [fault.key for fault in faults] == keys
    for fault in faults:
        assert fault.key.rpartition(".")[2] + ":" in lines[(fault.line or 0) - 1]
