"""The report: made from the files alone, well formed, self-contained, with the numbers of the tables."""

from __future__ import annotations

import csv
import json
import math
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.errors import SolveError
from crackgrow.results.atomic import FolderError
from crackgrow.results.report.page import write_report
from crackgrow.results.writer import RunWriter
from tests.scenes import HOSTILE, SLOWLY, make_run, rows_of, shipped_case

VOID = ("meta", "input", "img")
ROUNDING = 1e-5  # six digits are shown
PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "m": 1e-3, "µ": 1e-6, "n": 1e-9, "": 1.0}


class Page(HTMLParser):
    """A page taken apart; every element that is opened has to be closed, in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.content: dict[str, str] = {}
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        inner = self.open[-1] if self.open else ""
        self.content[inner] = self.content.get(inner, "") + data

    @property
    def data(self) -> dict[str, Any]:
        """What the scripts of the page draw."""
        text = self.content["script"]
        decoded: dict[str, Any] = json.JSONDecoder().raw_decode(text)[0]
        return decoded


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_run(tmp_path_factory.mktemp("run"), [f"title='{HOSTILE}'"])


@pytest.fixture(scope="module")
def page(folder: Path) -> Page:
    return read(folder)


def read(folder: Path) -> Page:
    return Page((folder / "report.html").read_text(encoding="utf-8"))


def numbers(table: list[dict[str, str]], name: str) -> list[float]:
    return [float(row[name]) for row in table]


def in_si(shown: float | None, label: str) -> float:
    """A number of the page as it is in the tables, by the unit in its label."""
    match = re.search(r"\[([GMkmµn]?)(?:Pa|m|J/m)(?:√m)?\]", label)
    assert match, label
    return math.nan if shown is None else shown * PREFIXES[match[1]]


def copied(folder: Path, to: Path) -> Path:
    return Path(shutil.copytree(folder, to / "copy"))


def told_of(folder: Path, target: Path, summary: dict[str, Any], steps: dict[int, dict[str, str]]) -> str:
    """The words of the page of a run whose summary and rows of steps.csv are changed, with | between elements."""
    copy = copied(folder, target)
    told = json.loads((copy / "summary.json").read_text())
    (copy / "summary.json").write_text(json.dumps(told | summary))
    table = rows_of(copy / "steps.csv")
    for number, cells in steps.items():
        table[number] |= cells
    with (copy / "steps.csv").open("w", newline="") as out:
        writer = csv.DictWriter(out, list(table[0]))
        writer.writeheader()
        writer.writerows(table)
    return re.sub(r"(\s*<[^>]*>\s*)+", "|", write_report(copy).read_text(encoding="utf-8"))


def test_page_is_well_formed_and_needs_no_network(page: Page) -> None:
    for _, attributes in page.elements:
        for name in ("src", "href", "xlink:href", "srcset", "action"):
            assert re.match("$|#|data:", attributes.get(name) or "")
    assert "url(" not in page.content["style"]
    assert "@import" not in page.content["style"]
    urls = re.findall(r"https?://[^\"'\s]*", page.content["style"] + page.content["script"])
    assert set(urls) <= {"http://www.w3.org/2000/svg"}  # a name, not a place
    policy = next(attributes["content"] for tag, attributes in page.elements if "http-equiv" in attributes)
    assert policy is not None
    assert policy.startswith("default-src 'none'")


def test_everything_from_the_case_is_escaped(page: Page, folder: Path) -> None:
    assert page.content["h1"] == HOSTILE
    assert [tag for tag, _ in page.elements].count("script") == 2
    assert page.content["pre"] == (folder / "case.yaml").read_text()


def test_tips_and_contact_points_are_those_of_the_tables(page: Page, folder: Path) -> None:
    tips, table = page.data["tips"], rows_of(folder / "tips.csv")
    shown = [row for step in sorted(tips["steps"], key=int) for row in tips["steps"][step]]
    assert [(*row[:2], row[8]) for row in shown] == [(row["crack"], row["tip"], row["criterion"]) for row in table]
    for column, name in enumerate(("K_I", "K_II", "K_growth", "sigma_1", "sigma_3"), start=2):
        values = [in_si(row[column], tips["header"][column]) for row in shown]
        np.testing.assert_allclose(values, numbers(table, name), rtol=ROUNDING)
    for column, name in ((7, "criticality"), (9, "kink_deg")):
        np.testing.assert_allclose([row[column] for row in shown], numbers(table, name), rtol=ROUNDING)
    contact, table = page.data["contact"], rows_of(folder / "contact.csv")
    assert not contact["left_out"]
    steps = [step for _, step in sorted(contact["surfaces"]["flaw"].items(), key=lambda item: int(item[0]))]
    for name, unit in contact["units"].items():
        values = [in_si(value, f"[{unit}]") for step in steps for value in step[name]]
        np.testing.assert_allclose(values, numbers(table, name), rtol=ROUNDING)
    assert [state for step in steps for state in step["state"]] == [row["state"] for row in table]


@pytest.mark.physics
@pytest.mark.parametrize(("case", "settings", "title", "x", "y"), [
    ("compression30", ["loading=critical"], "Load curve", "load_displacement", "load_factor"),
    ("edge_tension", SLOWLY, "Growth in time", "time", "crack_length"),
])  # fmt: skip
def test_loads_that_vary_and_growth_that_takes_time_have_their_curves(
    case: str, settings: list[str], title: str, x: str, y: str, tmp_path: Path
) -> None:
    make_run(tmp_path, settings, case=case)
    chart = next(chart for chart in read(tmp_path).data["charts"] if chart["title"] == title)
    table = rows_of(tmp_path / "steps.csv")
    (series,) = chart["series"]
    for name, shown, label in ((x, series["x"], chart["xlabel"]), (y, series["y"], chart["ylabel"])):
        values = shown if name in ("time", "load_factor") else [in_si(value, label) for value in shown]
        np.testing.assert_allclose(values, numbers(table, name), rtol=ROUNDING)
    if x == "time":
        assert chart["xlabel"] == "time [s]"
        assert numbers(table, x)[-1] == json.loads((tmp_path / "summary.json").read_text())["time"] > 0.0


@pytest.mark.parametrize(("error", "status"), [(SolveError(), "failed"), (KeyboardInterrupt(), "interrupted")])
def test_a_run_that_solved_nothing_shows_the_scene_and_why(tmp_path: Path, error: BaseException, status: str) -> None:
    writer = RunWriter(shipped_case("compression30"), tmp_path)
    writer.begin()
    writer.break_off(error, "no solution <here>")
    page = read(tmp_path)
    assert page.content["strong"] == status
    assert "no solution <here>" in page.content["p"]
    assert page.data["places"] == [0]
    assert [
        attributes["id"] for _, attributes in page.elements if (attributes.get("id") or "").startswith("step-")
    ] == ["step-0"]


@pytest.mark.parametrize(("name", "text", "message"), [
    ("summary.json", '{"case": "comp', "line 1"),
    ("summary.json", "[]", "it is no mapping"),
    ("summary.json", '{"case": "a"}', "it has no title, status"),
    ("summary.json", "\udcff", "utf-8"),
    ("contact.csv", "step,crack\n0,flaw\n", "it has no column s; its columns are step, crack"),
    ("paths.csv", "crack,vertex,x,y,step\nflaw,0,0.1\n", "row 1 has 3 values, the header has 5"),
    ("paths.csv", "crack,vertex,x,y,step\nflaw,0,0.1e,0.1,0\n", "x: could not convert"),
    ("figures/sigma_1_last.png", "half a picture", "cannot identify image file"),
])  # fmt: skip
def test_damaged_files_are_named(folder: Path, tmp_path: Path, name: str, text: str, message: str) -> None:
    copy = copied(folder, tmp_path)
    (copy / name).parent.mkdir(exist_ok=True)
    (copy / name).write_text(text, encoding="utf-8", errors="surrogateescape")
    damaged = f"{re.escape(str(copy / name))} is damaged(, or of another version)?: "
    with pytest.raises(FolderError, match=damaged) as got:
        write_report(copy)
    assert message in str(got.value)


COMMIT = "0123456789abcdef"
ESTIMATE = {"energy_norm_percent": {"first": 4.25, "last": None}, "of_another_version": 7.0,
            "K_percent_expected": 0.25, "K_percent_at_most": 0.75}  # fmt: skip


@pytest.mark.parametrize(("summary", "steps", "told"), [
    ({}, {2: {"residual": "2e-10"}}, "|equilibrium residual|2e-10|2|1e-09|ok|"),
    ({}, {2: {"residual": "2e-9"}}, "|equilibrium residual|2e-09|2|1e-09|above the limit|"),
    ({}, {2: {"residual": "nan"}}, "|equilibrium residual|\N{EN DASH}|2|1e-09|above the limit|"),
    ({"error_estimate": ESTIMATE}, {},
     "|energy norm, first step [%]|4.25|of_another_version|7|"
     "K, error that is expected, over the largest K of its step [%]|0.25|"
     "K, error at most, over the largest K of its step [%]|0.75|"),
    ({"version": "7", "git_commit": None, "git_modified": None}, {}, "crackgrow 7 "),  # an installed program
    ({"version": "7", "git_commit": COMMIT, "git_modified": False}, {}, "crackgrow 7 (0123456789ab) "),
    ({"version": "7", "git_commit": COMMIT, "git_modified": True}, {}, "crackgrow 7 (0123456789ab, modified) "),
    ({}, {}, "|black: the given cracks; grown in step 1|"),
])  # fmt: skip
def test_checks_estimates_version_and_legend_are_told(
    summary: dict[str, Any], steps: dict[int, dict[str, str]], told: str, folder: Path, tmp_path: Path
) -> None:
    assert told in told_of(folder, tmp_path, summary, steps)
