"""The writer: what was solved is on disk after every step, whatever ends the run."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista

from crackgrow.errors import SolveError
from crackgrow.results import writer as writer_module
from crackgrow.results.atomic import OccupiedError, OutputError
from crackgrow.results.leftovers import OWN_KEYS
from crackgrow.results.lock import LOCK
from crackgrow.results.writer import RunWriter
from crackgrow.run.result import RunEnd
from tests.unit.results.synthetic import make_case, make_end, make_event, make_paths, make_result


@pytest.fixture(autouse=True)
def dumped_case(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer_module, "dump_case", lambda case: f"title: {case.title}\n")


def column(path: Path, name: str) -> list[str]:
    with path.open(newline="") as file:
        return [row[name] for row in csv.DictReader(file)]


def files(folder: Path) -> set[str]:
    """All but the lock of a run that goes on."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file() and path.name != LOCK}


def a_run_s(folder: Path) -> Path:
    """A folder in which a run has begun, and ended."""
    writer = RunWriter(make_case(), folder)
    writer.begin()
    writer.finish(make_end(0))
    return folder


TABLES = {
    "case.yaml", "run.log", "tips.csv", "paths.csv", "contact.csv", "reactions.csv", "steps.csv", "events.csv",
    "summary.json",
}  # fmt: skip


def test_everything_is_on_disk_after_every_step(tmp_path: Path) -> None:
    writer = RunWriter(make_case(), tmp_path / "out")
    writer.begin()
    assert files(tmp_path / "out") == TABLES
    assert (tmp_path / "out" / "case.yaml").read_text() == "title: A block with a crack\n"
    for step in range(3):
        writer.add(make_result(step))
        steps = [str(k) for k in range(step + 1)]
        assert column(tmp_path / "out" / "steps.csv", "step") == steps
        assert column(tmp_path / "out" / "tips.csv", "step") == [k for k in steps for _ in range(2)]
        assert sorted(set(column(tmp_path / "out" / "contact.csv", "step"))) == steps
        assert len(column(tmp_path / "out" / "paths.csv", "x")) == 2 + step
        for series in ("block.pvd", "block_cracks.pvd"):
            assert pyvista.get_reader(tmp_path / "out" / series).time_values == list(range(step + 1))
        assert pyvista.read(tmp_path / "out" / "frames" / f"step_{step:04d}.vtu").n_points > 0
        summary = json.loads((tmp_path / "out" / "summary.json").read_text())
        assert (summary["status"], summary["steps_done"], summary["n_solves"]) == ("running", step, step + 1)
        assert f"step {step}/2" in (tmp_path / "out" / "run.log").read_text()
    writer.finish(make_end(3))
    assert len(column(tmp_path / "out" / "paths.csv", "x")) == 5
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["status"] == "completed"
    frames = {f"{kind}/step_000{k}.{end}" for k in range(3) for kind, end in (("frames", "vtu"), ("cracks", "vtp"))}
    assert files(tmp_path / "out") == TABLES | frames | {"block.pvd", "block_cracks.pvd"}


def test_events_are_on_disk_and_in_the_log_as_they_come(tmp_path: Path) -> None:
    writer = RunWriter(make_case(frames="none"), tmp_path)
    writer.begin()
    assert column(tmp_path / "events.csv", "kind") == []
    writer.add(make_result(0))
    writer.add(make_result(1, events=(make_event(1), make_event(1, tip="start", met="its own path"))))
    assert column(tmp_path / "events.csv", "met") == ["crack 'b, the second'", "its own path"]
    line = "step 1, coalescence: crack 'flaw' (end) reached crack 'b, the second' at (12 mm, 2 mm)"
    assert (tmp_path / "run.log").read_text().count(line) == 1
    last = make_event(2, kind="break_through", met="the outline of body 'rock'")
    writer.finish(RunEnd("broke_through", "a piece came loose", make_paths(2), (last,)))
    assert column(tmp_path / "events.csv", "step") == ["1", "1", "2"]
    assert "step 2, break_through: crack 'flaw' (end) reached the outline" in (tmp_path / "run.log").read_text()
    assert [event["step"] for event in json.loads((tmp_path / "summary.json").read_text())["events"]] == [1, 1, 2]


