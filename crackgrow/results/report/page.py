"""The page: its parts in order, and the file."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from crackgrow.results.atomic import write_text
from crackgrow.results.folder import REPORT, RunFolder, open_run
from crackgrow.results.report.charts import charts
from crackgrow.results.report.checks import check_rows, estimate_rows, status_badge
from crackgrow.results.report.markup import Markup, join, json_script, table, tag, text
from crackgrow.results.report.pictures import pictures
from crackgrow.results.report.scene import describe_actions, draw_scene, step_colour, view_of
from crackgrow.results.report.step_data import contact_data, event_rows, step_words, tip_data
from crackgrow.results.units import counted, shown

SHOWN_WARNINGS = 200  # of more the first ones are shown

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
script-src 'unsafe-inline'">
<title>$title</title>
<style>
$style
</style>
</head>
<body>
$body
$data
<script>
$script
</script>
</body>
</html>
""")


def write_report(folder: Path) -> Path:
    """Write the report of the run in `folder` beside its files, and return where it is.

    Raises FolderError where the folder has no results, CaseError where its case is not of this version, OutputError.
    """
    path = folder / REPORT
    write_text(path, page(open_run(folder)))
    return path


def page(run: RunFolder) -> str:
    """The report as HTML."""
    contact = contact_data(run)
    shots = pictures(run)
    plots = charts(run)
    data = {
        "places": run.places,
        "words": step_words(run),
        "tips": tip_data(run, view_of(run.case)),
        "contact": contact,
        "charts": plots,
        "pictures": shots,
    }
    body = join(
        [
            _header(run),
            tag("noscript", tag("p", "Without JavaScript this page shows the end of the run, and no plots.")),
            _slider(run),
            tag("main", _steps(run, contact, shots), _plots(plots), _quality(run), _settings(run)),
        ],
        "\n",
    )
    return PAGE.substitute(
        title=text(f"{run.summary['case']}: {run.summary['title']}"),
        style=_own_file("page.css"),
        body=body,
        data=json_script(data),
        script=_own_file("chart.js") + _own_file("page.js"),
    )


def _own_file(name: str) -> str:
    return files("crackgrow.results.report").joinpath(name).read_text(encoding="utf-8")


def _header(run: RunFolder) -> Markup:
    summary = run.summary
    n_dofs = summary["n_dofs"]
    commit, modified = summary["git_commit"], ", modified" if summary["git_modified"] else ""  # None where installed
    facts = [
        f"crackgrow {summary['version']}{f' ({commit[:12]}{modified})' if commit else ''}",
        f"plane {run.case.plane}",
        counted(summary["n_solves"], "solved step"),
        f"{' to '.join(dict.fromkeys(str(n) for n in n_dofs.values()))} unknowns" if n_dofs else "nothing solved",
        f"{shown(summary['wall_seconds']['total'], 3)} s, {summary['peak_memory_mb']:.0f} MB",
    ]
    return tag(
        "header",
        tag("h1", summary["title"]),
        tag("p", status_badge(summary["status"]), " ", summary["stop_reason"], class_="status"),
        tag("p", join(facts, " · "), class_="facts"),
        tag("p", run.case.source, class_="facts"),
    )


def _slider(run: RunFolder) -> Markup:
    """Play button, slider and what they stand at; nothing where there is but one step."""
    last = len(run.places) - 1
    if last == 0:
        return Markup("")
    return tag(
        "div",
        tag("button", "Play", id="play", type="button"),
        tag("label", "Step", for_="step"),
        Markup(f'<input id="step" type="range" min="0" max="{last}" value="{last}" step="1">'),
        tag("output", id="now", for_="step", aria_live="polite"),
        class_="controls",
        role="group",
        aria_label="step shown",
    )


