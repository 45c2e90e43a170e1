"""The same scene written otherwise: turned, mirrored, in other units, scaled, cracks in another order, reversed, split.

Of a changed case document everything that a run writes is known from what it writes of the first one.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import shapely

from crackgrow.case.units import UNITS
from crackgrow.fracture.advance import TIE
from tests.stability.judge.written import WrittenRun
from tests.stability.random_scenes import Scene

LENGTHS = frozenset({"center", "width", "height", "radius", "polygon", "points", "at", "spacing", "increment"})
STRESSES = frozenset({"young", "tension", "cohesion", "traction", "pressure", "stress"})
PLACES = frozenset({"center", "polygon", "points", "at"})
VECTORS = frozenset({"traction", "gravity"})
QUARTER = np.array([[0, -1], [1, 0]])
MIRROR = np.array([[-1, 0], [0, 1]])
EDGES = {(0, -1): "bottom", (1, 0): "right", (0, 1): "top", (-1, 0): "left"}
NORMALS = {edge: normal for normal, edge in EDGES.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """x -> size turn x for places, stresses times `stress`, in SI units; and how the case says so."""

    name: str
    apply: Callable[[Scene], Scene]
    turn: np.ndarray
    size: float = 1.0
    stress: float = 1.0
    reverses: bool = False


def multiplied(value: Any, length: float, stress: float, key: str = "") -> Any:
    """A document with its lengths and stresses multiplied; displacements are lengths."""
    if isinstance(value, dict):
        inside = "radius" if key == "displacement" else ""
        return {name: multiplied(inner, length, stress, inside or name) for name, inner in value.items()}
    if isinstance(value, list):
        return [multiplied(inner, length, stress, key) for inner in value]
    if isinstance(value, str | bool):
        return value
    return value * (length if key in LENGTHS else stress if key in STRESSES else 1.0)


def in_other_units(scene: Scene) -> Scene:
    """Inches for lengths would round; the next unit does it."""
    length, stress = scene["units"]["length"], scene["units"]["stress"]
    other_length = {"m": "mm", "cm": "m", "mm": "cm"}[length]
    other_stress = {"Pa": "MPa", "kPa": "Pa", "MPa": "GPa"}[stress]
    factors = (
        float(UNITS["length"][length] / UNITS["length"][other_length]),
        float(UNITS["stress"][stress] / UNITS["stress"][other_stress]),
    )
    return {**multiplied(scene, *factors), "units": {"length": other_length, "stress": other_stress}}


def scaled(size: float, stress: float) -> Callable[[Scene], Scene]:
    """A larger specimen of a stiffer, stronger rock under larger loads."""

    def apply(scene: Scene) -> Scene:
        found = multiplied(scene, size, stress)
        for load in found["loads"]:
            if "gravity" in load:
                load["gravity"] = [stress / size * g for g in load["gravity"]]
        return found

    return apply


def turned(turn: np.ndarray) -> Callable[[Scene], Scene]:
    """Turned or mirrored about the origin by a matrix of zeros and ones."""
    return lambda scene: _turned(scene, turn)


def _turned(value: Any, turn: np.ndarray, key: str = "") -> Any:
    if key in PLACES or key in VECTORS:
        return (np.asarray(value) @ turn.T).tolist()
    if key == "stress" and isinstance(value, list):
        xx, yy, xy = value
        found = turn @ np.array([[xx, xy], [xy, yy]]) @ turn.T
        return [float(found[0, 0]), float(found[1, 1]), float(found[0, 1])]
    if key == "displacement":
        parts = [(sign * value[axis], name) for name, (axis, sign) in _components(turn).items() if axis in value]
        return {name: part for part, name in parts}
    if isinstance(value, dict):
        found = {name: _turned(inner, turn, name) for name, inner in value.items()}
        if key == "rectangle" and turn[0, 0] == 0:
            found["width"], found["height"] = found["height"], found["width"]
        if key == "on":
            _turn_edge(found, turn)
        return found
    return [_turned(inner, turn) for inner in value] if isinstance(value, list) else value


def _components(turn: np.ndarray) -> dict[str, tuple[str, int]]:
    """Which component, with which sign, becomes x and which y."""
    return {name: ("xy"[int(np.flatnonzero(row)[0])], int(row.sum())) for name, row in zip("xy", turn, strict=True)}


def _turn_edge(on: Scene, turn: np.ndarray) -> None:
    """The name of an edge; whole edges of rectangles, or parts of arcs."""
    if on["edge"] == "arc":
        ends = [90.0 + on["from"], 90.0 + on["to"]] if turn[0, 0] == 0 else [180.0 - on["to"], 180.0 - on["from"]]
        on["from"], on["to"] = ends
    elif on["edge"] in NORMALS:
        x, y = turn @ np.array(NORMALS[on["edge"]])
        on["edge"] = EDGES[int(x), int(y)]


def in_another_order(scene: Scene) -> Scene:
    """Cracks, loads and supports the other way round."""
    found = copy.deepcopy(scene)
    found["cracks"] = dict(reversed(found["cracks"].items()))
    found["loads"].reverse()
    found["supports"].reverse()
    return found


def reversed_cracks(scene: Scene) -> Scene:
    """Start and end of every crack exchanged."""
    found = copy.deepcopy(scene)
    for crack in found["cracks"].values():
        crack["path"]["points"].reverse()
        crack["tips"] = {"start": "end", "end": "start"}.get(crack["tips"], crack["tips"])
    return found


def with_more_vertices(scene: Scene) -> Scene:
    """The first segment of every crack in two."""
    found = copy.deepcopy(scene)
    for crack in found["cracks"].values():
        first, second, *others = crack["path"]["points"]
        crack["path"]["points"] = [
            first,
            [0.45 * a + 0.55 * b for a, b in zip(first, second, strict=True)],
            second,
            *others,
        ]
    return found


TOLERANCE = 1e-6
"""Of K, of increments, of load factors."""

NO_K = 1e-3
"""Of the stress at tips times the root of a spacing: smaller K are those of cracks that stick, and round-off."""

AS_IT_IS = np.eye(2)
CHANGES = (
    Change("turned by 90 degrees", turned(QUARTER), QUARTER),
    Change("mirrored", turned(MIRROR), MIRROR),
    Change("other units", in_other_units, AS_IT_IS),
    Change("scaled", scaled(37.0, 5.0), AS_IT_IS, 37.0, 5.0),
    Change("another order", in_another_order, AS_IT_IS),
    Change("reversed", reversed_cracks, AS_IT_IS, reverses=True),
    Change("a vertex more", with_more_vertices, AS_IT_IS),
)


@dataclass(frozen=True, slots=True)
class Deviations:
    """What a changed scene gave otherwise, relative; nan where there is nothing to compare."""

    K_first: float  # of the largest K of the run, at step 0
    K: float  # at any step
    path: float  # of the increment, or of a spacing where nothing grows
    factor: float  # of the load factor
    ended: str  # how each run ended, if not alike

    @property
    def largest(self) -> float:
        """Infinite where a run ended otherwise."""
        return np.inf if self.ended else float(np.nanmax([self.K, self.path, self.factor, 0.0]))


def deviations(first: WrittenRun, other: WrittenRun, change: Change) -> Deviations:
    """What the changed run has otherwise than the first one.

    Of tips that are equally critical but for what a lattice resolves the leftmost grows. Which that is depends on how
    the scene is turned: where such tips grow otherwise the runs are compared up to that step.
    """
    ends = [(run.exit_code, run.summary.get("status"), run.summary.get("steps_done")) for run in (first, other)]
    ended = "" if ends[0] == ends[1] else f"{ends[0]}, {ends[1]}"
    if any(run.exit_code not in (0, 3) or "tips" not in run.tables for run in (first, other)):
        return Deviations(np.nan, np.nan, np.nan, np.nan, ended)
    last = _tied_at(first, other, change)
    if last is not None:
        first, other, ended = _up_to(first, last), _up_to(other, last), ""
    K = _K_deviation(first, other, change)
    steps = [run.tables["steps"].set_index("step")["load_factor"] for run in (first, other)]
    both = steps[0].index.intersection(steps[1].index)
    if not len(both) or first.tables["tips"].empty:
        return Deviations(np.nan, np.nan, np.nan, np.nan, ended)
    sizes = np.maximum(np.abs(steps[0][both]), 1e-300)
    factor = float((np.abs(steps[0][both] - steps[1][both]) / sizes).max())
    return Deviations(
        float(K[K.index == 0].max()), float(K.max()), _path_deviation(first, other, change), factor, ended
    )


def _tied_at(first: WrittenRun, other: WrittenRun, change: Change) -> int | None:
    """The step in which the runs first let other tips grow, if these are equally critical in both; else None."""
    tips = [run.tables["tips"].copy() for run in (first, other)]
    if change.reverses:
        tips[1]["tip"] = tips[1]["tip"].map({"start": "end", "end": "start"})
    both = tips[0].merge(tips[1], on=["step", "crack", "tip"], suffixes=("", "_other"))
    otherwise = both[both["advanced"] != both["advanced_other"]]
    if otherwise.empty:
        return None
    step = int(otherwise["step"].min())
    tied = otherwise.loc[otherwise["step"] == step, ["criticality", "criticality_other"]].to_numpy(dtype=float)
    return step if bool(np.all(tied.min(axis=0) >= (1.0 - TIE) * tied.max(axis=0))) else None


def _up_to(run: WrittenRun, step: int) -> WrittenRun:
    """What a run has written of a step and those before, and of its cracks before they grew in it."""
    tables = {name: table[table["step"] <= step] for name, table in run.tables.items() if "step" in table}
    return replace(run, tables={**run.tables, **tables})


def _K_deviation(first: WrittenRun, other: WrittenRun, change: Change) -> pd.Series:
    """By step, of the largest K of the first run."""
    tables = [run.tables["tips"].copy() for run in (first, other)]
    stress = float(np.nanmax(np.abs(tables[0][["sigma_1", "sigma_3"]].to_numpy(dtype=float)), initial=0.0))
    size = float(np.nanmax(np.abs(tables[0][["K_I", "K_II"]].to_numpy(dtype=float)), initial=0.0))
    size = max(size, NO_K * stress * np.sqrt(first.spacing))
    by = change.stress * np.sqrt(change.size)
    tables[1]["K_I"] /= by
    tables[1]["K_II"] /= by * np.linalg.det(change.turn)
    if change.reverses:
        tables[1]["tip"] = tables[1]["tip"].map({"start": "end", "end": "start"})
    joint = tables[0].merge(tables[1], on=["step", "crack", "tip"], suffixes=("", "_other"))
    off = np.maximum(np.abs(joint["K_I"] - joint["K_I_other"]), np.abs(joint["K_II"] - joint["K_II_other"]))
    return (off / size if size > 0.0 else off).groupby(joint["step"]).max()


def _path_deviation(first: WrittenRun, other: WrittenRun, change: Change) -> float:
    """Of the increment."""
    scale = first.growth["increment"] if first.growth else first.spacing
    worst = 0.0
    for name in first.case["cracks"]:
        (here, _), (there, _) = first.path(name, 10**9), other.path(name, 10**9)
        back = there @ np.asarray(change.turn, dtype=float) / change.size
        back = back[::-1] if change.reverses else back
        if len(here) == len(back):
            worst = max(worst, float(np.hypot(*(here - back).T).max()))
        else:
            worst = max(worst, shapely.hausdorff_distance(shapely.LineString(here), shapely.LineString(back)))
    return worst / scale
