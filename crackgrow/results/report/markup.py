"""The HTML of the report: its cards, top to bottom. Whatever is no Markup of its own is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from typing import Any, Final

from markupsafe import Markup

from crackgrow.results.folder import RunFolder
from crackgrow.results.units import counted, cut, shown

SHORT: Final = 12  # characters of a cell that is not broken
SHOWN_WARNINGS: Final = 200  # of more the first ones are shown
BADGES: Final = {"failed": "bad", "interrupted": "doubtful", "running": "doubtful"}
ESTIMATES: Final = {
    "first": "energy norm, first step [%]",
    "last": "energy norm, last step [%]",
    "K_percent_expected": "K, error that is expected, over the largest K of its step [%]",
    "K_percent_at_most": "K, error at most, over the largest K of its step [%]",
    "K_spread_percent": "spread of K over discs of its integral, not its error [%]",
    "kink_degrees_at_most": "directions of growth, at most [°]",
    "load_factor_percent_at_most": "critical load factors, at most [%]",
    "goal_percent_at_most": "numerics.goal, at most, over its largest value [%]",
}
CONTROLS: Final = Markup("""<div class="controls" role="group" aria-label="step shown">
<button id="play" type="button">Play</button><label for="step">Step</label>
<input id="step" type="range" min="0" max="{last}" value="{last}" step="1">
<output id="now" for="step" aria-live="polite"></output></div>
""")
PICTURE: Final = Markup("""<figure><div class="scroll"><img id="picture" alt=""></div>
<figcaption id="caption"></figcaption></figure>
<button id="larger" type="button" aria-pressed="false">Larger</button>""")
FACES: Final = Markup("""<label>Surface <select id="surface">{}</select></label>
<div id="contact"></div>{}""")
TIPS: Final = Markup("""<div class="scroll tall" tabindex="0" role="region" aria-label="tips of the step">
<table><caption id="tips-caption"></caption><thead id="tips-head"></thead>
<tbody id="tips-body"></tbody></table></div>""")


def page_of(run: RunFolder, data: str, sections: Iterable[Markup]) -> str:
    """The whole page; `data`, in JSON, is what its scripts draw, and has no text that ends their element."""
    last = len(run.places) - 1
    return _file("page.html").format(
        case=run.summary["case"], title=run.summary["title"], style=_file("page.css"), header=_header(run),
        controls=CONTROLS.format(last=last) if last else "", sections=joined("{}\n", sections), data=Markup(data),
        script=_file("chart.js") + _file("page.js"),
    )  # fmt: skip


def _file(name: str) -> Markup:
    return Markup(files("crackgrow.results.report").joinpath(name).read_text(encoding="utf-8"))


def joined(form: str, items: Iterable[object]) -> Markup:
    """Each item in a form such as "<li>{}</li>", one behind the other."""
    return Markup("").join(Markup(form).format(item) for item in items)


def section(label: str, cards: Iterable[Markup], kind: str = "cards") -> Markup:
    """Cards beside each other."""
    form = Markup('<section class="{}" aria-label="{}">\n{}</section>')
    return form.format(kind, label, joined("{}\n", cards))


def card(title: str, content: Markup, *, wide: bool = False) -> Markup:
    """A part of the page with a title."""
    kind = "card wide" if wide else "card"
    return Markup('<article class="{}"><h2>{}</h2>\n{}\n</article>').format(kind, title, content)


def table(caption: str, header: Sequence[str], rows: Iterable[Iterable[object]]) -> Markup:
    """A table of cells: numbers as they are read, true and false as the verdict on a check, Markup as it is."""
    form = Markup(
        '<div class="scroll" tabindex="0" role="region" aria-label="{}"><table><caption>{}</caption>\n'
        "<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>"
    )
    body = joined("<tr>{}</tr>\n", (Markup("").join(map(_cell, row)) for row in rows))
    return form.format(caption, caption, joined('<th scope="col">{}</th>', header), body)


def _cell(value: object) -> Markup:
    if isinstance(value, bool):
        kind, words = ("good", "ok") if value else ("bad", "above the limit")
        content: object = Markup('<span class="{}">{}</span>').format(kind, words)
    else:
        content = shown(value) if isinstance(value, float) else value
    is_short = not isinstance(value, Markup) and len(str(value)) <= SHORT
    return Markup('<td class="short">{}</td>' if is_short else "<td>{}</td>").format(content)


def _header(run: RunFolder) -> Markup:
    """What has run, how it has ended, and what it took."""
    told, commit = run.summary, ""
    if told["git_commit"]:
        commit = f" ({told['git_commit'][:12]}{', modified' if told['git_modified'] else ''})"
    sizes = told["n_dofs"] and " to ".join(map(str, dict.fromkeys(told["n_dofs"].values())))
    facts = [
        f"crackgrow {told['version']}{commit}",
        f"plane {run.case.plane}",
        counted(told["n_solves"], "solved step"),
        f"{sizes} unknowns" if sizes else "nothing solved",
        f"{shown(told['wall_seconds']['total'], 3)} s, {told['peak_memory_mb']:.0f} MB",
    ]
    return Markup(
        '<header><h1>{}</h1>\n<p class="status"><strong class="badge {}">{}</strong> {}</p>\n'
        '<p class="facts">{}</p>\n<p class="facts">{}</p></header>\n'
    ).format(
        told["title"], BADGES.get(told["status"], "good"), told["status"], told["stop_reason"],
        " \N{MIDDLE DOT} ".join(facts), run.case.source,
    )  # fmt: skip


def scene_card(run: RunFolder, scene: Markup, ramp: str) -> Markup:
    """The drawing of the scene, and what its colours and signs mean as far as they are there."""
    last_made, legend = int(run.table("paths").steps().max(initial=0)), []
    if run.case.cracks:
        legend.append(Markup("black: the given cracks"))
    if last_made:
        colours = Markup('<span class="ramp" style="background: linear-gradient(to right, {})"></span>').format(ramp)
        legend.append(Markup("grown in step 1 {} {}").format(colours, last_made))
    if len(run.table("tips")):
        legend.append(Markup("circles: tips, filled where they advance"))
    if run.case.interfaces:
        legend.append(Markup("violet: interfaces, dashed unless bonded"))
    words = joined('\n<p class="legend">{}</p>', [Markup("; ").join(legend)] if legend else [])
    return card("Scene and cracks", scene + words)


def step_cards(run: RunFolder, data: Mapping[str, Any]) -> list[Markup]:
    """What moves with the slider, besides the scene."""
    cards = [card("Picture", PICTURE)] if data["pictures"] else []
    if surfaces := data["contact"]["surfaces"]:
        rest = "\n<p>Some steps are left out to keep the page small.</p>" if data["contact"]["left_out"] else ""
        cards.append(card("Along the faces", FACES.format(joined("<option>{}</option>", surfaces), Markup(rest))))
    return [*cards, card("Tips", TIPS, wide=True)] if len(run.table("tips")) else cards


def chart_cards(data: Mapping[str, Any]) -> list[Markup]:
    """Where the scripts draw the charts."""
    places = (Markup('<div class="chart" id="chart-{}"></div>').format(n) for n in range(len(data["charts"])))
    return [card(chart["title"], place) for chart, place in zip(data["charts"], places, strict=True)]


def quality_cards(
    run: RunFolder, checks: Sequence[Sequence[object]], events: tuple[list[str], list[list[Any]]] | None
) -> list[Markup]:
    """How good the run is, what it took, and what happened."""
    summary, cards = run.summary, []
    if checks:
        header = ("check", "worst", "step", "limit", "")
        cards.append(card("Checks", table("Worst of all steps, relative", header, checks)))
    estimates = [
        (ESTIMATES.get(key, key), shown(number))
        for name, told in summary["error_estimate"].items()
        for key, number in (told if isinstance(told, dict) else {name: told}).items()
        if isinstance(number, int | float)
    ]
    if estimates:
        cards.append(card("Estimated error", table("By the run's own account", ("quantity", "value"), estimates)))
    phases = dict(summary["wall_seconds"]["by_phase"])
    phases["other"] = max(summary["wall_seconds"]["total"] - sum(phases.values()), 0.0)
    bar, most = Markup('<div class="bar" style="width: {:.1f}%"></div>'), max(phases.values()) or 1.0
    times = [(phase, shown(spent, 3), bar.format(100.0 * spent / most)) for phase, spent in phases.items()]
    cards.append(card("Time", table("Wall time by phase", ("phase", "seconds", ""), times)))
    warnings = cut(summary["warnings"], SHOWN_WARNINGS, "and {} more, see summary.json")
    listed = Markup("<ul>{}</ul>").format(joined("<li>{}</li>", warnings)) if warnings else Markup("<p>none</p>")
    cards.append(card("Warnings", listed))
    if events:
        met = table("Tips that have met something, and cracks that have started", *events)
        cards.append(card("Events", met, wide=True))
    return cards


def case_cards(run: RunFolder, actions: Sequence[Sequence[str]]) -> list[Markup]:
    """What was asked for."""
    text = Markup('<details><summary>case.yaml, in SI units</summary><pre tabindex="0">{}</pre></details>')
    told = table("As the case says; SI units", ("key", "value"), actions)
    return [card("Supports and loads", told, wide=True), card("Case", text.format(run.case_text), wide=True)]