def _steps(run: RunFolder, contact: dict[str, Any], shots: list[dict[str, Any]]) -> Markup:
    """What moves with the slider: the scene, pictures, tractions, tips."""
    cards = [_card("Scene and cracks", draw_scene(run), _step_legend(run))]
    if shots:
        picture = tag("div", Markup('<img id="picture" alt="">'), class_="scroll")
        larger = tag("button", "Larger", id="larger", type="button", aria_pressed="false")
        cards.append(_card("Picture", tag("figure", picture, tag("figcaption", id="caption")), larger))
    if contact["surfaces"]:
        choice = tag("select", *(tag("option", name) for name in contact["surfaces"]), id="surface")
        label = tag("label", "Surface ", choice)
        left_out = tag("p", "Some steps are left out to keep the page small.") if contact["left_out"] else ""
        cards.append(_card("Along the faces", label, tag("div", id="contact"), left_out))
    if len(run.table("tips")):
        tips = tag(
            "table", tag("caption", id="tips-caption"), tag("thead", id="tips-head"), tag("tbody", id="tips-body")
        )
        box = tag("div", tips, class_="scroll tall", tabindex="0", role="region", aria_label="tips of the step")
        cards.append(_card("Tips", box, wide=True))
    return tag("section", *cards, class_="cards steps", aria_label="step by step")


def _step_legend(run: RunFolder) -> Markup:
    last = int(run.table("paths").steps().max(initial=0))
    if last == 0:
        return tag("p", "black: the given cracks" if run.case.cracks else "dashed: interfaces", class_="legend")
    colours = ", ".join(step_colour(step, 9) for step in range(1, 10))
    bar = tag("span", class_="ramp", style=f"background: linear-gradient(to right, {colours})")
    words = "black: the given cracks; grown in step 1 ", bar, f" {last}; circles: tips, filled where they advance"
    return tag("p", *words, class_="legend")


def _plots(plots: list[dict[str, Any]]) -> Markup:
    if not plots:
        return Markup("")
    cards = [_card(chart["title"], tag("div", class_="chart", id=f"chart-{k}")) for k, chart in enumerate(plots)]
    return tag("section", *cards, class_="cards", aria_label="plots")


def _quality(run: RunFolder) -> Markup:
    """Checks, estimated errors, warnings, events, time."""
    summary = run.summary
    cards = []
    rows = list(check_rows(run))
    if rows:
        cards.append(
            _card("Checks", table("Worst of all steps, relative", ("check", "worst", "step", "limit", ""), rows))
        )
    estimates = estimate_rows(summary)
    if estimates:
        cards.append(_card("Estimated error", table("By the run's own account", ("quantity", "value"), estimates)))
    cards.append(_card("Time", table("Wall time by phase", ("phase", "seconds", ""), _phase_rows(summary))))
    cards.append(_card("Warnings", _warnings(summary["warnings"])))
    events = run.table("events")
    if len(events):
        told = "Tips that have met something, and cracks that have started"
        cards.append(_card("Events", table(told, *event_rows(events)), wide=True))
    return tag("section", *cards, class_="cards", aria_label="quality")


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


def _warnings(warnings: list[str]) -> Markup:
    if not warnings:
        return tag("p", "none")
    more = len(warnings) - SHOWN_WARNINGS
    items = [*warnings[:SHOWN_WARNINGS], *([f"and {more} more, see summary.json"] if more > 0 else [])]
    return tag("ul", *(tag("li", item) for item in items))


def _settings(run: RunFolder) -> Markup:
    """What holds and loads the specimen in words, and the whole case."""
    actions = describe_actions(run.case)
    words = table("As the case says; SI units", ("key", "value"), actions)
    case = tag("details", tag("summary", "case.yaml, in SI units"), tag("pre", run.case_text, tabindex="0"))
    cards = [_card("Supports and loads", words, wide=True), _card("Case", case, wide=True)]
    return tag("section", *cards, class_="cards", aria_label="settings")


def _card(title: str, *content: object, wide: bool = False) -> Markup:
    return tag("article", tag("h2", title), *content, class_="card wide" if wide else "card")
