"""The page: what its template, `page.html`, shows of a run and of its steps, which move with the slider, and the file.

`chart.js` draws what `charts` has, `page.js` moves with the slider. Pictures are those of `crackgrow render`, or else
the figures of the run.
"""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jinja2 import Environment

from crackgrow.case.model import Case
from crackgrow.results.atomic import FolderError, write_text
from crackgrow.results.declarations import LOADER
from crackgrow.results.drawing import scene_svg, step_colour
from crackgrow.results.folder import PICTURE, REPORT, RunFolder, open_run, own_files
from crackgrow.results.log import load_words
from crackgrow.results.report.charts import charts
from crackgrow.results.run import Columns, Run
from crackgrow.results.units import INTENSITIES, LENGTHS, STRESSES, Unit, counted, cut, rounded_all, shown, unit_of
from crackgrow.run.result import CHECK_LIMITS

CHECKS = {  # columns of steps.csv, in the words of the page
    "residual": "equilibrium residual",
    "penetration": "penetration at contact points, by the step's largest jump",
    "complementarity": "complementarity of contact",
    "overlap_share": "overlap anywhere along the faces, by what is small beside jump and displacement",
    "energy_error": "error of the energy balance",
}
SHOWN_WARNINGS = 200  # of more the first ones are shown
MOST_CONTACT_ROWS = 20_000  # about 1.3 MB; of longer tables every second, third... step is kept
MOST_TIP_ROWS = 8_000  # about 1 MB
MOST_EVENTS = 1_000
OF_TIPS = ("crack", "tip", "K_I", "K_II", "K_growth", "sigma_1", "sigma_3", "criticality", "criterion", "kink_deg",
           "advanced")  # fmt: skip
LABELS = {"K_growth": "grows at K", "kink_deg": "kink", "advanced": "advances"}  # of columns with other names
FIRST_FIELD = "sigma_1"  # of which the page has pictures rather than of others
MOST_PICTURES = 40  # of a rendered series
MOST_PIXELS = 720  # of the longer side of those
MOST_PIXELS_OF_FIGURES = 1400
QUALITY = 80  # of JPEG
MOST_BYTES = 1_500_000  # of all pictures of the page


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
        last_made=int(run.table("paths")["step"].max(initial=0)),
        ramp=", ".join(step_colour(step, 9) for step in range(1, 10)),
        checks=check_rows(run),
        warnings=cut(run.summary["warnings"], SHOWN_WARNINGS, "and {} more, see summary.json"),
        events=event_rows(run.table("events")) if run.table("events").n_rows else None,
        actions=described_actions(run),
        data=data,
        # no text in the data can end the element of the page's scripts
        json=json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"),
    )


def _own_file(name: str) -> str:
    return files("crackgrow.results.report").joinpath(name).read_text(encoding="utf-8")


def check_rows(run: Run) -> list[tuple[str, str, int, str, bool]]:
    """What is checked in each step: its meaning, worst value, step of that, limit, and whether it is below."""
    rows = []
    for name, words in CHECKS.items() if run.solved else ():
        values, limit = np.abs(run.table("steps")[name]), CHECK_LIMITS[name]
        if name == "penetration":
            contact = run.table("contact")
            jumps = np.zeros(len(values))
            sizes = np.hypot(contact["opening"], contact["slip"])
            np.maximum.at(jumps, np.searchsorted(run.solved, contact["step"]), sizes)
            values = np.divide(values, jumps, out=np.zeros_like(values), where=jumps > 0.0)
        worst = int(np.argmax(np.where(np.isnan(values), np.inf, values)))
        rows.append((words, shown(values[worst], 3), run.solved[worst], f"{limit:g}", bool(values[worst] <= limit)))
    return rows


def described_actions(run: RunFolder) -> list[tuple[str, str]]:
    """What holds and what loads the specimen, in words: name, and what case.yaml says of it, in SI."""
    told, rows = yaml.load(run.case_text, LOADER), []
    for kind in ("supports", "loads"):
        for number, item in enumerate(told[kind]):
            text = json.dumps(item, ensure_ascii=False)[1:-1].replace('"', "")
            short = re.sub(r"-?\d+\.\d+(e[-+]?\d+)?", lambda found: f"{float(found[0]):.12g}", text)
            rows.append((f"{kind}.{number}", short))
    return rows


def tip_data(run: Run) -> dict[str, Any]:
    """Rows of the table of tips by step, a row for each tip, under a header with units."""
    tips = run.table("tips")
    K, stress = _unit(tips, INTENSITIES, "K_I", "K_II"), _unit(tips, STRESSES, "sigma_1", "sigma_3")
    units = {"K_I": K, "K_II": K, "K_growth": K, "sigma_1": stress, "sigma_3": stress}
    header, of_tips = _with_units(tips, OF_TIPS, {**units, "criticality": (1.0, ""), "kink_deg": (1.0, "°")})
    kept, rows = _kept_steps(tips, MOST_TIP_ROWS), dict[int, list[Any]]()
    for step, row in zip(tips["step"].tolist(), of_tips, strict=True):
        if step in kept:
            rows.setdefault(step, []).append(row)
    return {"header": header, "steps": rows}


