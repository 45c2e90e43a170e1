"""A plate with many random flaws: the scene of cases/random_flaws.yaml in a specimen that grows with their number.

`python -m tests.benchmarks.flaw_field` measures runs with more and more flaws and writes the tables of flaw_field.md.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import shapely
import yaml

from crackgrow.case import load_case
from crackgrow.case.model import Case
from crackgrow.linear import ConstrainedSystem
from crackgrow.run.configuration import Configuration
from crackgrow.run.loop import solved_steps
from crackgrow.solid.places import boxes_of_functions
from tests.benchmarks.beside import PHASES
from tests.benchmarks.paths import HERE, ROOT
from tests.benchmarks.tables import number, table, write_part

FLAWS = (25, 50, 100, 200)
STEPS = 10

SIDE_OF_FIFTY = 150.0  # mm
APART = 4.0  # mm, between flaws
FROM_SIDES = 8.0  # mm
SEED = 2017


def field_side(n: int) -> float:
    """Side (mm) of the plate that holds n flaws as densely as fifty lie in the case's, a whole number."""
    return float(round(SIDE_OF_FIFTY * np.sqrt(n / 50.0)))


def field_flaws(n: int) -> list[dict[str, Any]]:
    """Paths of n flaws of 10 to 16 mm, by the recipe of cases/random_flaws.yaml."""
    rng, half_side = np.random.default_rng(SEED), field_side(n) / 2.0

    def draw() -> dict[str, Any]:
        middle = rng.uniform(-half_side, half_side, 2).round(1).tolist()
        length, angle = round(rng.uniform(10.0, 16.0), 1), float(round(rng.uniform(0.0, 180.0)))
        return {"center": middle, "length": length, "angle": angle}

    return kept_apart(draw, n, half_side - FROM_SIDES, APART)


def kept_apart(draw: Callable[[], dict[str, Any]], n: int, reach: float, apart: float) -> list[dict[str, Any]]:
    """n paths of those drawn that lie within `reach` (mm) of the middle, and `apart` (mm) from each other."""
    paths: list[dict[str, Any]] = []
    lines: list[shapely.LineString] = []
    while len(paths) < n:
        path = draw()
        angle = np.deg2rad(path["angle"])
        half = 0.5 * path["length"] * np.array([np.cos(angle), np.sin(angle)])
        line = shapely.LineString([path["center"] - half, path["center"] + half])
        inside = np.abs(shapely.get_coordinates(line)).max() <= reach
        if inside and all(line.distance(other) >= apart for other in lines):
            lines.append(line)
            paths.append(path)
    return paths


def field_case(n: int, steps: int, **numerics: Any) -> Case:
    """A plate with n flaws that grow, the most critical tip first, at the loads at which they just do."""
    side = field_side(n)
    half = side / 2.0
    document = {
        "title": f"{n} random flaws under uniaxial compression",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": side, "height": side}},
                "material": {"young": 10000, "poisson": 0.25},
                "strength": {"tension": 2, "cohesion": 10, "friction_angle": 40},
            }
        },
        "cracks": {
            f"f{k + 1:03d}": {"path": path, "contact": {"friction": 0.3, "cohesion": 0}}
            for k, path in enumerate(field_flaws(n))
        },
        "supports": [
            {"at": [-half, -half], "displacement": {"y": 0}},
            {"at": [half, -half], "displacement": {"y": 0}},
            {"at": [0, -half], "displacement": {"x": 0}},
        ],
        "loads": [
            {"on": {"body": "rock", "edge": "top"}, "traction": [0, -10]},
            {"on": {"body": "rock", "edge": "bottom"}, "traction": [0, 10]},
        ],
        "loading": "critical",
        "growth": {
            "steps": steps,
            "increment": 4,
            "advance": "most_critical",
            "criterion": "directional_strength",
            "tip_stress": {"radius": 2},
        },
        "numerics": numerics or {"accuracy": "draft"},
        "output": {"frames": "none", "figures": False},
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "field.yaml"
        file.write_text(yaml.safe_dump(document))
        return load_case(file)


