"""Stress at a crack tip, or where a crack may start, by Shepard interpolation over the quadrature points of a disc.

sigma(tip) = sum w_q sigma_q / sum w_q with w_q = A_q / r_q, A_q the quadrature weight (area) and r_q the distance of a
point (Shepard 1968). The points are a polar rule of the disc, so the value does not depend on where the lattice's own
points happen to lie. Points outside of the body do not count; points behind another crack do. The radius is a material
length: for the singular field <s_yy> = 1.5279 K_I / sqrt(2 pi R) and <s_xy> = 1.0186 K_II / sqrt(2 pi R).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from crackgrow.arrays import Bools, Floats
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.fracture.sites import LARGEST_KINK, Site
from crackgrow.quadrature.rules import gauss
from crackgrow.solid.elasticity import PlaneElasticity
from crackgrow.solid.recovery import stress_at

N_RAYS = 72
"""Rays of the polar rule, 5 degrees apart."""

NEXT_TO_TIP = 1e-3
"""Lines of sight begin at this fraction of their length: the tip itself lies on its crack."""

N_RADIAL = 6
"""Points on a ray."""

ON_SEGMENT = 1e-12
"""Parts of a segment of a crack: a ray that passes its end by less than this meets it."""

SITES_AT_ONCE = 8
"""Sites whose points are evaluated together: a call costs as much as some hundred points."""


@dataclass(frozen=True, slots=True, eq=False)
class TipField:
    """Stress round a site. Angles are counted counter-clockwise from its direction."""

    direction: float  # rad from +x: outward direction of a tip
    angles: Floats  # (n,) rad, of the rays
    rays: Floats  # (n, 3) Pa: xx, yy, xy averaged along each ray, as far as no crack crosses it (nan for none)
    mean: Floats  # (3,) Pa: Shepard average over the disc
    half_width: float = LARGEST_KINK  # rad: no crack goes further to either side


def site_fields(
    cover: Cover,
    materials: Sequence[PlaneElasticity],
    u: Floats,
    sites: Sequence[Site],
    radius: float | Sequence[float],
) -> list[TipField]:
    """Stress round sites of the cover within `radius` (m), one or one a site; `u` (n_dofs,) m."""
    fields = []
    radii = np.broadcast_to(radius, len(sites)).tolist()
    for first in range(0, len(sites), SITES_AT_ONCE):
        some = sites[first : first + SITES_AT_ONCE]
        rules = [_rule(cover, *each) for each in zip(some, radii[first : first + SITES_AT_ONCE], strict=True)]
        points = np.concatenate([rule.points(site.point) for site, rule in zip(some, rules, strict=True)])
        body = np.repeat([site.body for site in some], N_RAYS * N_RADIAL)
        elements = locate(cover.lattice, cover.elements, points, body)
        inside = elements >= 0
        stress = np.zeros((len(points), 3))
        stress[inside] = stress_at(cover, materials, u, points[inside], elements[inside])
        parts = (np.split(values, len(some)) for values in (inside, stress))
        fields += [_averaged(cover, *each) for each in zip(some, rules, *parts, strict=True)]
    return fields


@dataclass(frozen=True, slots=True, eq=False)
class _Rule:
    """The polar rule of a disc round a site."""

    direction: float  # rad from +x
    angles: Floats  # (rays,) rad
    toward: Floats  # (rays, 2) unit directions
    r: Floats  # (points on a ray,) distances from the site, spacings
    weight: Floats  # (points on a ray,) area / distance, up to a factor

    def points(self, place: Floats) -> Floats:
        """All points (rays * points on a ray, 2), ray by ray."""
        return np.asarray((place + self.toward[:, None] * self.r[None, :, None]).reshape(-1, 2))


def _rule(cover: Cover, site: Site, radius: float) -> _Rule:
    angles = np.pi * (2.0 * np.arange(N_RAYS) + 1.0 - N_RAYS) / N_RAYS
    x, w = gauss(N_RADIAL)
    r = x**2 * radius / cover.lattice.spacing  # r^(-1/2) dr is a polynomial in x
    toward = np.stack([np.cos(site.direction + angles), np.sin(site.direction + angles)], axis=1)
    return _Rule(site.direction, angles, toward, r, 2.0 * x * w)  # area / distance = dr dt


def _averaged(cover: Cover, site: Site, rule: _Rule, inside: Bools, values: Floats) -> TipField:
    """The field of a site from the stress `values` (n, 3) at the points of its rule that are `inside` (n,)."""
    stress = values.reshape(N_RAYS, -1, 3)
    weights = inside.reshape(N_RAYS, -1) * rule.weight
    seen = weights * _in_sight(cover, site, rule)
    along = np.einsum("nr,nrc->nc", seen, stress)
    total = seen.sum(axis=1)
    # a ray that sees only a part R_c of R would see a singular field larger by sqrt(R / R_c)
    whole = np.sqrt(total * rule.weight.sum())[:, None]
    rays = np.divide(along, whole, out=np.full_like(along, np.nan), where=whole > 0.0)
    mean = np.einsum("nr,nrc->c", weights, stress) / weights.sum()
    if site.both_ways:
        rays = 0.5 * (rays + np.roll(rays, N_RAYS // 2, axis=0))  # a crack takes a ray and the one opposite
    return TipField(rule.direction, rule.angles, rays, mean, site.half_width)


def _in_sight(cover: Cover, site: Site, rule: _Rule) -> Bools:
    """Which points (rays, points on a ray) of a rule a straight line from the site reaches without crossing a crack."""
    start, reach = site.point, rule.r[-1]
    near = np.sort(cover.crack_tree.query(shapely.box(*(start - reach), *(start + reach))))
    if len(near) == 0:
        return np.ones((len(rule.toward), len(rule.r)), dtype=bool)
    paths = [cover.cracks[number].points for number in near.tolist()]
    x, y = (np.concatenate([path[:-1] for path in paths]) - start).T
    step_x, step_y = np.concatenate([np.diff(path, axis=0) for path in paths]).T
    toward_x, toward_y = rule.toward.T[:, :, None]
    across = toward_x * step_y - toward_y * step_x  # (rays, segments)
    across[across == 0.0] = np.nan  # side by side: they don't cross
    distance, part = (x * step_y - y * step_x) / across, (x * toward_y - y * toward_x) / across
    distance[~(np.abs(part - 0.5) <= 0.5 + ON_SEGMENT)] = np.nan
    r = rule.r[:, None]
    return np.asarray(~np.any((distance[:, None] >= NEXT_TO_TIP * r) & (distance[:, None] <= r), axis=2))
