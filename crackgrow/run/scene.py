"""What stays the same through a run: the lattice, the bodies, their materials and the surfaces that do not grow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely

from crackgrow.accuracy.companion import BY_HAND, Grading
from crackgrow.case import model
from crackgrow.case.sizing import Length, rim_lengths
from crackgrow.case.surface import numbered
from crackgrow.case.toughness import BY_K, averaging_radius, shear_radius, start_radius
from crackgrow.cover.cover import Foundation
from crackgrow.cover.lattice import Lattice, place_lattice
from crackgrow.cover.shapes import BodyGeometry, CrackGeometry, body_index
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.fracture.debond import Debond, bonds
from crackgrow.fracture.sites import Site
from crackgrow.geometry.tolerance import ON_LINE
from crackgrow.run.surface_laws import SurfaceLaw, surface_law
from crackgrow.solid.elasticity import PlaneElasticity, plane_elasticity
from crackgrow.solid.in_situ import InSitu

if TYPE_CHECKING:
    from crackgrow.fracture.stress_intensity import BodyForce


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A case made ready for its steps."""

    case: model.Case
    lattice: Lattice
    materials: tuple[PlaneElasticity, ...]  # body by body, without in-situ stress
    regions: tuple[shapely.Polygon, ...]  # body by body, m
    bodies: tuple[BodyGeometry, ...]  # body by body, lattice coordinates
    interfaces: tuple[CrackGeometry, ...]  # line by line, lattice coordinates
    foundations: tuple[Foundation, ...]
    crack_bodies: tuple[int, ...]  # crack by crack, the body it lies in
    lengths: tuple[Length, ...]  # what the stress varies over besides cracks
    laws: tuple[SurfaceLaw, ...]  # of the cracks, the interfaces and the foundations, as the cover's surfaces
    grading: Grading = BY_HAND
    stage: int | None = None  # its number, from 0 on: the load factor rises by one in each; None: there are none
    whole: Scene | None = None  # with the rock that is gone; None: none is
    debonds: tuple[Debond, ...] = ()  # cracked parts of interfaces that have a toughness

    @property
    def at_start(self) -> Scene:
        """The scene with all of its rock: its cells are those of every stage."""
        return self.whole or self

    def parts(self, load: model.Load) -> tuple[float, float]:
        """a and b: at a load factor F a load acts with a + b F."""
        if self.stage is None:
            return (1.0, 0.0) if load.held else (0.0, 1.0)
        return self.through_stage(
            lambda stage: dict(stage.loads).get(load.name or "", 1.0 if load.held else stage.factor)
        )

    def through_stage(self, value: Callable[[model.Stage], float]) -> tuple[float, float]:
        """a and b: what has some `value` at the end of a stage is a + b F at a load factor F of the one of now."""
        loading, number = self.case.loading, self.stage
        assert isinstance(loading, model.Stages)
        assert number is not None
        begin, end = value(loading.stages[number - 1] if number else loading.before), value(loading.stages[number])
        return begin - number * (end - begin), end - begin

    def share(self, load: model.Load, load_factor: float) -> float:
        """How much of a load acts at a load factor."""
        a, b = self.parts(load)
        return a + b * load_factor

    @property
    def given_parts(self) -> tuple[float, float]:
        """The same of given displacements."""
        return (0.0, 1.0) if self.stage is None else self.through_stage(lambda stage: stage.factor)

    def body_force(self, body: int, load_factor: float) -> BodyForce | None:
        """What pulls at the rock of a body at a load factor, besides a uniform in-situ stress; None for nothing."""
        weight, stress, rock = np.zeros(2), self._in_situ(body, load_factor), self.case.bodies[body]
        for load in self.case.loads:
            if isinstance(load, model.Gravity) and load.body == rock.name:
                assert rock.material.density is not None  # the case was checked
                weight += rock.material.density * np.asarray(load.acceleration) * self.share(load, load_factor)
        if not stress.varying:
            return (lambda places: np.broadcast_to(weight, places.shape)) if weight.any() else None
        return lambda places: weight + stress.divergence(places, self.lattice.spacing)

    def _in_situ(self, body: int, load_factor: float) -> InSitu:
        """In-situ stress of a body at a load factor."""
        stress = InSitu()
        for load in self.case.loads:
            if isinstance(load, model.InSituStress) and load.body == self.case.bodies[body].name:
                stress = stress.plus(load, self.share(load, load_factor))
        return stress

    def with_cracks(self, growing: Sequence[GrowingCrack]) -> Scene:
        """The scene with what has started since the case was made, and fluids in all cracks that they reach."""
        case, n = self.case, len(self.case.cracks)
        new = growing[n:]
        loads = self._with_fluids_beyond(growing)
        if not new:
            return self if loads is case.loads else replace(self, case=replace(case, loads=loads))
        cracks = [growing_crack.crack for growing_crack in new]
        laws = [surface_law(case, crack.contact, crack.body) for crack in cracks]
        return replace(
            self,
            case=replace(case, cracks=(*case.cracks, *cracks), loads=loads),
            crack_bodies=(*self.crack_bodies, *(body_index(case.bodies, crack.body) for crack in cracks)),
            laws=(*self.laws[:n], *laws, *self.laws[n:]),
        )

    def with_debonds(self, debonds: tuple[Debond, ...]) -> Scene:
        """The scene with interfaces cracked so far."""
        if all(debond.is_as_given for debond in debonds):
            return replace(self, debonds=debonds)
        interfaces = list(self.case.interfaces)
        for number, interface in enumerate(interfaces):
            mine = [debond for debond in debonds if debond.bodies == interface.bodies]
            if mine:
                lines = bonds(interface.boundary, mine) if interface.beside_crack else [each.points for each in mine]
                interfaces[number] = replace(interface, lines=tuple(lines))
        case, n = replace(self.case, interfaces=tuple(interfaces)), len(self.case.cracks)
        geometries, laws = _on_interfaces(case, self.lattice)
        all_laws = (*self.laws[:n], *laws, *self.laws[len(self.laws) - len(self.foundations) :])
        return replace(self, case=case, interfaces=tuple(geometries), laws=all_laws, debonds=debonds)

    def _with_fluids_beyond(self, growing: Sequence[GrowingCrack]) -> tuple[model.Load, ...]:
        """The loads with each fluid in the cracks that it reaches: what starts on its crack, and where it is connected
        what touches. Cracks with a fluid of their own keep that, and those that two fluids reach have the first.
        """
        loads = self.case.loads
        fluids = [load for load in loads if isinstance(load, model.FluidPressure | model.FluidVolume)]
        if not fluids or not (any(load.connected for load in fluids) or len(growing) > len(self.case.cracks)):
            return loads
        parted = [
            line
            for line, law in zip(self.interfaces, self.laws[len(self.case.cracks) :], strict=False)
            if not law.bonded
        ]
        names = [*(each.crack.surface for each in growing), *(line.name for line in parted)]
        points = [*(self.lattice.to_lattice(each.crack.points) for each in growing), *(line.points for line in parted)]
        lines = np.array([shapely.LineString(line) for line in points])
        touching = shapely.STRtree(lines).query(lines, "dwithin", distance=ON_LINE).T.tolist()
        started = [(each.parent, number) for number, each in enumerate(growing) if each.parent is not None]
        own = {number for number, name in enumerate(names) if any(name.is_of(load.surface) for load in fluids)}
        found: dict[int, model.Load] = {}
        for load in fluids:
            filled = [number for number in own if names[number].is_of(load.surface)]
            for number in filled:  # it grows on the way
                for one, other in (*started, *(touching if load.connected else ())):
                    if one == number and other not in own and other not in filled:
                        filled.append(other)
            beyond = [number for number in filled if number not in own]
            found[id(load)] = replace(load, beyond=tuple(names[number] for number in beyond))
            own.update(beyond)
        return tuple(found.get(id(load), load) for load in loads)

    def with_grading(self, grading: Grading) -> Scene:
        """Return the scene with other refinement levels, which the scene before excavation gets, too."""
        return replace(self, grading=grading, whole=self.whole and self.whole.with_grading(grading))

    @property
    def growth(self) -> model.Growth:
        """How cracks grow: of a case with growth."""
        assert self.case.growth is not None
        return self.case.growth

    def growing_in(self, body: int) -> tuple[model.Growth, model.Strength]:
        """How cracks grow, and the strength of the body that they grow in, which has one."""
        strength = self.case.bodies[body].strength
        assert strength is not None
        return self.growth, strength

    def start_radius(self, body: int) -> float:
        """Radius (m) of the criterion in such a body where cracks start, and at tips of those that have so in shear."""
        return start_radius(*self.growing_in(body))

    def radius_at(self, site: Site) -> float:
        """Radius (m) over which stress is averaged at a site in such a body."""
        radius = start_radius if site.kind != "tip" or site.in_shear else averaging_radius
        return radius(*self.growing_in(site.body))

    def shear_radius_at(self, site: Site) -> float | None:
        """The same (m) for shear at a tip that may grow in it by a toughness; None elsewhere.

        Where cracks start there is no K: a wing has taken the singularity away. Over a longer length stress is larger
        there, and a larger toughness would let them start sooner.
        """
        growth, strength = self.growing_in(site.body)
        shears = site.in_shear or (site.kind == "tip" and growth.criterion not in BY_K)
        return shear_radius(growth, strength) if shears else None

    def materials_at(self, load_factor: float) -> tuple[PlaneElasticity, ...]:
        """Materials, body by body, with their in-situ stress at a load factor."""
        return tuple(
            replace(material, initial=self._in_situ(body, load_factor)) for body, material in enumerate(self.materials)
        )


