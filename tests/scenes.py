"""Scenes as documents of a case: specimens and plates with flaws, for tests and benchmarks; short runs of them."""

from __future__ import annotations

import csv
import json
from collections.abc import Generator, Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from PIL import Image

from crackgrow.case import Case, load_case
from crackgrow.errors import CaseError, Fault, SolveError
from crackgrow.results.writer import RunWriter
from crackgrow.run.loop import for_each, grow
from crackgrow.run.result import RunEnd, StepResult
from tests.verification.solutions import CASES, case_of

MPA = 1e6


def shipped_case(name: str, settings: Iterable[str] = ()) -> Case:
    return load_case(CASES / f"{name}.yaml", list(settings))


def shipped(name: str) -> dict[str, Any]:
    """A shipped scene for one static solve."""
    scene: dict[str, Any] = yaml.safe_load((CASES / f"{name}.yaml").read_text().replace(" on:", " 'on':").replace(
        "{on:", "{'on':"))  # fmt: skip
    return {key: value for key, value in scene.items() if key not in ("growth", "loading")}


def plate(points: list[list[float]], size: float, axial: float, lateral: float, friction: float) -> dict[str, Any]:
    """A square plate under compression (MPa) with one flaw (mm), loaded by tractions."""
    edges = {"left": [lateral, 0], "right": [-lateral, 0], "top": [0, -axial], "bottom": [0, axial]}
    shape, corner = {"rectangle": {"center": [0, 0], "width": size, "height": size}}, 0.5 * size
    return {
        "title": "a closed flaw with wings",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {"rock": {"shape": shape, "material": {"young": 20000, "poisson": 0.25}}},
        "cracks": {"flaw": {"path": {"points": points}, "contact": {"friction": friction, "cohesion": 0}}},
        "supports": [
            {"at": [-corner, -corner], "displacement": {"x": 0, "y": 0}},
            {"at": [corner, -corner], "displacement": {"y": 0}},
        ],
        "loads": [{"on": {"body": "rock", "edge": edge}, "traction": force} for edge, force in edges.items()],
        "numerics": {"spacing": 1},
    }


def specimen(
    cracks: dict[str, Any], size: tuple[float, float] = (31.0, 55.0), sigma: float = 1.0, **more: Any
) -> dict[str, Any]:
    """A plate (mm) that is pulled along y (MPa), held where it takes no force, of rock in which cracks may grow."""
    x, y = 0.5 * size[0], 0.5 * size[1]
    rock = {
        "shape": {"rectangle": {"center": [0, 0], "width": size[0], "height": size[1]}},
        "material": {"young": 10000, "poisson": 0.25},
        "strength": {"tension": 0.5, "cohesion": 10, "friction_angle": 40},
    }
    pulled = {"top": sigma, "bottom": -sigma}
    return {
        "title": "plate",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {"rock": rock},
        "cracks": cracks,
        "supports": [
            {"at": [-x, -y], "displacement": {"y": 0}},
            {"at": [x, -y], "displacement": {"y": 0}},
            {"at": [0, -y], "displacement": {"x": 0}},
        ],
        "loads": [{"on": {"body": "rock", "edge": edge}, "traction": [0, t]} for edge, t in pulled.items()],
        "output": {"frames": "none", "figures": False},
        **more,
    }


def winged(half: float, angle: float, wing: float, turn: float) -> list[list[float]]:
    """Vertices of a flaw with straight wings, symmetric by point reflection; degrees."""
    inner = half * np.exp(1j * np.deg2rad(angle))
    outer = inner + wing * np.exp(1j * np.deg2rad(angle + turn))
    return [[float(z.real), float(z.imag)] for z in (-outer, -inner, inner, outer)]


def faults_of(file: Path, *settings: str) -> tuple[Fault, ...]:
    with pytest.raises(CaseError) as caught:
        load_case(file, settings)
    return caught.value.faults


def fault_of(file: Path, *settings: str) -> Fault:
    """The only fault of a case file with settings."""
    (fault,) = faults_of(file, *settings)
    return fault


def told(warnings: Iterable[str]) -> list[str]:
    """Warnings but the one that cells by hand have no error."""
    return [text for text in warnings if "no error is measured" not in text]


SPACINGS = {
    "brazilian_disk": 2.5, "compression30": 1.5, "compression45": 1.5, "compression60": 1.5, "confined30": 2,
    "cyclic_friction": 2.5, "edge_tension": 1.2, "en_echelon": 2, "flaw_and_hole": 1.5, "junction_static": 1.5,
    "slant_tension": 1, "tension0": 1.5, "two_flaws": 2, "two_flaws_overlapping": 2,
}  # fmt: skip
"""Spacings of one size, in the unit of the case, for scenes whose own cells follow from their accuracy."""


