"""What `crackgrow check` says of a case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.plan.cost import estimated_nodes
from crackgrow.plan.text import overview
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, load

LAW = "{friction: 0.5, cohesion: 1, residual_friction: 0.3, cohesion_after_slip: kept, dilation_angle: 5}"
PLAIN_LAW = "{friction: 0.5, cohesion: 1, residual_friction: 0.5}"
OTHER = "cracks.other={path: {points: [[-3, 9], [0, -3], [3, 9]]}, contact: none}"
PRESSURE = "loads.0={{on: {{edge: top}}, pressure: '{}'}}"


@pytest.mark.parametrize(
    ("name", "settings", "parts"),
    [
        (
            "compression30",
            ["numerics.spacing=1.5"],
            [
                "body rock: 31 x 55 mm, E = 10 GPa, nu = 0.25; tension 0.5 MPa",
                "crack flaw: length 10 mm, tips: start and end; friction 0, cohesion 0 MPa",
                "cracks: 1, tips: 2\n",
                "supports: 3 at points, 0 on edges, 0 rigid foundations",
                "loads: 2 tractions on edges, load factors 1",
                "22 steps of 2 mm, directional_strength, most critical",
                "spacing 1.5 mm",
            ],
        ),
        ("cyclic_friction", ["loads.2.held=true"], [
            "loads: 6 tractions on edges (3 held), 25 load factors 0.2, 0.4, 0.6, 0.8, 1, 0.8",
            "0, -0.2, -0.4, ..., 1\ngrowth: none, 25 static solves",
        ]),
        ("compression30", ["loads=[]"], ["loads: 0 tractions on edges, load factors 1"]),
        ("confined30", ["loads.0.held=true", "loads.1.held=true"], [
            "loads: 4 tractions on edges (held), load factors 1",
        ]),
        ("tunnel_excavated", [], [
            "in stages: at rest (factor 1), face near by (without core, 60 % of core released), "
            "face far away (100 % of core released), wet (water times 1), drained (water times 0)",
        ]),
        ("compression30", ["loading=critical", "growth.steps=0"], [
            "each step at its critical load factor\n"
            "growth: none, directional_strength is judged, tip radius 1 mm",
        ]),
        ("compression30", ["growth.unload_between_steps=false", "growth.steps=1", "numerics.spacing=1.5"], [
            "growth: 1 step of 2 mm, directional_strength, most critical, tip radius 1 mm (0.667 x",
            "the spacing), without unloading between steps",
        ]),
        # the whole law where it is not the default
        ("compression30", [f"cracks.flaw.contact={LAW}"], [
            "tips: start and end; friction 0.5, cohesion 1 MPa, residual friction 0.3, cohesion kept after slip, "
            "dilation angle 5 deg\n",
        ]),
        ("compression30", [f"cracks.flaw.contact={PLAIN_LAW}"], [
            "tips: start and end; friction 0.5, cohesion 1 MPa\n",
        ]),
        ("junction_static", [], ["cracks: 3, tips: 3, meeting at 1 place\n"]),
        ("compression30", [OTHER], ["cracks: 2, tips: 4, meeting at 2 places\n"]),
        # a formula is told in the unit it was given in, and never silently cut
        ("compression30", [PRESSURE.format("max(0, 10 - y/y)")], [
            "pressure max(0, 10 - y / 0.001 / (y / 0.001)) [MPa] on rock.top",
        ]),
        ("compression30", [PRESSURE.format(" + ".join(f"{n}*x" for n in range(20)))], ["... [MPa] on rock.top"]),
    ],
)  # fmt: skip
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


@pytest.mark.parametrize("spacing", [0.005, 0.001, 0.0004])
def test_estimated_nodes_is_close_to_the_count_on_a_rectangle(spacing: float) -> None:
    case = shipped_case("compression30", [f"numerics.spacing={spacing} m"])
    reach = case.numerics.support * spacing
    count = np.prod([np.floor((length + 2 * reach) / spacing) for length in (0.031, 0.055)])
    assert estimated_nodes(case) == pytest.approx(count, rel=0.15)