def event_rows(events: Columns) -> tuple[list[str], list[list[Any]]]:
    """Header and rows of the table of events, places in a unit in which they are read easily."""
    header, rows = _with_units(events, tuple(events), dict.fromkeys("xy", _unit(events, LENGTHS, "x", "y")))
    return header, rows[:MOST_EVENTS]


def _unit(table: Columns, units: Sequence[Unit], *names: str) -> Unit:
    """The one of some units in which columns are read easily together."""
    return unit_of(np.concatenate([table[name] for name in names]), units)


def _with_units(table: Columns, names: Sequence[str], units: Mapping[str, Unit]) -> tuple[list[str], list[list[Any]]]:
    """Header and rows of some columns of a table, numbers in their units."""
    told = [(LABELS.get(name, name), units.get(name, (1.0, ""))[1]) for name in names]
    header = [f"{label} [{unit}]" if unit else label for label, unit in told]
    columns = [rounded_all(table[n], units[n][0]) if n in units else table[n].tolist() for n in names]
    return header, [list(row) for row in zip(*columns, strict=True)]


def contact_data(run: Run) -> dict[str, Any]:
    """Contact points by surface and step.

    units     by column, the name of its unit; tractions have one, and jumps
    surfaces     by name and step: the columns s, normal_traction, tangential_traction, opening, slip, state
    left_out     whether steps were left out to keep the page small
    """
    table = run.table("contact")
    kept = _kept_steps(table, MOST_CONTACT_ROWS)
    tractions, jumps = ("normal_traction", "tangential_traction"), ("opening", "slip")
    units = {"s": _unit(table, LENGTHS, "s")}
    units |= dict.fromkeys(tractions, _unit(table, STRESSES, *tractions))
    units |= dict.fromkeys(jumps, _unit(table, LENGTHS, *jumps))
    surfaces: dict[str, dict[int, dict[str, list[Any]]]] = {}
    for (name, step), points in table.by("crack", "step").items():
        if step in kept:
            columns = {column: rounded_all(points[column], size) for column, (size, _) in units.items()}
            surfaces.setdefault(name, {})[step] = columns | {"state": points["state"].tolist()}
    return {
        "units": {column: unit for column, (_, unit) in units.items()},
        "surfaces": surfaces,
        "left_out": len(kept) < len(np.unique(table["step"])),
    }


def _kept_steps(table: Columns, most: int) -> set[int]:
    """Steps of a table that the page shows, so that it has about as many rows as `most`; the last one always."""
    steps = np.unique(table["step"])[::-1]
    return set(steps[:: max(1, -(-table.n_rows // most))].tolist())


def step_words(run: Run) -> dict[int, str]:
    """What the slider says of each step."""
    words = {}
    steps = run.table("steps")
    for step, factor, n in zip(run.solved, steps["load_factor"].tolist(), steps["n_dofs"], strict=True):
        words[step] = f"{load_words(run.case, factor)}, {n} unknowns"
    return {place: words.get(place, "after the last advance, not solved") for place in run.places}


def pictures(run: RunFolder) -> list[dict[str, Any]]:
    """Step, caption and data of each picture, in the order of the steps; those of a series at most MOST_BYTES.

    Raises FolderError for one that is damaged.
    """
    series: dict[str, dict[int, Path]] = {}
    for own in own_files(run.folder, names=[PICTURE]):
        if own.whole and own.step in run.solved:
            series.setdefault(own.path.parent.name, {})[own.step] = own.path
    if series:
        field = min(series, key=lambda name: (name != FIRST_FIELD, name))
        steps = sorted(series[field], reverse=True)  # evenly spaced, the last one among them
        chosen = [_picture(k, field, series[field][k], MOST_PIXELS) for k in steps[:: -(-len(steps) // MOST_PICTURES)]]
        size = sum(len(picture["uri"]) for picture in chosen)
        return chosen[:: -(-size // MOST_BYTES)][::-1]
    figures = zip(("first", "last"), (run.solved[:1], run.solved[-1:]), strict=True)
    paths = [(step, run.folder / "figures" / f"sigma_1_{which}.png") for which, steps in figures for step in steps]
    words = "major principal stress"
    return [_picture(step, words, path, MOST_PIXELS_OF_FIGURES) for step, path in paths if path.is_file()]


def _picture(step: int, words: str, path: Path, most_pixels: int) -> dict[str, Any]:
    """A picture as JPEG: of smooth colours PNG takes several times as much."""
    from PIL import Image  # here: reports without pictures do not need it

    try:
        with Image.open(path) as image:
            small = image.convert("RGB")
    except OSError as error:
        raise FolderError(f"{path} is damaged: {error}") from error
    small.thumbnail((most_pixels, most_pixels))
    data = io.BytesIO()
    small.save(data, format="JPEG", quality=QUALITY, optimize=True)
    uri = f"data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode()}"
    return {"step": step, "words": words, "uri": uri}
