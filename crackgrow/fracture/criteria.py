"""Growth criteria: when a tip grows, and where to.

Strength: tension cut-off sigma_1 >= T0, else Mohr-Coulomb shear |tau| >= c - tan(phi) sigma_n (paper, section 3).
`strength` applies it to the averaged stress of the tip, `directional_strength` to hoop tension and shear on every ray,
averaged from the tip with the same weights. (The stress at the ray's end alone would follow the direction of K less
well: the stress parallel to the crack weighs more there.)

Maximum hoop stress (Erdogan, Sih 1963): the hoop stress of K_I and K_II alone, at the radius, against T0.

Where the rock has a toughness a tip opens by K alone in all three, where K_eq is the toughness: the average over R has
the pressure of a fluid or of confinement in it, and would let mode I grow at several times the toughness. The direction
stays that of the average: by that of K straight increments turn to and fro beside closed faces, by 35 to 50 degrees in
compression30. Shear goes by the average, too, since pressure on a plane holds it.

Where the rock has bedding tensile strength and toughness follow the direction of a crack (`share_across`), and it goes
where the stress over them is largest.

Cracks that have started in shear go on by `shear_growth`, whatever the criterion, as long as that is met.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from crackgrow.arrays import Floats, Ints
from crackgrow.case.model import Strength
from crackgrow.cover.shapes import Roots
from crackgrow.fracture.opening import (
    KINKS,
    Resisting,
    hoop_and_shear_at,
    opening,
    peak_of,
    peaks_of,
    share_across,
)
from crackgrow.solid.elasticity import principal

if TYPE_CHECKING:  # what reads the criteria alone needs no basis
    from crackgrow.fracture.tip_stress import TipField

AT_STRENGTH = 1e-9
"""A criticality this close below 1 is 1 but for round-off, as it is at a critical load."""

LEAST_RESISTANCE = 1e-30
"""Pa: a resistance below this, or negative, is used up."""

LARGEST_RATIO = 1e30
"""Ratio that stands for a resistance that is used up."""


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What a criterion says of a tip."""

    sigma_1: float  # Pa, of the averaged stress
    sigma_3: float  # Pa
    mode: Literal["tension", "shear"]  # how the tip grows, or would
    criticality: float  # stress over strength: the tip grows from 1 on
    kink: float  # rad, from the tip's direction to the growth direction
    of_shear: float = 0.0  # stress over strength in shear, where tension comes first: a lower load may have met it

    @property
    def largest(self) -> float:
        """The largest ratio of all branches. While the load rises from none, its first 1 is where the tip grows."""
        return max(self.criticality, self.of_shear)

    @property
    def branch(self) -> Literal["tension", "shear", "none"]:
        """The part of the criterion that is met."""
        return self.mode if self.criticality >= 1.0 - AT_STRENGTH else "none"


@dataclass(frozen=True, slots=True, eq=False)
class TipLoading:
    """What criteria know of a tip, or of another site, which has no K."""

    field: TipField
    K_I: float  # Pa sqrt(m), nan where it is not known
    K_II: float  # Pa sqrt(m)
    radius: float  # m, material length of the criterion
    roots: Roots = (1j, 1j)  # of the rock, in the axes of the tip

    @property
    def K_eq(self) -> float:
        """The K_I (Pa sqrt(m)) that alone has the largest hoop stress of K_I and K_II, which is at the kink."""
        return opening((self.K_I, self.K_II), self.roots)[0]

    @property
    def none(self) -> TipLoading:
        """The same tip without any load."""
        field = self.field.mapped(lambda stress: 0.0 * stress)
        return replace(self, field=field, K_I=0.0 * self.K_I, K_II=0.0 * self.K_II)

    @staticmethod
    def between(first: TipLoading, last: TipLoading, share: float) -> TipLoading:
        """The loading at a share of the way from one load to another where everything is linear in the load."""
        field = first.field.mapped(lambda a, b: a + share * (b - a), last.field)
        K_I, K_II = (a + share * (b - a) for a, b in ((first.K_I, last.K_I), (first.K_II, last.K_II)))
        return replace(first, field=field, K_I=K_I, K_II=K_II)