@dataclass(frozen=True, slots=True)
class Growth:
    """What the steps of a run with n flaws took: CPU seconds, medians of the later ones."""

    flaws: int
    n_dofs: int
    n_contact: int
    steps: int
    first: float
    step: float
    worst: float  # the slowest later step
    total: float
    factorization: float  # one from nothing, of the last configuration
    peak_MB: float  # of the run, without that
    kept: float  # part of the clusters that a step takes over
    read_anew: float  # part of the stresses and integrals of tips that a step reads anew
    seconds: dict[str, float]  # by phase


def measured(n: int, steps: int) -> Growth:
    """A run with n flaws. The wall clock, by which the program times its phases, is the CPU clock meanwhile."""
    taken: list[float] = []
    phases: list[dict[str, float]] = []
    kept: list[float] = []
    anew: list[float] = []
    with mock.patch("time.perf_counter", time.process_time):
        run, start = solved_steps(field_case(n, steps)), time.process_time()
        for result, solution in run:
            taken.append(time.process_time() - start)
            configuration = solution.configuration
            kept.append(1.0 - configuration.stiffness.n_integrated / len(configuration.stiffness.clusters))
            anew.append(configuration.readings.n_made / (len(configuration.cover.tips) + len(configuration.fields)))
            phases.append(result.seconds)
            print(f"{n} flaws, step {result.step}: {taken[-1]:.1f} s", file=sys.stderr, flush=True)
            start = time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return Growth(
        flaws=n,
        n_dofs=result.n_dofs,
        n_contact=configuration.faces.n,
        steps=len(taken) - 1,
        first=taken[0],
        step=float(np.median(taken[1:])),
        worst=max(taken[1:]),
        total=sum(taken),
        factorization=min(factorization(configuration) for _ in range(2)),
        peak_MB=peak,
        kept=float(np.median(kept[1:])),
        read_anew=float(np.median(anew[1:])),
        seconds={phase: float(np.median([one[phase] for one in phases[1:]])) for phase in PHASES},
    )


def in_own_process(n: int, steps: int) -> Growth:
    """The run by a fresh process, whose peak memory is its own."""
    command = [sys.executable, "-m", "tests.benchmarks.flaw_field", str(n), str(steps)]
    return Growth(**json.loads(subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, text=True).stdout))


def text_of(runs: Sequence[Growth]) -> str:
    """The tables."""
    sizes = [run.flaws for run in runs]
    whole = table(
        ("flaws", "unknowns", "contact points", "steps", "first step", "a later one", "the slowest",
         "one factorization", "step / factorization", "peak, MB", "clusters taken over", "tips read anew"),
        [
            (str(run.flaws), str(run.n_dofs), str(run.n_contact), str(run.steps), number(run.first), number(run.step),
             number(run.worst), number(run.factorization), number(run.step / run.factorization), number(run.peak_MB),
             f"{100.0 * run.kept:.0f} %", f"{100.0 * run.read_anew:.0f} %")
            for run in runs
        ],
    )  # fmt: skip
    values = {"step": [run.step for run in runs], "one factorization": [run.factorization for run in runs]}
    values |= {phase: [run.seconds[phase] for run in runs] for phase in PHASES}
    values["peak memory"] = [run.peak_MB for run in runs]
    grown = table(
        ("", *(f"{n} flaws" for n in sizes), "exponent"),
        [(name, *map(number, some), number(exponent(sizes, some))) for name, some in values.items()],
    )
    return f"{whole}\n{grown}"


def factorization(configuration: Configuration) -> float:
    """CPU seconds of factorizing the held stiffness, with nothing known before."""
    stiff, places = configuration.contact.system.stiffness, boxes_of_functions(configuration.cover)
    start = time.process_time()
    ConstrainedSystem(stiff, configuration.held.matrix, places)
    return time.process_time() - start


def exponent(sizes: Sequence[float], values: Sequence[float]) -> float:
    """Slope of log(values) over log(sizes) by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def main() -> None:
    """With a number of flaws and of steps one run, printed as JSON; else all of them, written."""
    if len(sys.argv) > 1:
        print(json.dumps(asdict(measured(int(sys.argv[1]), int(sys.argv[2])))))
        return
    text = text_of([in_own_process(n, STEPS) for n in FLAWS])
    write_part(HERE / "flaw_field.md", "table", text)
    print(text)


if __name__ == "__main__":
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    main()
