"""The plan of a case: counts are those of the run, cost and warnings follow the scene."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.case import Case
from crackgrow.plan import cost
from crackgrow.plan.cost import Sizes, cost_of, estimated_cost, guessed_sizes, sizes_of
from crackgrow.plan.text import plan_text
from crackgrow.run import grow
from tests.scenes import shipped_case

CASES = Path(__file__).parents[3] / "cases"
COARSE = {
    "compression30": ("numerics.spacing=3",),
    "interface_friction04": ("numerics.spacing=0.1",),
    "block_rigid": ("numerics.spacing=0.25",),
    "junction_static": ("numerics.spacing=4",),
    "cyclic_friction": ("numerics.spacing=15",),
}


def words_of(sizes: Sizes) -> tuple[str, ...]:
    return tuple(warning.words for warning in sizes.scene_warnings)


def coarse(name: str, *settings: str) -> Case:
    return shipped_case(name, (*COARSE.get(name, ()), *settings))


@pytest.mark.parametrize("name", sorted(COARSE))
def test_counts_are_those_of_the_run(name: str) -> None:
    case = coarse(name)
    sizes, first = sizes_of(case), next(grow(case))
    assert (sizes.n_dofs, sizes.n_contact) == (first.n_dofs, len(first.contact.s))
    assert sizes.n_dofs == 2 * sizes.n_patches + 8 * sizes.n_singular
    assert sizes.n_tips == len(first.tips)
    plan_alone = {text for text in words_of(sizes) if text.startswith("the increment")}
    assert set(words_of(sizes)) - plan_alone <= set(first.warnings)  # the same words


FRICTION = "cracks.flaw.contact.friction=0.3"
SMOOTH = "interfaces=[{between: [lower, upper], contact: {friction: 0, cohesion: 0}}]"
BONDED = "interfaces=[{between: [lower, upper], contact: bonded}]"


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("compression30", [], r"flaw: .*normal contact alone: neither friction nor cohesion"),
        ("compression30", [], r"\n  3 multipliers for supports and bonds\n"),
        ("compression30", [FRICTION], r"flaw: \d+ points?, with friction or cohesion"),
        ("compression30", [FRICTION], r"contact: \d+ tractions at \d+ mortar nodes, normal and tangential"),
        ("compression30", ["cracks.flaw.contact=none"], "flaw: no contact: its faces never touch"),
        ("interface_friction04", [SMOOTH], "points, normal contact alone: neither"),
        ("interface_friction04", [BONDED], "bonded: multipliers close gap and slip"),
        ("block_rigid", [], "points, with friction or cohesion"),
    ],
)
def test_text_says_what_is_modelled_and_why(name: str, settings: list[str], words: str) -> None:
    assert re.search(words, plan_text(coarse(name, *settings)))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (("numerics.spacing=3",), "cells are by hand, and no error is measured"),
        (("cracks={}",), "22 growth steps are asked for, but no crack has a tip"),
        (("cracks.flaw.tips=none",), "22 growth steps are asked for, but no crack has a tip"),
        (("loads.1.traction=[0, 50]",), "1.55e+06 N/m of the loads (33 %) are carried by supports at points"),
    ],
)
def test_warnings_come_before_the_run(settings: tuple[str, ...], words: str) -> None:
    assert any(words in text for text in words_of(sizes_of(coarse("compression30", *settings))))


PRESSED = (
    "{on: {edge: top}, traction: [0, -20], held: true}, {on: {edge: bottom}, traction: [0, PUSH], held: true}, "
    "{stress: [0, -20, 0], held: true}"
)
WEIGHT = "{gravity: [0, -80000 m/s^2], held: true}"  # 11 MPa over the height


@pytest.mark.parametrize(
    ("loads", "warned"),
    [
        (PRESSED.replace("PUSH", "20"), False),
        (PRESSED.replace("PUSH", "31"), True),
        (f"{PRESSED.replace('PUSH', '31')}, {WEIGHT}", False),
        (f"{PRESSED.replace('PUSH', '20')}, {WEIGHT}", False),
    ],
)
def test_loads_that_stress_in_the_rock_or_weight_balances_leave_nothing_to_points(loads: str, warned: bool) -> None:
    settings = ("bodies.rock.material.density=2500 kg/m^3", f"loads=[{loads}]")
    told = words_of(sizes_of(coarse("compression30", *settings)))
    assert any("are carried by supports at points" in text for text in told) == warned


def test_more_memory_than_the_machine_has_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    case = coarse("compression30")
    needed = cost_of(case).memory
    monkeypatch.setattr(cost, "machine_memory", lambda: 1.1 * needed)
    assert "of memory, and this machine" not in plan_text(case)
    monkeypatch.setattr(cost, "machine_memory", lambda: 0.9 * needed)
    assert f"needs about {needed:.0f} MiB of memory, and this machine has {0.9 * needed:.0f} MiB" in plan_text(case)


@pytest.mark.parametrize("spacing", [0.8, 0.4])
def test_a_guess_without_a_cover_is_near_that_with_one(spacing: float) -> None:
    case = shipped_case("compression30", [f"numerics.spacing={spacing}", "growth.steps=0"])
    counted, guessed = (estimated_cost(case, sizes(case)) for sizes in (sizes_of, guessed_sizes))
    assert guessed.seconds == pytest.approx(counted.seconds, rel=0.25)
    assert guessed.memory == pytest.approx(counted.memory, rel=0.25)


def test_a_sound_case_has_no_warnings() -> None:
    assert words_of(sizes_of(shipped_case("compression30"))) == ()
    assert plan_text(shipped_case("compression30")).endswith("no warnings")


def test_check_draws_where_it_is_told_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = str(CASES / "compression30.yaml")
    assert cli.main(["check", case, "--set", "numerics.spacing=3", "--picture", str(tmp_path / "a.png")]) == 0
    assert f"picture in {tmp_path / 'a.png'}" in capsys.readouterr().out
    assert (tmp_path / "a.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(SystemExit) as caught:
        cli.main(["check", case, "--picture", "a.gif"])
    assert caught.value.code == 2
    assert "ends in .png or .svg" in capsys.readouterr().err


UNTOLD = {
    **dict.fromkeys(("en_echelon", "tunnel_excavated"), "three and more rounds of refinement in a step"),
    "13_curved": "two rounds: cells to begin with take no heed of curves",
    "05_initiation": "cracks that are not there yet",
    "08_safety": "one factor after the other is tried",
}
"""What makes runs longer, and is not told of."""


@pytest.mark.physics
@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.yaml")))
def test_what_is_told_of_a_shipped_case_is_within_a_factor_of_two_of_what_it_took(name: str) -> None:
    lines = (CASES.parent / "tests" / "benchmarks" / "cost.md").read_text(encoding="utf-8").splitlines()
    taken = next(cells for line in lines if (cells := [cell.strip() for cell in line.split("|")])[1:2] == [name])
    told = cost_of(shipped_case(name))
    lowest = 0.2 if name in UNTOLD else 0.5
    assert lowest < told.seconds / float(taken[4]) < 2.0
    assert lowest < told.memory / float(taken[6]) < 2.0
