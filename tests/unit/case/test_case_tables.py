"""What is refused of cases and what is read of them, by the tables faults.yaml and read.yaml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.case.segments import meeting_places
from crackgrow.errors import CaseError
from tests.scenes import faults_of
from tests.unit.case.scenes import COMPRESSION, EVERYTHING, edited, reread, same, text_of

ROOT = Path(__file__).parents[3]
HERE = Path(__file__).parent
TABLE = yaml.safe_load((HERE / "faults.yaml").read_text(encoding="utf-8"))
READ = yaml.safe_load((HERE / "read.yaml").read_text(encoding="utf-8"))
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


def at(found: Any, name: str) -> Any:
    """What a name such as cracks.0.points leads to, arrays as lists."""
    first, _, rest = name.partition(".")
    if isinstance(found, np.ndarray):
        return at(found.tolist(), name)
    if first == "":
        return [at(each, "") for each in found] if isinstance(found, tuple | list) else found
    if first == "*":
        return [at(each, rest) for each in found]
    if isinstance(found, tuple | list):
        return at(found[int(first)] if first.isdigit() else {each.name: each for each in found}[first], rest)
    return at(getattr(found, first), rest)


def assert_alike(found: Any, wanted: Any, within: float) -> None:
    if isinstance(wanted, list):
        assert len(found) == len(wanted), (found, wanted)
        for one, other in zip(found, wanted, strict=True):
            assert_alike(one, other, within)
    elif isinstance(wanted, int | float) and not isinstance(wanted, bool):
        assert found == pytest.approx(wanted, rel=1e-15, abs=within)
    else:
        assert found == wanted


@pytest.mark.parametrize(
    ("group", "row"),
    [
        pytest.param(group, row, id=f"{group['about']}: {row[0]}".encode("ascii", "replace").decode()[:150])
        for group in READ
        for row in group["rows"]
    ],
)
def test_read(group: dict[str, Any], row: list[Any], tmp_path: Path):
    """A case of read.yaml has these values, and reads back to the last bit, where it needs its files no more."""
    settings, _ = written(group, row[0], tmp_path)
    case = load_case(tmp_path / "scene.yaml", settings)
    for name, wanted in (dict(zip(group.get("wanted", ()), row[1:], strict=True)) | group.get("are", {})).items():
        meetings = meeting_places([crack.points for crack in case.cracks], 1e-8)
        found = meetings.tolist() if name == "meetings" else at(case, name)
        assert_alike(found, wanted, 1.4e-8 if name == "meetings" else group.get("within", 1e-15))
    (tmp_path / "elsewhere").mkdir()
    told: dict[str, Any] = {"moved": (), "cut": ()}  # of what was brought together when it was read first
    assert same(replace(reread(case, tmp_path / "elsewhere"), **told), replace(case, **told))