def make_scene(case: model.Case, offset: tuple[float, float] = (0.0, 0.0)) -> Scene:
    """Place the lattice, moved by `offset` spacings for studies, and evaluate the materials of a case.

    Where errors are measured the largest cells of the lattice are the companion's: twice the spacing.
    """
    corners = np.concatenate([body.outline for body in case.bodies])
    numerics, grading = case.numerics, Grading(nested=case.numerics.measured)
    spacing = 2.0 * numerics.spacing if grading.nested else numerics.spacing
    lattice = place_lattice(corners.min(axis=0), corners.max(axis=0), spacing, numerics.support, offset)
    scene = replace(_scene_on(case, replace(lattice, map_origin=case.origin)), grading=grading)
    scene = scene.with_cracks([GrowingCrack.given(crack) for crack in case.cracks])
    return replace(scene, stage=0) if isinstance(case.loading, model.Stages) else scene


def scene_of_stage(scene: Scene, number: int) -> Scene:
    """The scene of a stage, from 0 on, of a case that has them: without the rock that is gone, on the same lattice.

    What acts on that goes, too, but for supports, which keep their numbers.
    """
    case = scene.case
    assert isinstance(case.loading, model.Stages)
    gone = {body for body, _ in case.loading.stages[number].excavated}
    if not gone:
        return replace(scene, stage=number)

    def is_left(load: model.Load) -> bool:
        if isinstance(load, model.Fluid):
            return not load.surface.bounds(gone)
        return (load.region.body if isinstance(load, model.EdgeLoad) else load.body) not in gone

    case = replace(
        case,
        bodies=tuple(body for body in case.bodies if body.name not in gone),
        interfaces=tuple(interface for interface in case.interfaces if not interface.surface.bounds(gone)),
        loads=tuple(filter(is_left, case.loads)),
    )
    left = replace(_scene_on(case, scene.lattice), grading=scene.grading, lengths=scene.lengths, debonds=scene.debonds)
    return replace(left, stage=number, whole=scene)


