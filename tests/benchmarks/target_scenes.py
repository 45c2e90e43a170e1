"""Scenes whose K is known, that a target of the error of K is asked of."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from crackgrow.arrays import Floats
from tests.scenes import MPA, plate, shipped, winged
from tests.verification.slit_body import closed_plate
from tests.verification.slit_body import plate as open_plate
from tests.verification.solutions import rows

WIDE = 200.0
"""mm, side of plates for the infinite one: half a length of a flaw is 1 mm, and the plate's part of K 0.01 %."""

FINITE = 2e-4
"""Of K: what K in such plates may differ by from K in the infinite one; runs on fine cells agree on 1.5e-4."""

UNIT = MPA * np.sqrt(np.pi * 1e-3)
"""Pa sqrt(m), of 1 MPa and a half length of 1 mm."""

ENDS = ("start", "end")

Truth = dict[tuple[str, str], tuple[float, float]]
"""K_I and K_II (Pa sqrt(m)) by crack and end; only the size of K_II counts."""


@dataclass(frozen=True, slots=True)
class Known:
    """A scene and its K."""

    case: Any  # a document, or the name of a shipped case
    truth: Truth | None = None  # of the first step; None: that of smaller cells
    within: float = 1e-4  # of the largest K: what the truth itself is good to


def alike(K: tuple[float, float], names: Iterable[str] = ("flaw",)) -> Truth:
    """The same K at both ends of cracks."""
    return {(name, end): K for name in names for end in ENDS}


def straight(angle: float, axial: float, lateral: float, friction: float) -> Known:
    """A flaw under compression (MPa) in a wide plate."""
    exact = (
        open_plate(1.0, angle, WIDE, WIDE, -axial)
        if axial < 0.0
        else closed_plate(1.0, angle, WIDE, WIDE, (-lateral, -axial, 0.0), friction)
    )
    K = (1e6 * exact.K_I * np.sqrt(1e-3), 1e6 * exact.K_II * np.sqrt(1e-3))
    return Known(plate(winged(1.0, angle, 1.0, 0.0)[1:3], WIDE, axial, lateral, friction), alike(K), FINITE)


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
    case = plate(points, WIDE, 1.0, float(row["lateral_over_axial"]), float(row["mu"]))
    return Known(case, alike((UNIT * float(row["K_I"]), UNIT * float(row["K_II"]))), FINITE)


def kinked_scene(turn: float) -> dict[str, Any]:
    """A closed flaw of 40 mm at 45 degrees with closed wings of 10 mm, turned on by degrees, under lateral pressure."""
    flaw, along = np.deg2rad([45.0, 45.0 + turn])
    kink = 20.0 * np.array([np.cos(flaw), np.sin(flaw)])
    tip = kink + 10.0 * np.array([np.cos(along), np.sin(along)])
    return plate(np.round([-tip, -kink, kink, tip], 5).tolist(), WIDE, 10.0, 4.0, 0.3)


def kinked(turn: float) -> Known:
    """The same with its K."""
    row = next(row for row in rows("closed_kink_K.csv") if float(row["turn_deg"]) == turn)
    K = (MPA * float(row["K_I_MPa_sqrtm"]), MPA * float(row["K_II_MPa_sqrtm"]))
    return Known(kinked_scene(turn), alike(K), 3e-3)


def specimen(friction: float) -> Known:
    """The flaw of `compression30` before growth."""
    case = shipped("compression30")
    case["cracks"]["flaw"]["contact"]["friction"] = friction
    found = [row for row in rows("closed_crack_K.csv") if row["stiffness_N_per_m3"] == "inf"]
    (row,) = [row for row in found if float(row["friction"]) == friction]
    return Known(case, alike((0.0, MPA * float(row["K_II_abs_MPa_sqrtm"]))))


def handbook(name: str, scene: str) -> Known:
    """A shipped scene under tension."""
    case, per_mm = shipped(name), MPA * np.sqrt(1e-3)
    found = [row for row in rows("open_crack_K.csv") if row["scene"] == scene]
    (crack,) = case["cracks"]
    return Known(case, {(crack, row["tip"]): (per_mm * float(row["K_I_MPa_sqrtmm"]), 0.0) for row in found})


DISK = {90.0: (860836.300, 0.0), 75.0: (430559.466, -1037577.623)}
"""K (Pa sqrt(m)) of the Brazilian disk by the angle (degrees) of its crack to x, loads on arcs, by a series."""


def cracked_disk(angle: float) -> Known:
    """The Brazilian disk with its crack at an angle to x."""
    case = shipped("brazilian_disk")
    case["cracks"]["flaw"]["path"]["angle"] = angle
    return Known(case, alike(DISK[angle]), 5e-4)  # the case has a polygon


def exact_of(case: str) -> list[tuple[float, float]]:
    """K_I and K_II (Pa sqrt(m)) of the rows of a case of open cracks, in turn."""
    found = [row for row in rows("open_cracks_K.csv") if row["case"] == case]
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
    (kink, other, *_) = exact_of(f"one kink {turn:g} deg b={arm:g}")
    points = [ray(180.0), ray(0.0), ray(0.0) + ray(turn, arm)]
    case = cracks((0.0, 1.0), {"flaw": (points, "both")})
    return Known(case, {("flaw", "end"): kink, ("flaw", "start"): other}, FINITE)


def star() -> Known:
    """Three arms."""
    K = exact_of("star3 load (1, 1, 0)")
    lines = {f"arm{n}": ([np.zeros(2), ray(angle)], "end") for n, angle in enumerate((90.0, 210.0, 330.0))}
    return Known(cracks((1.0, 1.0), lines), {(name, "end"): k for name, k in zip(lines, K, strict=True)}, FINITE)


