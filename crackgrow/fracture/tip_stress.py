"""Stress at a crack tip, or where a crack may start, by Shepard interpolation over the quadrature points of a disc.

sigma(tip) = sum w_q sigma_q / sum w_q with w_q = A_q / r_q, A_q the quadrature weight (area) and r_q the distance of a
point (Shepard 1968). The points are a polar rule of the disc, so the value does not depend on where the lattice's own
points happen to lie. Points outside of the body do not count; points behind another crack do. The radius is a material
length: for the singular field <s_yy> = 1.5279 K_I / sqrt(2 pi R) and <s_xy> = 1.0186 K_II / sqrt(2 pi R).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.sparse import csr_array

from crackgrow.approximation.basis import basis_at
from crackgrow.arrays import Bools, Floats, Ints
from crackgrow.cover.cover import Cover
from crackgrow.cover.elements import locate
from crackgrow.fracture.readings import Made, Place, Reading, Readings
from crackgrow.fracture.sites import LARGEST_KINK, Site
from crackgrow.quadrature.rules import gauss
from crackgrow.ragged import distinct
from crackgrow.solid.elasticity import PlaneElasticity

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
    """The polar rule of a disc round a site."""

    radius: float  # m
    direction: float  # rad from +x
    angles: Floats  # (rays,) rad
    toward: Floats  # (rays, 2) unit directions
    r: Floats  # (points on a ray,) distances from the site, spacings
    weight: Floats  # (points on a ray,) area / distance, up to a factor

    def points(self, place: Floats) -> Floats:
        """All points (rays * points on a ray, 2), ray by ray."""
        return np.asarray((place + self.toward[:, None] * self.r[None, :, None]).reshape(-1, 2))


@dataclass(frozen=True, slots=True, eq=False)
class FieldReading:
    """The averages round a site, as what they take of the displacement gradients."""

    site: Site
    rule: Rule
    functions: Ints  # (k,)
    reading: Reading
    shear: FieldReading | None = None  # the same over the length of the toughness in shear


def field_readings(readings: Readings, sites: Sequence[Site], radius: float | Sequence[float]) -> list[FieldReading]:
    """What the fields round `sites` of a cover within `radius` (m), one or one a site, read off."""
    cover = readings.cover
    radii = np.broadcast_to(radius, len(sites)).tolist()
    rules = [_rule(cover, *each) for each in zip(sites, radii, strict=True)]
    places = [_place(cover, *each) for each in zip(sites, rules, strict=True)]

    def make(new: list[int]) -> Iterator[Made]:
        return _read(cover, [sites[number] for number in new], [rules[number] for number in new])

    found = readings.at(places, make)
    return [FieldReading(site, rule, *each) for site, rule, each in zip(sites, rules, found, strict=True)]


def fields_of(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, readings: Sequence[FieldReading]
) -> list[TipField]:
    """Stress round sites, of what is read off the displacement `u` (n_dofs,) m."""
    shears = {number: known.shear for number, known in enumerate(readings) if known.shear is not None}
    found = _averaged(cover, materials, u, readings)
    for number, field in zip(shears, _averaged(cover, materials, u, list(shears.values())), strict=True):
        found[number] = replace(found[number], shear=field)
    return found


def _rule(cover: Cover, site: Site, radius: float) -> Rule:
    angles = np.pi * (2.0 * np.arange(N_RAYS) + 1.0 - N_RAYS) / N_RAYS
    x, w = gauss(N_RADIAL)
    r = x**2 * radius / cover.lattice.spacing  # r^(-1/2) dr is a polynomial in x
    toward = np.stack([np.cos(site.direction + angles), np.sin(site.direction + angles)], axis=1)
    return Rule(radius, site.direction, angles, toward, r, 2.0 * x * w)  # area / distance = dr dt


def _place(cover: Cover, site: Site, rule: Rule) -> Place:
    """Where the field of a site is read off, and all that it depends on besides the elements there."""
    reach = rule.r[-1]
    near = np.sort(cover.crack_tree.query(shapely.box(*(site.point - reach), *(site.point + reach)))).tolist()
    paths = [cover.cracks[number].points for number in near]
    lengths = np.array([len(path) for path in paths], dtype=np.float64)
    own = np.concatenate([np.array([site.direction, site.body]), site.point, rule.r, lengths, *map(np.ravel, paths)])
    return Place(site.point - reach, site.point + reach, own.tobytes())


def _read(cover: Cover, sites: Sequence[Site], rules: Sequence[Rule]) -> Iterator[Made]:
    """What fields read off, site by site: sums along the rays of the derivatives by x, and over the disc; then by y."""
    for first in range(0, len(sites), SITES_AT_ONCE):
        some, own = sites[first : first + SITES_AT_ONCE], rules[first : first + SITES_AT_ONCE]
        points = np.concatenate([rule.points(site.point) for site, rule in zip(some, own, strict=True)])
        body = np.repeat([site.body for site in some], N_RAYS * N_RADIAL)
        elements = locate(cover.lattice, cover.elements, points, body)
        inside = elements >= 0
        gradients = basis_at(cover, points[inside], elements[inside]).gradients()
        weights = inside.reshape(len(some), N_RAYS, -1) * np.stack([rule.weight for rule in own])[:, None]
        seen = weights * np.stack([_in_sight(cover, *each) for each in zip(some, own, strict=True)])
        summing = _summing(weights, seen, inside)
        sums = [csr_array(summing @ each) for each in gradients]
        ends = gradients[0].indptr[np.append(0, np.cumsum(inside))[:: N_RAYS * N_RADIAL]].tolist()
        for number in range(len(some)):
            functions = distinct(gradients[0].indices[ends[number] : ends[number + 1]])
            yield functions, Reading(_rows_of(number, functions, sums), (weights[number], seen[number]))


def _summing(weights: Floats, seen: Floats, inside: Bools) -> csr_array:
    """Sums (sites * (rays + 1), n) along each ray of what is `seen`, and over the disc, site by site.

    Both are weights (sites, rays, points on a ray); of values at the n points that are `inside`.
    """
    site, ray = np.divmod(np.arange(weights.size) // weights.shape[2], N_RAYS)
    first, point = (N_RAYS + 1) * site[inside], np.arange(np.count_nonzero(inside))
    rows, columns = np.concatenate([first + ray[inside], first + N_RAYS]), np.tile(point, 2)
    data = np.concatenate([seen.ravel()[inside], weights.ravel()[inside]])
    return csr_array((data, (rows, columns)), shape=((N_RAYS + 1) * len(weights), len(point)))


def _rows_of(site: int, functions: Ints, sums: Sequence[csr_array]) -> Floats:
    """The rows (q, k) of a site in some `sums`, one after the other, of these `functions` (k,) on it, ascending."""
    first = (N_RAYS + 1) * site
    rows = np.zeros((len(sums) * (N_RAYS + 1), len(functions)))
    for each, table in zip(sums, np.split(rows, len(sums)), strict=True):
        start = each.indptr[first : first + N_RAYS + 2]
        own = slice(start[0], start[-1])
        row = np.arange(N_RAYS + 1).repeat(np.diff(start))
        table[row, np.searchsorted(functions, each.indices[own])] = each.data[own]
    return rows


def _sums(weights: Floats, seen: Floats) -> Floats:
    """Weights (rays + 1, rays * points on a ray) of the sums along each ray of what is `seen`, and over the disc."""
    sums = np.zeros((N_RAYS + 1, *seen.shape))
    sums[np.arange(N_RAYS), np.arange(N_RAYS)] = seen
    sums[-1] = weights
    return sums.reshape(N_RAYS + 1, -1)


def _averaged(
    cover: Cover, materials: Sequence[PlaneElasticity], u: Floats, readings: Sequence[FieldReading]
) -> list[TipField]:
    """The fields of sites over one length each, of what is read off the displacement `u` (n_dofs,) m."""
    if not readings:
        return []
    amplitudes = u.reshape(-1, 2)
    by = np.stack([known.reading.of(amplitudes[known.functions]) for known in readings])
    by_x, by_y = by.reshape(len(readings), 2, N_RAYS + 1, 2).swapaxes(0, 1)
    strain = np.stack([by_x[..., 0], by_y[..., 1], by_y[..., 0] + by_x[..., 1]], axis=2)
    weights, seen = (np.stack(each) for each in zip(*(known.reading.more for known in readings), strict=True))
    total, whole = seen.sum(axis=2), weights.reshape(len(weights), -1).sum(axis=1)
    sums, found = np.empty(strain.shape), []
    for number, known in enumerate(readings):
        material = materials[known.site.body]
        sums[number] = strain[number] @ material.matrix
        sums[number] += np.append(total[number], whole[number])[:, None] * np.array(material.initial.uniform)
        if material.initial.varying:
            places = cover.lattice.to_metres(known.rule.points(known.site.point))
            sums[number] += _sums(weights[number], seen[number]) @ material.initial.more_at(places)
    # a ray that sees only a part R_c of R would see a singular field larger by sqrt(R / R_c)
    least = np.sqrt(total * np.array([known.rule.weight.sum() for known in readings])[:, None])[:, :, None]
    rays = np.divide(sums[:, :-1], least, out=np.full((len(readings), N_RAYS, 3), np.nan), where=least > 0.0)
    opposite = 0.5 * (rays + np.roll(rays, N_RAYS // 2, axis=1))
    for number, known in enumerate(readings):
        site, rule = known.site, known.rule
        own = opposite if site.both_ways else rays  # a crack takes a ray and the one opposite
        mean = sums[number, -1] / whole[number]
        found.append(TipField(rule.direction, rule.angles, own[number], mean, site.half_width, rule.radius))
    return found


def _in_sight(cover: Cover, site: Site, rule: Rule) -> Bools:
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
