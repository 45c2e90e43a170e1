"""Scenes whose K is known, that a target of the error of K is asked of."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from tests.benchmarks.paths import REFERENCES
from tests.scenes import MPA, plate, shipped, winged
from tests.verification.rows.closed_kink import corners
from tests.verification.slit_body import closed_plate, disk
from tests.verification.slit_body import plate as open_plate
from tests.verification.solutions import rows

WIDE = 200.0
"""mm, side of plates for the infinite one: half a length of a flaw is 1 mm, and the plate's part of K 0.01 %."""

FINITE = 2e-4
"""Of K: what K in such plates may differ by from K in the infinite one; runs on fine cells agree on 1.5e-4."""

UNIT = MPA * np.sqrt(np.pi * 1e-3)
"""Pa sqrt(m), of 1 MPa and a half length of 1 mm."""

TARGETS = (0.03, 0.01, 0.003, 0.001)

Truth = dict[tuple[str, str], tuple[float, float]]
"""K_I and K_II (Pa sqrt(m)) by crack and end; only the size of K_II counts."""


@dataclass(frozen=True, slots=True)
class Known:
    """A scene and its K."""

    case: dict[str, Any]
    truth: Truth | None  # None: its own K at the smallest target
    within: float = 1e-4  # of the largest K: what the truth itself is good to


@dataclass(frozen=True, slots=True)
class Entry:
    """A row of the table."""

    kind: str
    make: Callable[[], Known]
    targets: tuple[float, ...] = TARGETS


def straight(angle: float, axial: float, lateral: float, friction: float) -> Known:
    """A flaw under compression (MPa) in a wide plate."""
    exact = (
        open_plate(1.0, angle, WIDE, WIDE, -axial)
        if axial < 0.0
        else closed_plate(1.0, angle, WIDE, WIDE, (-lateral, -axial, 0.0), friction)
    )
    K = (1e6 * exact.K_I * np.sqrt(1e-3), 1e6 * exact.K_II * np.sqrt(1e-3))
    case = plate(winged(1.0, angle, 1.0, 0.0)[1:3], WIDE, axial, lateral, friction)
    return Known(case, {("flaw", "start"): K, ("flaw", "end"): K}, FINITE)


def wings(name: str) -> Known:
    """The specimen of `compression30` with wings, without friction."""
    case = shipped("compression30")
    points = [[float(row["x_mm"]), float(row["y_mm"])] for row in rows(f"{name}_path.csv")]
    case["cracks"]["flaw"]["path"] = {"points": points}
    mine = [row for row in rows("grown_K.csv") if row["scene"] == name]
    K = {("flaw", row["tip"]): (MPA * float(row["K_I_MPa_sqrtm"]), MPA * float(row["K_II_MPa_sqrtm"])) for row in mine}
    return Known(case, K, 5e-4)


def winged_flaw(number: int) -> Known:
    """Straight wings of a flaw with contact, a row of the table."""
    row = rows("wing_K_contact.csv")[number]
    angle = float(row["flaw_angle_from_x_deg"])
    turn = 70.5288 if row["wing"] == "hoop" else 90.0 - angle
    points = winged(1.0, angle, float(row["l_over_a"]), turn)
    K = (UNIT * float(row["K_I"]), UNIT * float(row["K_II"]))
    case = plate(points, WIDE, 1.0, float(row["lateral_over_axial"]), float(row["mu"]))
    return Known(case, {("flaw", "start"): K, ("flaw", "end"): K}, 2e-4)


def kinked(turn: float) -> Known:
    """A closed crack with closed wings under lateral pressure."""
    case = plate(corners(turn), WIDE, 10.0, 4.0, 0.3)
    row = next(row for row in rows("closed_kink_K.csv") if float(row["turn_deg"]) == turn)
    K = (MPA * float(row["K_I_MPa_sqrtm"]), MPA * float(row["K_II_MPa_sqrtm"]))
    return Known(case, {("flaw", "start"): K, ("flaw", "end"): K}, 3e-3)


