"""The READMEs: generated parts are current and complete, links and pictures are there, what is shown is right."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from crackgrow.case import load_case
from crackgrow.case.accuracy import CELLS
from crackgrow.case.json_schema import case_schema
from crackgrow.case.keys import case_keys
from crackgrow.cli.reference import FOLDERS, key_entry
from tests.readme.generated import CELL_RULES, PARTS, part_of, tutorial_settings
from tests.readme.run import EXIT_CODES, NEEDS_A_WINDOW, READMES, ROOT, all_commands

TEXTS = {name: (ROOT / name).read_text(encoding="utf-8") for name in READMES}
SCHEMA = json.loads(case_schema())
LINK = re.compile(r"\]\((?!https://)([^)]+)\)")


@pytest.mark.parametrize(("file", "name"), PARTS)
def test_generated_parts_are_current(file: str, name: str) -> None:
    assert part_of(TEXTS[file], name).strip() == PARTS[file, name]().strip(), "write it with: make docs"


def schema_keys(schema: dict[str, Any], before: str = "") -> Iterator[str]:
    """Dotted names of all keys that the JSON Schema of cases has, wherever it has them."""
    for name, inner in schema.get("properties", {}).items():
        yield before + name
        yield from schema_keys(inner, f"{before}{name}.")
    if isinstance(schema.get("additionalProperties"), dict):
        yield from schema_keys(schema["additionalProperties"], f"{before}NAME.")
    if "items" in schema:
        yield from schema_keys(schema["items"], f"{before}N.")
    for form in (*schema.get("anyOf", ()), *schema.get("allOf", ())):
        yield from schema_keys(form, before)
    if "$ref" in schema:
        yield from schema_keys(SCHEMA["$defs"][schema["$ref"].rpartition("/")[2]], before)


def test_every_key_of_the_format_has_its_line() -> None:
    told = {key.name for key in case_keys()}
    untold = {"numerics.auto_rule", "loads.N.along", "supports.N.along"}  # the program's own; other spellings of `on`
    assert {name for name in schema_keys(SCHEMA) if ".along." not in name} - told == untold
    assert len(told) == len(case_keys())
    assert [key.name for key in case_keys() if not (key.doc.strip() and key.kind and key.default)] == []
    assert [key.name for key in case_keys() if key_entry(key).facts["type"].startswith("<")] == []


def test_every_file_column_and_number_of_cells_has_its_line() -> None:
    files = [file for files in FOLDERS.values() for file in files]
    assert [file.name for file in files if len(file.doc) < 10] == []
    assert [(file.name, column.name) for file in files for column in file.columns if len(column.doc) < 5] == []
    assert all(len(set(file.header)) == len(file.columns) for file in files)
    assert set(CELL_RULES) == set(CELLS)


def test_every_readme_is_run_and_what_is_not_is_a_command_of_them() -> None:
    files = (path.relative_to(ROOT) for path in ROOT.rglob("README.md"))
    written = {str(f) for f in files if f.parts[0] != "build" and not any(part.startswith(".") for part in f.parts)}
    assert written <= set(READMES)
    shown = {command.text for command in all_commands()}
    assert {*NEEDS_A_WINDOW, *EXIT_CODES, "make run CASE=compression30"} <= shown


def prose(text: str) -> str:
    """The text without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(text: str) -> set[str]:
    """The anchors of the headings: lower case, without punctuation, hyphens for blanks."""
    headings = re.findall(r"^#+ (.*)$", prose(text), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("name", READMES)
def test_links_lead_somewhere(name: str) -> None:
    broken = []
    for link in LINK.findall(prose(TEXTS[name])):
        file, _, anchor = link.partition("#")
        target = (ROOT / name).parent / file if file else ROOT / name
        if not target.is_file() or (anchor and anchor not in anchors(target.read_text(encoding="utf-8"))):
            broken.append(link)
    assert broken == []


def test_files_that_are_named_are_there() -> None:
    """Of the package in its README, and of tests in docstrings and texts."""
    named = {f"crackgrow/{name}" for name in re.findall(r"`(\w+/\w+\.py)`", TEXTS["crackgrow/README.md"])}
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "crackgrow").rglob("*.py")]
    named |= {name for text in (*TEXTS.values(), *sources) for name in re.findall(r"\btests/[\w/]+\.(?:py|md)\b", text)}
    assert [name for name in sorted(named) if not (ROOT / name).is_file()] == []


def test_pictures_and_scenes_are_all_shown() -> None:
    shown = {name for text in TEXTS.values() for name in re.findall(r"!\[[^\]]+\]\([./]*/?\.readme/([^)]+)\)", text)}
    assert shown == {path.name for path in (ROOT / ".readme").iterdir()}
    listed = set(re.findall(r"^\| .*", TEXTS["cases/README.md"].split("## Before a run")[0], flags=re.MULTILINE))
    names = {name for line in listed for name in re.findall(r"`(\w+)\.yaml`", line)}
    assert names == {path.stem for path in (ROOT / "cases").glob("*.yaml") if not path.stem.startswith("my_")}


def test_the_first_readme_shows_a_case_and_how_to_look_at_it(tmp_path: Path) -> None:
    (shown,) = re.findall(r"^```yaml\n(.*?)^```$", TEXTS["README.md"], flags=re.MULTILINE | re.DOTALL)
    (tmp_path / "shown.yaml").write_text(shown)
    case = load_case(tmp_path / "shown.yaml")
    assert case.growth is not None
    assert (case.growth.steps, case.cracks[0].name) == (8, "flaw")
    factor, low, high = tutorial_settings()
    assert factor >= 1.0
    assert -low == high > 0.0
