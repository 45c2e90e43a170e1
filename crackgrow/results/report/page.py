"""The page: what its template, `page.html`, shows of a run, how good that is, and the file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, Final

import numpy as np
from jinja2 import Environment

from crackgrow.case.model import Case
from crackgrow.results.atomic import write_text
from crackgrow.results.declarations import STEPS
from crackgrow.results.drawing import scene_svg, step_colour
from crackgrow.results.folder import REPORT, RunFolder, open_run
from crackgrow.results.report.charts import charts
from crackgrow.results.report.step_data import contact_data, event_rows, pictures, step_words, tip_data
from crackgrow.results.units import counted, cut, shown
from crackgrow.run.result import CHECK_LIMITS

SHOWN_WARNINGS: Final = 200  # of more the first ones are shown
NUMBER: Final = re.compile(r"-?\d+\.\d+(e[-+]?\d+)?")

ESTIMATES: Final = {
    "K_percent_expected": "K, error that is expected, over the largest K of its step [%]",
    "K_percent_at_most": "K, error at most, over the largest K of its step [%]",
    "K_spread_percent": "spread of K over discs of its integral, not its error [%]",
    "kink_degrees_at_most": "directions of growth, at most [°]",
    "load_factor_percent_at_most": "critical load factors, at most [%]",
    "goal_percent_at_most": "numerics.goal, at most, over its largest value [%]",
}
"""Numbers of the summary in words."""


def write_report(folder: Path, case: Case | None = None) -> Path:
    """Write the report of the run in `folder` beside its files, and return where it is; `case` is its, if it is there.

    Raises FolderError where the folder has no results, CaseError where its case is not of this version, OutputError.
    """
    path = folder / REPORT
    run = open_run(folder)
    if case is not None:
        run.case = case
    write_text(path, page(run))
    return path


def page(run: RunFolder) -> str:
    """The report as HTML; whatever comes from a case is escaped."""
    data: dict[str, Any] = {
        "places": run.places,
        "words": step_words(run),
        "tips": tip_data(run),
        "contact": contact_data(run),
        "charts": charts(run),
        "pictures": pictures(run),
    }
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters |= {"shown": shown, "counted": counted}
    return environment.from_string(_own_file("page.html")).render(
        file=_own_file,
        run=run,
        summary=run.summary,
        scene=scene_svg(run, data["tips"]["steps"]),
        last_made=int(run.table("paths").steps().max(initial=0)),
        ramp=", ".join(step_colour(step, 9) for step in range(1, 10)),
        checks=check_rows(run),
        estimates=estimate_rows(run.summary),
        warnings=cut(run.summary["warnings"], SHOWN_WARNINGS, "and {} more, see summary.json"),
        events=event_rows(run.table("events")) if len(run.table("events")) else None,
        actions=describe_actions(run.case),
        data=data,
        # no text in the data can end the element of the page's scripts
        json=json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )


def _own_file(name: str) -> str:
    return files("crackgrow.results.report").joinpath(name).read_text(encoding="utf-8")


def check_rows(run: RunFolder) -> list[tuple[str, str, int, str, bool]]:
    """What is checked in each step: its meaning, worst value, step of that, limit, and whether it is below."""
    rows = []
    meanings = {column.name: column.doc for column in STEPS.columns}
    for name, limit in CHECK_LIMITS.items() if run.solved else ():
        values, words = np.abs(run.table("steps").numbers(name)), meanings[name]
        if name == "penetration":
            words += ", by the largest jump of its step"
            contact = run.table("contact")
            jumps = np.zeros(len(values))
            sizes = np.hypot(contact.numbers("opening"), contact.numbers("slip"))
            np.maximum.at(jumps, np.searchsorted(run.solved, contact.steps()), sizes)
            values = np.divide(values, jumps, out=np.zeros_like(values), where=jumps > 0.0)
        worst = int(np.argmax(np.where(np.isnan(values), np.inf, values)))
        rows.append((words, shown(values[worst], 3), run.solved[worst], f"{limit:g}", bool(values[worst] <= limit)))
    return rows


def estimate_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the run estimates of its own error, the worst of all steps: any numbers that the summary has."""
    found: dict[str, Any] = dict(summary.get("error_estimate") or {})
    norm = found.pop("energy_norm_percent", None) or {}
    values = {f"energy norm, {which} step [%]": value for which, value in norm.items()}
    values |= {ESTIMATES.get(name, name): found[name] for name in found}
    return [(name, shown(value)) for name, value in values.items() if isinstance(value, int | float)]


def describe_actions(case: Case) -> list[tuple[str, str]]:
    """What holds and what loads the specimen, in words: name, and what the case says of it, in SI."""
    told, rows = case.to_dict(), []
    for kind in ("supports", "loads"):
        items = told[kind]
        assert isinstance(items, list)
        for number, item in enumerate(items):
            text = json.dumps(item, ensure_ascii=False)[1:-1].replace('"', "")
            rows.append((f"{kind}.{number}", NUMBER.sub(lambda found: f"{float(found[0]):.12g}", text)))
    return rows
