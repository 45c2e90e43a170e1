"""The writer: what was solved is on disk after every step, whatever ends the run, and nobody else's files go."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import pyvista

from crackgrow.case import dump_case
from crackgrow.errors import SolveError
from crackgrow.results.atomic import OccupiedError, OutputError
from crackgrow.results.folder import SUMMARY_KEYS
from crackgrow.results.lock import LOCK
from crackgrow.results.writer import RunWriter
from crackgrow.run.result import RunEnd, StepResult
from tests.scenes import rows_of, summary_of
from tests.unit.results.synthetic import make_case, make_end, make_event, make_paths, make_result

TABLES = {
    "case.yaml", "run.log", "tips.csv", "paths.csv", "contact.csv", "reactions.csv", "steps.csv", "events.csv",
    "interface_tips.csv", "summary.json",
}  # fmt: skip


def begun(folder: Path, results: Sequence[StepResult] = (), **output: Any) -> RunWriter:
    """A run after some steps."""
    writer = RunWriter(make_case(**output), folder)
    writer.begin()
    for result in results:
        writer.add(result)
    return writer


def a_run(folder: Path, results: Sequence[StepResult] = (), **output: Any) -> Path:
    """A folder in which a run has begun, and ended."""
    begun(folder, results, **output).finish(make_end(max(len(results) - 1, 0)))
    return folder


def column(path: Path, name: str) -> list[str]:
    return [row[name] for row in rows_of(path)]


def files(folder: Path) -> set[str]:
    """All but the lock of a run that goes on."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file() and path.name != LOCK}


def test_everything_is_on_disk_after_every_step(tmp_path: Path) -> None:
    out = tmp_path / "out"
    writer = begun(out)
    assert files(out) == TABLES
    assert (out / "case.yaml").read_text() == dump_case(make_case())
    for step in range(3):
        writer.add(make_result(step))
        steps = [str(k) for k in range(step + 1)]
        assert column(out / "steps.csv", "step") == steps
        assert column(out / "tips.csv", "step") == [k for k in steps for _ in range(2)]
        assert sorted(set(column(out / "contact.csv", "step"))) == steps
        assert len(column(out / "paths.csv", "x")) == 2 + step
        for series in ("block.pvd", "block_cracks.pvd"):
            assert pyvista.get_reader(out / series).time_values == list(range(step + 1))
        assert pyvista.read(out / "frames" / f"step_{step:04d}.vtu").n_points > 0
        told = summary_of(out)
        assert (told["status"], told["steps_done"], told["n_solves"]) == ("running", step, step + 1)
        assert f"step {step}/2" in (out / "run.log").read_text()
    writer.finish(make_end(3))
    assert len(column(out / "paths.csv", "x")) == 5
    assert summary_of(out)["status"] == "completed"
    frames = {f"{kind}/step_000{k}.{end}" for k in range(3) for kind, end in (("frames", "vtu"), ("cracks", "vtp"))}
    assert files(out) == TABLES | frames | {"block.pvd", "block_cracks.pvd"}


def test_events_are_in_the_table_the_log_and_the_summary_as_they_come(tmp_path: Path) -> None:
    writer = begun(tmp_path, [make_result(0)], frames="none")
    assert column(tmp_path / "events.csv", "kind") == []
    writer.add(make_result(1, events=(make_event(1), make_event(1, tip="start", met="its own path"))))
    assert column(tmp_path / "events.csv", "met") == ["crack 'b, the second'", "its own path"]
    line = "step 1, coalescence: crack 'flaw' (end) reached crack 'b, the second' at (12 mm, 2 mm)"
    assert (tmp_path / "run.log").read_text().count(line) == 1
    last = make_event(2, kind="break_through", met="the outline of body 'rock'")
    writer.finish(RunEnd("broke_through", "a piece came loose", make_paths(2), (last,)))
    assert "step 2, break_through: crack 'flaw' (end) reached the outline" in (tmp_path / "run.log").read_text()
    first, *_, third = summary_of(tmp_path)["events"]
    x, y = make_event(1).point
    assert first == {
        "step": 1, "kind": "coalescence", "crack": "flaw", "tip": "end", "x": x, "y": y, "met": "crack 'b, the second'",
        "words": line.partition(": ")[2],
    }  # fmt: skip
    rows = rows_of(tmp_path / "events.csv")
    assert [row["step"] for row in rows] == ["1", "1", "2", "2"]
    assert (rows[3]["kind"], rows[3]["met"]) == ("parted", "a piece came loose")
    told = {name: str(value) for name, value in third.items() if name != "words"}
    assert told | {"load_factor": "nan", "energy": "nan"} == rows[2]


@pytest.mark.physics
@pytest.mark.parametrize(("factors", "curve"), [([1.0], False), ([1.0, 1.0, 1.0], False), ([1.0, 0.8, 0.9], True)])
def test_figures_are_those_that_show_something(tmp_path: Path, factors: list[float], curve: bool) -> None:
    """Curves where load factor and stress change, with the peak in the summary; one picture twice in one step."""
    a_run(tmp_path, [make_result(k, load_factor=f) for k, f in enumerate(factors)], frames="none", figures=True)
    assert ("figures/load_curve.png" in files(tmp_path)) == curve
    assert ("figures/stress_strain.png" in files(tmp_path)) == (len(factors) > 1)
    assert summary_of(tmp_path)["peak_load"] == {"load_factor": 1.0, "step": 0}
    first, last = ((tmp_path / "figures" / f"sigma_1_{name}.png").read_bytes() for name in ("first", "last"))
    assert (first == last) == (len(factors) == 1)