def fork() -> Known:
    """A stem and two branches."""
    K = exact_of("Y: stem to the left 1, branches +-45 deg, 0.5 load (1, 1, 0)")
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
    return Known(cracks((1.0, 1.0), lines), alike((0.86354210 * UNIT, 0.0), lines), FINITE)


def stacked() -> Known:
    """Two cracks one above the other."""
    (K,) = exact_of("two stacked, spacing 0.5")
    lines = {name: ([[-1.0, y], [1.0, y]], "both") for name, y in (("lower", -0.25), ("upper", 0.25))}
    return Known(cracks((0.0, 1.0), lines), alike(K, lines), FINITE)


def passing() -> Known:
    """Two cracks that overlap by their half length."""
    outer, inner = exact_of("en echelon dx=1 dy=0.5")
    lines = {"left": ([[-1.5, -0.25], [0.5, -0.25]], "both"), "right": ([[-0.5, 0.25], [1.5, 0.25]], "both")}
    ends = {("left", "start"): outer, ("left", "end"): inner, ("right", "start"): inner, ("right", "end"): outer}
    return Known(cracks((0.0, 1.0), lines), ends, FINITE)


def in_line(friction: float) -> Known:
    """Two closed flaws at 45 degrees, one behind the other, half a half length between them."""
    found = [row for row in rows("closed_cracks_K.csv") if row["case"] == "coplanar 45, gap 0.5"]
    lines, truth = {}, {}
    for row in found:
        if float(row["mu"]) == friction:
            name, centre = f"flaw{row['flaw']}", (-1.25, 1.25)[int(row["flaw"])]
            lines[name] = ([ray(45.0, centre - 1.0), ray(45.0, centre + 1.0)], "both")
            truth |= {(name, end): (0.0, UNIT * float(row[f"K_II_{end}"])) for end in ENDS}
    return Known(cracks((0.0, -1.0), lines, {"friction": friction, "cohesion": 0}), truth, FINITE)


def fifty() -> Known:
    """The flaws of `random_flaws`."""
    tenth = 0.1 * MPA  # the reference has 100 MPa, the case 10
    K = {
        (row["crack"], row["tip"]): (tenth * float(row["K_I_MPa_sqrtm"]), tenth * float(row["K_II_abs_MPa_sqrtm"]))
        for row in rows("random_flaws_K.csv")
    }
    return Known(shipped("random_flaws"), K, 1e-3)


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
    return Known(case)


def of_sizes() -> Known:
    """A crack of 2 mm between the tips of cracks of 20 mm."""
    paths = {
        "left": [[-24.0, 0.0], [-4.0, 0.0]],
        "small": [[-1.0, 1.0], [1.0, 1.5]],
        "right": [[4.0, 0.0], [24.0, 0.0]],
    }
    return Known(cracks((0.0, 1.0), {name: (path, "both") for name, path in paths.items()}))


SCENES: Mapping[str, Callable[[], Known]] = {
    "open, 20 degrees": partial(straight, 20.0, -10.0, 0.0, 0.0),
    "closed, 45 degrees": partial(straight, 45.0, 10.0, 2.0, 0.0),
    "friction 0.3, 45 degrees": partial(straight, 45.0, 10.0, 2.0, 0.3),
    "friction 0.6, 60 degrees": partial(straight, 60.0, 10.0, 0.0, 0.6),
    "specimen": partial(specimen, 0.0),
    "specimen, friction 0.3": partial(specimen, 0.3),
    "centre crack": partial(handbook, "tension0", "centre_theta0_31x55_a5"),
    "edge crack": partial(handbook, "edge_tension", "edge_straight_30x120_a6"),
    "disk, along the load": partial(cracked_disk, 90.0),
    "disk, 15 degrees off": partial(cracked_disk, 75.0),
    "grown wings": partial(wings, "grown30"),
    "young wings": partial(wings, "young30"),
    "wings, friction 0.3, 30": partial(winged_flaw, 4),
    "wings, hoop, 30": partial(winged_flaw, 7),
    "wings, hoop, 45": partial(winged_flaw, 21),
    "wings, friction 0.3, 60": partial(winged_flaw, 27),
    "closed kink of 30": partial(kinked, 30.0),
    "open kink of 30, short": partial(one_kink, 30.0, 0.1),
    "open kink of 60": partial(one_kink, 60.0, 0.5),
    "star": star,
    "fork": fork,
    "cross": cross,
    "stacked": stacked,
    "passing": passing,
    "in line": partial(in_line, 0.0),
    "in line, friction 0.3": partial(in_line, 0.3),
    "flaw and hole": lambda: Known(shipped("flaw_and_hole")),
    "bimaterial": bimaterial,
    "of two sizes": of_sizes,
    "wings, 30, short": partial(winged_flaw, 0),
    "wings, hoop, friction 0.3, 30": partial(winged_flaw, 9),
    "held out: wings, friction 0.3, 45": partial(winged_flaw, 16),
    "held out: wings, hoop, friction 0.3, 45": partial(winged_flaw, 22),
    "held out: wings, 60": partial(winged_flaw, 25),
    "held out: wings, hoop, 60": partial(winged_flaw, 30),
    "held out: open kink of 45": partial(one_kink, 45.0, 0.5),
    "held out: open kink of 90": partial(one_kink, 90.0, 0.5),
    "held out: closed, 60 degrees": partial(straight, 60.0, 10.0, 2.0, 0.1),
    "held out: friction 0.3, 30 degrees": partial(straight, 30.0, 10.0, 0.0, 0.3),
    "fifty flaws": fifty,
}
"""By name. Held out: no constant of the program was fitted to these."""