def without_K(field: TipField, radius: float) -> TipLoading:
    """What criteria know where K is not known, with their material length (m)."""
    return TipLoading(field, np.nan, np.nan, radius)


CriterionFunction = Callable[[Sequence[TipLoading], Strength], list[Verdict]]
"""What a criterion says of each of some sites in rock of the same strength."""


def one_by_one(evaluate: Callable[[TipLoading, Strength], Verdict]) -> CriterionFunction:
    """The criterion that a function is for one site."""
    return lambda loadings, limits: [evaluate(loading, limits) for loading in loadings]


@dataclass(frozen=True, slots=True)
class Criterion:
    """A growth criterion."""

    name: str  # as in a case file
    at_tips: CriterionFunction  # tips
    at_starts: CriterionFunction  # other sites, without K


def strength(loading: TipLoading, limits: Strength) -> Verdict:
    """Evaluate the criterion of the averaged stress at a tip: growth perpendicular to sigma_1, or on a shear plane.

    Tension is sigma_1 over the tensile strength, or K over the toughness where both are known; with bedding in the
    direction where the hoop stress over the strength is largest. Mohr-Coulomb planes lie at 45 - phi/2 degrees to the
    major compression; of the two, growth takes the one on which the ray from the tip carries the larger shear stress.
    Tension governs from its strength on, and where it is nearer to it than shear.
    """
    field = loading.field
    s1, s3, axis = (float(v[0]) for v in principal(field.mean[None]))
    phi = np.deg2rad(limits.friction_angle)
    centre, radius = 0.5 * (s1 + s3), 0.5 * (s1 - s3)
    shear = float(_ratio(radius, limits.cohesion * np.cos(phi) - centre * np.sin(phi)))
    compression_axis = axis + 0.5 * np.pi - field.direction
    pulled, across = s1, _forward(compression_axis)  # perpendicular to sigma_1
    if limits.bedding is not None:
        # every axis is among the KINKS, and not at their end
        hoop, _ = hoop_and_shear_at(field.direction + KINKS, field.mean)
        pulled, across = peak_of(KINKS, hoop / share_across(limits, _known(loading, limits), field.direction + KINKS))
        across = _forward(across)
    tension = _tension(pulled, loading, limits)
    planes = [_forward(compression_axis + sense * (0.25 * np.pi - 0.5 * phi)) for sense in (-1.0, 1.0)]
    planes = [plane for plane in planes if _within(field, plane)]
    tension, shear = tension * _within(field, across), shear * bool(planes)
    if tension >= 1.0 or tension >= shear or not planes:
        return Verdict(s1, s3, "tension", tension, across, shear)
    _, along = hoop_and_shear(field, field.rays)
    seen = np.isfinite(along)
    shears = [abs(np.interp(plane, field.angles[seen], along[seen])) for plane in planes]
    kink = planes[int(np.argmax(shears))]
    return Verdict(s1, s3, "shear", shear, kink)