@pytest.mark.parametrize(("policy", "n_steps", "kept"), [
    ("every_step", 3, [0, 1, 2]), ("first_and_last", 3, [0, 2]), ("first_and_last", 1, [0]), ("none", 3, [])
])  # fmt: skip
def test_frames_policy(tmp_path: Path, policy: str, n_steps: int, kept: list[int]) -> None:
    a_run(tmp_path, [make_result(step) for step in range(n_steps)], frames=policy)
    assert sorted(path.name for path in tmp_path.glob("frames/*")) == [f"step_{step:04d}.vtu" for step in kept]
    assert sorted(path.name for path in tmp_path.glob("cracks/*")) == [f"step_{step:04d}.vtp" for step in kept]
    listed = [[part.time for part in pyvista.get_reader(path).datasets] for path in tmp_path.glob("*.pvd")]
    assert listed == [kept, kept] if kept else listed == []


@pytest.mark.physics
def test_a_run_that_fails_keeps_what_was_solved(tmp_path: Path) -> None:
    begun(tmp_path, [make_result(0), make_result(1)], frames="none", figures=True).break_off(SolveError("no solution"))
    told = summary_of(tmp_path)
    assert (told["status"], told["stop_reason"]) == ("failed", "no solution")
    assert (told["steps_done"], told["n_solves"]) == (1, 2)
    assert column(tmp_path / "steps.csv", "step") == ["0", "1"]
    assert len(column(tmp_path / "paths.csv", "x")) == 3
    assert "failed: no solution" in (tmp_path / "run.log").read_text()
    figures = ("path", "sigma_1_first", "sigma_1_last", "contact", "stress_strain")
    assert files(tmp_path) == TABLES | {f"figures/{name}.png" for name in figures}


def test_earlier_results_go_and_other_files_stay(tmp_path: Path) -> None:
    mine = ["frames/step_0007.vtu", "frames/step_12345.vtu", "frames/.step_0008.tmp.vtu",
            "cracks/step_0007.vtp", "figures/path.png", ".summary.tmp.json", "figures/load_curve.png", "report.html",
            "render/sigma_1/step_0007.png", "render/sigma_1/animation.gif"]  # fmt: skip
    others = ["notes.txt", "other.pvd", "frames/step_1.vtu", "frames/mine.vtu", "figures/own.png",
              "cracks/step_0007.csv", "checkpoint/state", "render/sigma_1/own.png"]  # fmt: skip
    a_run(tmp_path, [make_result(0)])
    for name in mine + others:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    RunWriter(replace(make_case(), name="next"), tmp_path).begin()
    assert files(tmp_path) == TABLES | set(others)
    assert all((tmp_path / name).read_text() == name for name in others)


OWN = json.dumps(dict.fromkeys(SUMMARY_KEYS, "mine"))
SUMMARIES = (
    b"what I found", b'{"case": "blo', b'{"case": "a", "status": "ok", "stop_reason": "done", "version": "7"}',
    f"{OWN}\n{OWN}\n".encode(), OWN.encode("utf-16"), b"[" * 100_000,
)  # fmt: skip


@pytest.mark.parametrize(("name", "contents"), [
    ("summary.json", SUMMARIES),
    *((name, (b"", b"mine", b"PK\x03\x04")) for name in (
        "summary.json", "checkpoint/step_0000.npz", "checkpoint/step_12345.npz", "render/sigma_1/step_0001.png",
        "render/mine/animation.gif", "run.log", "figures/path.png", ".steps.tmp.csv",
    )),
])  # fmt: skip
def test_no_file_goes_that_no_run_has_written(name: str, contents: Sequence[bytes], tmp_path: Path) -> None:
    """Of a summary also where a run's other files lie beside it."""
    folders = (tmp_path / "new", *([a_run(tmp_path / "run")] if contents is SUMMARIES else []))
    for folder, content in product(folders, contents):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
        before = files(folder)
        with pytest.raises(OccupiedError, match="would be replaced") as caught:
            begun(folder)
        assert caught.value.exit_code == 2
        assert (files(folder), (folder / name).read_bytes()) == (before, content)


LONG = "n" * 300


@pytest.mark.parametrize(("folder", "name", "error", "words"), [
    ("/", "block", OccupiedError, "the root of all folders"),
    (LONG, "block", OutputError, "the name is too long; choose another folder"),
    (f"new/{LONG}/inner", "block", OutputError, "the name is too long; choose another folder"),
    (".", "n" * 245, OutputError, r"_cracks\.pvd: the name is too long; rename the case"),  # its .pvd could be
    ("new", "n" * 245, OutputError, r"_cracks\.pvd: the name is too long; rename the case"),
])  # fmt: skip
def test_folders_and_names_that_cannot_be_are_told_before_anything_is_made(
    folder: str, name: str, error: type[Exception], words: str, tmp_path: Path
) -> None:
    with pytest.raises(error, match=words):
        RunWriter(replace(make_case(), name=name), tmp_path / folder).begin()
    assert not list(tmp_path.iterdir())