def _scene_on(case: model.Case, lattice: Lattice) -> Scene:
    """The scene of a case on a lattice."""
    materials = tuple(
        plane_elasticity(m.young, m.poisson, case.plane, m.bedding) for m in (body.material for body in case.bodies)
    )
    crack_bodies = tuple(body_index(case.bodies, crack.body) for crack in case.cracks)
    interfaces, laws = _on_interfaces(case, lattice)
    bodies = {body.name for body in case.bodies}
    supports = [each for each in case.supports if isinstance(each, model.ContactSupport) and each.region.body in bodies]
    names = numbered([support.surface for support in supports])
    held = [support.region for support in case.supports if not isinstance(support, model.PointSupport)]
    loaded = [load.region for load in case.loads if isinstance(load, model.EdgeLoad)]
    rims = {body.name: [ring.points for ring in body.rings] for body in case.bodies}
    joined = ((interface.bodies, interface.lines) for interface in case.interfaces)
    return Scene(
        case=case,
        lattice=lattice,
        materials=materials,
        regions=tuple(shapely.Polygon(b.rings[0].points, [r.points for r in b.rings[1:]]) for b in case.bodies),
        bodies=tuple(
            BodyGeometry(tuple(lattice.to_lattice(r.points) for r in b.rings), b.name, m.roots)
            for b, m in zip(case.bodies, materials, strict=True)
        ),
        interfaces=tuple(interfaces),
        foundations=tuple(
            Foundation(name, each.region, each.moves) for name, each in zip(names, supports, strict=True)
        ),
        crack_bodies=crack_bodies,
        lengths=tuple(rim_lengths(rims, joined, held, loaded, case.origin)),
        laws=(
            *(surface_law(case, crack.contact, crack.body) for crack in case.cracks),
            *laws,
            *(surface_law(case, support.contact, support.region.body) for support in supports),
        ),
    )


def _on_interfaces(case: model.Case, lattice: Lattice) -> tuple[list[CrackGeometry], list[SurfaceLaw]]:
    """The lines of the interfaces of a case on a lattice, and what holds each of them."""
    lines = [(interface, line) for interface in case.interfaces for line in interface.lines]
    names = numbered([interface.surface for interface, _ in lines])
    return (
        [
            CrackGeometry(name, lattice.to_lattice(line), False, False)
            for name, (_, line) in zip(names, lines, strict=True)
        ],
        [surface_law(case, interface.contact, *interface.bodies) for interface, _ in lines],
    )
