"""Tensile cracks of specimens that were tested in laboratories: where their cracks ran, and where they run here.

    python -m tests.experiments.specimens

Renews the table of specimens.md and specimens.png beside this file (four minutes).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
import yaml
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from crackgrow.arrays import Floats
from crackgrow.case.model import Case
from crackgrow.run.result import CrackPath
from tests.benchmarks.tables import renew_table, table
from tests.whole_run import whole_run

HERE = Path(__file__).parent
INCH = 25.4  # mm

COMMON = """
units: {length: mm, stress: MPa}
plane: stress
loading: critical
numerics: {accuracy: draft}
output: {figures: false, frames: none}
"""
PMMA = """
    material: {young: 3000, poisson: 0.35}
    strength: {tension: 70, cohesion: 100, friction_angle: 0, toughness: 1 MPa sqrt(m)}
"""

SLANTED = """
title: Slanted crack in tension
source: "Erdogan, Sih 1963, Journal of Basic Engineering 85, 519-525"
bodies:
  sheet:
    shape: {{rectangle: {{center: [0, 0], width: 229, height: 457}}}}{PMMA}
cracks:
  crack: {{path: {{center: [0, 0], length: 50.8, angle: {angle}}}, contact: none}}
supports: minimal
loads:
  - {{on: {{body: sheet, edge: top}}, traction: [0, 1]}}
  - {{on: {{body: sheet, edge: bottom}}, traction: [0, -1]}}
growth: {{steps: 1, increment: 2, criterion: max_hoop_stress, direction: explicit}}
"""
MEASURED_KINK = {30: 62.4, 40: 55.6, 50: 51.1, 60: 43.1, 70: 30.7, 80: 17.3}
"""Degrees, by the angle between crack and load."""

PASSING = """
title: Two edge cracks that pass each other
source: "Fender, Lechenault, Daniels 2010, Physical Review Letters 105, 125505"
bodies:
  sheet:
    shape: {{rectangle: {{center: [0, 0], width: 200, height: 300}}}}{PMMA}
cracks:
  left: {{path: {{points: [[-100, -{half}], [-{inner}, -{half}]]}}, contact: none, tips: end}}
  right: {{path: {{points: [[100, {half}], [{inner}, {half}]]}}, contact: none, tips: end}}
supports:
  - {{on: {{body: sheet, edge: bottom}}, displacement: {{y: -0.1}}}}
  - {{on: {{body: sheet, edge: top}}, displacement: {{y: 0.1}}}}
  - {{at: [0, -150], displacement: {{x: 0}}}}
growth: {{steps: 80, increment: {increment}, criterion: max_hoop_stress}}
"""

THREE_HOLES = """
title: Beam with three holes
source: "Ingraffea, Grigoriu 1990, Report 90-8, School of Civil Engineering, Cornell University"
bodies:
  beam:
    shape:
      rectangle: {{center: [0, 101.6], width: 508, height: 203.2}}
      holes:
        - disk: {{center: [-101.6, 69.85], radius: 6.35}}
        - disk: {{center: [-101.6, 120.65], radius: 6.35}}
        - disk: {{center: [-101.6, 171.45], radius: 6.35}}{PMMA}
cracks:
  notch: {{path: {{points: [[-{offset}, 0], [-{offset}, {length}]]}}, contact: none, tips: end}}
supports:
  - {{at: [-228.6, 0], displacement: {{x: 0, y: 0}}}}
  - {{at: [228.6, 0], displacement: {{y: 0}}}}
loads: [{{at: [0, 203.2], force: [0, -1 kN/m]}}]
growth: {{steps: 60, increment: 6, criterion: max_hoop_stress}}
"""
HOLES = {"lower": 69.85, "middle": 120.65, "upper": 171.45}  # mm, their centres
MEASURED_HOLE = {(6.0, 1.0): "middle", (6.0, 2.5): "-", (5.0, 1.5): "-", (5.15, 1.5): "-"}
"""The hole that the crack meets, by offset and length of the notch (inch)."""

SHEAR_BEAM = """
title: Four-point shear beam
source: "Arrea, Ingraffea 1982, Report 81-13, Department of Structural Engineering, Cornell University"
bodies:
  beam:
    shape: {rectangle: {center: [661, 153], width: 1322, height: 306}}
    material: {young: 24800, poisson: 0.18}
    strength: {tension: 3, cohesion: 100, friction_angle: 0, toughness: 1.57 MPa sqrt(m)}
cracks:
  notch: {path: {points: [[661, 0], [661, 82]]}, contact: none, tips: end}
supports:
  - {at: [600, 0], displacement: {x: 0, y: 0}}
  - {at: [1119, 0], displacement: {y: 0}}
loads:
  - {at: [203, 306], force: [0, -0.13 kN/mm]}
  - {at: [722, 306], force: [0, -1 kN/mm]}
