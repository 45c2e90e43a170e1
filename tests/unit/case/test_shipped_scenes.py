"""What the shipped scenes show of the format: every key of the reference stands in one of them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.yaml12 import read_yaml12

CASES = Path(__file__).parents[3] / "cases"
ROW = re.compile(r"^\| `(\S+)` \| .*? \| (.*?) \| [^|]*\|$", re.MULTILINE)
LEFT_OUT = {"cracks.NAME.path.layer": "of a GeoPackage alone, which is no text"}
"""Keys that no scene has, and why."""

TUTORIAL = sorted(CASES.glob("[0-9][0-9]_*.yaml"))


def reference() -> dict[str, str]:
    """What each key of KEYS.md takes, by its whole name."""
    found: dict[str, str] = {}
    for section in (CASES / "KEYS.md").read_text(encoding="utf-8").split("\n## ")[1:]:
        head = section.split("`")[1]
        found.update({head + key if key.startswith(".") else key: takes for key, takes in ROW.findall(section)})
    return found


def keys_in(value: Any, before: str = "") -> Iterator[str]:
    """The dotted names of all keys below a value."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for name, inner in items:
        yield f"{before}{name}"
        yield from keys_in(inner, f"{before}{name}.")


def keys_of(text: str) -> set[str]:
    """The keys of a case, those that it sets on its base as if they stood in it."""
    case = read_yaml12(text)
    names = [
        *keys_in(case),
        *(f"{key}.{name}" for key, value in case.get("set", {}).items() for name in keys_in(value)),
    ]
    whole = [*names, *case.get("set", {})]
    return {".".join(parts[: end + 1]) for parts in (name.split(".") for name in whole) for end in range(len(parts))}


def stands(key: str, takes: dict[str, str], used: set[str]) -> bool:
    """Whether a key is used where the reference has it, or where another key takes the same mapping."""
    places = [key]
    for other, text in takes.items():
        if (like := re.search(r"with the keys of ([\w.]+\w)", text)) and key.startswith(f"{like[1]}."):
            by_name = ".NAME.NAME" if other.endswith("contact_by") else ""
            places.append(other + by_name + key.removeprefix(like[1]))
    patterns = (re.escape(place).replace("NAME", r"[^.]+").replace(r"\.N\.", r"\.\d+\.") for place in places)
    return any(re.fullmatch(pattern, name) for pattern in patterns for name in used)


def test_every_key_stands_in_a_shipped_scene() -> None:
    takes = reference()
    used = set().union(*(keys_of(file.read_text(encoding="utf-8")) for file in CASES.glob("*.yaml")))
    assert {key for key in takes if not stands(key, takes, used)} == set(LEFT_OUT)


def test_a_key_that_no_scene_has_is_found() -> None:
    takes = reference()
    used = set().union(*(keys_of(file.read_text(encoding="utf-8")) for file in TUTORIAL))
    assert not stands("laws.NAME.barton.jrc", takes, used)
    assert stands("laws.NAME.wear.slip", takes, used)
    assert len(takes) > 150


@pytest.mark.parametrize("file", TUTORIAL, ids=lambda file: file.stem)
def test_a_scene_of_the_tutorial_is_short_and_says_what_one_sees(file: Path) -> None:
    lines = file.read_text(encoding="utf-8").splitlines()
    words = [line for line in lines[:5] if line.startswith("# ")]
    assert len(words) == 5
    assert words[0].startswith(f"# Tutorial {int(file.stem[:2])}: ")
    assert words[1].startswith("# You see ")
    assert words[4].startswith("# New: ")
    assert len(lines) <= 30
