"""Held loads, load histories and critical loads; growth of no steps, and with memory."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from crackgrow.case import dump_case, load_case
from crackgrow.case.model import CriticalLoad, LoadHistory
from crackgrow.errors import CaseError
from tests.unit.case.scenes import EVERYTHING, fault, load
from tests.unit.case.test_case_load import reread, same

CASES = Path(__file__).parents[3] / "cases"
FILE = CASES / "compression30.yaml"


def faults(*overrides: str) -> list[tuple[str, str]]:
    """Return key and message of the faults of compression30 with these overrides."""
    with pytest.raises(CaseError) as caught:
        load_case(FILE, overrides)
    return [(found.key, found.message) for found in caught.value.faults]


@pytest.mark.parametrize("path", sorted(CASES.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_shipped_case_loads_and_reads_back(path: Path, tmp_path: Path):
    case = load_case(path)
    again = reread(case, tmp_path)
    told = {"moved": (), "cut": ()}  # of the map, which was brought together when it was read first
    assert same(replace(case, **told), replace(again, **told))
    assert dump_case(again) == dump_case(case)


@pytest.mark.parametrize(
    ("setting", "factors"),
    [
        ("loading.history=[1, 0, -1]", (1.0, 0.0, -1.0)),
        ("loading={history: [0.5, 0.5, 1e-1]}", (0.5, 0.5, 0.1)),
        ("loading.history=[0]", (0.0,)),
        ("loading={}", (1.0,)),
    ],
)
def test_history(setting: str, factors: tuple[float, ...]):
    case = load_case(FILE, [setting])
    assert isinstance(case.loading, LoadHistory)
    assert case.loading.factors == factors


def test_the_way_to_a_load_is_taken_by_events_or_in_increments(tmp_path: Path):
    for setting, number in (("events", None), ("8", 8)):
        case = load_case(FILE, [f"loading.follow={setting}"])
        assert isinstance(case.loading, LoadHistory)
        assert (case.loading.factors, case.loading.increments) == ((1.0,), number)
        assert same(case, reread(case, tmp_path))
    assert faults("loading.follow=0")[0][0] == "loading.follow"


def test_critical_load(tmp_path: Path):
    case = load_case(FILE, ["loading=critical", "growth.steps=0"])
    assert isinstance(case.loading, CriticalLoad)
    assert case.growth is not None
    assert case.growth.steps == 0
    assert case.resolved["loading"] == "critical"
    assert same(case, reread(case, tmp_path))


def test_an_override_puts_a_history_in_the_place_of_a_word_and_back(tmp_path: Path):
    path = tmp_path / "critical.yaml"
    path.write_text(FILE.read_text(encoding="utf-8") + "\nloading: critical\n", encoding="utf-8")
    assert isinstance(load_case(path).loading, CriticalLoad)
    history = load_case(path, ["loading.history=[1, 0, -1]"]).loading
    assert isinstance(history, LoadHistory)
    assert history.factors == (1.0, 0.0, -1.0)
    assert isinstance(load_case(path, ["loading.history=[1]", "loading=critical"]).loading, CriticalLoad)
    last = load_case(path, ["loading=critical", "loading.history=[2, 3]", "loading.history.1=4"]).loading
    assert isinstance(last, LoadHistory)
    assert last.factors == (2.0, 4.0)


def test_a_word_gives_way_at_loading_only():
    ((key, message),) = faults("cracks.flaw.contact=none", "cracks.flaw.contact.friction=1")
    assert (key, message) == (
        "cracks.flaw.contact.friction",
        "cracks.flaw.contact is the single value 'none': no key inside it",
    )


def test_held_loads(tmp_path: Path):
    overrides = [f"loads.{index}.held=true" for index in (0, 2, 3, 4)]
    case = load(tmp_path, EVERYTHING, *overrides)
    assert [item.held for item in case.loads] == [True, False, True, True, True]
    assert [item["held"] for item in case.resolved["loads"]] == [True, False, True, True, True]  # type: ignore[attr-defined]
    assert not any(item.held for item in load(tmp_path, EVERYTHING).loads)


def test_friction_may_remember_between_steps():
    case = load_case(FILE, ["growth.unload_between_steps=false", "loading.history=[0.5, 1]"])
    assert case.growth is not None
    assert case.growth.unload_between_steps is False


HELD = ("loads.0.held=true", "loads.1.held=true")


def test_a_critical_load_needs_growth(tmp_path: Path):
    text = FILE.read_text(encoding="utf-8")
    before, _, after = text.partition("growth:  ")
    path = tmp_path / "static.yaml"
    path.write_text(f"{before}numerics:{after.partition('numerics:')[2]}", encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_case(path, ["loading=critical"])
    (found,) = caught.value.faults
    assert found.key == "loading"
    assert "critical needs `growth`, whose criterion says which load is critical (steps: 0" in found.message


@pytest.mark.parametrize(
    "overrides",
    [
        ("loads.0.held=true",),
        (*HELD, "supports.0.displacement.y=0.1"),
        (*HELD, 'supports.0={on: {body: rock, edge: bottom}, displacement: {y: "0.1 + 0.01*x"}}'),
        (*HELD, "loads=[{crack: flaw, pressure: -1}]"),
        ("loads=[{body: rock, stress: [0, 0, 1]}]",),
    ],
)
def test_what_a_critical_load_can_scale(overrides: tuple[str, ...]):
    assert isinstance(load_case(FILE, ["loading=critical", *overrides]).loading, CriticalLoad)


def test_other_faults_hide_what_a_critical_load_lacks(tmp_path: Path):
    scene: dict[str, Any] = {**EVERYTHING, "loads": [], "loading": "critical"}
    assert fault(tmp_path, scene, "supports.2.at=[99, 99]")[0] == "supports.2.at"
