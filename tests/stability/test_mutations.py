"""Mutated case files are accepted or refused with a place; nothing else happens, and none takes long."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.case import load_case
from crackgrow.cli.start import template_text
from crackgrow.errors import CaseError
from tests.stability.mutants import LONGEST, Verdict, peak_memory, verdicts
from tests.stability.mutations import KINDS, NAMES, TAGS, good_cases

CASES = Path(__file__).parents[2] / "cases"

MOST_MEMORY = 600.0
"""MiB that the process of the tests may grow by."""

LEAST_AGREEMENT = 0.95
"""Of the mutants that the reader refuses for one value alone, or as YAML: how many the JSON Schema refuses, too."""


def judged(n: int, first: int = 0) -> list[Verdict]:
    before = peak_memory()
    found = list(verdicts(n, first))
    assert [(v.number, v.kind, v.case, v.broken) for v in found if v.broken] == []
    assert max(v.seconds for v in found) < LONGEST
    assert peak_memory() - before < MOST_MEMORY
    return found


def agreement(found: list[Verdict]) -> float:
    refused = [v for v in found if v.wrong_alone]
    return sum(not v.editor_accepts for v in refused) / len(refused)


def test_mutants_are_accepted_or_refused_with_a_place() -> None:
    found = judged(300)
    assert {v.kind for v in found} == set(KINDS)
    assert 0.5 < sum(not v.accepted for v in found) / len(found) < 1.0
    assert agreement(found) >= LEAST_AGREEMENT
    assert [(v.number, v.kind, v.case) for v in found if v.accepted and not v.editor_accepts] == []


@pytest.mark.slow
def test_twenty_thousand_mutants() -> None:
    assert agreement(judged(20_000, first=300)) >= LEAST_AGREEMENT


@pytest.mark.parametrize("tag", TAGS)
def test_tags_never_construct_anything(tag: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.yaml").write_text(template_text("tension").replace('source: ""', f"source: {tag}"))
    with pytest.raises(CaseError, match=r"scene\.yaml:\d+: source: "):
        load_case("scene.yaml")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.yaml"]


@pytest.mark.parametrize("name", NAMES)
def test_names_cannot_lead_out_of_the_folder_of_the_results(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "inner").mkdir()
    monkeypatch.chdir(tmp_path / "inner")
    text = template_text("tension").replace("notch:", f'"{name}":').replace("steps: 6", "steps: 0")
    Path("scene.yaml").write_text(text, encoding="utf-8")
    code = cli.main(["run", "scene.yaml", "--quiet", "--set", "numerics.spacing=6", "--set", "output.figures=false"])
    assert code in (0, 2)
    assert [path.name for path in tmp_path.iterdir()] == ["inner"]
    assert {path.name for path in Path().iterdir()} <= {"scene.yaml", "outputs"}
    assert [path.name for path in Path("outputs").glob("*")] == ([] if code else ["scene"])


def test_good_cases_are_good(tmp_path: Path) -> None:
    """Else mutants would be refused for what they were made from."""
    for file in CASES.glob("*.geojson"):
        shutil.copy(file, tmp_path)
    for text in good_cases().values():
        (tmp_path / "scene.yaml").write_text(text, encoding="utf-8")
        assert load_case(tmp_path / "scene.yaml").bodies
