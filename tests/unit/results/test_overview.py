"""What `crackgrow check` says of a case."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.results.overview import estimated_nodes, overview
from tests.unit.results.synthetic import HEIGHT, WIDTH, make_case


def test_overview_names_bodies_cracks_tips_and_spacing() -> None:
    text = overview(make_case())
    for part in ("body rock: 30 x 50 mm, E = 10 GPa", "crack flaw: length 20 mm, tips: start and end", "tips: 2"):
        assert part in text
    assert "2 steps of 2 mm" in text
    assert "spacing 5 mm" in text


def test_overview_of_a_static_case_without_cracks() -> None:
    text = overview(replace(make_case(), cracks=(), growth=None))
    assert "cracks: 0, tips: 0" in text
    assert "one static solve" in text


@pytest.mark.parametrize("spacing", [0.005, 0.001, 0.0004])
def test_estimated_nodes_is_close_to_the_count_on_a_rectangle(spacing: float) -> None:
    case = make_case()
    numerics = replace(case.numerics, spacing=spacing)
    reach = numerics.support * spacing
    count = np.prod([np.floor((length + 2 * reach) / spacing) for length in (WIDTH, HEIGHT)])
    assert estimated_nodes(replace(case, numerics=numerics)) == pytest.approx(count, rel=0.15)
