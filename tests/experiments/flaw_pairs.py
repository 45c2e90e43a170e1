"""Pairs of flaws in compression after Wong, Chau (1998): how they coalesce, at one set of values for all bridge angles.

    python -m tests.experiments.flaw_pairs [--angles A ...] [--frictions F ...]

Solves the pairs that outputs/experiments/flaw_pairs does not have (some minutes each), and renews the table of
flaw_pairs.md and flaw_pairs.png beside this file. The load rises by STEP as soon as nothing grows any more, up to the
strength of the rock, or until the flaws are linked.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from crackgrow.case.model import Case
from crackgrow.run import grow
from crackgrow.run.result import Checkpoint, CrackPath, Event, StepResult
from tests.benchmarks.tables import renew_table, table

HERE = Path(__file__).parent
KEPT = HERE.parents[1] / "outputs" / "experiments" / "flaw_pairs"
FLAW, BRIDGE = 12.0, 20.0  # mm: length of a flaw, distance of the inner tips
WIDTH, HEIGHT = 60.0, 120.0  # mm
FIRST, STEP = 1.3, 0.05  # MPa: the first load, and by how much it rises
STRENGTH = 2.09  # MPa: what the rock bears in compression
JOINED = 1e-6  # m: ends of cracks that lie so close to another one are on it
MEASURED = {45: "S", 60: "S or M", 75: "M", 90: "M or W", 105: "W", 120: "W"}
FRICTIONS = (0.6, 0.7)

SCENE = """
title: Two flaws at 45 degrees, bridge at {angle} degrees
source: "Wong, Chau 1998, International Journal of Rock Mechanics and Mining Sciences 35, 147-164"
units: {{length: mm, stress: MPa}}
plane: strain
bodies:
  rock:
    shape: {{rectangle: {{center: [30, 60], width: 60, height: 120}}}}
    material: {{young: 330, poisson: 0.19}}
    strength: {{tension: 0.35, cohesion: 0.58, friction_angle: 32, toughness: 0.0443 MPa sqrt(m)}}
cracks:
  lower: {{path: {{points: {lower}}}, contact: {{friction: {friction}, cohesion: 0}}}}
  upper: {{path: {{points: {upper}}}, contact: {{friction: {friction}, cohesion: 0}}}}
supports:
  - {{at: [0, 0], displacement: {{y: 0}}}}
  - {{at: [60, 0], displacement: {{y: 0}}}}
  - {{at: [30, 0], displacement: {{x: 0}}}}
loads:
  - {{on: {{body: rock, edge: top}}, traction: [0, {down}]}}
  - {{on: {{body: rock, edge: bottom}}, traction: [0, {up}]}}
growth:
  steps: 200
  increment: 3
  advance: all
  criterion: max_hoop_stress
  initiation: ends
  link_distance: 1.5
