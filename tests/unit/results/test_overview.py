"""What `crackgrow check` says of a case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.results.overview import estimated_nodes, overview
from tests.unit.case.scenes import EVERYTHING, load, rectangle, with_body

CASE = Path(__file__).parents[3] / "cases" / "compression30.yaml"


def test_overview_names_bodies_cracks_tips_and_spacing() -> None:
    text = overview(load_case(CASE))
    for part in (
        "body rock: 31 x 55 mm, E = 10 GPa, nu = 0.25; tension 0.5 MPa",
        "crack flaw: length 10 mm, tips: start and end; friction 0, cohesion 0 MPa",
        "cracks: 1, tips: 2",
        "supports: 3 at points, 0 on edges, 0 rigid foundations",
        "loads: 2 tractions on edges, load factors 1",
        "22 steps of 2 mm, directional_strength, most critical",
        "spacing 1.5 mm",
    ):
        assert part in text
    assert "interface" not in text


def test_overview_of_a_static_case_without_cracks(tmp_path: Path) -> None:
    scene = with_body(rectangle(0, 0, 4, 3))
    scene["supports"] = [{"on": {"body": "rock", "edge": "left"}, "displacement": {"x": 0, "y": 0}}]
    text = overview(load(tmp_path, scene))
    assert "cracks: 0, tips: 0" in text
    assert "one static solve" in text
    assert "loads: 0 tractions on edges" in text
    assert "no strength given" in text


def test_overview_of_everything(tmp_path: Path) -> None:
    lines = overview(load(tmp_path, EVERYTHING)).splitlines()
    for line in (
        "body foundation: 40 x 10 mm, E = 10 GPa, nu = 0.25; no strength given",
        "body block: 20 x 20 mm with 3 holes, E = 10 GPa, nu = 0.25, density 2500 kg/m^3; tension 0.5 MPa, "
        "cohesion 10 MPa, friction angle 40 deg",
        "interface between block and foundation: length 20 mm; friction 0.5, cohesion 0 MPa",
        "interface between plug and block: length 12.5662 mm; bonded",  # 720 * 2 mm * sin(0.5 deg)
        "supports: 1 at points, 1 on edges, 1 rigid foundation",
        "foundation on edge bottom of foundation: friction 0.3, cohesion 1 MPa",
        "loads: 2 tractions on edges, gravity on block, pressure 2 MPa in flaw, in-situ stress in block, "
        "load factors 1",
        "growth: 2 steps of 1 mm, max_hoop_stress (implicit direction), all, tip radius 1 mm",
    ):
        assert line in lines


@pytest.mark.parametrize("spacing", [0.005, 0.001, 0.0004])
def test_estimated_nodes_is_close_to_the_count_on_a_rectangle(spacing: float) -> None:
    case = load_case(CASE, [f"numerics.spacing={spacing} m"])
    reach = case.numerics.support * spacing
    count = np.prod([np.floor((length + 2 * reach) / spacing) for length in (0.031, 0.055)])
    assert estimated_nodes(case) == pytest.approx(count, rel=0.15)


@pytest.mark.parametrize("size", [0.3, 2.0])
def test_estimated_nodes_leave_out_those_inside_of_a_hole(size: float, tmp_path: Path) -> None:
    """A hole of less than a patch's width, 0.4, hides no node; one of 2 those within 1.6 by 1.6."""
    scene = with_body({**rectangle(0, 0, 4, 3), "holes": [rectangle(0.5, 0.5, size, size)]})
    scene["supports"] = [{"on": {"body": "rock", "edge": "left"}, "displacement": {"x": 0, "y": 0}}]
    hidden = max(size - 0.4, 0.0) ** 2
    assert estimated_nodes(load(tmp_path, scene)) == round((4.4 * 3.4 - hidden) / 0.01)
