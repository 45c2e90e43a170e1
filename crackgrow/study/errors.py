"""Errors of a run's results against those of a reference: K, contact, energy, crack paths. Both are result folders.

K, contact and energy are those of the first step of growth, where both have the same cracks; without growth, of the
last load factor. A measure that a scene does not have is nan.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import PchipInterpolator

from crackgrow.arrays import Floats
from crackgrow.results.folder import RunFolder
from crackgrow.study.compare import compared_growth

if TYPE_CHECKING:
    import pandas as pd

ERRORS = (
    "K_error", "K_II_error", "pressure_error", "shear_error", "slip_error", "energy_error",
    "path_hausdorff", "path_frechet", "length_error",
)  # fmt: skip
"""Columns of the table, in the order of `errors_of`; paths as far as both have grown."""

NEGLIGIBLE = 1e-3  # of the largest K, slip or traction: a part of the reference below it has no relative error

SAME_PLACE = 1e-9  # of a surface's length: less than contact points are apart


def errors_of(run: Path, reference: Path, *, grows: bool) -> dict[str, float]:
    """The errors of a result folder against another, by column; `grows`: whether the case has growth."""
    both = RunFolder(run), RunFolder(reference)
    tips, contacts, steps = (
        [_judged(table, grows) for table in tables]
        for tables in ([one.tips for one in both], [one.contact for one in both], [one.steps for one in both])
    )
    mine, true = (float(table["strain_energy"].iloc[0]) for table in steps)
    energy = abs(mine - true) / abs(true) if true else math.nan
    pairs = compared_growth(run, reference)
    common = [pair.common for pair in pairs if pair.common is not None]
    hausdorff = max((deviation.hausdorff for deviation in common), default=math.nan)
    frechet = max((deviation.frechet for deviation in common), default=math.nan)
    lengths = max((abs(pair.length_a - pair.length_b) for pair in pairs), default=math.nan)
    values = *K_errors(*tips), *contact_errors(*contacts), energy, hausdorff, frechet, lengths
    return dict(zip(ERRORS, values, strict=True))


def _judged(table: pd.DataFrame, grows: bool) -> pd.DataFrame:
    """The rows of a table at the step that is judged."""
    return table[table["step"] == (0 if grows or table.empty else table["step"].iloc[-1])]


def K_errors(mine: pd.DataFrame, true: pd.DataFrame) -> tuple[float, float]:
    """Relative errors of K and of K_II over all tips that both have."""
    both = mine.merge(true, on=["crack", "tip"], suffixes=("", "_true"))
    if both.empty:
        return math.nan, math.nan
    known = both[["K_I_true", "K_II_true"]].to_numpy()
    off, size = both[["K_I", "K_II"]].to_numpy() - known, np.hypot(*known.T).max()
    size_II = np.abs(known[:, 1]).max()
    K_error = float(np.hypot(*off.T).max() / size) if size > 0 else math.nan
    return K_error, float(np.abs(off[:, 1]).max() / size_II) if size_II > NEGLIGIBLE * size else math.nan


def contact_errors(mine: pd.DataFrame, true: pd.DataFrame) -> tuple[float, float, float]:
    """Relative L2 errors of pressure, shear and slip along all faces in contact that both have.

    The reference is interpolated at the run's own contact points, so that nothing is said of what lies between them.
    """
    off, size = np.zeros(3), np.zeros(3)
    for surface, points in mine.groupby("crack", sort=False):
        known = true[true["crack"] == surface]
        if len(known):
            (s, values), (s_true, values_true) = _along(points), _along(known)
            expected = _interpolated(s, s_true, values_true)
            weights = _lengths(s)
            off += weights @ (values - expected) ** 2
            size += weights @ expected**2
    tractions = size[0] + size[1]
    if tractions == 0.0:
        return math.nan, math.nan, math.nan
    pressure, shear = np.sqrt(off[:2] / tractions)
    return float(pressure), float(shear), float(np.sqrt(off[2] / size[2])) if size[2] > 0.0 else math.nan


def _along(points: pd.DataFrame) -> tuple[Floats, Floats]:
    """Arc lengths (n,) m of a surface's contact points, ascending, and pressure, shear, slip (n, 3) there."""
    table = points[["s", "normal_traction", "tangential_traction", "slip"]].to_numpy()
    table = table[np.argsort(table[:, 0], kind="stable")]
    return table[:, 0], table[:, 1:]


def _interpolated(s: Floats, s_known: Floats, values: Floats) -> Floats:
    """Values (n, k) at places (n,) between known ones, cubic and monotone; constant beyond the first and the last.

    At a kink of the surface two known points lie at one place, one for each side: values jump there, and each side goes
    by its own. So does the second of two of the places that lie there.
    """
    near = SAME_PLACE * s_known[-1]
    doubled = np.flatnonzero(np.diff(s_known) <= near)
    kinks = s_known[doubled]
    second = np.diff(s, prepend=-np.inf) <= near
    side = np.searchsorted(kinks + near, s)
    side += second & (np.abs(s - np.append(kinks, np.inf)[side]) <= near)
    expected = np.empty((len(s), values.shape[1]))
    for number, part in enumerate(np.split(np.arange(len(s_known)), doubled + 1)):
        mine = np.flatnonzero(side == number)
        if len(part) == 1:
            expected[mine] = values[part]
        else:
            known = s_known[part]
            expected[mine] = PchipInterpolator(known, values[part])(np.clip(s[mine], known[0], known[-1]))
    return expected


def _lengths(s: Floats) -> Floats:
    """The length (n,) that each of the ascending places stands for; 1 for a single one."""
    if len(s) == 1:
        return np.ones(1)
    middle = (s[1:] + s[:-1]) / 2
    return np.diff(np.concatenate([[s[0]], middle, [s[-1]]]))