numerics: {{accuracy: draft}}
output: {{figures: false, frames: none}}
"""


def flaws(angle: float) -> tuple[list[list[float]], list[list[float]]]:
    """Ends (mm) of the lower and the upper flaw; the bridge between their inner tips is at an angle (degrees) to x."""
    along = FLAW * np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])
    half = 0.5 * BRIDGE * np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    middle = 0.5 * np.array([WIDTH, HEIGHT])
    lower, upper = middle - half, middle + half
    return np.round([lower - along, lower], 6).tolist(), np.round([upper, upper + along], 6).tolist()


def scene(angle: float, friction: float, load: float) -> Case:
    """The case of a pair under a load (MPa)."""
    lower, upper = flaws(angle)
    text = SCENE.format(angle=angle, friction=friction, lower=lower, upper=upper, down=-load, up=load)
    return Case.from_dict(yaml.safe_load(text), "flaw_pair")


Piece = tuple[str, str, int]
"""What a segment was made by: its crack, the end that advanced (`start` or `end`), and the step."""


@dataclass(frozen=True, slots=True)
class Moment:
    """What has grown by a step."""

    load: float  # MPa
    result: StepResult | None  # None: the last advance could not be solved any more
    events: tuple[Event, ...]
    cracks: tuple[CrackPath, ...]
    why: str = ""  # it could not be solved


def rising(case_at: Callable[[float], Case], load: float) -> Iterator[Moment]:
    """The steps under loads that rise where nothing grows any more. Every step starts from the unloaded state.

    A step is told of again at every load that it is solved for.
    """
    kept: Checkpoint | None = None
    while load <= STRENGTH:
        steps = grow(case_at(load), kept)
        while True:
            try:
                result = next(steps)
            except StopIteration as stop:
                if stop.value.status != "arrested":
                    yield Moment(load, None, stop.value.events, stop.value.cracks, stop.value.reason)
                    return
                break
            kept = result.checkpoint
            yield Moment(load, result, result.events, result.cracks)
        load = round(load + STEP, 6)


class Growth:
    """What is told of a pair while it grows."""

    def __init__(self) -> None:
        self.made: dict[Piece, str] = {}  # `tension` or `shear`
        self.first: dict[str, float] = {}  # MPa, at which growth began, by mode

    def see(self, moment: Moment) -> None:
        """Take over what a step tells."""
        for event in moment.events:
            if event.kind == "initiation":
                self._made((event.crack, "end", event.step), event.met.partition("(")[2].rstrip(")"), moment.load)
        for tip in moment.result.tips if moment.result else ():
            if tip.advanced and moment.result:
                self._made((tip.crack, tip.tip, moment.result.step + 1), tip.criterion, moment.load)

    def _made(self, piece: Piece, mode: str, load: float) -> None:
        self.made[piece] = mode
        self.first.setdefault(mode, load)

    def modes(self, path: CrackPath) -> list[str]:
        """Modes of the segments of a crack; a flaw itself is `given`."""
        found = []
        for before, after in pairwise(path.steps.tolist()):
            tip = "start" if before > after else "end"
            found.append("given" if before == after == 0 else self.made[path.name, tip, max(before, after)])
        return found


def link(paths: Sequence[CrackPath], modes: Mapping[str, list[str]]) -> str:
    """The kind of the shortest way along cracks from one flaw to the other: S, W or M; empty where there is none."""
    numbers: dict[tuple[float, ...], int] = {}
    edges: dict[tuple[int, int], tuple[float, str]] = {}
    for path in paths:
        line = shapely.LineString(path.points)
        ends = [shapely.Point(other.points[k]) for other in paths if other is not path for k in (0, -1)]
        on = [float(line.project(end)) for end in ends if shapely.dwithin(line, end, JOINED)]
        corners = [float(line.project(shapely.Point(point))) for point in path.points]
        for begin, end in pairwise(sorted({*corners, *on})):
            mode = modes[path.name][int(np.searchsorted(corners, 0.5 * (begin + end))) - 1]
            places = [shapely.get_coordinates(line.interpolate(at))[0] for at in (begin, end)]
            i, j = (numbers.setdefault(tuple(np.round(place / JOINED).tolist()), len(numbers)) for place in places)
            if i != j:
                edges[i, j] = ((end - begin) if mode != "given" else 1e-3 * JOINED, mode)
    rows, columns = zip(*edges, strict=True)
    graph = coo_array(([length for length, _ in edges.values()], (rows, columns)), shape=2 * (len(numbers),))
    first, last = (numbers[tuple(np.round(_given(paths, name) / JOINED).tolist())] for name in ("lower", "upper"))
    _, before = dijkstra(graph.tocsr(), directed=False, indices=first, return_predecessors=True)
    seen, at = set(), last
    while at != first and before[at] >= 0:
        seen.add((edges.get((at, before[at])) or edges[before[at], at])[1])
        at = int(before[at])
    if at != first:
        return ""
    return {frozenset({"shear"}): "S", frozenset({"tension"}): "W"}.get(frozenset(seen - {"given"}), "M")


def _given(paths: Sequence[CrackPath], name: str) -> Any:
    """A vertex (2,) m of a flaw."""
    path = next(path for path in paths if path.name == name)
    return path.points[np.argmin(path.steps)]


def solved(angle: int, friction: float) -> dict[str, Any]:
    """How a pair coalesces; taken from its file where it is known."""
    place = KEPT / f"{angle}_{friction}.json"
    if place.exists():
        known: dict[str, Any] = json.loads(place.read_text(encoding="utf-8"))
        return known
    growth, began, kind, why = Growth(), time.monotonic(), "none", ""
    for moment in rising(lambda load: scene(angle, friction, load), FIRST):
        growth.see(moment)
        load, cracks, why = moment.load, moment.cracks, moment.why
        modes = {path.name: growth.modes(path) for path in cracks}
        kind = link(cracks, modes) or "none"
        if kind != "none":
            break
    found = {
        "mode": kind,
        "load": load,
        "why": why,
        "first": growth.first,
        "seconds": time.monotonic() - began,
        "cracks": {path.name: (1e3 * path.points).tolist() for path in cracks},
        "modes": modes,
    }
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(json.dumps(found), encoding="utf-8")
    return found


COLOURS = {"given": "black", "tension": "tab:blue", "shear": "tab:red"}


def draw(found: Mapping[tuple[int, float], dict[str, Any]]) -> Figure:
    """The cracks of every pair when they link, or at the end; a row for each friction."""
    frictions, angles = ([*dict.fromkeys(key[n] for key in found)] for n in (1, 0))
    figure = Figure(figsize=(1.8 * len(angles), 2.8 * len(frictions)))
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(frictions), len(angles), squeeze=False)
    for (angle, friction), one in found.items():
        axes = panels[frictions.index(friction), angles.index(angle)]
        for name, points in one["cracks"].items():
            for ends, mode in zip(pairwise(points), one["modes"][name], strict=True):
                axes.plot(*np.array(ends).T, color=COLOURS[mode], linewidth=2.0 if mode == "given" else 1.0)
        axes.set_title(f"{angle} deg, mu {friction}: {one['mode']}", fontsize=7)
    for axes in panels.flat:
        axes.set(xlim=(0.0, WIDTH), ylim=(15.0, 105.0), aspect="equal", xticks=[], yticks=[])
    figure.tight_layout()
    return figure


def lines(found: Mapping[tuple[int, float], dict[str, Any]]) -> Iterator[tuple[str, ...]]:
    """The rows of the table."""
    for (angle, friction), one in found.items():
        loads = [f"{one['first'][mode]:.2f}" if mode in one["first"] else "-" for mode in ("tension", "shear")]
        known = MEASURED[angle] if friction == FRICTIONS[0] else "-"
        hit = "" if one["mode"] in known.split(" or ") or known == "-" else " (missed)"
        at = "-" if one["mode"] == "none" else f"{one['load']:.2f}"
        yield str(angle), str(friction), known, f"{one['mode']}{hit}", *loads, at


def main() -> None:
    """Solve what is missing, and write the table and the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--angles", type=int, nargs="*", default=list(MEASURED))
    parser.add_argument("--frictions", type=float, nargs="*", default=list(FRICTIONS))
    given = parser.parse_args()
    for friction in given.frictions:
        for angle in given.angles:
            one = solved(angle, friction)
            print(
                angle, friction, one["mode"], one["first"], f"{one['load']:.2f} MPa {one['seconds']:.0f} s", flush=True
            )
    keys = [(angle, friction) for friction in FRICTIONS for angle in MEASURED]
    found = {key: solved(*key) for key in keys if (KEPT / f"{key[0]}_{key[1]}.json").exists()}
    head = ("bridge", "friction", "tests", "found", "first wing", "first shear crack", "link")
    renew_table(HERE / "flaw_pairs.md", table(head, lines(found)))
    draw(found).savefig(HERE / "flaw_pairs.png", dpi=110)


if __name__ == "__main__":
    main()
