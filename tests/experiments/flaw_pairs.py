"""Pairs of flaws in compression after Wong, Chau (1998): how they coalesce, at one set of values for all bridge angles.

    python -m tests.experiments.flaw_pairs [--seconds S] [--angles A ...] [--frictions F ...]

Goes on with every pair for S seconds at most, from where outputs/experiments/flaw_pairs has it, and writes
flaw_pairs.md and flaw_pairs.png beside this file. The load rises by STEP as soon as nothing grows any more.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.run import grow
from crackgrow.run.result import Checkpoint, CrackPath, Event, StepResult

HERE = Path(__file__).parent
KEPT = HERE.parents[1] / "outputs" / "experiments" / "flaw_pairs"
FLAW, BRIDGE = 12.0, 20.0  # mm: length of a flaw, distance of the inner tips
WIDTH, HEIGHT = 60.0, 120.0  # mm
FIRST, STEP, LAST = 1.3, 0.1, 2.5  # MPa: the first load, by how much it rises, the last
MEASURED = {45: "S", 60: "S or M", 75: "M", 90: "M or W", 105: "W", 120: "W"}
FRICTIONS = (0.6, 0.7)
UNFINISHED = "not yet"

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
  increment: 2
  advance: all
  criterion: max_hoop_stress
  initiation: {{at: cracks}}
  link_distance: 1
numerics: {{accuracy: draft, spacing: auto}}
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
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flaw_pair.yaml"
        path.write_text(text, encoding="utf-8")
        return load_case(path)


HEAD = """# Pairs of flaws

Made by `python -m tests.experiments.flaw_pairs`. Two closed flaws of 12 mm at 45 degrees, their inner tips 20 mm apart
in a direction at the bridge angle to x, in a specimen of 60 x 120 mm, as in the tests of Wong and Chau (1998) on a
rock-like material. One set of values for all pairs, that of the tests: E 0.33 GPa, Poisson's ratio 0.19, tension
0.35 MPa, K_Ic 0.0443 MPa sqrt(m), and of the compressive strength of 2.09 MPa cohesion 0.58 MPa at 32 degrees.
`max_hoop_stress`, `initiation: {at: cracks}`, increments and `link_distance` of 2 and 1 mm, automatic cells (`draft`).
The load rises by 0.1 MPa where nothing grows any more; loads are in MPa.

S: shear cracks link the flaws, W: wings do, M: both have part in it. In the picture black flaws, blue wings, red cracks
that have started in shear. The modes of the tests are as they are quoted, not read from the paper. `not yet`: broken
off before anything linked; the script goes on with it. What wings do alone is in [wings_alone.md](wings_alone.md).

