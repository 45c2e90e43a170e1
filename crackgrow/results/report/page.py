"""The page: what its template, `page.html`, shows of a run, how good that is, and the file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment
from markupsafe import Markup, escape

from crackgrow.arrays import Floats
from crackgrow.case.dump import written
from crackgrow.case.model import Case
from crackgrow.case.units import Coordinate
from crackgrow.results.atomic import write_text
from crackgrow.results.drawing import scene_svg, step_colour
from crackgrow.results.folder import REPORT, RunFolder, open_run
from crackgrow.results.report.charts import charts
from crackgrow.results.report.step_data import contact_data, event_rows, pictures, step_words, tip_data
from crackgrow.results.units import counted, cut, shown
from crackgrow.run.result import CHECK_LIMITS

SHOWN_WARNINGS = 200  # of more the first ones are shown
SHORT = 12  # characters of a cell that is not broken

WHAT = {
    "residual": "equilibrium residual",
    "penetration": "penetration at contact points, by the step's largest jump",
    "complementarity": "complementarity of contact",
    "overlap_share": "overlap anywhere along the faces, by what is small beside jump and displacement",
    "energy_error": "error of the energy balance",
}

ESTIMATES = {
    "energy_norm_percent, first": "energy norm, first step [%]",
    "energy_norm_percent, last": "energy norm, last step [%]",
    "K_percent_expected": "K, error that is expected, over the largest K of its step [%]",
    "K_percent_at_most": "K, error at most, over the largest K of its step [%]",
    "K_spread_percent": "spread of K over discs of its integral, not its error [%]",
    "kink_degrees_at_most": "directions of growth, at most [°]",
    "load_factor_percent_at_most": "critical load factors, at most [%]",
    "goal_percent_at_most": "numerics.goal, at most, over its largest value [%]",
}
"""Numbers of the summary in the order of the table, in words."""


def tag(name: str, *content: object, **attributes: object) -> Markup:
    """An element; `_` in the name of an attribute is a dash, at the end of it nothing; None leaves it out."""
    given = {key.rstrip("_").replace("_", "-"): value for key, value in attributes.items() if value is not None}
    words = Markup("").join(Markup(' {}="{}"').format(key, value) for key, value in given.items())
    return Markup("<{0}{1}>{2}</{0}>").format(Markup(name), words, Markup("").join(map(escape, content)))


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
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(_own_file("page.html"))
    return template.render(
        SHORT=SHORT,
        file=_own_file,
        run=run,
        summary=run.summary,
        badge=status_badge(run.summary["status"]),
        facts=_facts(run),
        scene=scene_svg(run, data["tips"]["steps"]),
        legend=Markup("; ").join(_legend(run)),
        checks=list(check_rows(run)),
        estimates=estimate_rows(run.summary),
        phases=_phase_rows(run.summary),
        warnings=cut(run.summary["warnings"], SHOWN_WARNINGS, "and {} more, see summary.json"),
        events=event_rows(run.table("events")) if len(run.table("events")) else None,
        actions=describe_actions(run.case),
        data=data,
        json=_in_script(data),
    )


def _own_file(name: str) -> str:
    return files("crackgrow.results.report").joinpath(name).read_text(encoding="utf-8")


def _in_script(data: object) -> str:
    """Data for the scripts of the page; no text in it can end their element."""
    return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _legend(run: RunFolder) -> Iterator[str]:
    """What the lines of the scene mean, those that are there."""
    last = int(run.table("paths").steps().max(initial=0))
    if run.case.cracks:
        yield "black: the given cracks"
    if last:
        colours = ", ".join(step_colour(step, 9) for step in range(1, 10))
        ramp = tag("span", class_="ramp", style=f"background: linear-gradient(to right, {colours})")
        yield Markup("grown in step 1 {} {}").format(ramp, last)
    if len(run.table("tips")):
        yield "circles: tips, filled where they advance"
    if run.case.interfaces:
        yield "violet: interfaces, dashed unless bonded"


def _facts(run: RunFolder) -> list[str]:
    summary = run.summary
    n_dofs = summary["n_dofs"]
    commit, modified = summary["git_commit"], ", modified" if summary["git_modified"] else ""  # None where installed
    return [
        f"crackgrow {summary['version']}{f' ({commit[:12]}{modified})' if commit else ''}",
        f"plane {run.case.plane}",
        counted(summary["n_solves"], "solved step"),
        f"{' to '.join(dict.fromkeys(str(n) for n in n_dofs.values()))} unknowns" if n_dofs else "nothing solved",
        f"{shown(summary['wall_seconds']['total'], 3)} s, {summary['peak_memory_mb']:.0f} MB",
    ]


def _phase_rows(summary: dict[str, Any]) -> list[tuple[object, ...]]:
    """Seconds by phase, and what none of them counts, with bars."""
    seconds = summary["wall_seconds"]
    phases = dict(seconds["by_phase"])
    phases["other"] = max(seconds["total"] - sum(phases.values()), 0.0)
    longest = max(phases.values()) or 1.0
    return [
        (phase, shown(value, 3), tag("div", class_="bar", style=f"width: {100 * value / longest:.1f}%"))
        for phase, value in phases.items()
    ]


def check_rows(run: RunFolder) -> Iterator[tuple[object, ...]]:
    """Rows of the table of checks: name, worst value, step, limit, verdict."""
    jumps = _largest_jumps(run)
    for name, words in WHAT.items():
        values = np.abs(run.table("steps").numbers(name))
        if name == "penetration":
            values = np.divide(values, jumps, out=np.zeros_like(values), where=jumps > 0.0)
        if len(values) == 0:
            continue
        worst = int(np.argmax(np.where(np.isnan(values), np.inf, values)))
        good = bool(values[worst] <= CHECK_LIMITS[name])
        verdict = tag("span", "ok" if good else "above the limit", class_="good" if good else "bad")
        yield words, shown(float(values[worst]), 3), run.solved[worst], f"{CHECK_LIMITS[name]:g}", verdict


def estimate_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Rows of what the run estimates of its own error, the worst of all steps: any values that the summary has."""
    known = dict(_flat(summary.get("error_estimate") or {}, ""))
    order = [*(name for name in ESTIMATES if name in known), *(name for name in known if name not in ESTIMATES)]
    return [(ESTIMATES.get(name, name), known[name]) for name in order]


