"""The command line: exit codes, messages, and what is left on disk however a run ends."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path

import pytest

import crackgrow
from crackgrow import cli
from crackgrow.case.model import Case
from crackgrow.errors import GeometryError, SolveError
from crackgrow.results import writer
from crackgrow.run.result import RunEnd, StepResult
from crackgrow.run.warning_causes import StepWarning
from tests.scenes import summary_of
from tests.unit.results.synthetic import make_case, make_end, make_result

ROOT = Path(__file__).resolve().parents[2]
COMPRESSION = str(ROOT / "cases" / "compression30.yaml")

Grow = Callable[[Case, object], Generator[StepResult, None, RunEnd]]


def growing(case: Case, checkpoint: object) -> Generator[StepResult, None, RunEnd]:
    for step in range(3):
        yield make_result(step, step_warnings=(StepWarning("NOTE", "thin cell"),))
    return make_end(3)


def breaking(error: BaseException, after: int = 2) -> Grow:
    def grow(case: Case, checkpoint: object) -> Generator[StepResult, None, RunEnd]:
        for step in range(after):
            yield make_result(step)
        raise error

    return grow


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a case file, as the current directory; loading and growing are stand-ins."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "block.yaml").write_text("title: A block with a crack\n")
    monkeypatch.setattr(crackgrow, "load_case", lambda path, overrides: make_case(frames="none"), raising=False)
    monkeypatch.setattr(crackgrow, "grow", growing, raising=False)
    return tmp_path


def n_rows(path: Path) -> int:
    return len(path.read_text().splitlines()) - 1


def test_run_writes_into_outputs_and_tells_of_every_step(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["run", "block.yaml"]) == 0
    assert summary_of(scene / "outputs" / "block")["status"] == "completed"
    out, err = capsys.readouterr()
    assert err == ""
    lines = out.splitlines()
    assert lines[0] == "block: A block with a crack"
    assert re.fullmatch(r"about \d+(\.\d)? s of CPU and \d+ MiB of memory", lines[1])
    assert cli.main(["check", "block.yaml"]) == 0
    assert f"the whole run takes {lines[1]}, within a factor of two" in capsys.readouterr().out  # one estimate
    assert [line.split(",")[0] for line in lines[2:5]] == ["step 0/2", "step 1/2", "step 2/2"]
    told = (
        r"step 0/2, load factor 1, criticality [\d.]+, .*flaw end \(tension\) K_I -?[\d.]+ K_II -?[\d.]+ \w+ sqrt\(m\),"
    )
    assert re.fullmatch(told + r" cracks [\d.]+ m+ long", lines[2])
    log = (scene / "outputs" / "block" / "run.log").read_text().splitlines()
    assert re.search(told + r".* \d+ dofs, \d contact iterations?, ", log[1])
    assert lines[5:] == [
        "warning: steps 0 to 2: thin cell",
        "estimated error: K by at most 1 % of the largest",
        "completed: 2 growth steps done",
        "results in outputs/block",
    ]


@pytest.mark.parametrize("columns", [80, 30])
def test_terminal_has_one_live_line_with_a_bar_where_there_is_room(
    columns: int, scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", str(columns))
    assert cli.main(["run", "block.yaml"]) == 0
    live = [line for line in re.split("[\r\n]", capsys.readouterr().out) if line.endswith("\x1b[K")]
    assert all(len(line.removesuffix("\x1b[K")) <= columns for line in live)
    if columns == 30:
        assert live[-1].startswith("step 2/2, load factor")
    else:
        told = r"\[#{10}\.{10}\] step 1/2, \d+ s left, load factor [\d.]+, criticality [\d.]+, crac"
        assert re.match(told, live[-2])
        assert re.search(r"step 2/2, load factor [\d.]+, criticality [\d.]+, cracks [\d.]+ m", live[-1])


def test_wrong_case_lists_its_faults_and_touches_nothing(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text("old")
    for command in (["run", COMPRESSION, "--out", str(tmp_path)], ["check", COMPRESSION]):
        assert cli.main([*command, "--set", "plane=strian", "--set", "x=1"]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert [line.split(":")[0] for line in err.splitlines()] == ["--set x", "--set plane"]
    assert (tmp_path / "summary.json").read_text() == "old"


@pytest.mark.parametrize(("error", "code", "status", "reason", "told"), [
    (SolveError("no convergence"), 3, "failed", "no convergence", "crackgrow: no convergence\n"),
    (GeometryError("no convergence"), 3, "failed", "no convergence", "crackgrow: no convergence\n"),
    (OSError(errno.EMFILE, "Too many open files", "/dev/null"), 3, "failed",
     "the system refuses: Too many open files: /dev/null",
     "crackgrow: the system refuses: Too many open files: /dev/null\n"),
    (ZeroDivisionError("oops"), 1, "failed", "internal error: ZeroDivisionError: oops", "Traceback"),
    (KeyboardInterrupt(), 130, "interrupted", "by Ctrl-C, after step 1",
     "crackgrow run block.yaml --set plane=strain --out 'my results' --resume\n"),
])  # fmt: skip
def test_a_run_that_breaks_off_keeps_its_results_and_says_why(
    error: BaseException, code: int, status: str, reason: str, told: str,
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(crackgrow, "grow", breaking(error))
    assert cli.main(["run", "block.yaml", "--set", "plane=strain", "--out", "my results"]) == code
    err = capsys.readouterr().err
    assert told in err
    assert ("Traceback" in err) == ("internal error" in err) == (code == 1)
    written = summary_of(scene / "my results")
    assert (written["status"], written["stop_reason"], written["n_solves"]) == (status, reason, 2)
    assert n_rows(scene / "my results" / "steps.csv") == 2


@pytest.mark.parametrize(("method", "code", "status"), [("add", 130, "interrupted"), ("finish", 0, "completed")])
def test_an_interrupt_waits_for_what_is_being_written(
    method: str, code: int, status: str,
    scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Of a step all of it is there, and a run whose end is written is complete."""
    write = getattr(writer.RunWriter, method)

    def pressed(self: writer.RunWriter, what: object) -> None:
        signal.raise_signal(signal.SIGINT)
        write(self, what)

    monkeypatch.setattr(writer.RunWriter, method, pressed)
    assert cli.main(["run", "block.yaml"]) == code
    assert ("go on with" in capsys.readouterr().err) == (code == 130)
    written, n = summary_of(scene / "outputs" / "block"), 1 if code else 3
    assert (written["status"], written["n_solves"], n_rows(scene / "outputs" / "block" / "steps.csv")) == (status, n, n)


