"""Contact points against Coulomb's law: signs, bounds of friction, gaps; from contact.csv and case.yaml."""

from __future__ import annotations

import numpy as np
import pandas as pd
import shapely

from tests.stability.judge.written import Court, WrittenRun

ROUND_OFF = 1e-7
"""Of the largest traction of a step."""

UNLOADED = 1e-9
"""Of the largest traction of a run, or the mean stress that its supports have borne: a step with less has no load, and
its tractions are round-off."""


ON_AVERAGE = 1e-7
"""Of the largest jump of a surface: what the averages may be off."""


NO_JUMP = 0.1
"""Of what the largest pressure on any surface would open a crack of this length by: a surface whose jump is smaller is
held against that."""

GIVEN_WAY = 0.6
"""The same of what the rock of a spacing gives way to that pressure."""

ON_PATH = 1e-6
"""Spacings: a point so close to the crack as it was given lies on its given faces."""


def judge_contact(court: Court) -> None:
    """All steps and surfaces."""
    run = court.run
    tractions = run.tables["contact"][["normal_traction", "tangential_traction"]]
    forces = run.tables["reactions"][["force_x", "force_y"]].to_numpy()
    across = np.sqrt(sum(run.region(body).area for body in run.case["bodies"]))
    least = UNLOADED * max(np.abs(tractions.to_numpy()).max(initial=0.0), np.abs(forces).max(initial=0.0) / across)
    for step, rows in run.tables["contact"].groupby("step", sort=True):
        size = float(np.abs(rows[tractions.columns].to_numpy()).max())
        size = 0.0 if size <= least else size
        for name, law in run.laws().items():
            points = rows[rows["crack"] == name]
            if len(points) and size > 0.0:
                largest = _size(court.run, points, float(-rows["normal_traction"].min()))
                _bounds(court, points, law, size, name, int(step))
                if largest > 0.0:
                    _averages(court, points, law, largest, name, int(step))


def _bounds(court: Court, points: pd.DataFrame, law: dict, size: float, name: str, step: int) -> None:
    """Pressure alone, and the shear that the law allows: all of it where a point slips, none where it is open."""
    normal, shear = (points[f"{which}_traction"].to_numpy() for which in ("normal", "tangential"))
    state, shear = points["state"].to_numpy(), np.abs(shear)
    court.check("tension across faces", float(normal.max()) / size, ROUND_OFF, step, name)
    given = _given(court.run, points, name)
    mu, after = law["friction"], law["residual_friction"]
    kept = law["cohesion"] if law["cohesion_after_slip"] == "kept" else 0.0
    fresh = np.where(given, law["cohesion"] - mu * normal, -max(mu, after) * normal)
    court.check("shear beyond friction", float((shear - fresh).max()) / size, ROUND_OFF, step, name)
    pressed = (state == "slip") & (normal < -ROUND_OFF * size)
    if pressed.any():
        bounds = np.stack([np.where(given, c, 0.0) - after * normal for c in (kept, 0.0)])
        off = np.abs(shear - bounds).min(axis=0)[pressed]
        court.check("slip below friction", float(off.max()) / size, ROUND_OFF, step, name)
    apart = state == "open"
    if apart.any():
        loaded = np.hypot(normal, shear)[apart]
        court.check("traction on open faces", float(loaded.max()) / size, ROUND_OFF, step, name)


def _given(run: WrittenRun, points: pd.DataFrame, name: str) -> np.ndarray:
    """Which points lie on faces that the case gives; the others growth has made, which have no cohesion."""
    if name not in run.case["cracks"]:
        return np.ones(len(points), dtype=bool)
    line = shapely.LineString(run.case["cracks"][name]["path"]["points"])
    return shapely.dwithin(shapely.points(points[["x", "y"]].to_numpy()), line, ON_PATH * run.spacing)


def _averages(court: Court, points: pd.DataFrame, law: dict, largest: float, name: str, step: int) -> None:
    """The law itself: nowhere overlap, and under pressure no gap but what dilation opens."""
    gap, slip = points["mean_opening"].to_numpy(), points["mean_slip"].to_numpy()
    court.check("average overlap", float((-gap).max()) / largest, ON_AVERAGE, step, name)
    closed = points["state"].to_numpy() != "open"
    if closed.any():
        risen = (gap - np.abs(slip) * np.tan(np.deg2rad(law["dilation_angle"])))[closed]
        court.check("average gap under pressure", float(np.abs(risen).max()) / largest, ON_AVERAGE, step, name)


def _size(run: WrittenRun, points: pd.DataFrame, pressure: float) -> float:
    """The jump (m) that others of a surface are held against; `pressure` (Pa) is the largest of the step."""
    length = float(np.ptp(points["s"])) + run.spacing
    by_pressure = (NO_JUMP * 2.0 * length, GIVEN_WAY * run.spacing)
    return max(float(np.hypot(points["opening"], points["slip"]).max()), max(by_pressure) * pressure / run.softest)
