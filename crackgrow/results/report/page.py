"""The page: what its template, `page.html`, shows of a run, and the file."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment

from crackgrow.results.atomic import write_text
from crackgrow.results.folder import REPORT, RunFolder, open_run
from crackgrow.results.report.charts import charts
from crackgrow.results.report.checks import check_rows, estimate_rows, status_badge
from crackgrow.results.report.scene import describe_actions, draw_scene, step_colour, tag, view_of
from crackgrow.results.report.step_data import contact_data, event_rows, pictures, step_words, tip_data
from crackgrow.results.units import counted, shown

SHOWN_WARNINGS = 200  # of more the first ones are shown
SHORT = 12  # characters of a cell that is not broken


def write_report(folder: Path) -> Path:
    """Write the report of the run in `folder` beside its files, and return where it is.

    Raises FolderError where the folder has no results, CaseError where its case is not of this version, OutputError.
    """
    path = folder / REPORT
    write_text(path, page(open_run(folder)))
    return path


def page(run: RunFolder) -> str:
    """The report as HTML; whatever comes from a case is escaped."""
    data = {
        "places": run.places,
        "words": step_words(run),
        "tips": tip_data(run, view_of(run.case)),
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
        scene=draw_scene(run),
        n_steps=int(run.table("paths").steps().max(initial=0)),
        colours=", ".join(step_colour(step, 9) for step in range(1, 10)),
        checks=list(check_rows(run)),
        estimates=estimate_rows(run.summary),
        phases=_phase_rows(run.summary),
        warnings=_warnings(run.summary["warnings"]),
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


def _warnings(warnings: list[str]) -> list[str]:
    more = len(warnings) - SHOWN_WARNINGS
    return [*warnings[:SHOWN_WARNINGS], *([f"and {more} more, see summary.json"] if more > 0 else [])]
