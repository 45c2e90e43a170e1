"""Random scenes, judged from their files alone: what is wrong must be told by the run."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from crackgrow.case.surface import crack_name
from crackgrow.cover.cover import build_cover
from crackgrow.cover.lattice import place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry
from crackgrow.geometry.tolerance import ON_LINE
from tests.stability.growing_scenes import Scene, growing_scene, text_of
from tests.stability.judge.balance import judge_energies, judge_forces
from tests.stability.judge.contact import judge_contact
from tests.stability.judge.tips import judge_tips
from tests.stability.judge.written import Court, WrittenRun, run_case

DONE = ("completed", "arrested", "broke_through")

CHECKS: tuple[Callable[[Court], None], ...] = (judge_contact, judge_forces, judge_energies, judge_tips)


def judged(run: WrittenRun) -> Court:
    """All checks that what is there allows."""
    court = Court(run)
    court.check("bug", float(run.exit_code not in (0, 2, 3) or "Traceback" in run.errors), 0.5, 0)
    if run.exit_code == 0:
        court.check("status", float(run.summary.get("status") not in DONE), 0.5, 0)
    if run.exit_code in (2, 3):
        court.check("no reason", float(not re.search(r"\S+: \S+", run.errors)), 0.5, 0)
    solved = len(run.tables) == 6 and len(run.tables["steps"]) and run.exit_code in (0, 3)
    for check in CHECKS if solved else ():
        check(court)
    return court


GROWING = (1, 16, 10, 31, 4)
"""Seeds: growth in tension, of edge cracks, with fluid pressure, of a block on a base, of pieces that lie anywhere."""
MANY = 400

NO_EXCUSE = ("energy balance", "dissipation falls", "released energy below zero", "reactions", "moment")
"""In scenes that are no limit states the run may not even have to tell of these."""


def run(folder: Path, document: Scene) -> WrittenRun:
    """The run of a document by the command line."""
    folder.mkdir()
    (folder / "scene.yaml").write_text(text_of(document), encoding="utf-8")
    return run_case(folder / "scene.yaml", folder / "out")


def silent(court: Court, no_excuse: tuple[str, ...] = ()) -> list[str]:
    """Departures that the run has not told of, or that it may not have."""
    wrong = [departure for departure in court.departures if departure.kind in no_excuse or not departure.told]
    return [f"{d.kind} {d.size:.2g} step {d.step} {d.place}" for d in wrong]


@pytest.mark.parametrize("seeds", [GROWING, pytest.param(range(MANY), marks=pytest.mark.slow)], ids=len)
def test_nothing_is_wrong_without_a_word(seeds: Sequence[int], tmp_path: Path) -> None:
    n_solved, few = 0, seeds == GROWING
    for seed in seeds:
        found = run(tmp_path / str(seed), growing_scene(seed))
        assert not few or found.summary["status"] in DONE, f"seed {seed}: {found.errors}"
        assert not silent(judged(found), NO_EXCUSE if few else ()), f"seed {seed}"
        n_solved += found.exit_code == 0
    assert n_solved > 0.7 * len(seeds)


# Scenes that random ones came down to: each of them was refused or wrong once, without need.


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_cracks_start_anywhere_on_a_slanting_side(support: float) -> None:
    """Rounding puts the end to either side of the outline; a speck of rock between them would cut the crack short."""
    corners = np.array([[0.0, 0.0], [7.3, 1.9], [5.1, 6.7]])
    lattice = place_lattice(corners.min(axis=0), corners.max(axis=0), 1.0, support)
    for share in np.random.default_rng(4).uniform(0.15, 0.85, 40):
        path = np.array([(1.0 - share) * corners[0] + share * corners[1], corners.mean(axis=0)])
        crack = CrackGeometry(crack_name("flaw"), lattice.to_lattice(path), False, True)
        cover = build_cover(lattice, [BodyGeometry((lattice.to_lattice(corners),))], [crack])
        assert len(cover.tips) == 1
        ends = cover.surfaces[0].edges.s[[0, -1], [0, 1]]  # of the edges that the crack is cut into
        assert ends == pytest.approx([0.0, np.hypot(*np.diff(cover.cracks[0].points, axis=0)[0])], abs=ON_LINE)
