"""Tips: K of closed ones, criteria met by those that advance, kinks in the path; from tips.csv."""

from __future__ import annotations

import numpy as np
import pandas as pd

from tests.stability.judge.written import Court, WrittenRun

K_I_CLOSED = 0.01
"""Of K_II, or of what a pressed crack of its length that stuck nowhere would have."""

STUCK = 0.01
"""K of a crack that sticks, of p sqrt(pi a)."""

BELOW_ZERO = 0.03
"""Of the larger K of the tip."""

LEAST_SLIP = 0.02
"""K_II, of p sqrt(pi a), below which a crack is taken to stick."""

LOCKED = 1e-6
"""Of what the pressure would open a crack by: the slip of a crack that has never slipped."""

MET, TIE = 1e-6, 6e-3
"""Of the strength: the most critical tip meets it; one that differs by less than a lattice resolves may advance."""

DEGREES = 1e-4


def judge_tips(court: Court) -> None:
    """All steps."""
    tips = court.run.tables["tips"]
    for step, rows in tips.groupby("step", sort=True):
        for _, tip in rows.iterrows():
            _closed(court, tip, int(step))
            _kinks(court, tip, int(step))
        if court.run.growth is not None:
            _advances(court, rows, int(step))


def _closed(court: Court, tip: pd.Series, step: int) -> None:
    """K of a tip whose crack is pressed together all along, and the sign of K_I of any."""
    run, name = court.run, tip["crack"]
    K_I, K_II = _K(tip)
    court.check("K without a number", 0.0 if np.isfinite([K_I, K_II]).all() else 1.0, 0.5, step, name)
    contact = run.tables["contact"]
    points = contact[(contact["step"] == step) & (contact["crack"] == name)]
    path, _ = run.path(name, step)
    half = 0.5 * float(np.hypot(*np.diff(path, axis=0).T).sum())
    pressure = float(-points["normal_traction"].min()) if len(points) else 0.0
    whole = pressure * np.sqrt(np.pi * half)
    error = float(tip["K_I_error"]) if "K_I_spread" in tip else 0.0  # without that column it is the spread
    if run.case["cracks"][name]["contact"] == "none":
        court.check("overlap without contact", -K_I / max(abs(K_I), abs(K_II)), BELOW_ZERO, step, name)
        return
    if max(abs(K_I), abs(K_II)) > LEAST_SLIP * whole:
        court.check("K_I below zero", -K_I / max(abs(K_I), abs(K_II)), BELOW_ZERO, step, name, error >= -K_I)
    if whole > 0.0 and (points["state"] != "open").all() and len(path) == 2 and _dilation(run, name) == 0.0:
        if (points["state"] == "stick").all():
            if float(points["mean_slip"].abs().max()) > LOCKED * pressure * half / run.softest:
                return  # slip of earlier loads is locked in
            both = error >= abs(K_I) and float(tip["K_II_error"]) >= abs(K_II)
            court.check("K of a stuck crack", np.hypot(K_I, K_II) / whole, STUCK, step, name, both)
        else:
            size = max(abs(K_II), LEAST_SLIP * whole)
            court.check("K_I of a closed straight tip", abs(K_I) / size, K_I_CLOSED, step, name, error >= abs(K_I))


def _dilation(run: WrittenRun, name: str) -> float:
    law = run.case["cracks"][name]["contact"]
    return float(law["dilation_angle"]) if isinstance(law, dict) else 0.0


def _K(tip: pd.Series) -> tuple[float, float]:
    """K_I and K_II to go by: from the faces where the integral finds no room."""
    found = (float(tip["K_I"]), float(tip["K_II"]))
    return found if np.isfinite(found).all() else (float(tip["K_I_faces"]), float(tip["K_II_faces"]))


def _kinks(court: Court, tip: pd.Series, step: int) -> None:
    """The kink that is told is that of the path."""
    run, name = court.run, tip["crack"]
    if run.growth is None or not tip["advanced"]:
        return
    events, following, at_end = run.meetings, step + 1, tip["tip"] == "end"
    met = ((events["step"] == following) & (events["crack"] == name) & (events["tip"] == tip["tip"])).any()
    points, _ = run.path(name, following)
    points = points if at_end else points[::-1]
    grown = len(run.path(name, step)[0]) < len(points) and np.allclose(points[-2], tip[["x", "y"]].astype(float))
    if met or run.growth["direction"] == "implicit" or not grown:
        return
    before, after = np.diff(points, axis=0)[-2:]
    turn = np.rad2deg(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after))
    court.check("kink of the path", abs(turn - tip["kink_deg"]), DEGREES, step, name)


def _advances(court: Court, rows: pd.DataFrame, step: int) -> None:
    """Who advances has met the criterion, and who has met it most advances, one or all of them."""
    run, growth = court.run, court.run.growth
    critical = run.case["loading"] == "critical"
    values = rows["criticality"].to_numpy(dtype=float)
    advanced = rows["advanced"].to_numpy(dtype=bool)
    for name, value in zip(rows["crack"][advanced], values[advanced], strict=True):
        if np.isfinite(value):
            court.check("advanced below its strength", 1.0 - value, TIE if critical else MET, step, name)
    grows = np.array([_can_grow(run, tip) for _, tip in rows.iterrows()])
    known = advanced.any() and np.isfinite(values[grows]).all()
    if known and critical:
        court.check("critical load that is not", abs(values[grows].max() - 1.0), MET, step)
    if growth["advance"] != "all":
        court.check("more than one advance", float(advanced.sum()), 1.0, step)
    if known and growth["advance"] == "all":
        left = np.where(grows & ~advanced, values, 0.0)
        court.check("critical but not advanced", float(left.max()) - 1.0, MET, step)
    if known and growth["advance"] == "most_critical":
        largest = float(np.where(grows, values, 0.0).max())
        court.check("not the most critical advanced", 1.0 - values[advanced].min() / largest, TIE, step)


def _can_grow(run: WrittenRun, tip: pd.Series) -> bool:
    """Whether the case lets a tip grow; one that has met something has no row."""
    tips = run.case["cracks"][tip["crack"]]["tips"]
    return tips in ("both", tip["tip"])