"""


@dataclass(frozen=True, slots=True)
class Moment:
    """What has grown by a step."""

    load: float  # MPa
    result: StepResult | None  # None: the last advance could not be solved any more
    events: tuple[Event, ...]
    cracks: tuple[CrackPath, ...]
    why: str = ""  # it could not be solved


def rising(case_at: Callable[[float], Case], load: float, kept: Checkpoint | None) -> Iterator[Moment]:
    """The steps under loads that rise where nothing grows any more. Every step starts from the unloaded state.

    With a checkpoint the first of them is the one that it was made of.
    """
    while load <= LAST + 0.5 * STEP:
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


class Pair:
    """What is told of a pair while it grows."""

    def __init__(self, known: dict[str, Any]) -> None:
        self.modes: dict[str, list[str]] = known.get("modes", {"lower": [], "upper": []})  # of segments, crack by crack
        self.parent: dict[str, str] = known.get("parent", {})
        self.first: dict[str, float] = known.get("first", {})  # load at which growth began, by mode
        self.linked = ""

    def see(self, moment: Moment) -> None:
        """Take over what a step tells."""
        for event in moment.events:
            if event.kind == "initiation":
                mode = event.met.partition("(")[2].rstrip(")")
                self.parent[event.crack] = event.met.split("'")[1]
                self.modes[event.crack] = [mode]
                self.first.setdefault(mode, moment.load)
            elif event.kind == "coalescence" and event.met.startswith("crack '"):
                met = event.met.split("'")[1]
                if self.flaw(event.crack) != self.flaw(met):
                    self.linked = self.kind(event.crack, met)
                    return
        for tip in moment.result.tips if moment.result else ():
            if tip.advanced:
                self.modes.setdefault(tip.crack, []).append(tip.criterion)
                self.first.setdefault(tip.criterion, moment.load)

    def flaw(self, crack: str) -> str:
        """The flaw that a crack has come from."""
        while crack in self.parent:
            crack = self.parent[crack]
        return crack

    def kind(self, *cracks: str) -> str:
        """S, W or M: shear, wings or both, of the cracks that link and of new ones that they have started on."""
        modes = set()
        for crack in cracks:
            modes |= set(self.modes[crack])
            while crack in self.parent and self.parent[crack] in self.parent:
                crack = self.parent[crack]
                modes |= set(self.modes[crack])
        return {frozenset({"shear"}): "S", frozenset({"tension"}): "W"}.get(frozenset(modes), "M")


def solved(angle: int, friction: float, seconds: float) -> dict[str, Any]:
    """How a pair coalesces; what is known of it is gone on from."""
    place = KEPT / f"{angle}_{friction}.json"
    known: dict[str, Any] = json.loads(place.read_text(encoding="utf-8")) if place.exists() else {}
    if known.get("mode", UNFINISHED) != UNFINISHED:
        return known
    if known and known["checkpoint"] is None:
        known = {}
    pair, began, end, why = Pair(known), time.monotonic(), "none", ""
    kept = loaded(place, known) if known else None
    again = kept is not None  # the first step is seen twice
    for moment in rising(lambda load: scene(angle, friction, load), known.get("load", FIRST), kept):
        if not again:
            pair.see(moment)
        again, load, cracks = False, moment.load, moment.cracks
        kept = moment.result.checkpoint if moment.result else kept
        if pair.linked or moment.result is None:
            end, why = pair.linked or "not solved any more", moment.why
            break
        if time.monotonic() - began > seconds:
            end = UNFINISHED
            break
    found = {
        "mode": end,
        "load": load,
        "why": why,
        "first": pair.first,
        "seconds": known.get("seconds", 0.0) + time.monotonic() - began,
        "cracks": {path.name: (1e3 * path.points).tolist() for path in cracks},
        "modes": pair.modes,
        "parent": pair.parent,
        "checkpoint": None if kept is None else [kept.step, dict(kept.values)],
    }
    place.parent.mkdir(parents=True, exist_ok=True)
    if kept is not None:
        np.savez(place.with_suffix(".npz"), **dict(kept.arrays))
    place.write_text(json.dumps(found), encoding="utf-8")
    return found


def loaded(place: Path, known: dict[str, Any]) -> Checkpoint | None:
    """The checkpoint that was kept of a pair."""
    if known["checkpoint"] is None:
        return None
    with np.load(place.with_suffix(".npz")) as arrays:
        return Checkpoint(*known["checkpoint"], dict(arrays))


def draw(found: dict[tuple[int, float], dict[str, Any]]) -> Figure:
    """The cracks of every pair when they link, or at the end."""
    figure = Figure(figsize=(1.8 * len(found), 2.8))
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(found), squeeze=False)[0]
    for axes, ((angle, friction), one) in zip(panels, found.items(), strict=True):
        for name, points in one["cracks"].items():
            shear = one["modes"].get(name, [""])[0] == "shear"
            axes.plot(*np.array(points).T, color="tab:red" if shear else "tab:blue", linewidth=1.0)
        for points in flaws(angle):
            axes.plot(*np.array(points).T, color="black", linewidth=2.0)
        axes.set(xlim=(0.0, WIDTH), ylim=(20.0, 100.0), aspect="equal", xticks=[], yticks=[])
        axes.set_title(f"{angle} deg, mu {friction}: {one['mode']}", fontsize=6)
    figure.tight_layout()
    return figure


def table(found: dict[tuple[int, float], dict[str, Any]]) -> str:
    """The table in Markdown."""
    head = "| bridge | friction | tests | found | first wing | first shear crack | load at the end |"
    lines = [head, "|---|---|---|---|---|---|---|"]
    for (angle, friction), one in found.items():
        first = [f"{one['first'][mode]:.1f}" if mode in one["first"] else "-" for mode in ("tension", "shear")]
        hit = "" if one["mode"] in (UNFINISHED, *MEASURED[angle].split(" or ")) else " (missed)"
        values = [angle, friction, MEASURED[angle], f"{one['mode']}{hit}", *first, f"{one['load']:.1f}"]
        lines.append(f"| {' | '.join(map(str, values))} |")
    return "\n".join(lines)


def main() -> None:
    """Solve what is missing, and write the table and the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0, help="for each pair")
    parser.add_argument("--angles", type=int, nargs="*", default=list(MEASURED))
    parser.add_argument("--frictions", type=float, nargs="*", default=list(FRICTIONS))
    given = parser.parse_args()
    for friction in given.frictions:
        for angle in given.angles:
            one = solved(angle, friction, given.seconds)
            told = f"{angle} {friction} {one['mode']} {one['first']} {one['load']:.1f} MPa {one['seconds']:.0f} s"
            print(told, flush=True)
    known = {(a, f): KEPT / f"{a}_{f}.json" for f in FRICTIONS for a in MEASURED}
    found = {key: json.loads(place.read_text(encoding="utf-8")) for key, place in known.items() if place.exists()}
    if not found:
        return
    (HERE / "flaw_pairs.md").write_text(HEAD + table(found) + "\n\n![The pairs](flaw_pairs.png)\n", encoding="utf-8")
    draw(found).savefig(HERE / "flaw_pairs.png", dpi=110)


if __name__ == "__main__":
    main()