@pytest.mark.parametrize(("factors", "is_drawn"), [([1.0, 1.0, 1.0], False), ([1.0, 0.8, 0.9], True)])
def test_load_curve_is_drawn_where_the_load_factor_changes(
    tmp_path: Path, factors: list[float], is_drawn: bool
) -> None:
    writer = RunWriter(make_case(frames="none", figures=True), tmp_path)
    writer.begin()
    for step, factor in enumerate(factors):
        writer.add(make_result(step, load_factor=factor, mesh=None))
    writer.finish(make_end(2))
    assert ("figures/load_curve.png" in files(tmp_path)) == is_drawn


@pytest.mark.parametrize("n_steps", [1, 2])
def test_a_picture_of_the_first_step_is_that_of_the_last_where_there_is_no_other(tmp_path: Path, n_steps: int) -> None:
    writer = RunWriter(make_case(frames="none", figures=True), tmp_path)
    writer.begin()
    for step in range(n_steps):
        writer.add(make_result(step))
    writer.finish(make_end(n_steps - 1))
    first, last = ((tmp_path / "figures" / f"sigma_1_{name}.png").read_bytes() for name in ("first", "last"))
    assert (first == last) == (n_steps == 1)


@pytest.mark.parametrize(("policy", "steps"), [("every_step", [0, 1, 2]), ("first_and_last", [0, 2]), ("none", [])])
def test_frames_policy(tmp_path: Path, policy: str, steps: list[int]) -> None:
    writer = RunWriter(make_case(frames=policy), tmp_path)
    writer.begin()
    for step in range(3):
        writer.add(make_result(step))
    writer.finish(make_end(2))
    assert sorted(path.name for path in tmp_path.glob("frames/*")) == [f"step_{step:04d}.vtu" for step in steps]
    assert sorted(path.name for path in tmp_path.glob("cracks/*")) == [f"step_{step:04d}.vtp" for step in steps]
    assert [path.name for path in tmp_path.glob("*.pvd") if "cracks" not in path.name] == ["block.pvd"] * bool(steps)


def test_first_and_last_of_one_step_is_one_frame(tmp_path: Path) -> None:
    writer = RunWriter(make_case(frames="first_and_last"), tmp_path)
    writer.begin()
    writer.add(make_result(0))
    writer.finish(make_end(0))
    assert len(pyvista.get_reader(tmp_path / "block.pvd").datasets) == 1


def test_failed_run_keeps_what_was_solved(tmp_path: Path) -> None:
    writer = RunWriter(make_case(figures=True), tmp_path)
    writer.begin()
    writer.add(make_result(0))
    writer.add(make_result(1))
    writer.break_off(SolveError("contact did not converge"))
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["status"], summary["stop_reason"]) == ("failed", "contact did not converge")
    assert (summary["steps_done"], summary["n_solves"]) == (1, 2)
    assert column(tmp_path / "steps.csv", "step") == ["0", "1"]
    assert len(column(tmp_path / "paths.csv", "x")) == 3
    assert {"figures/path.png", "figures/sigma_1_first.png", "figures/sigma_1_last.png"} <= files(tmp_path)
    assert "failed: contact did not converge" in (tmp_path / "run.log").read_text()


def test_run_that_fails_before_its_first_step(tmp_path: Path) -> None:
    writer = RunWriter(make_case(figures=True), tmp_path)
    writer.begin()
    writer.break_off(SolveError("no support"))
    assert files(tmp_path) == TABLES
    assert json.loads((tmp_path / "summary.json").read_text())["steps_done"] == 0


def test_step_without_mesh_and_cracks_writes_no_frame(tmp_path: Path) -> None:
    writer = RunWriter(make_case(figures=True), tmp_path)
    writer.begin()
    writer.add(make_result(0, mesh=None, faces=()))
    writer.finish(make_end(0))
    assert files(tmp_path) == TABLES | {"figures/path.png"}


def test_figure_that_fails_does_not_take_the_summary_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise ValueError("no figure")

    monkeypatch.setattr("crackgrow.results.figures.draw_paths", refuse)
    writer = RunWriter(make_case(figures=True), tmp_path)
    writer.begin()
    writer.add(make_result(0))
    with pytest.raises(ValueError, match="no figure"):
        writer.finish(make_end(0))
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "completed"


