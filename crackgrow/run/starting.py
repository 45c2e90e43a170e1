"""Cracks that start in a run: where they may, and what they are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from crackgrow.arrays import Floats
from crackgrow.case.model import Case, CoulombContact, Crack
from crackgrow.cover.cover import Cover
from crackgrow.errors import SolveError
from crackgrow.fracture.advance import GrowingCrack, Start
from crackgrow.fracture.sites import Site, StartRegions, start_sites, tip_site
from crackgrow.geometry.tolerance import SAME_PLACE
from crackgrow.run.scene import Scene


def sites_of(scene: Scene, cover: Cover, growing: Sequence[GrowingCrack]) -> tuple[Site, ...]:
    """The tips of the cover in their order, then the places where cracks may start."""
    tips, growth = tuple(tip_site(tip, growing[tip.crack].in_shear) for tip in cover.tips), scene.case.growth
    if growth is None or growth.initiation.at == "tips":
        return tips
    at, spacing, h = growth.initiation.at, growth.initiation.spacing, scene.lattice.spacing
    began = _free_ends(scene, growing) if at == "ends" else map(_began, growing)
    places = [place for some in began for place in scene.lattice.to_lattice(some)]
    strong = [body.strength is not None for body in scene.case.bodies]
    radii = [scene.start_radius(n) if has_strength else None for n, has_strength in enumerate(strong)]
    if spacing is None:
        spacing = max([growth.increment, *(radius for radius in radii if radius is not None)])
    apart = tuple(None if radius is None else radius / h for radius in radii)
    regions = StartRegions(at != "ends", at in ("outlines", "anywhere"), at == "anywhere", spacing / h, apart)
    return (*tips, *start_sites(cover, scene.crack_bodies, places, regions))


def _free_ends(scene: Scene, growing: Sequence[GrowingCrack]) -> Iterator[Floats]:
    """Of each crack that was given, the ends (n, 2) m that it has grown from and where none has started yet.

    One start uses up the rock within the averaging radius: what the criterion averages over is broken.
    """
    starts = [crack.crack.points[crack.rooted][0] for crack in growing if crack.steps.min() > 0]
    for index, crack in enumerate(growing):
        if crack.steps.min() > 0:
            continue
        ends = _began(crack)
        if scene.case.bodies[scene.crack_bodies[index]].strength is not None:
            near = scene.start_radius(scene.crack_bodies[index])
            ends = ends[[all(np.hypot(*(end - start)) > near for start in starts) for end in ends]]
        yield ends


def _began(growing: GrowingCrack) -> Floats:
    """Vertices (n, 2) m from which a crack has grown on."""
    first, last = np.flatnonzero(growing.rooted)[[0, -1]]
    ends = [vertex for vertex, end in ((first, 0), (last, len(growing.steps) - 1)) if vertex != end]
    return np.asarray(growing.crack.points[ends])


def start_at(scene: Scene, growing: Sequence[GrowingCrack], others: Sequence[Start], site: Site, mode: str) -> Start:
    """What starts at a site besides `others`, in `tension` or `shear`."""
    name = new_name([*growing, *others])
    crack = new_crack(scene.case, growing, name, scene.case.bodies[site.body].name, site.crack)
    place, where = _place(scene, growing, site), f"{_where(scene, growing, site)} ({mode})"
    return Start(crack, site.crack, mode == "shear", place, site.direction, site.both_ways, where)


def _place(scene: Scene, growing: Sequence[GrowingCrack], site: Site) -> Floats:
    """Where a site lies (2,) m: exactly on its crack, or rim. The cover has rounded both."""
    place = np.asarray(scene.lattice.to_metres(site.point))
    if site.kind == "rock":
        return place
    line: shapely.Geometry = scene.regions[site.body].boundary
    if site.crack is not None:
        points = growing[site.crack].crack.points
        nearest = points[np.argmin(np.hypot(*(points - place).T))]
        if np.hypot(*(nearest - place)) <= SAME_PLACE * scene.lattice.spacing:
            return np.asarray(nearest)
        line = shapely.LineString(points)
    return np.asarray(shapely.get_coordinates(shapely.shortest_line(line, shapely.Point(place)))[0])


def new_name(known: Sequence[GrowingCrack | Start]) -> str:
    """The name of the next crack that starts."""
    names = {each.crack.name for each in known}
    return next(name for number in range(1, len(names) + 2) if (name := f"new{number}") not in names)


def new_crack(case: Case, growing: Sequence[GrowingCrack], name: str, body: str, parent: int | None) -> Crack:
    """A crack that starts in a run on another one (its number) or on none, but for its points and tips.

    Its faces are broken from the start, as those that growth makes. On another crack they have its law of contact,
    elsewhere the friction of the rock's own shear strength.
    """
    if parent is None:
        strength = next(each.strength for each in case.bodies if each.name == body)
        if strength is None:
            raise SolveError(f"a crack starts in body '{body}', which has no strength")
        friction = float(np.tan(np.deg2rad(strength.friction_angle)))
        contact: CoulombContact | None = CoulombContact(friction, 0.0, friction, False)
    else:
        law = growing[parent].crack.contact
        contact = None if law is None else law.without_bond
    return Crack(name, np.zeros((2, 2)), True, True, contact, body)


def _where(scene: Scene, growing: Sequence[GrowingCrack], site: Site) -> str:
    """What a site lies on, in words."""
    body = scene.case.bodies[site.body]
    if site.crack is not None:
        return growing[site.crack].crack.surface.words
    if site.kind == "rock":
        return f"the rock of body '{body.name}'"
    for number, ring in enumerate(scene.bodies[site.body].rings[1:]):
        if shapely.dwithin(shapely.LinearRing(ring), shapely.Point(site.point), SAME_PLACE):
            return f"hole{number} of body '{body.name}'"
    return f"the outline of body '{body.name}'"