STUCK = """
import hashlib, sys
import crackgrow
from crackgrow import cli
def stuck(case, checkpoint):
    print("stuck", flush=True)
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # minutes in a library that never looks for signals
    yield
crackgrow.grow = stuck
sys.exit(cli.main(["run", sys.argv[1]]))
"""


@pytest.mark.physics
def test_a_second_interrupt_ends_what_a_library_is_doing(tmp_path: Path) -> None:
    words = [sys.executable, "-c", STUCK, str(ROOT / "cases" / "block_rigid.yaml")]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(words, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)}, **pipes) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert "stuck\n" in iter(process.stdout.readline, "")
        time.sleep(1.0)  # until it is in the library
        process.send_signal(signal.SIGINT)
        assert "once more ends it at once" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 130
        assert process.stderr.read() == ""
    assert summary_of(tmp_path / "outputs" / "block_rigid")["status"] == "running"  # as that of a run that was killed


def test_case_file_in_the_folder_of_the_results_is_not_replaced(
    scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["run", "block.yaml", "--out", "slope", "--quiet"]) == 0
    (scene / "slope" / "case.yaml").write_text("# mine\n")
    assert cli.main(["run", "slope/case.yaml", "--out", "slope"]) == 2
    assert capsys.readouterr().err.startswith("crackgrow: slope/case.yaml is the case itself, which the run would")
    assert (scene / "slope" / "case.yaml").read_text() == "# mine\n"
    assert cli.main(["run", "slope/case.yaml", "--out", "other"]) == 0


def test_check_tells_its_plan_in_words_or_as_json_and_draws(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    settings = ("--set", "numerics.spacing=4", "--set", "cracks.flaw.contact.friction=0.3")
    words = ["check", COMPRESSION, *settings, "--unique"]
    picture = tmp_path / "scene.png"
    assert cli.main([*words, "--picture", str(picture)]) == 0
    out = capsys.readouterr().out
    assert "solutions of the contact\n  at load factor 1: " in out
    assert f"picture in {picture}" in out
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert cli.main([*words, "--json"]) == 0
    plan = json.loads(capsys.readouterr().out)
    assert (plan["case"], plan["spacing"]) == ("compression30", 0.004)
    assert plan["model"]["n_tips"] == 2
    assert plan["model"]["surfaces"] == [
        {"name": "flaw", "n_points": plan["model"]["n_contact"], "bonded": False, "touching": True, "rough": True}
    ]
    assert set(plan["cost"]) == {"seconds", "memory", "n_dofs"}
    assert plan["cost"]["n_dofs"] == plan["model"]["n_dofs"]
    assert all(isinstance(text, str) for text in [*plan["warnings"], *plan["unique"]])


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_what_a_command_prints_is_not_lost_without_a_word() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "crackgrow", "schema"], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 3
    assert done.stderr == "crackgrow: cannot write standard output: No space left on device\n"
