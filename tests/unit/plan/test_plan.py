"""What `crackgrow check` says of a case: its words, counts that are those of the run, cost and warnings."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from crackgrow.case import Case
from crackgrow.plan import cost
from crackgrow.plan.cost import Sizes, cost_of, estimated_cost, guessed_sizes, sizes_of
from crackgrow.plan.text import overview, plan_text
from crackgrow.run import grow
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, load

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
BONDED = "interfaces=[{between: [lower, upper], contact: bonded}]"


@pytest.mark.parametrize(("name", "settings", "words"), [
    ("compression30", [], r"flaw: .*normal contact alone: neither friction nor cohesion"),
    ("compression30", [], r"\n  3 multipliers for supports and bonds\n"),
    ("compression30", [FRICTION], r"flaw: \d+ points?, with friction or cohesion"),
    ("compression30", [FRICTION], r"contact: \d+ tractions at \d+ mortar nodes, normal and tangential"),
    ("compression30", ["cracks.flaw.contact=none"], "flaw: no contact: its faces never touch"),
    ("interface_friction04", [BONDED], "bonded: multipliers close gap and slip"),
])  # fmt: skip
def test_text_says_what_is_modelled_and_why(name: str, settings: list[str], words: str) -> None:
    assert re.search(words, plan_text(coarse(name, *settings)))


@pytest.mark.parametrize(("settings", "words"), [
    (("numerics.spacing=3",), "cells are by hand, and no error is measured"),
    (("cracks={}",), "22 growth steps are asked for, but no crack has a tip"),
    (("cracks.flaw.tips=none",), "22 growth steps are asked for, but no crack has a tip"),
    (("loads.1.traction=[0, 50]",), "1.55e+06 N/m of the loads (33 %) are carried by supports at points"),
])  # fmt: skip
def test_warnings_come_before_the_run(settings: tuple[str, ...], words: str) -> None:
    assert any(words in text for text in words_of(sizes_of(coarse("compression30", *settings))))


PRESSED = (
    "{on: {edge: top}, traction: [0, -20], held: true}, {on: {edge: bottom}, traction: [0, PUSH], held: true}, "
    "{stress: [0, -20, 0], held: true}"
)
WEIGHT = "{gravity: [0, -80000 m/s^2], held: true}"  # 11 MPa over the height


@pytest.mark.parametrize(("loads", "warned"), [
    (PRESSED.replace("PUSH", "20"), False),
    (PRESSED.replace("PUSH", "31"), True),
    (f"{PRESSED.replace('PUSH', '31')}, {WEIGHT}", False),
    (f"{PRESSED.replace('PUSH', '20')}, {WEIGHT}", False),
])  # fmt: skip
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


LAW = "{friction: 0.5, cohesion: 1, residual_friction: 0.3, cohesion_after_slip: kept, dilation_angle: 5}"
PRESSURE = "loads.0={{on: {{edge: top}}, pressure: '{}'}}"


@pytest.mark.parametrize(("name", "settings", "parts"), [
    ("cyclic_friction", ["loads.2.held=true"], [
        "loads: 6 tractions on edges (3 held), 25 load factors 0.2, 0.4, 0.6, 0.8, 1, 0.8",
        "0, -0.2, -0.4, ..., 1\ngrowth: none, 25 static solves",
    ]),
    ("tunnel_excavated", [], [
        "in stages: at rest (factor 1), face near by (without core, 60 % of core released), "
        "face far away (100 % of core released), wet (water times 1), drained (water times 0)",
    ]),
    ("compression30", ["loading=critical", "growth.steps=0"], [
        "each step at its critical load factor\n"
        "growth: none, directional_strength is judged, tip radius 1 mm",
    ]),
    # the whole law where it is not the default
    ("compression30", [f"cracks.flaw.contact={LAW}"], [
        "tips: start and end; friction 0.5, cohesion 1 MPa, residual friction 0.3, cohesion kept after slip, "
        "dilation angle 5 deg\n",
    ]),
    ("junction_static", [], ["cracks: 3, tips: 3, meeting at 1 place\n"]),
    # a formula is told in the unit it was given in, and never silently cut
    ("compression30", [PRESSURE.format("max(0, 10 - y/y)")], [
        "pressure max(0, 10 - y / 0.001 / (y / 0.001)) [MPa] on rock.top",
    ]),
    ("compression30", [PRESSURE.format(" + ".join(f"{n}*x" for n in range(20)))], ["... [MPa] on rock.top"]),
])  # fmt: skip
def test_overview_of_shipped_cases(name: str, settings: list[str], parts: list[str]) -> None:
    text = overview(shipped_case(name, settings))
    assert [part for part in parts if part not in text] == []


def test_overview_of_everything(tmp_path: Path) -> None:
    lines = overview(load(tmp_path, EVERYTHING)).splitlines()
    for line in (
        "body foundation: 40 x 10 mm, E = 10 GPa, nu = 0.25; no strength given",
        "body block: 20 x 20 mm with 3 holes, E = 10 GPa, nu = 0.25, density 2500 kg/m^3; tension 0.5 MPa, "
        "cohesion 10 MPa, friction angle 40 deg",
        "interface between block and foundation: length 20 mm; friction 0.5, cohesion 0 MPa",
        "interface between plug and block: length 12.5662 mm; bonded",  # 720 * 2 mm * sin(0.5 deg)
        "supports: 1 at points, 1 on edges, 1 rigid foundation",
        "platen that moves on edge bottom of foundation: friction 0.3, cohesion 1 MPa",
        "loads: 2 tractions on edges, gravity on block, pressure 2 MPa in flaw, in-situ stress in block, "
        "load factors 1",
        "growth: 2 steps of 1 mm, max_hoop_stress (implicit direction), all, tip radius 1 mm (1 x the spacing)",
    ):
        assert line in lines
    held = [f"loads.{index}.held=true" for index in (0, 2, 4)]
    assert (
        "loads: 2 tractions on edges (1 held), gravity on block (held), pressure 2 MPa in flaw, in-situ stress in "
        "block (held), load factors 1, -0.5"
    ) in overview(load(tmp_path, EVERYTHING, *held, "loading.history=[1, -0.5]")).splitlines()
