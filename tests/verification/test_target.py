"""K on cells that a run chooses, for a target of its error or by a name: it is within the target, and the bound holds.

Of all scenes of tests/benchmarks/errors.md these are the quick ones.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.accuracy.companion import BOUND
from crackgrow.case import Case, load_case
from crackgrow.run import grow
from crackgrow.run.caution import Cause
from crackgrow.run.loading import load
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from tests.benchmarks.errors import wings
from tests.benchmarks.target_scenes import SCENES as TABLE
from tests.benchmarks.target_scenes import Known
from tests.scenes import MPA, plate


def row_of_cracks() -> Known:
    """One of a row of collinear cracks between rollers: sqrt(2 b / (pi a) tan(pi a / (2 b))) sigma sqrt(pi a)."""
    half, width, height = 12.0, 40.0, 160.0
    scene = plate([[-half, 0.0], [half, 0.0]], width, -10.0, 0.0, 0.0)
    scene["bodies"]["rock"]["shape"]["rectangle"].update(width=width, height=height)
    scene["supports"] = [{"on": {"edge": edge}, "displacement": {"x": 0.0}} for edge in ("left", "right")]
    scene["supports"].append({"at": [-width / 2, -height / 2], "displacement": {"y": 0.0}})
    scene["loads"] = [{"on": {"edge": edge}, "traction": [0.0, t]} for edge, t in (("top", 10.0), ("bottom", -10.0))]
    K = 10.0 * MPA * np.sqrt(width * 1e-3 * np.tan(np.pi * half / width))
    return Known(scene, {("flaw", end): (K, 0.0) for end in ("start", "end")})


QUICK = ("grown wings", "young wings", "wings, friction 0.3, 30", "friction 0.3, 45 degrees", "open, 20 degrees",
         "closed kink of 30", "edge crack", "disk, along the load", "cross", "stacked")  # fmt: skip
"""Of the table of targets."""
SCENES = {"between rollers": row_of_cracks, **{name: TABLE[name].make for name in QUICK}}
GOOD_TO = {"closed kink of 30": 3e-3, "grown wings": 5e-4, "young wings": 5e-4}
"""What truths are good to, of the largest K; plates a hundred half lengths wide add 8e-4."""


def solved(name: str, accuracy: float | str) -> tuple[StepResult, float]:
    """A scene, and what the worst tip is off by, over the largest K."""
    known = SCENES[name]()
    assert known.truth is not None
    case = {**known.case, "numerics": {"accuracy": accuracy}, "output": {"frames": "none", "figures": False}}
    step = next(grow(Case.from_dict(case)))
    largest = max(np.hypot(*K) for K in known.truth.values())
    off = max(
        np.hypot(tip.K_I - K[0], abs(tip.K_II) - abs(K[1]))
        for tip in step.tips
        if (K := known.truth.get((tip.crack, tip.tip)))
    )
    return step, float(off / largest)


@pytest.mark.parametrize(
    ("name", "target"),
    [
        *((name, target) for name in SCENES for target in (0.03, 0.01, 0.003)),
        ("grown wings", 0.1),
        ("between rollers", 0.001),
    ],
)
def test_K_is_within_the_target_and_the_bound_holds(name: str, target: float) -> None:
    """All but what the truth is good to: tests/benchmarks/errors.md has more scenes."""
    step, off = solved(name, target)
    largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    assert off <= max(tip.K_I_error for tip in step.tips) / largest + GOOD_TO.get(name, 1e-3)
    assert all(tip.K_I_error > tip.K_error_expected for tip in step.tips)
    if target != 0.003 or name in ("young wings", "friction 0.3, 45 degrees"):  # of others the truth is not good enough
        assert off <= target
        assert not any(caution.cause is Cause.TARGET for caution in step.cautions)
        assert step.n_dofs < 25_000


@pytest.mark.parametrize("number", [4, 22, 36])
def test_faces_that_touch_next_to_a_tip_are_seen(number: int) -> None:
    """Wings whose tips are closed over less than a cell: K_I was below zero there, and K_II 1.4 to 2.5 % off.

    Both meshes miss that alike. The truth is that of cells three levels finer.
    """
    _, scene = [*wings(2)][number]
    ((step, solution),) = solved_steps(Case.from_dict({**scene, "numerics": {"accuracy": "standard"}}))
    levels = tuple(level + 3 for level in solution.scene.grading.cracks or (0,))
    finer = load(solution.scene.with_grading(replace(solution.scene.grading, cracks=levels)), solution.cracks)
    for tip, true in zip(step.tips, finer.tips, strict=True):
        off = np.hypot(tip.K_I - true.K[0], tip.K_II - true.K[1])
        assert off <= tip.K_I_error


def beside(what: str, room: float) -> dict[str, Any]:
    """A crack of 10 mm in a plate under tension whose right tip lies `room` (mm) beside a stiff body or a hole."""
    x, soft = 5.0 + room, {"young": 10_000.0, "poisson": 0.25}
    right = 50.0 if what == "hole" else x
    rock: dict[str, Any] = {"shape": {"polygon": [[-50, -50], [right, -50], [right, 50], [-50, 50]]}, "material": soft}
    scene: dict[str, Any] = {
        "title": f"a tip beside a {what}",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {"rock": rock},
        "cracks": {"flaw": {"path": {"points": [[-5, 0], [5, 0]]}, "contact": "none"}},
        "supports": [{"at": [-50, -50], "displacement": {"x": 0, "y": 0}}, {"at": [50, -50], "displacement": {"y": 0}}],
    }
    if what == "hole":
        rock["shape"]["holes"] = [{"disk": {"center": [x + 4.0, 0], "radius": 4.0}}]
    else:
        stiff = {**soft, "young": 30_000.0}
        scene["bodies"]["stiff"] = {
            "shape": {"polygon": [[x, -50], [50, -50], [50, 50], [x, 50]]}, "material": stiff,
        }  # fmt: skip
        scene["interfaces"] = [{"between": ["rock", "stiff"], "contact": "bonded"}]
    pulled = [(body, edge, sign) for body in scene["bodies"] for edge, sign in ((0, -1.0), (2, 1.0))]
    scene["loads"] = [{"on": {"body": body, "edge": edge}, "traction": [0, t]} for body, edge, t in pulled]
    return scene


@pytest.mark.parametrize(
    ("what", "room", "asked"), [("hole", 0.1, 0.03), ("interface", 0.1, 0.005), ("interface", 0.01, "standard")]
)
def test_cells_at_a_tip_are_small_by_its_room(tmp_path: Path, what: str, room: float, asked: float | str) -> None:
    """Two cells of different size, both larger than the room, agreed on what was 2.6, 1.4 and 2 % off.

    The truth is that of `fine`, which has four cells in the room.
    """
    found = []
    for accuracy in ("fine", asked):
        file = tmp_path / "scene.yaml"
        file.write_text(yaml.safe_dump({**beside(what, room), "numerics": {"accuracy": accuracy}}))
        step = next(grow(load_case(file, ["output.frames=none", "output.figures=false", "output.report=false"])))
        found.append({tip.tip: tip for tip in step.tips}["end"])
        largest = max(np.hypot(tip.K_I, tip.K_II) for tip in step.tips)
    true, tip = found
    off, bound = (np.hypot(tip.K_I - true.K_I, tip.K_II - true.K_II), max(tip.K_I_error, tip.K_II_error))
    assert off <= bound + true.K_I_error
    assert bound <= BOUND * (asked if isinstance(asked, float) else 0.01) * largest
