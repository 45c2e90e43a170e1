"""The README's links lead to headings and files that are there, and the scenes that it lists are in `cases`."""

from __future__ import annotations

import re

from tests.readme.run import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
PROSE = re.sub(r"^```.*?^```$", "", README, flags=re.MULTILINE | re.DOTALL)


def anchor(heading: str) -> str:
    """The anchor that a heading gets: lower case, without punctuation, hyphens for blanks."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def test_links_lead_somewhere() -> None:
    anchors = {anchor(heading) for heading in re.findall(r"^#+ (.*)$", PROSE, flags=re.MULTILINE)}
    links = re.findall(r"\]\((?!https://)([^)]+)\)", PROSE)
    assert len(links) >= 10
    assert [link for link in links if link.startswith("#") and link.removeprefix("#") not in anchors] == []
    assert [link for link in links if not link.startswith("#") and not (ROOT / link).is_file()] == []


def test_pictures_are_all_shown() -> None:
    shown = set(re.findall(r"!\[[^\]]+\]\(\.readme/([^)]+)\)", PROSE))
    assert shown == {path.name for path in (ROOT / ".readme").iterdir()}


def test_scenes_that_are_listed_are_there() -> None:
    names = set(re.findall(r"`cases/(\w+)\.yaml`", README)) - {"NAME", "my_case", "my_rock", "my_blocks"}
    assert len(names) >= 15
    assert names - {path.stem for path in (ROOT / "cases").glob("*.yaml")} == set()


def test_a_picture_is_in_the_first_screen() -> None:
    assert README.index("](.readme/") < README.index("\n## ")