def directional_strength(loadings: Sequence[TipLoading], limits: Strength) -> list[Verdict]:
    """Strength on every ray from each of some sites: hoop tension first, then Mohr-Coulomb shear on the ray.

    Sites that see the same rays ahead are judged at once.
    """
    if not loadings:
        return []
    s1, s3, _ = principal(np.stack([loading.field.mean for loading in loadings]))
    sees = np.zeros(len(loadings), dtype=bool)
    peaks = np.zeros((4, len(loadings)))  # tension and its angle, shear and its angle
    tan_phi = np.tan(np.deg2rad(limits.friction_angle))
    for some, angles, hoop, shear in _ahead_together([loading.field for loading in loadings]):
        sees[some] = True
        directions = np.array([loadings[number].field.direction for number in some])[:, None] + angles
        peaks[:2, some] = peaks_of(angles, hoop / share_across(limits, _known(loadings[some[0]], limits), directions))
        peaks[2:, some] = peaks_of(angles, _ratio(np.abs(shear), limits.cohesion - tan_phi * hoop))
    found = []
    for number, (first, last, own) in enumerate(zip(s1.tolist(), s3.tolist(), peaks.T.tolist(), strict=True)):
        pulled, kink, sliding, shear_kink = own
        tension = _tension(pulled, loadings[number], limits)
        tough, of_shear = loadings[number].field.shear, sliding
        if tough is not None and sees[number]:
            toughness = _at_shear_toughness(tough, limits)
            sliding, shear_kink, of_shear = toughness.criticality, toughness.kink, toughness.of_shear
        if tension >= 1.0 or tension >= sliding:
            found.append(Verdict(first, last, "tension", tension, kink, of_shear))
        else:
            found.append(Verdict(first, last, "shear", sliding, shear_kink))
    return found


def shear_growth(loading: TipLoading, limits: Strength) -> Verdict:
    """What a crack goes on by that has started in shear: Mohr-Coulomb on the rays from its tip that are pressed.

    It is met where |tau| >= c - tan(phi) sigma_n on one of them. Of those on which it is met the crack takes the ray
    with the largest shear stress (Chao, Liu 1997): straight on in mode II. The largest ratio would lead to rays which
    the tip's own field relieves of their pressure, the more the further the load is beyond the criterion. Rays in
    tension open, and are left out.

    Without friction in the rock mode II meets it at K_II = c sqrt(2 pi R) / 2, with friction under a pressure p at
    (c + p tan(phi)) sqrt(2 pi R) / 2 straight ahead, and sooner beside it.
    """
    field = loading.field
    if field.shear is not None:
        return _at_shear_toughness(field.shear, limits)
    s1, s3, _ = (float(v[0]) for v in principal(field.mean[None]))
    hoop, shear = hoop_and_shear(field, field.rays)
    pressed = (np.abs(field.angles) <= field.half_width) & (hoop <= 0.0)  # nan is not
    if not pressed.any():
        return Verdict(s1, s3, "shear", 0.0, 0.0)
    angles, shear = field.angles[pressed], np.abs(shear[pressed])
    ratios = _ratio(shear, limits.cohesion - np.tan(np.deg2rad(limits.friction_angle)) * hoop[pressed])
    criticality, kink = peak_of(angles, ratios)
    met = ratios >= 1.0
    return Verdict(s1, s3, "shear", criticality, peak_of(angles[met], shear[met])[1] if met.any() else kink)


def _at_shear_toughness(field: TipField, limits: Strength) -> Verdict:
    """Shear at a tip whose toughness in shear is known: Mohr-Coulomb on the ray with the largest shear stress.

    So mode II grows straight on (Rao et al. 2003) at K_IIc, and under a pressure p where faces have a friction mu at
    (1 + p (tan(phi) - mu) / c) K_IIc. Where that ray is pulled by the tensile strength it opens.
    """
    s1, s3, _ = (float(v[0]) for v in principal(field.mean[None]))
    angles, hoop, shear = _ahead(field)
    if not len(angles):
        return Verdict(s1, s3, "shear", 0.0, 0.0)
    largest, kink = peak_of(angles, np.abs(shear))
    across = float(np.interp(kink, angles, hoop))
    resistance = limits.cohesion - np.tan(np.deg2rad(limits.friction_angle)) * across
    ratio = float(_ratio(largest, resistance))
    tension = limits.tension * float(share_across(limits, "tension", field.direction + kink))
    return Verdict(s1, s3, "shear", ratio if across < tension else 0.0, kink, ratio)


