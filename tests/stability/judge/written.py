"""A run of the command line, what it has written, which is all that a judge knows of it, and what is wrong with it."""

from __future__ import annotations

import contextlib
import io
import json
import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import shapely
import yaml

from crackgrow import cli

TABLES = ("contact", "events", "paths", "reactions", "steps", "tips")


@dataclass(frozen=True, slots=True, eq=False)
class WrittenRun:
    """What a run has left."""

    exit_code: int
    errors: str  # standard error
    case: dict[str, Any]  # case.yaml: SI, all defaults filled in; empty if there is none
    summary: dict[str, Any]
    tables: dict[str, pd.DataFrame]

    @property
    def growth(self) -> dict[str, Any] | None:
        """What the case says of growth."""
        return self.case.get("growth")

    @property
    def spacing(self) -> float:
        """m"""
        return float(self.case["numerics"]["spacing"])

    def warnings(self, step: int) -> list[tuple[str, str]]:
        """What the run has said up to a step: sentences, each with the places it is of, empty for the whole scene."""
        told = self.summary["cautions"]
        return [(record["words"], record["place"]) for record in told if record["steps"][0][0] <= step]

    def laws(self) -> dict[str, dict[str, float | str]]:
        """The laws of contact by the names that contact.csv has; cracks without contact are left out."""
        found = {name: crack["contact"] for name, crack in self.case["cracks"].items()}
        for interface in self.case["interfaces"]:
            found["/".join(interface["between"])] = interface["contact"]
        for support in self.case["supports"]:
            if "contact" in support:
                found[f"{support['on']['body']}.{support['on']['edge']}"] = support["contact"]
        return {name: law for name, law in found.items() if isinstance(law, dict)}

    @property
    def softest(self) -> float:
        """Pa: the least Young's modulus."""
        return min(float(body["material"]["young"]) for body in self.case["bodies"].values())

    @property
    def meetings(self) -> pd.DataFrame:
        """Events of tips that have met something, and of cracks that have started: they come of an advance."""
        events = self.tables["events"]
        return events[events["kind"].isin(["coalescence", "hole", "break_through", "interface", "initiation"])]

    def path(self, crack: str, step: int) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (n, 2) of a crack as it was in a step, and the steps (n,) that made them."""
        paths = self.tables["paths"]
        rows = paths[(paths["crack"] == crack) & (paths["step"] <= step)]
        return rows[["x", "y"]].to_numpy(), rows["step"].to_numpy()

    def region(self, body: str) -> shapely.Polygon:
        return region(self.case["bodies"][body]["shape"])


def region(shape: dict[str, Any]) -> shapely.Polygon:
    """What a shape encloses, less its holes."""
    holes = [ring(hole) for hole in shape.get("holes", [])]
    return ring(shape).difference(shapely.union_all(holes)) if holes else ring(shape)


def ring(shape: dict[str, Any]) -> shapely.Polygon:
    """What the outline of a shape encloses."""
    if "rectangle" in shape:
        (x, y), w, h = (shape["rectangle"][key] for key in ("center", "width", "height"))
        return shapely.box(x - w / 2, y - h / 2, x + w / 2, y + h / 2)
    if "disk" in shape:
        turns = np.deg2rad(np.arange(360.0))
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=1)
        return shapely.Polygon(np.array(shape["disk"]["center"]) + shape["disk"]["radius"] * circle)
    return shapely.Polygon(shape["polygon"])


def run_case(file: Path, folder: Path) -> WrittenRun:
    """Run a case by the command line into a folder."""
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors):
        code = cli.main(["run", str(file), "--out", str(folder), "--quiet"])
    return read_run(folder, code, errors.getvalue())


def read_run(folder: Path, exit_code: int, errors: str) -> WrittenRun:
    """What a run has left in its folder; of one that was refused nothing."""
    case, summary = folder / "case.yaml", folder / "summary.json"
    tables = {
        name: pd.read_csv(folder / f"{name}.csv", dtype={"crack": str})
        for name in TABLES
        if (folder / f"{name}.csv").is_file()
    }
    return WrittenRun(
        exit_code,
        errors,
        yaml.safe_load(case.read_text(encoding="utf-8")) if case.is_file() else {},
        json.loads(summary.read_text(encoding="utf-8")) if summary.is_file() else {},
        tables,
    )


_K = r"\bK\b|K_I"
TELLS = {
    "K_I of a closed straight tip": _K,
    "K of a stuck crack": _K,
    "K_I below zero": rf"{_K}|overlap",
    "energy balance": r"energ|balance",
    "dissipation falls": r"energ|dissipat",
    "released energy below zero": r"energ|releas",
    "reactions": r"balance|residual|ill conditioned|support",
    "moment": r"balance|residual|ill conditioned|support",
    "overlap without contact": r"contact: none",
    "critical load that is not": r"jumps",
}
"""Words of a warning that names such a departure; kinds without any have no excuse."""


@dataclass(frozen=True, slots=True)
class Departure:
    """Something that is not as it should be."""

    kind: str
    size: float  # relative, or degrees: see the check
    step: int
    place: str  # the crack or surface; empty: the scene
    told: bool


@dataclass(slots=True)
class Court:
    """Gathers what the checks of one run find."""

    run: WrittenRun
    departures: list[Departure] = field(default_factory=list)

    def check(self, kind: str, size: float, limit: float, step: int, place: str = "", stated: bool = False) -> None:
        """Hold one size against its limit; nan is beyond any. `stated`: the tables give an error as large."""
        if not size <= limit:
            size = float(size) if math.isfinite(size) else math.inf
            told = stated or self._told(kind, step, place)
            self.departures.append(Departure(kind, size, int(step), place, told))

    def _told(self, kind: str, step: int, place: str) -> bool:
        """Whether the run warns of such a departure, there or in the whole scene."""
        words = TELLS.get(kind)
        said = [where for text, where in self.run.warnings(step) if words and re.search(words, text)]
        return any(not where or not place or f"'{place}'" in where for where in said)