def test_earlier_results_go_and_other_files_stay(tmp_path: Path) -> None:
    mine = ["block.pvd", "frames/step_0007.vtu", "frames/step_12345.vtu", "frames/.step_0008.tmp.vtu",
            "cracks/step_0007.vtp", "figures/path.png", ".summary.tmp.json", "figures/load_curve.png", "report.html",
            "render/sigma_1/step_0007.png", "render/sigma_1/animation.gif"]  # fmt: skip
    others = ["notes.txt", "other.pvd", "frames/step_1.vtu", "frames/mine.vtu", "figures/own.png",
              "cracks/step_0007.csv", "checkpoint/state", "render/sigma_1/own.png"]  # fmt: skip
    a_run_s(tmp_path)
    for name in mine + others:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    RunWriter(make_case(), tmp_path).begin()
    assert files(tmp_path) == TABLES | set(others)
    assert all((tmp_path / name).read_text() == name for name in others)


@pytest.mark.parametrize("left", [None, ""])
def test_a_folder_that_has_lost_its_summary_is_still_a_run_s(left: str | None, tmp_path: Path) -> None:
    """As a loss of power may leave it: the log tells."""
    (a_run_s(tmp_path) / "summary.json").unlink()
    if left is not None:
        (tmp_path / "summary.json").write_text(left)
    RunWriter(make_case(), tmp_path).begin()
    assert json.loads((tmp_path / "summary.json").read_text())["status"] == "running"


OWN = json.dumps(dict.fromkeys(OWN_KEYS, "mine"))
FOREIGN = {
    "a text": b"what I found",
    "half a summary": b'{"case": "blo',
    "of another program": b'{"case": "a", "status": "ok", "stop_reason": "done", "version": "7"}',
    "lines of JSON": f"{OWN}\n{OWN}\n".encode(),
    "UTF-16": OWN.encode("utf-16"),
    "a list": b"[" * 100_000,
}


@pytest.mark.parametrize("content", FOREIGN.values(), ids=FOREIGN)
def test_a_summary_that_no_run_has_written_is_not_replaced(content: bytes, tmp_path: Path) -> None:
    for folder in (tmp_path, a_run_s(tmp_path / "with files of a run")):
        (folder / "summary.json").write_bytes(content)
        before = files(folder)
        with pytest.raises(OccupiedError, match=r"summary\.json.* would be replaced") as caught:
            RunWriter(make_case(), folder).begin()
        assert caught.value.exit_code == 2
        assert (files(folder), (folder / "summary.json").read_bytes()) == (before, content)


@pytest.mark.parametrize(
    "name",
    ["summary.json", "checkpoint/step_0000.npz", "checkpoint/step_12345.npz", "render/sigma_1/step_0001.png",
     "render/mine/animation.gif", "run.log", "figures/path.png", ".steps.tmp.csv"],
)  # fmt: skip
def test_no_file_of_a_stranger_goes(name: str, tmp_path: Path) -> None:
    """Empty, of text, an archive of numbers: whatever it holds."""
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    archive = io.BytesIO()
    np.savez(archive, header=np.frombuffer(b'{"format": 2}', dtype=np.uint8))
    for content in (b"", b"mine", archive.getvalue()):
        path.write_bytes(content)
        with pytest.raises(OccupiedError, match="would be replaced"):
            RunWriter(make_case(), tmp_path).begin()
        assert (files(tmp_path), path.read_bytes()) == ({name}, content)


def test_the_root_of_all_folders_is_none_for_results() -> None:
    with pytest.raises(OccupiedError, match="the root of all folders"):
        RunWriter(make_case(), Path("/")).begin()


def test_names_that_the_file_system_refuses_are_told_before_anything_is_made(tmp_path: Path) -> None:
    long = "n" * 300
    for folder in (tmp_path / long, tmp_path / "new" / long / "inner"):
        with pytest.raises(OutputError, match="the name is too long; choose another folder"):
            RunWriter(make_case(), folder).begin()
    case = replace(make_case(), name="n" * 245)  # its .pvd could be, that of its cracks not
    for folder in (tmp_path, tmp_path / "new"):
        with pytest.raises(OutputError, match=r"_cracks\.pvd: the name is too long; rename the case"):
            RunWriter(case, folder).begin()
    assert not files(tmp_path)
    assert not list(tmp_path.iterdir())


def test_series_of_another_case_go_with_its_frames(tmp_path: Path) -> None:
    writer = RunWriter(make_case(), tmp_path)
    writer.begin()
    writer.add(make_result(0))
    writer.finish(make_end(0))
    assert {"block.pvd", "block_cracks.pvd"} < files(tmp_path)
    RunWriter(replace(make_case(), name="other"), tmp_path).begin()
    assert files(tmp_path) == TABLES
