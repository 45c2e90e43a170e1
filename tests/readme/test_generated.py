"""The generated parts of the READMEs are current, and nothing that they should tell of lacks its line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest

from crackgrow import cli
from crackgrow.case.accuracy import CELLS
from crackgrow.case.json_schema import case_schema
from crackgrow.case.keys import case_keys
from crackgrow.cli.command_line import command_line
from crackgrow.cli.parser import GROUPS, commands_of
from crackgrow.cli.reference import FOLDERS, key_entry
from tests.readme.generated import CELL_RULES, PARTS, part_of, with_part
from tests.readme.run import ROOT


@pytest.mark.parametrize(("file", "name"), PARTS)
def test_parts_are_current(file: str, name: str) -> None:
    text = (ROOT / file).read_text(encoding="utf-8")
    assert part_of(text, name).strip() == PARTS[file, name]().strip(), "write it with: make docs"


def test_a_part_is_replaced_and_nothing_else() -> None:
    text = "a\n<!-- generated: x -->\n\nold\n\n<!-- end -->\nb\n<!-- generated: y -->\n<!-- end -->\n"
    assert part_of(with_part(text, "x", "new | \\n"), "x").strip() == "new | \\n"
    assert with_part(with_part(text, "x", "new"), "x", "old") == text
    with pytest.raises(ValueError, match="no part <!-- generated: z -->"):
        part_of(text, "z")


def schema_keys(schema: dict[str, Any], before: str = "") -> Iterator[str]:
    """Dotted names of all keys that the JSON Schema of cases has, wherever it has them."""
    for name, inner in schema.get("properties", {}).items():
        yield before + name
        yield from schema_keys(inner, f"{before}{name}.")
    if isinstance(schema.get("additionalProperties"), dict):
        yield from schema_keys(schema["additionalProperties"], f"{before}NAME.")
    if "items" in schema:
        yield from schema_keys(schema["items"], f"{before}N.")
    for form in schema.get("anyOf", ()):
        yield from schema_keys(form, before)


def test_every_key_of_the_format_is_told_of() -> None:
    told = {key.name for key in case_keys()}
    untold = {"numerics.auto_rule", "loads.N.along", "supports.N.along"}  # the program's own; other spellings of `on`
    assert set(schema_keys(json.loads(case_schema()))) - told == untold
    assert len(told) == len(case_keys())


def test_every_key_has_its_line() -> None:
    assert [key.name for key in case_keys() if not (key.doc.strip() and key.kind and key.default)] == []
    assert [key.name for key in case_keys() if key_entry(key).facts["type"].startswith("<")] == []


def test_every_file_and_column_has_its_line() -> None:
    files = [file for files in FOLDERS.values() for file in files]
    assert [file.name for file in files if len(file.doc) < 10] == []
    assert [(file.name, column.name) for file in files for column in file.columns if len(column.doc) < 5] == []
    assert all(len(set(file.header)) == len(file.columns) for file in files)


def test_explain_prints_the_line_of_the_reference(capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "cases" / "KEYS.md").read_text(encoding="utf-8")
    (row,) = (line for line in text.splitlines() if line.startswith("| `.refine.rings` |"))
    assert cli.main(["explain", "numerics.refine.rings"]) == 0
    words = [line.split(maxsplit=1)[1] for line in capsys.readouterr().out.splitlines()[1:]]
    assert [word for word in words if word not in row] == []


def test_every_number_of_cells_is_told_of() -> None:
    assert set(CELL_RULES) == set(CELLS)


def test_every_command_is_in_one_group() -> None:
    listed = [name for names in GROUPS.values() for name in names]
    assert sorted(listed) == sorted(commands_of(command_line()).choices)