def specimen(friction: float) -> Known:
    """The flaw of `compression30` before growth."""
    case = shipped("compression30")
    case["cracks"]["flaw"]["contact"]["friction"] = friction
    row = next(
        row
        for row in rows("closed_crack_K.csv")
        if (float(row["friction"]), row["stiffness_N_per_m3"]) == (friction, "inf")
    )
    K = (0.0, MPA * float(row["K_II_abs_MPa_sqrtm"]))
    return Known(case, {("flaw", "start"): K, ("flaw", "end"): K})


def handbook(name: str, scene: str) -> Known:
    """A shipped scene under tension."""
    found = [row for row in rows("open_crack_K.csv") if row["scene"] == scene]
    per_mm = MPA * np.sqrt(1e-3)
    case = shipped(name)
    (crack,) = case["cracks"]
    truth = {(crack, row["tip"]): (per_mm * float(row["K_I_MPa_sqrtmm"]), 0.0) for row in found}
    return Known(case, truth)


def cracked_disk(angle: float) -> Known:
    """The Brazilian disk with its crack at an angle to x."""
    exact = disk(0.025, angle, 0.05, 2.0, 100e6)
    case = shipped("brazilian_disk")
    case["cracks"]["flaw"]["path"]["angle"] = angle
    K = (exact.K_I, exact.K_II)
    return Known(case, {("flaw", "start"): K, ("flaw", "end"): K}, 5e-4)  # the case has a polygon


def exact_of(name: str, case: str) -> list[tuple[float, float]]:
    """K_I and K_II (Pa sqrt(m)) of the rows of a case of a table, in turn."""
    with (REFERENCES / name).open(newline="") as file:
        found = [row for row in csv.DictReader(file) if row["case"] == case]
    return [(UNIT * float(row["K_I"]), UNIT * float(row["K_II"])) for row in found]


def cracks(
    pulls: tuple[float, float], lines: Mapping[str, tuple[Iterable[Any], str]], law: Any = "none"
) -> dict[str, Any]:
    """A wide plate under tensions (MPa) in x and y with cracks: points (mm), and which ends are tips."""
    case = plate([[0.0, 0.0], [1.0, 0.0]], WIDE, -pulls[1], -pulls[0], 0.0)
    case["cracks"] = {
        name: {
            "path": {"points": np.round(np.array(list(points)), 9).tolist()},
            "tips": tips,
            "contact": law if isinstance(law, str) else dict(law),
        }
        for name, (points, tips) in lines.items()
    }
    return case


def ray(angle: float, length: float = 1.0) -> Floats:
    """The end of an arm (2,) mm from the origin."""
    t = np.deg2rad(angle)
    return length * np.array([np.cos(t), np.sin(t)])


def one_kink(turn: float, arm: float) -> Known:
    """An open crack, half length 1 mm, with an arm at its end."""
    (kink, other, *_) = exact_of("open_cracks_K.csv", f"one kink {turn:g} deg b={arm:g}")
    points = [np.array([-1.0, 0.0]), np.array([1.0, 0.0]), np.array([1.0, 0.0]) + ray(turn, arm)]
    return Known(
        cracks((0.0, 1.0), {"flaw": (points, "both")}), {("flaw", "end"): kink, ("flaw", "start"): other}, FINITE
    )


def star() -> Known:
    """Three arms."""
    K = exact_of("open_cracks_K.csv", "star3 load (1, 1, 0)")
    lines = {f"arm{n}": ([np.zeros(2), ray(angle)], "end") for n, angle in enumerate((90.0, 210.0, 330.0))}
    return Known(cracks((1.0, 1.0), lines), {(name, "end"): k for name, k in zip(lines, K, strict=True)}, FINITE)


def fork() -> Known:
    """A stem and two branches."""
    K = exact_of("open_cracks_K.csv", "Y: stem to the left 1, branches +-45 deg, 0.5 load (1, 1, 0)")
    lines = {
        "stem": ([ray(180.0), np.zeros(2)], "start"),
        "upper": ([np.zeros(2), ray(45.0, 0.5)], "end"),
        "lower": ([np.zeros(2), ray(-45.0, 0.5)], "end"),
    }
    ends = [("stem", "start"), ("upper", "end"), ("lower", "end")]
    return Known(cracks((1.0, 1.0), lines), dict(zip(ends, K, strict=True)), FINITE)