growth: {steps: 60, increment: 10, criterion: max_hoop_stress}
"""
LOADED = 722.0  # mm: where the larger force acts


@dataclass(frozen=True, slots=True)
class Specimen:
    """A specimen that was tested."""

    name: str
    scene: str  # the case file without what is common
    asked: str  # what is told of the crack
    measured: str  # in the laboratory; `-`: not known to us
    told: Callable[[tuple[CrackPath, ...]], str]


def kink(cracks: tuple[CrackPath, ...]) -> str:
    """Degrees by which the end of the crack turns."""
    old, new = np.diff(_mm(cracks[0])[-3:], axis=0)
    return f"{abs(np.rad2deg(np.arctan2(old[0] * new[1] - old[1] * new[0], old @ new))):.1f}"


def slenderness(cracks: tuple[CrackPath, ...]) -> str:
    """Distance of the tips over the largest width across it of what lies between the two cracks."""
    left, right = (_mm(crack) for crack in cracks)
    along = left[-1] - right[-1]
    length = float(np.hypot(*along))
    across = np.array([-along[1], along[0]]) / length
    return f"{length / float(np.ptp(np.concatenate([left, right])[_between(left, right)] @ across)):.2f}"


def _between(left: Floats, right: Floats) -> Floats:
    """Which vertices lie beside both cracks."""
    x = np.concatenate([left, right])[:, 0]
    return np.asarray((x > right[-1, 0]) & (x < left[-1, 0]))


def hole(cracks: tuple[CrackPath, ...]) -> str:
    """The hole that the crack ends at."""
    end = _mm(cracks[0])[-1]
    name, centre = min(HOLES.items(), key=lambda hole: abs(hole[1] - end[1]))
    return name if np.hypot(end[0] + 101.6, end[1] - centre) < 6.35 + 1e-3 else "none"


def side(cracks: tuple[CrackPath, ...]) -> str:
    """Where the crack leaves the beam."""
    x, y = _mm(cracks[0])[-1]
    return f"{x - LOADED:.0f} mm beyond the force" if y > 305.9 else "not at the top"


SPECIMENS = [
    *(
        Specimen(
            f"slanted crack, {angle} degrees to the load",
            SLANTED.format(PMMA=PMMA, angle=90 - angle),
            "kink, degrees",
            str(measured),
            kink,
        )
        for angle, measured in MEASURED_KINK.items()
    ),
    *(
        Specimen(
            f"passing cracks, {2 * half:g} mm apart",
            PASSING.format(PMMA=PMMA, half=half, inner=inner, increment=increment),
            "length over width of the lens",
            "2",
            slenderness,
        )
        for half, inner, increment in ((2.5, 30, 1), (5, 40, 2))
    ),
    *(
        Specimen(
            f"three holes, notch of {length:g} at {offset:g} inch",
            THREE_HOLES.format(PMMA=PMMA, offset=offset * INCH, length=length * INCH),
            "hole that the crack meets",
            measured,
            hole,
        )
        for (offset, length), measured in MEASURED_HOLE.items()
    ),
    Specimen("four-point shear beam", SHEAR_BEAM, "end of the crack", "beyond the force", side),
]


def case_of(specimen: Specimen) -> Case:
    """Its case."""
    return Case.from_dict(yaml.safe_load(specimen.scene + COMMON), "specimen")


def _mm(crack: CrackPath) -> Floats:
    return np.asarray(1e3 * crack.points)


def draw(found: dict[str, tuple[CrackPath, ...]]) -> Figure:
    """Outlines and cracks of the specimens that are cut or meet a hole."""
    shown = [one for one in SPECIMENS if not one.name.startswith("slanted")]
    figure = Figure(figsize=(12, 6))
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 4).ravel()
    for axes, one in zip(panels, shown, strict=False):
        for ring in case_of(one).bodies[0].rings:
            axes.plot(*np.vstack([1e3 * ring.points, 1e3 * ring.points[:1]]).T, color="grey", linewidth=0.8)
        for crack in found[one.name]:
            axes.plot(*_mm(crack).T, color="tab:red", linewidth=1.0)
            given = _mm(crack)[crack.steps == 0]
            axes.plot(*given.T, color="black", linewidth=1.5)
        lines = shapely.MultiLineString([_mm(crack) for crack in found[one.name]])
        x0, y0, x1, y1 = lines.buffer(0.2 * lines.length).bounds
        axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xticks=[], yticks=[])
        axes.set_title(one.name, fontsize=7)
    for axes in panels[len(shown) :]:
        axes.set_axis_off()
    figure.tight_layout()
    return figure


def main() -> None:
    """Solve all specimens, and write the table and the picture."""
    found, lines = {}, []
    for one in SPECIMENS:
        found[one.name] = whole_run(case_of(one))[1].cracks
        lines.append((one.name, one.asked, one.measured, one.told(found[one.name])))
        print(*lines[-1], flush=True)
    renew_table(HERE / "specimens.md", table(("specimen", "what", "measured", "found"), lines))
    draw(found).savefig(HERE / "specimens.png", dpi=90)


if __name__ == "__main__":
    main()
