"""Random scenes, judged from their files alone: what is wrong must be told by the run."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.stability.growing_scenes import Scene, growing_scene, text_of
from tests.stability.judge.court import Court
from tests.stability.judge.verdict import judged
from tests.stability.judge.written import WrittenRun, run_case

GROWING = (1, 16, 10, 31, 4)
"""Seeds: growth in tension, of edge cracks, with fluid pressure, of a block on a base, of pieces that lie anywhere."""
MANY = 400

NO_EXCUSE = ("energy balance", "dissipation falls", "released energy below zero", "reactions", "moment")
"""In scenes that are no limit states the run may not even have to tell of these."""

DONE = ("completed", "arrested", "broke_through")


def run_scene(folder: Path, name: str, document: Scene) -> WrittenRun:
    file = folder / f"{name}.yaml"
    file.write_text(text_of(document), encoding="utf-8")
    return run_case(file, folder / name)


def silent(court: Court, no_excuse: tuple[str, ...] = ()) -> list[str]:
    """Departures that the run has not told of, or that it may not have."""
    wrong = [departure for departure in court.departures if departure.kind in no_excuse or not departure.told]
    return [f"{d.kind} {d.size:.2g} step {d.step} {d.place}" for d in wrong]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[int, WrittenRun]:
    folder = tmp_path_factory.mktemp("runs")
    return {seed: run_scene(folder, str(seed), growing_scene(seed)) for seed in GROWING}


def test_nothing_is_wrong_without_a_word(runs: dict[int, WrittenRun]) -> None:
    for seed, run in runs.items():
        assert run.summary["status"] in DONE, f"seed {seed}: {run.errors}"
        assert not silent(judged(run), NO_EXCUSE), f"seed {seed}"
    assert sum(len(run.tables["steps"]) for run in runs.values()) > 12


@pytest.mark.slow
def test_nothing_is_wrong_without_a_word_in_many_scenes(tmp_path: Path) -> None:
    n_solved = 0
    for seed in range(MANY):
        found = judged(run_scene(tmp_path, f"growing{seed}", growing_scene(seed)))
        assert not silent(found), f"growing {seed}"
        n_solved += found.run.exit_code == 0
    assert n_solved > 0.7 * MANY
