"""K after growth, at kinks and of many flaws where presets halve the cells by themselves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from tests.verification.row import Row
from tests.verification.rows.closed_kink import FLAW, K_FLAW, expected, scene
from tests.verification.solutions import solved, solved_text, table

MPA = 1e6
AUTOMATIC = "numerics.spacing=auto"
WINGS = {"young30": "wings of one increment", "grown30": "wings of eight increments"}


def wings(name: str, accuracy: str) -> float:
    """Largest error of K_I and K_II at both tips over K_I, of the flaw of compression30 with wings, no friction."""
    path = table(f"{name}_path.csv")
    points = np.column_stack([path["x_mm"], path["y_mm"]]).tolist()
    settings = (f"cracks.flaw.path={{points: {points}}}", "growth.steps=0", AUTOMATIC, f"numerics.accuracy={accuracy}")
    found = solved("compression30", *settings)
    off = []
    for row in table("grown_K.csv"):
        if row["scene"] == name:
            K = MPA * np.array([row["K_I_MPa_sqrtm"], row["K_II_MPa_sqrtm"]])
            off.append(np.abs(np.subtract(found.tip(row["tip"]), K)).max() / K[0])
    return float(max(off))


def kinked(turn: float) -> float:
    """Largest error of K_I and K_II of a closed, kinked crack over the flaw's K."""
    found = solved_text(scene(turn, FLAW), AUTOMATIC)
    return float(np.abs(np.subtract(found.tip("start"), expected(turn))).max()) / K_FLAW


def fifty_flaws(share: float) -> float:
    """The error of K that a share of the tips does not exceed, over the largest K of all."""
    found = solved("random_flaws", "growth.steps=0", "loading={history: [1]}", AUTOMATIC)
    rows, tenth = table("random_flaws_K.csv"), 0.1 * MPA  # the reference has 100 MPa, the case 10
    truth = {(row["crack"], row["tip"]): (row["K_I_MPa_sqrtm"], row["K_II_abs_MPa_sqrtm"]) for row in rows}
    largest = tenth * max(map(max, truth.values()))
    off = [
        max(abs(K_I - tenth * truth[tip][0]), abs(abs(K_II) - tenth * truth[tip][1]))
        for tip, (K_I, K_II) in found.tips().items()
    ]
    return float(np.quantile(off, share)) / largest


def _rows() -> Iterator[Row]:
    for name, words in WINGS.items():
        for accuracy, tolerance in (("draft", 0.03), ("standard", 0.005), ("fine", 0.002)):
            quantity = f"{words}, K over K_I, {accuracy}: error"
            value = partial(wings, name, accuracy)
            yield Row("compression30", quantity, 0.0, "independent code", "grown_K.csv", tolerance, value, "at most")
    for turn in (30.0, 45.0, 60.0):
        quantity = f"K over the flaw's K, turn of {turn:g} degrees, standard: error"
        source, value = "closed_kink_K.csv", partial(kinked, turn)
        yield Row("closed kinked crack", quantity, 0.0, "independent code", source, 0.005, value, "at most")
    for share, tolerance in ((0.9, 0.01), (1.0, 0.02)):
        quantity = f"K over the largest K, standard, {100 * share:g} % of the tips: error"
        value = partial(fifty_flaws, share)
        yield Row("random_flaws", quantity, 0.0, "independent code", "random_flaws_K.csv", tolerance, value, "at most")


ROWS = [*_rows()]
