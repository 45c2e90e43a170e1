"""Which tips act on which elements: those whose singular patches lie over them, each pair once."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from crackgrow.cover.enrichment import entries, list_starts

KINKED = [(1.7, 2.2), (3.3, 2.6), (3.9, 3.8)]


def table(cover) -> np.ndarray:
    """Which tips act on which elements (tips, elements), as the enrichment has it."""
    element, pair = cover.enrichment.tips.of(np.arange(cover.elements.n))
    carries = np.zeros((len(cover.tips), cover.elements.n), dtype=bool)
    carries[cover.enrichment.tips.tip[pair], element] = True
    assert carries.sum() == len(pair)  # no pair occurs twice
    return carries


def test_entries_of_lists() -> None:
    start = list_starts(np.array([0, 0, 2, 2, 2, 3]), 5)
    np.testing.assert_array_equal(start, [0, 2, 2, 5, 6, 6])
    which, entry = entries(start, np.array([2, 1, 0, 2, 4]))
    np.testing.assert_array_equal(which, [0, 0, 0, 2, 2, 3, 3, 3])
    np.testing.assert_array_equal(entry, [2, 3, 4, 0, 1, 2, 3, 4])


@pytest.mark.parametrize("support", [1.5, 2.0])
def test_enriched_elements_are_those_of_the_singular_patches(build, support: float) -> None:
    cover = build.block((6, 5), [build.crack(KINKED)], support).cover
    for tip, carried in enumerate(table(cover)):
        nodes = cover.patch_nodes[cover.tip_function_ids[tip] >= 0]
        reached = np.abs(cover.elements.reference[:, None] - nodes[None]).max(axis=2).min(axis=1) < support
        assert not (carried & ~reached).any()
        at_tip = shapely.distance(cover.elements.polygons, shapely.Point(cover.tips[tip].point)) < 1e-8
        assert at_tip.sum() >= 2
        assert carried[cover.elements.n_whole :][at_tip].all()


def test_every_singular_patch_over_an_element_is_listed_once_with_its_functions(build) -> None:
    cover = build.field_of_cracks(2).cover
    enrichment = cover.enrichment
    element, pair = enrichment.tips.of(np.arange(cover.elements.n))
    which, entry = entries(enrichment.start, pair)
    tip, patch = enrichment.tips.tip[pair[which]], cover.functions[element[which], enrichment.slot[entry]]
    listed = set(zip(element[which].tolist(), tip.tolist(), patch.tolist(), strict=True))
    expected = {
        (e, t, p)
        for e, patches in enumerate(cover.functions.tolist())
        for p in patches
        for t, first in enumerate(cover.tip_function_ids)
        if p >= 0 and first[p] >= 0
    }
    assert len(which) == len(listed)
    assert listed == expected
    first = np.array(cover.tip_function_ids)
    np.testing.assert_array_equal(enrichment.number[entry], first[tip, patch])
    np.testing.assert_array_equal(enrichment.n_patches, np.bincount(element[which], minlength=cover.elements.n))


def test_uncut_body_has_no_enrichment(build) -> None:
    cover = build.block((6, 5)).cover
    assert not table(cover).any()
    assert not cover.enrichment.tips.any.any()
    assert not cover.enrichment.n_patches.any()
