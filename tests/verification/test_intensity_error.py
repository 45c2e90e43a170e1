"""The bound that a run states of the error of K: it holds for 95 % of tips, and is not many times too large.

Measured on these scenes and others: tips, those of them whose true error is within the bound, and bound over true error
in the median, by the larger component.

    straight flaw, 2.5 to 13 spacings                                   24   100 %   16
    young wings (`young30`), 3 and 1.5 mm                                4   100 %   11
    grown wings (`grown30`), 3, 1.5, 0.75 mm                             6   100 %    4
    closed kinks of 30 to 60 degrees, wings of 1, 2 and 5 spacings      18   100 %    3
    fifty flaws, 3, 2 and 1.5 mm                                       300    95 %    3
    wings of a flaw in a wide plate, 0.1 and 0.3 of its half length     16   100 %    3
  no term was fitted to these, but two numbers were turned once after a look at such scenes:
    random scenes of one to three bent cracks, 2 and 1 mm,
    against 0.35 mm                                                     68    97 %   12

The spread over discs is above the true error at 15 to 30 % of the last ones. A flaw that sticks, `stuck_flaw`, whose K
is all error, is within the bound at 3 mm, and at one end 1.9 times beyond it at 1.5 mm.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.run import grow
from tests.verification.solutions import CASES, REFERENCES, table

MPA = 1e6
Truth = dict[tuple[str, str], tuple[float, float]]
Errors = list[tuple[float, float]]
"""True error and bound of the larger component, Pa sqrt(m), tip by tip."""


def judged(folder: Path, scene: dict[str, Any], spacing: float, truth: Truth, *, signs: bool = True) -> Errors:
    """The errors of a static scene; without `signs` K_II of the reference is an absolute value."""
    file = folder / "scene.yaml"
    file.write_text(yaml.safe_dump(scene))
    settings = [f"numerics.spacing={spacing}", "output.frames=none", "output.figures=false", "output.report=false"]
    found = []
    for tip in next(grow(load_case(file, settings))).tips:
        K_I, K_II = truth[tip.crack, tip.tip]
        off = (abs(tip.K_I - K_I), abs(tip.K_II - K_II) if signs else abs(abs(tip.K_II) - abs(K_II)))
        found.extend(zip(off, (tip.K_I_error, tip.K_II_error), strict=True))
    return [max(found[k : k + 2], key=lambda pair: pair[0] / pair[1]) for k in range(0, len(found), 2)]


def shipped(name: str) -> dict[str, Any]:
    """A shipped scene for one static solve."""
    scene: dict[str, Any] = yaml.safe_load((CASES / f"{name}.yaml").read_text().replace(" on:", " 'on':").replace(
        "{on:", "{'on':"))  # fmt: skip
    return {key: value for key, value in scene.items() if key not in ("growth", "loading")}


def with_wings(folder: Path, name: str, spacing: float) -> Errors:
    path = table(f"{name}_path.csv")
    points = np.column_stack([path["x_mm"], path["y_mm"]]).tolist()
    scene = shipped("compression30")
    scene["cracks"]["flaw"]["path"] = {"points": points}
    found = [row for row in table("grown_K.csv") if row["scene"] == name]
    K = {("flaw", row["tip"]): (MPA * float(row["K_I_MPa_sqrtm"]), MPA * float(row["K_II_MPa_sqrtm"])) for row in found}
    return judged(folder, scene, spacing, K)


def plate(points: list[list[float]], size: float, axial: float, lateral: float, friction: float) -> dict[str, Any]:
    """A square plate under compression (MPa) with one flaw (mm), loaded by tractions."""
    edges = {"left": [lateral, 0], "right": [-lateral, 0], "top": [0, -axial], "bottom": [0, axial]}
    corner = 0.5 * size
    return {
        "title": "a closed flaw with wings",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": size, "height": size}},
                "material": {"young": 20000, "poisson": 0.25},
            }
        },
        "cracks": {"flaw": {"path": {"points": points}, "contact": {"friction": friction, "cohesion": 0}}},
        "supports": [
            {"at": [-corner, -corner], "displacement": {"x": 0, "y": 0}},
            {"at": [corner, -corner], "displacement": {"y": 0}},
        ],
        "loads": [{"on": {"body": "rock", "edge": edge}, "traction": force} for edge, force in edges.items()],
        "numerics": {"spacing": 1},
    }


def winged(half: float, angle: float, wing: float, turn: float) -> list[list[float]]:
    """Vertices of a flaw with straight wings, symmetric by point reflection; degrees."""
    inner = half * np.exp(1j * np.deg2rad(angle))
    outer = inner + wing * np.exp(1j * np.deg2rad(angle + turn))
    return [[float(z.real), float(z.imag)] for z in (-outer, -inner, inner, outer)]


def closed_kinks(folder: Path, spacing: float) -> Iterator[tuple[float, float]]:
    for row in table("closed_kink_K.csv"):
        scene = plate(winged(20.0, 45.0, 10.0, float(row["turn_deg"])), 200.0, 10.0, 4.0, 0.3)
        K = (MPA * float(row["K_I_MPa_sqrtm"]), MPA * float(row["K_II_MPa_sqrtm"]))
        yield from judged(folder, scene, spacing, {("flaw", "start"): K, ("flaw", "end"): K})


def wings_in_a_wide_plate(folder: Path, spacing: float) -> Iterator[tuple[float, float]]:
    """Half length 1 mm in a plate of 30 mm, 1 MPa; K of the infinite plate."""
    for row in table("wing_K_contact.csv")[::4]:
        angle, wing = float(row["flaw_angle_from_x_deg"]), float(row["l_over_a"])
        if wing > 0.5:
            continue  # the plate is not wide enough
        turn = 70.5288 if row["wing"] == "hoop" else 90.0 - angle
        scene = plate(winged(1.0, angle, wing, turn), 30.0, 1.0, float(row["lateral_over_axial"]), float(row["mu"]))
        K = (MPA * np.sqrt(np.pi * 1e-3) * float(row["K_I"]), MPA * np.sqrt(np.pi * 1e-3) * float(row["K_II"]))
        yield from judged(folder, scene, spacing, {("flaw", "start"): K, ("flaw", "end"): K})


def covered(errors: Errors) -> tuple[float, float]:
    """Part of the tips whose error is within the bound, and the median of bound over error."""
    off, bound = np.array(errors).T
    return float(np.mean(off <= bound)), float(np.median(bound / np.maximum(off, 1e-300)))


@pytest.mark.parametrize("spacing", [3.0, 1.5, 0.75])
def test_grown_wings_are_within_the_bound_which_is_not_ten_times_too_large(tmp_path: Path, spacing: float) -> None:
    """The spread over discs was 0.15 % of a K that is 2.8 % off."""
    part, ratio = covered(with_wings(tmp_path, "grown30", spacing))
    assert (part, 1.0 < ratio < 10.0) == (1.0, True)


@pytest.mark.parametrize("spacing", [3.0, 1.5])
def test_young_wings_are_within_the_bound(tmp_path: Path, spacing: float) -> None:
    part, ratio = covered(with_wings(tmp_path, "young30", spacing))
    assert (part, 1.0 < ratio < 15.0) == (1.0, True)


@pytest.mark.parametrize("spacing", [10.0, 5.0, 2.0])
def test_closed_kinks_are_within_the_bound(tmp_path: Path, spacing: float) -> None:
    assert covered(list(closed_kinks(tmp_path, spacing)))[0] == 1.0


def test_nineteen_of_twenty_tips_of_fifty_flaws_are_within_the_bound(tmp_path: Path) -> None:
    scene = shipped("random_flaws")  # 10 MPa; the reference has 100
    tenth = 0.1 * MPA
    K = {
        (row["crack"], row["tip"]): (tenth * float(row["K_I_MPa_sqrtm"]), tenth * float(row["K_II_abs_MPa_sqrtm"]))
        for row in table("random_flaws_K.csv")
    }
    part, ratio = covered(judged(tmp_path, scene, 3.0, K, signs=False))
    assert part >= 0.95
    assert ratio < 10.0


@pytest.mark.parametrize("spacing", [0.6, 0.4])
def test_wings_in_a_wide_plate_are_within_the_bound(tmp_path: Path, spacing: float) -> None:
    part, ratio = covered(list(wings_in_a_wide_plate(tmp_path, spacing)))
    assert part >= 0.95
    assert ratio < 20.0


def test_a_flaw_that_sticks_has_an_error_as_large_as_its_K(tmp_path: Path) -> None:
    """Exactly zero; contact that holds on average lets a coarse lattice open its ends."""
    scene = yaml.safe_load((REFERENCES / "stuck_flaw.yaml").read_text().replace("{on:", "{'on':"))
    del scene["growth"]
    errors = judged(tmp_path, scene, 3.0, {("flaw", end): (0.0, 0.0) for end in ("start", "end")})
    assert covered(errors)[0] == 1.0