def _flat(values: dict[str, Any], before: str) -> Iterator[tuple[str, str]]:
    for key, value in values.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{key}, ")
        elif value is not None:
            yield f"{before}{key}", value if isinstance(value, str) else shown(value)


def _largest_jumps(run: RunFolder) -> Floats:
    """Largest jump (m) at the contact points of each solved step; 0 where there are none."""
    contact = run.table("contact")
    steps = contact.steps()
    sizes = np.hypot(contact.numbers("opening"), contact.numbers("slip"))
    largest = np.zeros(len(run.solved))
    np.maximum.at(largest, np.searchsorted(run.solved, steps), sizes)
    return largest


def status_badge(status: str) -> Markup:
    """How the run ended, in a word."""
    kind = {"failed": "bad", "interrupted": "doubtful", "running": "doubtful"}.get(status, "good")
    return tag("strong", status, class_=f"badge {kind}")


def describe_actions(case: Case) -> list[tuple[str, str]]:
    """What holds and what loads the specimen, in words: name, and what the case says of it, in SI."""
    rows: list[tuple[str, str]] = []
    for kind in ("supports", "loads"):
        rows.extend((f"{kind}.{number}", _words(item)) for number, item in enumerate(written(case)[kind]))
    return rows


def _words(item: dict[str, object]) -> str:
    return ", ".join(f"{key}: {_value(value)}" for key, value in item.items())


def _value(value: object) -> str:
    if isinstance(value, dict):
        return "{" + _words(value) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(inner) for inner in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Coordinate):
        return value.text
    return f"{value:g}" if isinstance(value, float) else str(value)
