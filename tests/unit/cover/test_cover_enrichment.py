"""Which tips act on which elements: those whose singular patches lie over them, each pair once."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from tests.unit.cover_tables import function_table

KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]


def table(cover) -> np.ndarray:
    """Which tips act on which elements (tips, elements), as the enrichment has it."""
    tips = cover.enrichment.tips
    carries = np.zeros((len(cover.tips), cover.elements.n), dtype=bool)
    carries[tips.values, tips.row] = True
    assert carries.sum() == len(tips.values)  # no pair occurs twice
    return carries


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_enriched_elements_are_those_of_the_singular_patches(build, support: float) -> None:
    cover = build.block((6, 5), [build.crack(KINKED)], support).cover
    for tip, carried in enumerate(table(cover)):
        nodes = cover.patches.nodes[cover.tips[tip].patches]
        reached = np.abs(cover.elements.reference[:, None] - nodes[None]).max(axis=2).min(axis=1) < support
        assert not (carried & ~reached).any()
        at_tip = shapely.distance(cover.elements.polygons, shapely.Point(cover.tips[tip].point)) < 1e-8
        assert at_tip.sum() >= 2
        assert carried[cover.elements.n_whole :][at_tip].all()


def test_every_singular_patch_over_an_element_is_listed_once_with_its_functions(build) -> None:
    cover = build.field_of_cracks(2).cover
    enrichment = cover.enrichment
    carrier, of_element = enrichment.place.row, cover.patches.of_element
    pair, number = enrichment.first.row[carrier], enrichment.first.values[carrier]
    element, tip = enrichment.tips.row[pair], enrichment.tips.values[pair]
    patch = of_element.values[of_element.start[element] + enrichment.place.values]
    listed = set(zip(element.tolist(), tip.tolist(), patch.tolist(), strict=True))
    first = function_table(cover)
    expected = {
        (e, t, p)
        for e, p in zip(of_element.row.tolist(), of_element.values.tolist(), strict=True)
        for t in range(len(cover.tips))
        if first[t, p] >= 0
    }
    assert len(patch) == len(listed)
    assert listed == expected
    np.testing.assert_array_equal(number, first[tip, patch])
    np.testing.assert_array_equal(enrichment.share, 1.0)


def test_uncut_body_has_no_enrichment(build) -> None:
    cover = build.block((6, 5)).cover
    assert not table(cover).any()
    assert not cover.enrichment.acted_on.any()
    assert len(cover.enrichment.place.values) == 0


OFF = (0.0, 1e-15, 1e-9, 1e-7, 1e-5)


@pytest.mark.parametrize("levels", [1, 3, 6])
@pytest.mark.parametrize("support", [1.5, 2.0, 2.5, 3.0])
def test_a_tip_among_small_cells_has_the_functions_of_these(build, support: float, levels: int) -> None:
    """No more patches than in cells of one size hold it, also within rounding of a corner."""
    for off in (*OFF, 0.43 * 0.5**levels):
        tips = np.array([(3.0 + off, 3.0 - off), (5.3, 4.6)])
        cover = build.block((7, 6), [build.crack(tips)], support, levels, tips).cover
        assert [tip.size for tip in cover.tips] == [0.5**levels] * 2
        assert max(len(tip.patches) for tip in cover.tips) <= (2.0 * support) ** 2