def cross() -> Known:
    """Two cracks of equal length that cross, under equal tension: 0.86354 (Rooke, Sneddon 1969)."""
    lines = {name: ([ray(angle + 180.0), ray(angle)], "both") for name, angle in (("along", 0.0), ("across", 90.0))}
    K = (0.86354210 * UNIT, 0.0)
    return Known(cracks((1.0, 1.0), lines), {(name, end): K for name in lines for end in ("start", "end")}, FINITE)


def stacked() -> Known:
    """Two cracks one above the other."""
    (K,) = exact_of("open_cracks_K.csv", "two stacked, spacing 0.5")
    lines = {name: ([[-1.0, y], [1.0, y]], "both") for name, y in (("lower", -0.25), ("upper", 0.25))}
    return Known(cracks((0.0, 1.0), lines), {(name, end): K for name in lines for end in ("start", "end")}, FINITE)


def passing() -> Known:
    """Two cracks that overlap by their half length."""
    outer, inner = exact_of("open_cracks_K.csv", "en echelon dx=1 dy=0.5")
    lines = {"left": ([[-1.5, -0.25], [0.5, -0.25]], "both"), "right": ([[-0.5, 0.25], [1.5, 0.25]], "both")}
    ends = {("left", "start"): outer, ("left", "end"): inner, ("right", "start"): inner, ("right", "end"): outer}
    return Known(cracks((0.0, 1.0), lines), ends, FINITE)


def in_line(friction: float) -> Known:
    """Two closed flaws at 45 degrees, one behind the other, half a half length between them."""
    with (REFERENCES / "closed_cracks_K.csv").open(newline="") as file:
        found = [row for row in csv.DictReader(file) if row["case"] == "coplanar 45, gap 0.5"]
    mine = [row for row in found if float(row["mu"]) == friction]
    lines, truth = {}, {}
    for row in mine:
        name, centre = f"flaw{row['flaw']}", (-1.25, 1.25)[int(row["flaw"])]
        lines[name] = ([ray(45.0, centre - 1.0), ray(45.0, centre + 1.0)], "both")
        for end in ("start", "end"):
            truth[name, end] = (0.0, UNIT * float(row[f"K_II_{end}"]))
    return Known(cracks((0.0, -1.0), lines, {"friction": friction, "cohesion": 0}), truth, FINITE)


def fifty() -> Known:
    """The flaws of `random_flaws`."""
    tenth = 0.1 * MPA  # the reference has 100 MPa, the case 10
    K = {
        (row["crack"], row["tip"]): (tenth * float(row["K_I_MPa_sqrtm"]), tenth * float(row["K_II_abs_MPa_sqrtm"]))
        for row in rows("random_flaws_K.csv")
    }
    return Known(shipped("random_flaws"), K, 1e-3)


def beside_a_hole() -> Known:
    """The flaw and the hole of `flaw_and_hole`."""
    return Known(shipped("flaw_and_hole"), None, 1e-3)


def bimaterial() -> Known:
    """A crack below the bonded interface of soft rock and rock four times as stiff, pulled across."""
    case = plate([[-1.0, -0.5], [1.0, -0.5]], 20.0, -1.0, 0.0, 0.0)
    del case["bodies"]["rock"], case["loads"][0:2]
    for name, y, young in (("lower", -5.0, 20000), ("upper", 5.0, 80000)):
        shape = {"rectangle": {"center": [0, y], "width": 20, "height": 10}}
        case["bodies"][name] = {"shape": shape, "material": {"young": young, "poisson": 0.25}}
    case["interfaces"] = [{"between": ["lower", "upper"], "contact": "bonded"}]
    case["cracks"]["flaw"]["contact"] = "none"
    for load in case["loads"]:
        load["on"]["body"] = "upper" if load["on"]["edge"] == "top" else "lower"
    return Known(case, None, 1e-3)


def of_sizes() -> Known:
    """A crack of 2 mm between the tips of cracks of 20 mm."""
    lines = {
        "left": ([[-24.0, 0.0], [-4.0, 0.0]], "both"),
        "small": ([[-1.0, 1.0], [1.0, 1.5]], "both"),
        "right": ([[4.0, 0.0], [24.0, 0.0]], "both"),
    }
    return Known(cracks((0.0, 1.0), lines), None, 1e-3)


