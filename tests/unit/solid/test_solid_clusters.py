"""Clusters that a configuration has in common with the one before: found again, and never where something changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from crackgrow.cover.cover import Cover, build_cover
from crackgrow.quadrature.plain_kinds import plain_kinds
from crackgrow.solid.clusters import clusters_of, keys
from crackgrow.solid.elasticity import plane_elasticity
from crackgrow.solid.stiffness import plain_key, stiffness_after


def longer(build, cover: Cover, crack: int, by: tuple[float, float]) -> Cover:
    """The same body after one crack has grown at its end."""
    cracks = list(cover.cracks)
    grown = np.vstack([cracks[crack].points, cracks[crack].points[-1] + by])
    cracks[crack] = build.crack(grown, name=str(cracks[crack].name))
    return build_cover(cover.lattice, cover.bodies, cracks)


def test_every_element_that_is_not_plain_is_in_one_cluster_with_the_same_tips(build) -> None:
    cover = build.field_of_cracks(3).cover
    clusters = clusters_of(cover, 3)
    np.testing.assert_array_equal(np.sort(clusters.elements.values), np.flatnonzero(~cover.plain))
    acting = cover.enrichment.tips
    for cluster in range(clusters.elements.n):
        mine = clusters.elements.of(cluster)
        assert len({tuple(acting.of(element)) for element in mine}) == 1
        ids = cover.functions_on(mine).values
        span = clusters.span(cluster)
        local = clusters.local.taken(np.arange(span.start, span.stop)).values
        np.testing.assert_array_equal(clusters.functions[cluster][local], ids)


def test_points_of_clusters_are_those_of_their_elements(build) -> None:
    cover = build.field_of_cracks(2).cover
    clusters = clusters_of(cover, 3)
    for part in (clusters.inside, clusters.rim):
        owner = np.repeat(clusters.elements.values, np.diff(part.start))
        np.testing.assert_array_equal(part.element, owner)


def test_a_grown_tip_leaves_distant_clusters_and_changes_those_near_it(build) -> None:
    """The matrix is that of a fresh assembly to the last bit; only what the two tips of the crack see is new."""
    sample = build.field_of_cracks(4)
    first = stiffness_after(sample.cover, [sample.material], 2)
    cover = longer(build, sample.cover, 5, (0.3, 0.5))
    fresh = stiffness_after(cover, [sample.material], 2)
    later = stiffness_after(cover, [sample.material], 2, first)
    assert fresh.n_integrated == len(fresh.clusters)
    assert 0 < later.n_integrated < 0.5 * len(fresh.clusters)
    assert abs(later.matrix.tocsc() - fresh.matrix.tocsc()).max() == 0.0
    assert later.clusters.keys() == fresh.clusters.keys()


def test_nothing_is_integrated_twice(build) -> None:
    sample = build.field_of_cracks(2)
    first = stiffness_after(sample.cover, [sample.material], 2)
    again = stiffness_after(sample.cover, [sample.material], 2, first)
    assert again.n_integrated == 0
    assert abs(again.matrix.tocsc() - first.matrix.tocsc()).max() == 0.0


def test_plain_elements_are_not_integrated_twice(build) -> None:
    sample = build.block((12, 12), [build.crack([(4.3, 5.1), (7.2, 6.4)])])
    first = stiffness_after(sample.cover, [sample.material], 2)
    cover = longer(build, sample.cover, 0, (0.3, 0.5))
    fresh, later = (stiffness_after(cover, [sample.material], 2, before) for before in (None, first))
    common = later.plain.keys() & first.plain.keys()
    assert len(common) > 0.5 * len(later.plain) > 0
    assert all(later.plain[name] is first.plain[name] for name in common)
    assert abs(later.matrix.tocsc() - fresh.matrix.tocsc()).max() == 0.0


@pytest.mark.parametrize("changed", ["material", "quadrature", "support", "low", "size", "slots"])
def test_what_a_plain_matrix_depends_on_is_in_its_key(build, changed: str) -> None:
    sample = build.block((12, 12))
    cover, material, n, kind = sample.cover, sample.material, 2, plain_kinds(sample.cover)[0]
    before = plain_key(cover, kind, material, n)
    assert plain_key(cover, replace(kind, elements=kind.elements[:1]), material, n) == before
    if changed == "material":
        material = plane_elasticity(2.0, 0.3, "strain")
    elif changed == "quadrature":
        n = 3
    elif changed == "support":
        cover = replace(cover, lattice=replace(cover.lattice, support=cover.lattice.support + 0.25))
    elif changed == "slots":
        kind = replace(kind, slots=kind.slots + 1)
    else:
        kind = replace(kind, **{changed: getattr(kind, changed) + 0.125})
    assert plain_key(cover, kind, material, n) != before


@pytest.mark.parametrize(
    "changed", ["material", "quadrature", "fade", "tip", "share", "reference", "points", "spacing"]
)
def test_what_a_matrix_is_integrated_from_is_in_its_key(build, changed: str) -> None:
    sample = build.field_of_cracks(1)
    cover, material, n = sample.cover, sample.material, 2
    before = set(keys(cover, clusters_of(cover, n), [material]))
    clusters = None
    if changed == "material":
        material = replace(material, c12=1.000001 * material.c12)
    elif changed == "quadrature":
        n = 3
    elif changed == "fade":
        cover = replace(cover, tips=tuple(replace(tip, fade=1.001 * tip.fade) for tip in cover.tips))
    elif changed == "tip":
        cover = replace(cover, tips=tuple(replace(tip, rotation=-tip.rotation) for tip in cover.tips))
    elif changed == "share":
        cover = replace(cover, enrichment=replace(cover.enrichment, share=0.5 * cover.enrichment.share))
    elif changed == "reference":
        elements = replace(cover.elements, reference=cover.elements.reference + 1e-12)
        cover = replace(cover, elements=elements)
    elif changed == "points":
        clusters = clusters_of(cover, n)
        clusters = replace(clusters, rim=replace(clusters.rim, points=clusters.rim.points + 1e-12))
    else:
        cover = replace(cover, lattice=replace(cover.lattice, spacing=2.0))
    after = keys(cover, clusters or clusters_of(cover, n), [material])
    assert cover.enrichment.acted_on[~cover.plain].all()
    assert before.isdisjoint(after)
