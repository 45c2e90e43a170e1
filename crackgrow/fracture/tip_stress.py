"""Stress at a crack tip, or where a crack may start, by Shepard interpolation over the quadrature points of a disc.

sigma(tip) = sum w_q sigma_q / sum w_q with w_q = A_q / r_q, A_q the quadrature weight (area) and r_q the distance of a
point (Shepard 1968). The points are a polar rule of the disc, so the value does not depend on where the lattice's own
points happen to lie. The radius R is a material length: for the singular field <s_yy> = 1.5279 K_I / sqrt(2 pi R) and
<s_xy> = 1.0186 K_II / sqrt(2 pi R).

A ray ends on the rim of the body; what lies behind a crack counts for the disc, not for the ray. From a tip a ray that
meets a rim or a crack at s R is averaged over s^2 R, times s, which leaves the singular field what it is: beside a rim
the tip grows by its K, as everywhere. Averaged over all of s R, where the stress falls to that of the rim, a wing took
1.8 times the K of other steps to break into a hole, and wings stopped short of each other. Other sites have no K: from
there a ray is averaged over s R, times sqrt(s).

Each part of a ray has a rule of its own. Where a rule for the whole of it lost points to a hole, a stress over the
strength was 1.00, 0.91, 0.85, 0.77 with 6, 12, 24, 48 points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from crackgrow.arrays import Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.fracture.sites import LARGEST_KINK, Site
from crackgrow.geometry.tolerance import ROUND_OFF, SAME_PLACE
from crackgrow.quadrature.rules import gauss
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_at

N_RAYS = 72
"""Rays of the polar rule, 5 degrees apart."""

N_RADIAL = 6
"""Points on a ray, or on each of its parts."""


@dataclass(frozen=True, slots=True, eq=False)
class TipField:
    """Stress round a site. Angles are counted counter-clockwise from its direction."""

    direction: float  # rad from +x: outward direction of a tip
    angles: Floats  # (n,) rad, of the rays
    rays: Floats  # (n, 3) Pa: xx, yy, xy averaged along each ray, a singular field as over all of it; or nan
    mean: Floats  # (3,) Pa: Shepard average over the disc
    half_width: float = LARGEST_KINK  # rad: no crack goes further to either side
    radius: float | None = None  # m, of the average; None: that of the criterion
    shear: TipField | None = None  # of a tip: the same over the length of the toughness in shear, where there is one

    def mapped(self, change: Callable[..., Floats], *others: TipField) -> TipField:
        """The field with `change` of its stress, and of that of `others` at the same site."""
        rays = change(self.rays, *(each.rays for each in others))
        mean = change(self.mean, *(each.mean for each in others))
        shear = self.shear and self.shear.mapped(change, *(each.shear for each in others if each.shear))
        return replace(self, rays=rays, mean=mean, shear=shear)


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """The rays of a disc round a site."""

    radius: float  # m
    reach: float  # the same, spacings
    direction: float  # rad from +x
    angles: Floats  # (rays,) rad
    toward: Floats  # (rays, 2) unit directions


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """Points on the rays of a site."""

    places: Floats  # (n, 2), lattice coordinates
    ray: Ints  # (n,)
    weight: Floats  # (n,) area / distance, of which each ray would have 1 if nothing ended it
    averaged: Floats  # (n,) the same of points that the average on the ray is of, 0 of others


@dataclass(frozen=True, slots=True, eq=False)
class StressFunctional:
    """The averages round a site: what they are taken over."""

    site: Site
    rule: Rule
    points: _Points  # inside of the body
    elements: Ints  # (n,) of the points
    shear: StressFunctional | None = None  # the same over the length of the toughness in shear


def stress_functionals(cover: Cover, sites: Sequence[Site], radius: float | Sequence[float]) -> list[StressFunctional]:
    """What the fields round `sites` of a cover within `radius` (m), one or one a site, read off."""
    if not sites:
        return []
    radii = np.broadcast_to(radius, len(sites)).tolist()
    rules = [_rule(cover, *each) for each in zip(sites, radii, strict=True)]
    on_rays = [_on_rays(cover, *each) for each in zip(sites, rules, strict=True)]
    places, counts = np.concatenate([points.places for points in on_rays]), [len(p.ray) for p in on_rays]
    elements = locate(cover.lattice, cover.elements, places, np.repeat([site.body for site in sites], counts))
    found = []
    for site, rule, points, own in zip(sites, rules, on_rays, np.split(elements, np.cumsum(counts)[:-1]), strict=True):
        some = own >= 0
        inside = _Points(points.places[some], points.ray[some], points.weight[some], points.averaged[some])
        found.append(StressFunctional(site, rule, inside, own[some]))
    return found


def fields_of(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, functionals: Sequence[StressFunctional]
) -> list[TipField]:
    """Stress round sites, of what is read off the displacement `u` (n_dofs,) m."""
    shears = {number: known.shear for number, known in enumerate(functionals) if known.shear is not None}
    found = _averaged(cover, materials, u, functionals)
    for number, field in zip(shears, _averaged(cover, materials, u, list(shears.values())), strict=True):
        found[number] = replace(found[number], shear=field)
    return found


def _rule(cover: Cover, site: Site, radius: float) -> Rule:
    angles = np.pi * (2.0 * np.arange(N_RAYS) + 1.0 - N_RAYS) / N_RAYS
    toward = np.stack([np.cos(site.direction + angles), np.sin(site.direction + angles)], axis=1)
    return Rule(radius, radius / cover.lattice.spacing, site.direction, angles, toward)


def _box(site: Site, rule: Rule) -> shapely.Polygon:
    """The box round the disc of a site."""
    return shapely.box(*(site.point - rule.reach), *(site.point + rule.reach))


def _cracks_near(cover: Cover, site: Site, rule: Rule) -> Floats:
    """The segments (n, 2, 2) of cracks whose boxes reach into that of a site: what lies farther away may grow."""
    paths = [cover.cracks[number].points for number in np.sort(cover.crack_tree.query(_box(site, rule))).tolist()]
    segments = np.concatenate([np.empty((0, 2, 2)), *(np.stack([path[:-1], path[1:]], axis=1) for path in paths)])
    off = np.maximum(segments.min(axis=1) - site.point, site.point - segments.max(axis=1))
    return np.asarray(segments[(off <= rule.reach).all(axis=1)])


def _on_rays(cover: Cover, site: Site, rule: Rule) -> _Points:
    """The points of a disc: on the part of each ray that it is averaged over, then up to a crack, then up to the rim.

    Rays that leave a rim away from the body have points outside.
    """
    rim, crack = _met(cover, site, rule)
    sight = np.minimum(rim, crack)
    first = sight**2 if site.kind == "tip" else sight
    x, w = gauss(N_RADIAL)
    parts = [(np.arange(N_RAYS), first[:, None] * x**2, first[:, None] * (2.0 * x * w))]  # r^(-1/2) dr is smooth in x
    for begin, end in ((first, sight), (sight, rim)):
        some = np.flatnonzero(begin < end)
        length = (end - begin)[some, None]
        parts.append((some, begin[some, None] + length * x, length * w))
    ray, r, weight = (np.concatenate(part) for part in zip(*parts, strict=True))  # area / distance = dr dt
    averaged = weight.ravel().copy()
    averaged[N_RAYS * N_RADIAL :] = 0.0
    places = site.point + rule.reach * r[:, :, None] * rule.toward[ray, None]
    return _Points(places.reshape(-1, 2), ray.repeat(N_RADIAL), weight.ravel(), averaged)


def _met(cover: Cover, site: Site, rule: Rule) -> tuple[Floats, Floats]:
    """How far (rays,) it is to a rim, and to a crack, in parts of the reach; 1 where a ray meets none within it."""
    rims = cover.elements.outlines.points[cover.outline_tree.query(_box(site, rule))]
    cracks = _cracks_near(cover, site, rule)
    on_rims, on_cracks = (_crossings(segments - site.point, rule) for segments in (rims, cracks))
    return on_rims.min(axis=1, initial=1.0), on_cracks.min(axis=1, initial=1.0)


def _crossings(segments: Floats, rule: Rule) -> Floats:
    """How far (rays, n) it is to `segments` (n, 2, 2), as seen from the site, in parts of the reach.

    It is infinite where one is passed or lies behind, is side by side with the ray, or is what the site lies on.
    """
    (x, y), (step_x, step_y) = (segments[:, 0] / rule.reach).T, (np.diff(segments, axis=1)[:, 0] / rule.reach).T
    toward_x, toward_y = rule.toward.T[:, :, None]
    across = toward_x * step_y - toward_y * step_x
    across[across == 0.0] = np.nan
    distance, part = (x * step_y - y * step_x) / across, (x * toward_y - y * toward_x) / across
    # nearer is what the site itself lies on, its crack or a rim
    meets = (np.abs(part - 0.5) <= 0.5 + ROUND_OFF) & (rule.reach * distance >= 2.0 * SAME_PLACE)
    return np.where(meets, distance, np.inf)


def _averaged(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, functionals: Sequence[StressFunctional]
) -> list[TipField]:
    """The fields of sites over one length each, of what is read off the displacement `u` (n_dofs,) m."""
    if not functionals:
        return []
    n, parts = len(functionals), [known.points for known in functionals]
    places, elements = (
        np.concatenate(each) for each in zip(*((k.points.places, k.elements) for k in functionals), strict=True)
    )
    site = np.repeat(np.arange(n), [len(points.ray) for points in parts])
    ray, weight, averaged = (
        np.concatenate([getattr(p, name) for p in parts]) for name in ("ray", "weight", "averaged")
    )
    of_points = [*stress_at(cover, materials, u, places, elements).T, np.ones(len(site))]
    on_rays = np.stack([np.bincount(N_RAYS * site + ray, averaged * each, N_RAYS * n) for each in of_points], axis=1)
    in_disc = np.stack([np.bincount(site, weight * each, n) for each in of_points], axis=1)
    on_rays = on_rays.reshape(n, N_RAYS, 4)
    # over a part R_c of R alone a singular field is larger by sqrt(R / R_c)
    least = np.sqrt(on_rays[..., 3:])
    rays = np.divide(on_rays[..., :3], least, out=np.full((n, N_RAYS, 3), np.nan), where=least > 0.0)
    opposite, found = 0.5 * (rays + np.roll(rays, N_RAYS // 2, axis=1)), []
    for number, known in enumerate(functionals):
        rule, own = known.rule, opposite if known.site.both_ways else rays  # a crack takes a ray and the one opposite
        mean = in_disc[number, :3] / in_disc[number, 3]
        found.append(TipField(rule.direction, rule.angles, own[number], mean, known.site.half_width, rule.radius))
    return found
