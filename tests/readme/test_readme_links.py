"""What the READMEs link to and show is there, the first one is short, and the case that it shows is one."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from crackgrow.case import load_case
from tests.readme.run import READMES, ROOT

TEXTS = {name: (ROOT / name).read_text(encoding="utf-8") for name in READMES}
MOST_BYTES = 9 * 1024  # of the first one
LINK = re.compile(r"\]\((?!https://)([^)]+)\)")


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


def test_every_readme_can_be_reached_from_the_first() -> None:
    reached, waiting = {"README.md"}, ["README.md"]
    while waiting:
        name = waiting.pop()
        links = {link.partition("#")[0] for link in LINK.findall(prose(TEXTS[name]))}
        files = {str(((ROOT / name).parent / link).resolve().relative_to(ROOT)) for link in links if link}
        new = (files & set(READMES)) - reached
        reached |= new
        waiting += new
    assert reached == set(READMES)


def test_pictures_are_all_shown() -> None:
    shown = {name for text in TEXTS.values() for name in re.findall(r"!\[[^\]]+\]\([./]*/?\.readme/([^)]+)\)", text)}
    assert shown == {path.name for path in (ROOT / ".readme").iterdir()}


def test_scenes_that_are_listed_are_there_and_all_are_listed() -> None:
    listed = set(re.findall(r"^\| .*", TEXTS["cases/README.md"].split("## Before a run")[0], flags=re.MULTILINE))
    names = {name for line in listed for name in re.findall(r"`(\w+)\.yaml`", line)}
    assert names == {path.stem for path in (ROOT / "cases").glob("*.yaml") if not path.stem.startswith("my_")}


def test_the_first_readme_is_short_and_begins_with_a_picture() -> None:
    text = TEXTS["README.md"]
    assert len(text.encode()) <= MOST_BYTES
    assert text.index("](.readme/") < text.index("\n## ")
    assert text.index("](.readme/") < 700


def test_the_case_of_the_first_readme_is_one(tmp_path: Path) -> None:
    (shown,) = re.findall(r"^```yaml\n(.*?)^```$", TEXTS["README.md"], flags=re.MULTILINE | re.DOTALL)
    (tmp_path / "shown.yaml").write_text(shown)
    case = load_case(tmp_path / "shown.yaml")
    assert (case.growth.steps, case.cracks[0].name) == (8, "flaw")
    assert 25 <= len(shown.splitlines()) <= 32


def test_the_licence_is_told_to_be_open() -> None:
    assert "not chosen yet" in TEXTS["README.md"]
