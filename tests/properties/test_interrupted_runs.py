"""Runs that are killed, interrupted, or run out of disk: what they leave is whole, and goes on to the same bits."""

from __future__ import annotations

import ctypes
import itertools
import json
import os
import random
import resource
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.properties.broken_off import (
    assert_whole,
    command,
    command_killed_at,
    contents,
    finished,
    started,
    wait_for,
)

COARSE = ("numerics.spacing=3", "growth.steps=4", "cracks.flaw.contact.friction=0.3", "output.figures=false")
TITLE = "compression30: "


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that nothing has broken off."""
    folder = tmp_path_factory.mktemp("unbroken")
    done = finished(command("compression30", COARSE, folder))
    assert (done.returncode, done.stderr) == (0, "")
    return folder


@pytest.mark.parametrize("n_kills", [3, pytest.param(100, marks=pytest.mark.slow)])
def test_a_run_killed_again_and_again_ends_as_if_nothing_had_happened(
    unbroken: Path, tmp_path: Path, n_kills: int
) -> None:
    whole, moments = contents(unbroken), random.Random(n_kills)
    process = started(command("compression30", COARSE, tmp_path / "timed"))
    wait_for(process, TITLE)
    began = time.perf_counter()
    process.communicate()
    longest = time.perf_counter() - began
    killed, chain, n_finished = 0, 0, 0
    while killed < n_kills or chain:
        folder = tmp_path / str(n_finished)
        process = started(command("compression30", COARSE, folder, "--resume"))
        wait_for(process, TITLE)
        try:
            process.wait(moments.uniform(0.0, 0.5 * longest) if killed < n_kills else None)
            assert process.returncode == 0
            assert contents(folder) == whole
            n_finished, chain = n_finished + 1, 0
        except subprocess.TimeoutExpired:
            process.kill()
            killed, chain = killed + 1, chain + 1
            process.wait()
            assert_whole(folder, whole)
        process.communicate()
    assert n_finished > 0


@pytest.mark.slow
def test_a_run_killed_at_any_change_of_its_files_goes_on(unbroken: Path, tmp_path: Path) -> None:
    whole = contents(unbroken)
    for operation in itertools.count(1, 17):
        folder = tmp_path / str(operation)
        killed = finished(command_killed_at(operation, "compression30", COARSE, folder))
        if killed.returncode == 0:
            break
        assert killed.returncode == -signal.SIGKILL
        assert_whole(folder, whole)
        done = finished(command("compression30", COARSE, folder, "--resume"))
        assert (done.returncode, done.stderr) == (0, "")
        assert contents(folder) == whole
        assert (folder / "report.html").is_file()
    assert operation > 150  # files that are not there are not removed, and do not count


@pytest.mark.parametrize(
    ("case", "settings", "last"),
    [
        ("cyclic_friction", ("numerics.spacing=10", "output.figures=false"), 12),
        ("compression30", (*COARSE[:3], "growth.unload_between_steps=false", "output.frames=first_and_last"), 2),
        pytest.param(
            *("flaw_and_hole", ("numerics.spacing=3", "growth.steps=4", "output.frames=none"), 3),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "two_flaws",
            ("numerics.spacing=3", "growth.steps=11", "output.frames=none", "output.figures=false"),
            10,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_any_kind_of_run_goes_on(tmp_path: Path, case: str, settings: tuple[str, ...], last: int) -> None:
    finished(command(case, settings, tmp_path / "unbroken"))
    process = started(command(case, settings, tmp_path / "broken"))
    assert wait_for(process, f"step {last}")
    process.kill()
    process.communicate()
    assert json.loads((tmp_path / "broken" / "summary.json").read_text())["status"] == "running"
    done = finished(command(case, settings, tmp_path / "broken", "--resume"))
    assert (done.returncode, done.stderr) == (0, "")
    assert f"goes on with step {last}" in done.stdout
    assert f"step {last - 1}" not in done.stdout
    assert contents(tmp_path / "broken") == contents(tmp_path / "unbroken")


def test_ctrl_c_ends_with_what_is_done_and_the_command_to_go_on(unbroken: Path, tmp_path: Path) -> None:
    process = started(command("compression30", COARSE, tmp_path / "out put"))
    assert wait_for(process, "step 1")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    summary = json.loads((tmp_path / "out put" / "summary.json").read_text())
    assert (summary["status"], summary["steps_done"] >= 1) == ("interrupted", True)
    told = err.splitlines()
    assert ["once more" in line for line in told] == [True, False]
    done = finished(shlex.split(told[1].split("go on with: ")[1]))
    assert (done.returncode, done.stderr) == (0, "")
    assert contents(tmp_path / "out put") == contents(unbroken)


def test_a_full_disk_keeps_the_steps_before_and_the_run_goes_on_when_there_is_room(
    unbroken: Path, tmp_path: Path
) -> None:
    sizes = [path.stat().st_size for path in sorted(unbroken.glob("frames/*"))]
    limit = max(sizes[:2])
    full = next(step for step, size in enumerate(sizes) if size > limit)
    done = finished(
        command("compression30", COARSE, tmp_path / "out"),
        before=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    assert done.returncode == 3
    assert "cannot write" in done.stderr
    assert f"step_{full:04d}.vtu" in done.stderr
    assert "Traceback" not in done.stderr
    steps = (tmp_path / "out" / "steps.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in steps] == [str(step) for step in range(full)]
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["status"] == "failed"
    done = finished(shlex.split(done.stderr.split("go on with: ")[1]))
    assert done.returncode == 0
    assert contents(tmp_path / "out") == contents(unbroken)


def obey_permissions() -> None:
    """Take the right to write everywhere from a process to be, which the superuser's have (Linux)."""
    if os.geteuid() == 0:
        drop, cap_dac_override = 24, 1
        ctypes.CDLL(None).prctl(drop, cap_dac_override, 0, 0, 0)


def test_a_folder_that_becomes_read_only_is_an_error_and_keeps_what_it_has(unbroken: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    first = ("growth.steps=1", *(setting for setting in COARSE if "steps" not in setting))
    assert finished(command("compression30", first, folder)).returncode == 0
    before = contents(folder)
    folder.chmod(0o555)
    touching = f"import pathlib; pathlib.Path({str(folder / 'touched')!r}).touch()"
    if finished([sys.executable, "-c", touching], obey_permissions).returncode == 0:
        pytest.skip("nothing is read-only for this user")
    for more in ((), ("--resume",)):
        done = finished(command("compression30", COARSE, folder, *more), obey_permissions)
        assert done.returncode == 3
        assert done.stderr.startswith("crackgrow: cannot ")
        assert str(folder) in done.stderr
        assert len(done.stderr.splitlines()) == 1
        assert contents(folder) == before
    folder.chmod(0o755)
    assert finished(command("compression30", COARSE, folder, "--resume")).returncode == 0
    assert contents(folder) == contents(unbroken)