THREE_ONE = (0.03, 0.01)
THREE = (0.03, 0.01, 0.003)

SCENES: Mapping[str, Entry] = {
    "open, 20 degrees": Entry("straight", partial(straight, 20.0, -10.0, 0.0, 0.0)),
    "closed, 45 degrees": Entry("straight", partial(straight, 45.0, 10.0, 2.0, 0.0)),
    "friction 0.3, 45 degrees": Entry("closed with friction", partial(straight, 45.0, 10.0, 2.0, 0.3)),
    "friction 0.6, 60 degrees": Entry("closed with friction", partial(straight, 60.0, 10.0, 0.0, 0.6)),
    "specimen": Entry("closed in a specimen", partial(specimen, 0.0)),
    "specimen, friction 0.3": Entry("closed in a specimen", partial(specimen, 0.3)),
    "centre crack": Entry("open in a specimen", partial(handbook, "tension0", "centre_theta0_31x55_a5")),
    "edge crack": Entry("edge", partial(handbook, "edge_tension", "edge_straight_30x120_a6")),
    "disk, along the load": Entry("disk", partial(cracked_disk, 90.0)),
    "disk, 15 degrees off": Entry("disk", partial(cracked_disk, 75.0)),
    "grown wings": Entry("grown", partial(wings, "grown30"), TARGETS[:3]),
    "young wings": Entry("young", partial(wings, "young30"), TARGETS[:3]),
    "wings, friction 0.3, 30": Entry("grown", partial(winged_flaw, 4), TARGETS[:3]),
    "wings, hoop, 30": Entry("grown, confined", partial(winged_flaw, 7), TARGETS[:3]),
    "wings, hoop, 45": Entry("grown", partial(winged_flaw, 21), TARGETS[:3]),
    "wings, friction 0.3, 60": Entry("grown, confined", partial(winged_flaw, 27), TARGETS[:3]),
    "closed kink of 30": Entry("kinked", partial(kinked, 30.0), TARGETS[:3]),
    "open kink of 30, short": Entry("kinked", partial(one_kink, 30.0, 0.1)),
    "open kink of 60": Entry("kinked", partial(one_kink, 60.0, 0.5)),
    "star": Entry("branched", star, TARGETS[:3]),
    "fork": Entry("branched", fork, TARGETS[:3]),
    "cross": Entry("crossed", cross),
    "stacked": Entry("two interacting", stacked),
    "passing": Entry("two interacting", passing),
    "in line": Entry("two interacting", partial(in_line, 0.0)),
    "in line, friction 0.3": Entry("two interacting", partial(in_line, 0.3)),
    "flaw and hole": Entry("flaw and hole", beside_a_hole, THREE_ONE),
    "bimaterial": Entry("bimaterial", bimaterial, THREE_ONE),
    "of two sizes": Entry("two sizes", of_sizes, THREE_ONE),
    "wings, 30, short": Entry("grown", partial(winged_flaw, 0), THREE),
    "wings, hoop, friction 0.3, 30": Entry("grown", partial(winged_flaw, 9), THREE),
    **{
        f"held out: {name}": Entry("grown, held out", partial(winged_flaw, number), THREE)
        for name, number in {
            "wings, friction 0.3, 45": 16,
            "wings, hoop, friction 0.3, 45": 22,
            "wings, 60": 25,
            "wings, hoop, 60": 30,
        }.items()
    },
    **{
        f"held out: open kink of {turn:g}": Entry("kinked, held out", partial(one_kink, turn, 0.5), THREE)
        for turn in (45.0, 90.0)
    },
    "held out: closed, 60 degrees": Entry("straight, held out", partial(straight, 60.0, 10.0, 2.0, 0.1), THREE),
    "held out: friction 0.3, 30 degrees": Entry("straight, held out", partial(straight, 30.0, 10.0, 0.0, 0.3), THREE),
    "fifty flaws": Entry("fifty flaws", fifty, (0.03,)),
}
"""By name."""
