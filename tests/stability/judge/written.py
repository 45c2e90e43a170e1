"""A run of the command line, and what it has written: all that a judge knows of it."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import dataclass
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
        """The rock of a body."""
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
