"""Checks of what a run has written: forces and energies; K, criteria and kinks of tips; contact by Coulomb's law."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import shapely

from tests.stability.judge.written import Court, WrittenRun

FORCES = 1e-6
"""Of the sum of the magnitudes of all forces."""

UNLOADED = 1e-9
"""Of that sum in any step before: all forces of a step with less are round-off."""

ENERGIES = 1e-4
"""Of the largest energy."""

SIDES = {"bottom": (0, -1), "top": (0, 1), "left": (-1, 0), "right": (1, 0)}


def judge_forces(court: Court) -> None:
    """Loads and reactions of every step leave nothing; a step without load, of rock in two, has none."""
    run, least = court.run, 0.0
    scaled, held = (_loads(run, which) for which in (False, True))
    for step, rows in run.tables["reactions"].groupby("step", sort=True):
        outer = rows[~rows["where"].str.contains("/")]
        forces = outer[["force_x", "force_y"]].to_numpy()
        factor = float(outer["load_factor"].iloc[0]) if len(outer) else 0.0
        loads = [(share * force, place) for share, some in ((factor, scaled), (1.0, held)) for force, place in some]
        size = sum(np.hypot(*force) for force, _ in loads) + np.hypot(*forces.T).sum() + _within(run)
        least = max(least, UNLOADED * size)
        if size <= least:
            continue
        left = sum((force for force, _ in loads), start=forces.sum(axis=0))
        court.check("reactions", float(np.abs(left).max()) / size, FORCES, int(step))
        places = [_place(run, where) for where in outer["where"]]
        if all(place is not None for place in places) and all(place is not None for _, place in loads):
            turning = [*loads, *zip(forces, places, strict=True)]
            middle = np.mean([place for _, place in turning], axis=0)
            arms = [place - middle for _, place in turning]
            moment = sum(a[0] * f[1] - a[1] * f[0] for a, (f, _) in zip(arms, turning, strict=True))
            reach = max(np.hypot(*arm) for arm in arms)
            court.check("moment", abs(moment) / (size * reach), FORCES, int(step))


def _place(run: WrittenRun, where: str) -> np.ndarray | None:
    """Where a support at a point stands; None for others."""
    if not where.startswith("supports."):
        return None
    at = run.case["supports"][int(where.split(".")[1])].get("at")
    return None if at is None else np.array(at)


def _loads(run: WrittenRun, held: bool) -> list[tuple[np.ndarray, np.ndarray | None]]:
    """Forces (2,) N/m of the loads at a load factor of 1, each with its place; stress and pressure have none."""
    found = []
    for load in run.case["loads"]:
        if load["held"] != held:
            continue
        if "gravity" in load:
            region = run.region(load["body"])
            mass = run.case["bodies"][load["body"]]["material"]["density"] * region.area
            found.append((mass * np.array(load["gravity"]), np.array(region.centroid.coords[0])))
        elif "traction" in load:
            length, place = _edge(run, load["on"])
            found.append((length * np.array(load["traction"]), place))
    return found


def _within(run: WrittenRun) -> float:
    """N/m: what in-situ stress carries across the bodies, and balances in each."""
    stresses = [(load["body"], load["stress"]) for load in run.case["loads"] if "stress" in load]
    return sum(float(np.abs(stress).max() * np.sqrt(run.region(body).area)) for body, stress in stresses)


def _edge(run: WrittenRun, on: dict[str, Any]) -> tuple[float, np.ndarray]:
    """Length and middle of a whole side of a rectangle or a polygon, or of a part of a disk's arc."""
    shape = run.case["bodies"][on["body"]]["shape"]
    if "polygon" in shape:
        first, second = np.roll(shape["polygon"], -int(on["edge"]), axis=0)[:2]
        return float(np.hypot(*(second - first))), 0.5 * (first + second)
    if "disk" in shape:
        radius, (start, end) = shape["disk"]["radius"], (on["from"], on["to"])
        length = 2.0 * radius * np.sin(np.deg2rad(0.5)) * (end - start)
        turn = np.deg2rad(0.5 * (start + end))
        arm = np.sinc((end - start) / 360.0) * radius * np.array([np.cos(turn), np.sin(turn)])
        return length, np.array(shape["disk"]["center"]) + arm
    side = np.array(SIDES[on["edge"]])
    size = np.array([shape["rectangle"]["width"], shape["rectangle"]["height"]])
    return float(size[1 - np.flatnonzero(side)[0]]), np.array(shape["rectangle"]["center"]) + 0.5 * side * size


def judge_energies(court: Court) -> None:
    """Work is stored, dissipated or released; friction and growth never give energy back."""
    run, before, size = court.run, 0.0, 0.0
    goes_on = run.growth is None or not run.growth["unload_between_steps"]
    for _, row in run.tables["steps"].iterrows():
        work, strain, lost, released = (
            float(row[name]) for name in ("work", "strain_energy", "dissipation", "released_energy")
        )
        step, size = int(row["step"]), max(size, abs(work), float(strain), abs(lost))  # round-off is of all before
        if size == 0.0:
            continue
        court.check("strain energy below zero", -strain / size, ENERGIES, step)
        court.check("energy balance", abs(work - strain - lost - released) / size, ENERGIES, step)
        court.check("dissipation falls", (before - lost) / size, ENERGIES, step)
        court.check("released energy below zero", -released / size, ENERGIES, step)
        before = lost if goes_on else 0.0


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


ROUND_OFF = 1e-7
"""Of the largest traction of a step."""

NO_LOAD = 1e-9
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
    least = NO_LOAD * max(np.abs(tractions.to_numpy()).max(initial=0.0), np.abs(forces).max(initial=0.0) / across)
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