def max_hoop_stress(loading: TipLoading, limits: Strength) -> Verdict:
    """Tension where the hoop stress of K_I, K_II is largest: K_eq / sqrt(2 pi R) against T0.

    A tip under compression alone does not grow.
    """
    s1, s3, _ = (float(v[0]) for v in principal(loading.field.mean[None]))
    K, kink = opening((loading.K_I, loading.K_II), loading.roots, limits, loading.field.direction)
    return Verdict(s1, s3, "tension", float(K / (limits.tension * np.sqrt(2.0 * np.pi * loading.radius))), kink)


def _known(loading: TipLoading, limits: Strength) -> Resisting:
    """What lets a site open: the toughness where K is known, else the tensile strength."""
    return "tension" if limits.toughness is None or not np.isfinite(loading.K_eq) else "toughness"


def _tension(stress: float, loading: TipLoading, limits: Strength) -> float:
    """Tension over strength: K over the toughness where both are known, else a stress (Pa) over T0; across bedding."""
    if limits.toughness is None or _known(loading, limits) == "tension":
        return stress / limits.tension
    K, _ = opening((loading.K_I, loading.K_II), loading.roots, limits, loading.field.direction)
    return K / limits.toughness


CRITERIA = {
    criterion.name: criterion
    for criterion in (
        Criterion("strength", one_by_one(strength), one_by_one(strength)),
        Criterion("directional_strength", directional_strength, directional_strength),
        Criterion("max_hoop_stress", one_by_one(max_hoop_stress), directional_strength),
    )
}


def hoop_and_shear(field: TipField, stress: Floats) -> tuple[Floats, Floats]:
    """Hoop stress and shear stress (n,) Pa on the rays of a field, from stress (n, 3) there."""
    return hoop_and_shear_at(field.direction + field.angles, stress)


def _ahead(field: TipField) -> tuple[Floats, Floats, Floats]:
    """Angles (n,) of the rays that a crack may take, with their hoop stress and shear stress (n,) Pa."""
    hoop, shear = hoop_and_shear(field, field.rays)
    ahead = (np.abs(field.angles) <= field.half_width) & np.isfinite(hoop)
    return field.angles[ahead], hoop[ahead], shear[ahead]


def _ahead_together(fields: Sequence[TipField]) -> Iterator[tuple[Ints, Floats, Floats, Floats]]:
    """As `_ahead` of fields that have the same angles (n,) there: their numbers (m,), and hoop and shear (m, n).

    Those that have no ray ahead are left out.
    """
    alike: dict[bytes, list[int]] = {}
    for number, field in enumerate(fields):
        alike.setdefault(field.angles.tobytes(), []).append(number)
    for numbers in alike.values():
        angles = fields[numbers[0]].angles
        direction, width = np.array([(fields[number].direction, fields[number].half_width) for number in numbers]).T
        hoop, shear = hoop_and_shear_at(
            direction[:, None] + angles, np.stack([fields[number].rays for number in numbers])
        )
        ahead = (np.abs(angles) <= width[:, None]) & np.isfinite(hoop)
        see_the_same: dict[bytes, list[int]] = {}
        for row, rays in enumerate(ahead):
            see_the_same.setdefault(rays.tobytes(), []).append(row)
        for rows in see_the_same.values():
            rays = ahead[rows[0]]
            if rays.any():
                yield np.array(numbers)[rows], angles[rays], hoop[rows][:, rays], shear[rows][:, rays]


def _ratio(load: Floats | float, resistance: Floats | float) -> Floats:
    """Load over resistance; a resistance that is used up (by tension) counts as none."""
    return np.asarray(np.minimum(load / np.maximum(resistance, LEAST_RESISTANCE), LARGEST_RATIO))


def _within(field: TipField, kink: float) -> bool:
    """Whether a crack may leave a site at an angle (rad)."""
    return abs(kink) <= field.half_width


def _forward(angle: float) -> float:
    """The direction of an axis (rad, from the tip's direction) that points ahead: in [-pi/2, pi/2)."""
    return float((angle + 0.5 * np.pi) % np.pi - 0.5 * np.pi)
