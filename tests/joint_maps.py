"""Synthetic maps of joints as they are digitised on outcrops, with what such maps have: seeded, in map coordinates.

Sets of joints at some angles, rough, in an outline. Ends abut on other joints exactly, a little short of them or a
little beyond; some joints cross at small angles, some are drawn twice, or in pieces that overlap, or meet themselves.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Point
from shapely.ops import substring

Points = NDArray[np.float64]

SETS = {"J1": 15.0, "J2": 80.0, "J3": 130.0}  # degrees
SPREAD = 6.0  # degrees
SHARES = (0.45, 0.35, 0.2)  # of the sets
ROOM = 2.2  # m^2 of rock for each joint
STEP = 0.4  # m between vertices
ROUGH = 0.012  # m, how far they lie off the line
DIGITS = 6  # of coordinates in m


@dataclass(frozen=True)
class JointMap:
    """A map: an outline and traces with attributes, in m."""

    tolerance: float  # m, how exact it was drawn
    origin: tuple[float, float]  # m, a round place near it
    outline: Points  # (n, 2)
    traces: list[tuple[Points, dict[str, Any]]]  # each (n, 2), with attributes
    defects: dict[str, int]  # how many of each kind were drawn

    def write(self, folder: Path) -> Path:
        """Write joints.geojson and outline.geojson; returns the folder."""
        lines = [_feature("LineString", points.round(DIGITS).tolist(), values) for points, values in self.traces]
        ring = np.vstack([self.outline, self.outline[:1]]).round(DIGITS).tolist()
        for name, features in (("joints", lines), ("outline", [_feature("Polygon", [ring], {})])):
            text = ",\n".join(map(json.dumps, features))
            (folder / f"{name}.geojson").write_text(
                f'{{"type": "FeatureCollection", "features": [\n{text}\n]}}\n', encoding="utf-8"
            )
        return folder


def _feature(kind: str, coordinates: Any, values: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": values}


def joint_map(n: int, seed: int, tolerance: float = 0.02) -> JointMap:
    """A map of about n joints, and some tenth more that should not be there."""
    rng = np.random.default_rng([n, seed])
    half = 0.5 * np.sqrt(ROOM * n)
    outline = _outline(rng, half)
    lines: list[tuple[LineString, str]] = []
    for name, share in zip(SETS, SHARES, strict=True):
        lines += [(_joint(rng, half, SETS[name]), name) for _ in range(round(share * n))]
    drawn, defects = _abutting(rng, lines, tolerance)
    _add_defects(rng, drawn, defects, half, tolerance)
    origin = (float(rng.integers(100, 900) * 1000), float(rng.integers(200, 7000) * 1000))
    here = origin + rng.uniform(0.0, 900.0, 2).round(2)
    order = rng.permutation(len(drawn))
    traces = []
    for number, k in enumerate(order.tolist(), 1):
        points, name = drawn[k]
        values = {"id": number, "set": name, "aperture_mm": round(float(rng.gamma(2.0, 0.4)), 2)}
        traces.append((np.asarray(points) + here, values if rng.random() > 0.02 else {**values, "aperture_mm": None}))
    return JointMap(tolerance, origin, outline + here, traces, defects)


def _outline(rng: np.random.Generator, half: float) -> Points:
    """An outcrop: a ring of 14 corners, not always convex."""
    angles = np.sort(np.linspace(0.0, 2.0 * np.pi, 14, endpoint=False) + rng.uniform(-0.1, 0.1, 14))
    radii = half * rng.uniform(0.85, 1.15, 14)
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles)])


def _joint(rng: np.random.Generator, half: float, angle: float, length: float | None = None) -> LineString:
    """A rough joint of lognormal length; many leave the outline."""
    turned = np.deg2rad(angle + SPREAD * rng.standard_normal())
    length = float(np.clip(rng.lognormal(0.7, 0.5), 0.5, half)) if length is None else length
    s = np.linspace(-0.5, 0.5, max(2, round(length / STEP) + 1)) * length
    off = ROUGH * np.cumsum(rng.standard_normal(len(s))) / np.sqrt(len(s))
    along, across = np.array([np.cos(turned), np.sin(turned)]), np.array([-np.sin(turned), np.cos(turned)])
    return LineString(_place(rng, half) + np.outer(s, along) + np.outer(off, across))


def _place(rng: np.random.Generator, half: float) -> Points:
    """Somewhere in the outline, or a little beyond."""
    radius, angle = half * np.sqrt(rng.random()), rng.uniform(0.0, 2.0 * np.pi)
    return radius * np.array([np.cos(angle), np.sin(angle)])


def _abutting(
    rng: np.random.Generator, lines: list[tuple[LineString, str]], tolerance: float
) -> tuple[list[tuple[Points, str]], dict[str, int]]:
    """The joints, half the ends of which are brought to the next older joint: exactly, or short of it, or beyond."""
    found: list[tuple[Points, str]] = []
    defects = {"exact": 0, "gap": 0, "overshoot": 0}
    older: list[LineString] = []
    for line, name in lines:
        for end in (0, -1):
            hosts = [host for host in older if host.intersects(line)]
            if not hosts or rng.random() < 0.4:
                continue
            at = [line.project(Point(xy)) for host in hosts for xy in shapely.get_coordinates(host.intersection(line))]
            place = min(at) if end == 0 else max(at)
            kind = ("exact", "gap", "overshoot")[rng.integers(3)]
            off = {"exact": 0.0, "gap": -1.0, "overshoot": 1.0}[kind] * rng.uniform(0.05, 0.9) * tolerance
            cut = substring(line, place - off, line.length) if end == 0 else substring(line, 0.0, place + off)
            if cut.geom_type == "LineString" and cut.length > 10.0 * tolerance:
                line = cut
                defects[kind] += 1
        older.append(line)
        found.append((shapely.get_coordinates(line), name))
    return found, defects


def _add_defects(
    rng: np.random.Generator, drawn: list[tuple[Points, str]], defects: dict[str, int], half: float, tolerance: float
) -> None:
    """Draw what digitised maps have that they should not have."""
    n = len(drawn)

    def some(share: float) -> list[tuple[Points, str]]:
        return [drawn[k] for k in rng.choice(n, max(1, round(share * n)), replace=False).tolist()]

    def add(kind: str, points: Points, name: str) -> None:
        drawn.append((points, name))
        defects[kind] = defects.get(kind, 0) + 1

    for points, name in some(0.02):
        add("twice", points.copy(), name)
    for points, name in some(0.02):  # once more, by another hand
        line = LineString(points)
        again = [line.interpolate(s) for s in np.sort(rng.uniform(0.0, line.length, 6))]
        add("again", shapely.get_coordinates(again) + 0.3 * tolerance * rng.uniform(-1.0, 1.0, (6, 2)), name)
    for points, name in some(0.02):  # goes on from a place on the other one
        line = LineString(points)
        begin = rng.uniform(0.5, 0.9) * line.length
        ahead = points[-1] + (points[-1] - points[-2]) / np.hypot(*(points[-1] - points[-2])) * rng.uniform(0.3, 1.5)
        rest = shapely.get_coordinates(substring(line, begin, line.length))
        add("stacked", np.vstack([rest + 0.2 * tolerance * rng.uniform(-1.0, 1.0, rest.shape), ahead]), name)
    for points, name in some(0.02):  # crosses at a small angle
        middle, chord = points.mean(axis=0), points[-1] - points[0]
        turn = np.deg2rad(rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 8.0))
        way = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ chord
        add("small angle", middle + np.outer([-0.4, 0.5], way), name)
    for points, name in some(0.01):
        add("no length", np.repeat(points[:1], 2, axis=0), name)
    for points, name in some(0.01):
        add("stub", np.vstack([points[0], points[0] + 0.4 * tolerance]), name)
    for points, name in some(0.02):
        moved = points + rng.uniform(-0.3, 0.3, 2)
        add("repeated vertices", np.repeat(moved, [2, *rng.integers(1, 3, len(moved))[1:]], axis=0), name)
    for _, name in some(0.01):
        loop = np.array([[-0.8, -0.3], [0.3, 0.25], [0.45, 0.0], [0.3, -0.25], [-0.8, 0.35]])
        add("crosses itself", _place(rng, 0.8 * half) + loop, name)
    for _, name in some(0.01):
        centre, angles = _place(rng, 0.8 * half), np.linspace(0.0, 2.0 * np.pi, 9)
        ring = centre + 0.3 * np.column_stack([np.cos(angles), np.sin(angles)])
        add("ring", np.vstack([ring[:-1], ring[:1]]), name)
    add("outside", np.array([[2.0, 2.0], [2.5, 2.0]]) * half, "J1")


def case_text(map_: JointMap) -> str:
    """A case with the map in the folder of the case."""
    x, y = map_.origin
    return f"""
title: a map of joints
units: {{length: m, stress: MPa, origin: [{x:.0f}, {y:.0f}]}}
plane: strain
laws: {{rough: {{friction: 0.7, cohesion: 0}}, smooth: {{friction: 0.4, cohesion: 0}}}}
bodies: {{rock: {{shape: {{file: outline.geojson}}, material: {{young: 60 GPa, poisson: 0.25}}}}}}
cracks:
  joints:
    path: {{file: joints.geojson, tolerance: {map_.tolerance}}}
    contact: rough
    contact_by: {{set: {{J2: smooth}}}}
supports: minimal
numerics: {{accuracy: draft}}
"""