def one_size(scene: str) -> tuple[str, ...]:
    """The setting that gives a shipped scene cells of one size; none where it has them anyway."""
    return (f"numerics.spacing={SPACINGS[scene]}",) if scene in SPACINGS else ()


STARTS = (
    "growth.increment=2",
    "growth.advance=all",
    "cracks.flaw.contact.friction=0.3",
    "bodies.rock.strength.cohesion=0.6",
)
"""So that cracks start in shear at the flaw of `compression30`."""


# A plate under tension whose edge cracks grow below their toughness.

STRENGTH = "{tension: 5, cohesion: 20, friction_angle: 40, toughness: 0.5 MPa sqrt(m)}"
GROWTH = "steps: 4, increment: 1, advance: all, criterion: max_hoop_stress, direction: explicit"
LAW = "law: subcritical, subcritical: {velocity: 10 mm/s, exponent: 10}"
CYCLES = (
    "growth={steps: 4, increment: 1, advance: all, criterion: max_hoop_stress, direction: explicit, law: fatigue,"
    " fatigue: {rate: 1e-6 mm, at: 1 MPa sqrt(m), exponent: 3}}",
    "loading={history: [-0.5, 0.25, 1]}",
)
SHORTER = "cracks.shorter={path: {points: [[-15, 40], [-11, 40]]}, tips: end, contact: none}"  # than the notch, 6 mm
SLOWLY = (f"bodies.rock.strength={STRENGTH}", f"growth={{{GROWTH}, {LAW}}}", "numerics.spacing=3")


def slow_cracks(*settings: str) -> Case:
    """The plate with the edge crack `notch`, of 6 mm, at 0.39 of its toughness."""
    return shipped_case("edge_tension", [*SLOWLY, "output.frames=none", "output.figures=false", *settings])


ROCK_TOUGHNESS = 1e12 / (20e9 / (1.0 - 0.25**2))
"""J/m^2, G_c of the rock."""


AT_BOND = """
title: a crack that ends on the bond of two equal bodies
units: {length: mm, stress: MPa}
plane: strain
materials: {rock: {young: 20 GPa, poisson: 0.25}}
bodies:
  left:
    shape: {polygon: [[-200, -200], [0, -200], [0, 200], [-200, 200]]}
    material: rock
    strength: &strength {tension: 5, cohesion: 20, friction_angle: 40, toughness: 1 MPa sqrt(m)}
  right: {shape: {polygon: [[0, -200], [200, -200], [200, 200], [0, 200]]}, material: rock, strength: *strength}
cracks: {flaw: {path: [[-40, 0], [0, 0]], contact: none, tips: none}}
interfaces: [{between: [left, right], contact: {friction: 0, cohesion: 0}, toughness: 10 J/m^2}]
supports: minimal
loads: [{far_field: [1, 1, 0]}]
loading: critical
growth: {steps: 2, increment: 1, criterion: max_hoop_stress}
numerics: {accuracy: standard}
"""


def crack_at_bond(*settings: str) -> Case:
    """It grows at its end alone, by an increment of a 20th of its half length of 20 mm, at its critical load."""
    return case_of(AT_BOND, *settings)


COARSE = ("numerics.spacing=4", "growth.steps=3", "output.frames=none", "output.figures=false")
HOSTILE = '<script>document.title = "owned"</script> & "quotes" </title>'


def make_run(folder: Path, overrides: Sequence[str] = (), failing: str = "", case: str = "compression30") -> Path:
    """Run a coarse scene into a folder; with `failing`, break it off for this reason after its second step."""
    scene = shipped_case(case, [*COARSE, *overrides])
    writer = RunWriter(scene, folder)
    writer.begin()
    try:
        writer.finish(for_each(broken_off(grow(scene), failing) if failing else grow(scene), writer.add))
    except SolveError as error:
        writer.break_off(error)
    return folder


def rows_of(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def summary_of(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return found


def broken_off(steps: Generator[StepResult, None, RunEnd], reason: str) -> Generator[StepResult, None, RunEnd]:
    """The first two steps, then the failure."""
    yield from islice(steps, 2)
    raise SolveError(reason)


def paint(folder: Path, steps: Sequence[int], size: tuple[int, int] = (60, 90)) -> None:
    """Pictures as `crackgrow render` leaves them, a shade of grey for each step."""
    (folder / "render" / "sigma_1").mkdir(parents=True)
    for step in steps:
        Image.new("RGB", size, (40 * step % 256,) * 3).save(folder / "render" / "sigma_1" / f"step_{step:04d}.png")
