"""Forces and energies: reactions against loads, work against what it became; from reactions.csv and steps.csv."""

from __future__ import annotations

from typing import Any

import numpy as np

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
    run, before = court.run, 0.0
    goes_on = run.growth is None or not run.growth["unload_between_steps"]
    for _, row in run.tables["steps"].iterrows():
        work, strain, lost, released = (
            float(row[name]) for name in ("work", "strain_energy", "dissipation", "released_energy")
        )
        step, size = int(row["step"]), max(abs(work), float(strain), abs(lost))
        if size == 0.0:
            continue
        court.check("strain energy below zero", -strain / size, ENERGIES, step)
        court.check("energy balance", abs(work - strain - lost - released) / size, ENERGIES, step)
        court.check("dissipation falls", (before - lost) / size, ENERGIES, step)
        court.check("released energy below zero", -released / size, ENERGIES, step)
        before = lost if goes_on else 0.0
