"""Crack paths: inside the rock, not across each other, as long as steps.csv says; from paths.csv."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import shapely

from tests.stability.judge.written import Court, WrittenRun

BODY = "rock"
"""All cracks lie in it."""

SAME = 1e-6
"""Of the spacing."""

TURNED = 0.11
"""Of the increment: a segment that meets something is turned to it, and longer by as much at most."""


def judge_paths(court: Court) -> None:
    """The paths at the end, and the lengths in between."""
    run = court.run
    if run.tables["paths"].empty:
        return
    spacing, last = run.spacing, int(run.tables["paths"]["step"].max())
    names = list(run.tables["paths"]["crack"].unique())
    lines = {name: shapely.LineString(run.path(name, last)[0]) for name in names}
    rock = run.region(BODY)
    for name, line in lines.items():
        outside = shapely.hausdorff_distance(line, line.intersection(rock.buffer(SAME * spacing)))
        court.check("outside the rock", outside / spacing, 2.0 * SAME, last, name)
        court.check("crosses itself", 0.0 if _simple(line, spacing) else 1.0, 0.5, last, name)
        _segments(court, name, last)
    for pair in combinations(names, 2):
        court.check("cracks cross", _crossing(run, pair) / spacing, SAME, last, " ".join(pair))
    for _, row in run.tables["steps"].iterrows():
        length = _total_length(run, int(row["step"]))
        court.check("crack length", abs(length / row["crack_length"] - 1.0), SAME, int(row["step"]))
    solved = int(run.tables["steps"]["step"].max())
    said = run.summary["stop_reason"].startswith(f"step {last}:")
    court.check("an advance that steps.csv lacks", float(last > solved and not said), 0.5, last)


def _simple(line: shapely.LineString, spacing: float) -> bool:
    """Whether a path crosses itself nowhere; its ends may lie on it."""
    parts = [shapely.LineString(pair) for pair in zip(line.coords[:-1], line.coords[1:], strict=True)]
    ends = shapely.MultiPoint([line.coords[0], line.coords[-1]])
    for (i, a), (j, b) in combinations(enumerate(parts), 2):
        met = a.intersection(b)
        if j > i + 1 and not met.is_empty and met.distance(ends) > SAME * spacing:
            return False
    return True


def _crossing(run: WrittenRun, names: tuple[str, str]) -> float:
    """How far (m) from the ends of two cracks they meet where growth has made one of them."""
    (a, made_a), (b, made_b) = ((run.path(name, 10**9)) for name in names)
    ends, farthest = np.array([a[0], a[-1], b[0], b[-1]]), 0.0
    for i, j in np.ndindex(len(a) - 1, len(b) - 1):
        if max(*made_a[i : i + 2], *made_b[j : j + 2]):
            met = shapely.LineString(a[i : i + 2]).intersection(shapely.LineString(b[j : j + 2]))
            for place in shapely.get_coordinates(met):
                farthest = max(farthest, float(np.hypot(*(ends - place).T).min()))
    return farthest


def _segments(court: Court, name: str, last: int) -> None:
    """New segments are as long as the increment, but for those that have met something."""
    run = court.run
    points, steps = run.path(name, last)
    if run.growth is None:
        return
    events = run.meetings
    lengths = np.hypot(*np.diff(points, axis=0).T) / run.growth["increment"]
    for length, before, after in zip(lengths, steps[:-1], steps[1:], strict=True):
        made = max(before, after)
        if not made:
            continue
        tip = "end" if after > before else "start"
        here = (events["step"] == made) & (events["crack"] == name) & (events["tip"] == tip)
        met = bool(here.any())
        off = max(length - 1.0 - TURNED, 0.0) if met else abs(length - 1.0)
        court.check("increment", off, SAME, int(made), name)


def _total_length(run: WrittenRun, step: int) -> float:
    """Length (m) of all cracks as they were in a step."""
    names = run.tables["paths"]["crack"].unique()
    return float(sum(np.hypot(*np.diff(run.path(name, step)[0], axis=0).T).sum() for name in names))
