"""One step: a configuration of the cracks under its loads, with K, stress and criteria evaluated at its tips."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from crackgrow.accuracy.companion import Errors
from crackgrow.arrays import Floats
from crackgrow.case.formula import component_at
from crackgrow.case.model import CriticalLoad, FluidPressure, FluidVolume
from crackgrow.case.toughness import averaging_radius
from crackgrow.contact.faces import points_at
from crackgrow.contact.jump import elastic_tractions
from crackgrow.cover.shapes import turned_roots
from crackgrow.fracture.criteria import AT_STRENGTH, CRITERIA, TipLoading, Verdict, shear_growth, without_K
from crackgrow.fracture.debond import Debond
from crackgrow.fracture.face_displacements import from_face_displacements
from crackgrow.fracture.interface_tips import InterfaceTip, Release, released
from crackgrow.fracture.opening import share_across
from crackgrow.fracture.sites import Site
from crackgrow.fracture.stress_intensity import FaceTraction, StressIntensity
from crackgrow.fracture.subcritical import range_of_K
from crackgrow.fracture.tip_stress import TipField, fields_of
from crackgrow.run.clock import timed
from crackgrow.run.increments import FROM_REST, LoadState, Origin
from crackgrow.run.scene import Scene
from crackgrow.run.state_values import volume_pressure
from crackgrow.run.warning_causes import limit_of


@dataclass(frozen=True, slots=True, eq=False)
class TipState:
    """Fracture quantities of one tip of the cover."""

    intensity: StressIntensity
    K_faces: tuple[float, float]  # Pa sqrt(m): K_I and K_II from the displacement of the faces, as a check
    loading: TipLoading | None  # None without growth
    verdict: Verdict | None
    K_range: float = math.nan  # Pa sqrt(m), between the first and the last load; nan without cycles

    @property
    def K(self) -> tuple[float, float]:
        """K_I and K_II (Pa sqrt(m)) to go by: the integral's, or the faces' where the integral finds no room."""
        found = (self.intensity.K_I, self.intensity.K_II)
        return found if np.isfinite(found).all() else self.K_faces

    @property
    def K_growth(self) -> float:
        """K_eq in tension, |K_II| in shear, at which the tip grows if stress rises with it in proportion; or nan."""
        if self.loading is None or self.verdict is None or self.verdict.criticality <= 0.0:
            return float("nan")
        own = self.loading.K_eq if self.verdict.mode == "tension" else abs(self.loading.K_II)
        return own / self.verdict.criticality if own > 0.0 else float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class StartState:
    """What a place makes of its stress at which a crack may start."""

    site: Site
    loading: TipLoading
    verdict: Verdict


@dataclass(frozen=True, slots=True, eq=False)
class InterfaceTipState:
    """What is known of a tip of a cracked interface."""

    tip: InterfaceTip
    release: Release
    debond: Debond | None  # None: without a toughness, so that it does not grow

    @property
    def criticality(self) -> float:
        """sqrt(G / G_c); nan where one of them is not known."""
        return math.nan if self.debond is None else math.sqrt(max(self.release.G, 0.0) / self.debond.toughness)


@dataclass(frozen=True, eq=False, kw_only=True)
class StepSolution(LoadState):
    """A configuration under its loads with the fracture quantities of its tips, and how it was found."""

    tips: tuple[TipState, ...]
    starts: tuple[StartState, ...]
    interface_tips: tuple[InterfaceTipState, ...]
    origin: Origin = FROM_REST
    passed: tuple[LoadState, ...] = ()  # states of the loads before it, in turn, where the case asks for its history
    errors: Errors | None = None  # None: cells are by hand, and nothing was measured
    doubts: tuple[str, ...] = ()  # on the advance that led to it: its direction, the time that it took

    @property
    def jumps(self) -> list[float]:
        """What the criticality of each tip is beyond 1 at a critical load factor, where bonds break: 0 elsewhere."""
        if not isinstance(self.scene.case.loading, CriticalLoad):
            return [0.0] * len(self.tips)
        limit, ends = limit_of("JUMP"), self.cover.tip_ends
        beyond = [0.0 if tip.verdict is None else tip.verdict.criticality - 1.0 for tip in self.tips]
        grows = [self.cracks[crack].can_grow(at_end) for crack, at_end in ends]
        return [more if may and more > limit else 0.0 for may, more in zip(grows, beyond, strict=True)]


def evaluated(state: LoadState) -> StepSolution:
    """A loaded configuration with the fracture quantities of its tips."""
    scene, cover, configuration, materials = state.scene, state.cover, state.configuration, state.materials
    with timed("criterion"):
        u, n_tips = state.outcome.u, len(cover.tips)
        fields_at: dict[int, TipField] = {}  # the stress round every site at which something can grow, by its number
        if scene.case.growth is not None:
            functionals = configuration.stress_functionals
            fields_at = dict(zip(functionals, fields_of(cover, materials, u, list(functionals.values())), strict=True))
        tips, places = _tip_states(state, fields_at), configuration.sites[n_tips:]
        loadings = [without_K(fields_at[n], scene.start_radius(site.body)) for n, site in enumerate(places, n_tips)]
        starts = tuple(map(StartState, places, loadings, verdicts(scene, places, loadings)))
        forces = [scene.body_force(body, state.factor) for body in range(len(materials))]
        interface_tips = tuple(
            InterfaceTipState(tip, released(cover, materials, u, tip, _tractions(state, tip.surface), forces), debond)
            for tip, debond in configuration.interface_tips
        )
    known = {each.name: getattr(state, each.name) for each in fields(LoadState)}
    return StepSolution(**known, tips=tips, starts=starts, interface_tips=interface_tips)


def with_ranges(solution: StepSolution, first: LoadState) -> StepSolution:
    """The solution whose tips know the range of K since the first load of a cycle, as one across any bedding."""
    tips = list(solution.tips)
    for n, (was, now, site) in enumerate(zip(_intensities(first), tips, solution.configuration.sites, strict=False)):
        if now.loading is not None and now.verdict is not None:
            kink, (_, strength) = now.verdict.kink, solution.scene.growing_in(site.body)
            share = float(share_across(strength, "toughness", now.loading.field.direction + kink))
            tips[n] = replace(now, K_range=range_of_K(was.K, now.K, kink, now.loading.roots) / share)
    return replace(solution, tips=tuple(tips))


def _intensities(state: LoadState) -> list[TipState]:
    """K of all tips."""
    scene, cover, materials, u = state.scene, state.cover, state.materials, state.outcome.u
    tips = range(len(cover.tips))
    bodies = [scene.crack_bodies[crack] for crack, _ in cover.tip_ends]
    K_faces = from_face_displacements(cover, materials, u, tips)
    tractions = [_tractions(state, crack) for crack, _ in cover.tip_ends]
    forces = [scene.body_force(body, state.factor) for body in bodies]
    intensities = state.configuration.integrals.intensities(materials, u, tips, tractions, forces)
    return [TipState(K, K_of_faces, None, None) for K, K_of_faces in zip(intensities, K_faces, strict=True)]


def _tip_states(state: LoadState, fields: Mapping[int, TipField]) -> tuple[TipState, ...]:
    """Fracture quantities of all tips, with the stress `fields` round them."""
    scene, sites, found = state.scene, state.configuration.sites, _intensities(state)
    strong = [tip for tip in range(len(found)) if tip in fields]
    radii = [averaging_radius(*scene.growing_in(sites[tip].body)) for tip in strong]
    roots = [turned_roots(state.cover.bodies[tip.body].roots, tip.rotation) for tip in state.cover.tips]
    loadings = [TipLoading(fields[n], *found[n].K, radius, roots[n]) for n, radius in zip(strong, radii, strict=True)]
    said = verdicts(scene, [sites[tip] for tip in strong], loadings)
    for tip, loading, verdict in zip(strong, loadings, said, strict=True):
        found[tip] = replace(found[tip], loading=loading, verdict=verdict)
    return tuple(found)


def verdicts(scene: Scene, sites: Sequence[Site], loadings: Sequence[TipLoading]) -> list[Verdict]:
    """What the case's criterion says of each of some sites in bodies that have a strength."""
    alike: dict[tuple[int, bool], list[int]] = {}
    for number, site in enumerate(sites):
        alike.setdefault((site.body, site.kind == "tip"), []).append(number)
    found: dict[int, Verdict] = {}
    for (body, at_tip), numbers in alike.items():
        growth, strength = scene.growing_in(body)
        criterion = CRITERIA[growth.criterion]
        evaluate = criterion.at_tips if at_tip else criterion.at_starts
        found.update(zip(numbers, evaluate([loadings[number] for number in numbers], strength), strict=True))
        for number in numbers:
            if at_tip and sites[number].in_shear:
                # started in shear it goes on so where that law is met, or sooner: beyond both it would turn to and fro
                criticality, shears = found[number].criticality, shear_growth(loadings[number], strength)
                if shears.criticality >= min(criticality, 1.0 - AT_STRENGTH):
                    found[number] = replace(shears, criticality=max(shears.criticality, criticality))
    return [found[number] for number in range(len(sites))]


def _tractions(state: LoadState, surface: int) -> FaceTraction:
    """All that acts between the faces of a crack or an interface."""
    scene, cover, outcome = state.scene, state.cover, state.outcome
    faces, law = state.configuration.faces, state.configuration.contact.law
    name = cover.surfaces[surface].name
    pointwise = scene.laws[surface].elastic and scene.case.numerics.contact.discretization == "gauss"
    fluids = [load for load in scene.case.loads if isinstance(load, FluidPressure) and load.fills(name)]
    loads, factor = enumerate(scene.case.loads), state.factor
    volumes = [number for number, load in loads if isinstance(load, FluidVolume) and load.fills(name)]
    injected = sum(volume_pressure(state, number) for number in volumes)

    def traction(s: Floats) -> tuple[Floats, Floats]:
        if pointwise:
            normal, tangential = elastic_tractions(cover, faces, surface, s, law, outcome)
        else:
            points = outcome.points
            normal, tangential = faces.between(surface, s, points.normal, points.tangential)
        if fluids:
            places = cover.lattice.to_metres(points_at(cover, surface, s).points)
            normal = normal - sum(component_at(load.pressure, places) * scene.share(load, factor) for load in fluids)
        return normal - injected, tangential

    return traction
