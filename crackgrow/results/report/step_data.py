"""What the page shows of steps: tips, what is along the faces, pictures, which move with the slider, and events.

Pictures are those of `crackgrow render`, or else the figures of the run.
"""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np

from crackgrow.results.folder import FolderError, RunFolder, TextTable, rendered_files
from crackgrow.results.log import load_words
from crackgrow.results.units import INTENSITIES, LENGTHS, STRESSES, Unit, rounded_all, shown, unit_of

MOST_CONTACT_ROWS = 20_000  # about 1.3 MB; of longer tables every second, third... step is kept
MOST_TIP_ROWS = 8_000  # about 1 MB
CONTACT_COLUMNS = (
    (("s",), LENGTHS),
    (("normal_traction", "tangential_traction"), STRESSES),
    (("opening", "slip"), LENGTHS),
)  # those in one tuple are drawn together

FIRST_FIELD = "sigma_1"  # of which the page has pictures rather than of others
MOST_PICTURES = 40  # of a rendered series
MOST_PIXELS = 720  # of the longer side of those
MOST_PIXELS_OF_FIGURES = 1400
QUALITY = 80  # of JPEG
MOST_BYTES = 1_500_000  # of all pictures of the page


def tip_data(run: RunFolder) -> dict[str, Any]:
    """Rows of the table of tips by step, a row for each tip, under a header with units."""
    tips = run.table("tips")
    K = unit_of(np.concatenate([tips.numbers("K_I"), tips.numbers("K_II")]), INTENSITIES)
    stress = unit_of(np.concatenate([tips.numbers("sigma_1"), tips.numbers("sigma_3")]), STRESSES)
    header = ["crack", "tip", f"K_I [{K[1]}]", f"K_II [{K[1]}]", f"grows at K [{K[1]}]"]
    header += [f"sigma_1 [{stress[1]}]", f"sigma_3 [{stress[1]}]", "criticality", "criterion", "kink [°]", "advances"]
    sizes = {"K_I": K[0], "K_II": K[0], "K_growth": K[0], "sigma_1": stress[0], "sigma_3": stress[0]}
    sizes |= {"criticality": 1.0, "kink_deg": 1.0}
    numbers = [rounded_all(tips.numbers(name), size) for name, size in sizes.items()]
    *of_tip, kink = numbers
    advances = tips.words("advanced")
    columns = (tips.words("crack"), tips.words("tip"), *of_tip, tips.words("criterion"), kink, advances)
    rows: dict[int, list[Any]] = {}
    kept = _kept_steps(tips, MOST_TIP_ROWS)
    for step, row in zip(tips.steps().tolist(), zip(*columns, strict=True), strict=True):
        if step in kept:
            rows.setdefault(step, []).append(list(row))
    return {"header": header, "steps": rows}


def event_rows(events: TextTable) -> tuple[list[str], list[list[object]]]:
    """Header and rows of the table of events, places in a unit in which they are read easily."""
    places = {name: events.numbers(name) for name in ("x", "y")}
    size, unit = unit_of(np.concatenate(list(places.values())), LENGTHS)
    columns = [
        [shown(float(value) / size) for value in places[name]] if name in places else events.words(name)
        for name in events.columns
    ]
    header = [f"{name} [{unit}]" if name in places else name for name in events.columns]
    return header, [list(row) for row in zip(*columns, strict=True)]


def contact_data(run: RunFolder) -> dict[str, Any]:
    """Contact points by surface and step.

    units     by column, the name of its unit
    surfaces     by name and step: the columns s, normal_traction, tangential_traction, opening, slip, state
    left_out     whether steps were left out to keep the page small
    """
    table = run.table("contact")
    steps = table.steps()
    kept = _kept_steps(table, MOST_CONTACT_ROWS)
    units: dict[str, Unit] = {}
    for names, choice in CONTACT_COLUMNS:
        unit = unit_of(np.concatenate([table.numbers(name) for name in names]), choice)
        units |= dict.fromkeys(names, unit)
    columns = {name: rounded_all(table.numbers(name), unit[0]) for name, unit in units.items()}
    surfaces: dict[str, dict[int, dict[str, list[Any]]]] = {}
    for k, (step, name) in enumerate(zip(steps.tolist(), table.words("crack"), strict=True)):
        if step not in kept:
            continue
        of_step = surfaces.setdefault(name, {}).setdefault(step, {})
        for column, values in columns.items():
            of_step.setdefault(column, []).append(values[k])
        of_step.setdefault("state", []).append(table.words("state")[k])
    return {
        "units": {column: unit[1] for column, unit in units.items()},
        "surfaces": surfaces,
        "left_out": len(kept) < len(set(steps.tolist())),
    }


def _kept_steps(table: TextTable, most: int) -> set[int]:
    """Steps of a table that the page shows, so that it has about as many rows as `most`; the last one always."""
    steps = np.unique(table.steps())[::-1]
    return set(steps[:: max(1, -(-len(table) // most))].tolist())


def step_words(run: RunFolder) -> dict[int, str]:
    """What the slider says of each step."""
    words = {}
    steps = run.table("steps")
    for step, factor, n in zip(run.solved, steps.numbers("load_factor"), steps.words("n_dofs"), strict=True):
        words[step] = f"{load_words(run.case, float(factor))}, {n} unknowns"
    return {place: words.get(place, "after the last advance, not solved") for place in run.places}


def pictures(run: RunFolder) -> list[dict[str, Any]]:
    """Step, caption and data of each picture, in the order of the steps; those of a series at most MOST_BYTES.

    Raises FolderError for one that is damaged.
    """
    series: dict[str, dict[int, Path]] = {}
    for path in rendered_files(run.folder):
        if path.suffix == ".png":
            series.setdefault(path.parent.name, {})[int(path.stem.removeprefix("step_"))] = path
    if series:
        field = min(series, key=lambda name: (name != FIRST_FIELD, name))
        return _thinned(field, series[field], run)
    found = []
    for name, step in (("sigma_1_first", run.solved[:1]), ("sigma_1_last", run.solved[-1:])):
        path = run.folder / "figures" / f"{name}.png"
        if path.is_file() and step:
            found.append(_picture(step[0], "major principal stress", path, MOST_PIXELS_OF_FIGURES))
    return found


def _thinned(field: str, files: dict[int, Path], run: RunFolder) -> list[dict[str, Any]]:
    """Evenly spaced pictures of a series, the last one among them, made small."""
    steps = sorted(step for step in files if step in run.solved)[::-1]
    chosen = steps[:: -(-len(steps) // MOST_PICTURES)] if steps else []
    found = [_picture(step, field, files[step], MOST_PIXELS) for step in chosen]
    size = sum(len(picture["uri"]) for picture in found)
    return found[:: -(-size // MOST_BYTES)][::-1] if found else []


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
