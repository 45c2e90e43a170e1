"""Runs that are killed, interrupted, out of disk or memory: what they leave is whole, and goes on to the same bits.

Kernels that an earlier run has left give the same bits, too.
"""

from __future__ import annotations

import re
import resource
import shlex
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from tests.properties.broken_off import (
    ENVIRONMENT,
    assert_whole,
    command,
    command_killed_at,
    contents,
    finished,
    started,
    wait_for,
)
from tests.scenes import summary_of

COARSE = ("numerics.spacing=3", "growth.steps=4", "cracks.flaw.contact.friction=0.3", "output.figures=false")
MIB = 2**20


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run that nothing has broken off."""
    folder = tmp_path_factory.mktemp("unbroken")
    done = finished(command("compression30", COARSE, folder))
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def assert_goes_on(words: Sequence[str], folder: Path, whole: dict[str, object]) -> str:
    """The command ends without a complaint and leaves what the whole run has; returns what it prints."""
    done = finished(words)
    assert (done.returncode, done.stderr) == (0, "")
    assert contents(folder) == whole
    return done.stdout


@pytest.mark.parametrize("operations", [(110,), pytest.param(range(1, 240, 17), marks=pytest.mark.slow)], ids=len)
def test_a_run_killed_at_any_change_of_its_files_goes_on(
    unbroken: Path, tmp_path: Path, operations: Sequence[int]
) -> None:
    """Also one that is killed again as it goes on."""
    whole, n_killed = contents(unbroken), 0
    for operation in operations:
        folder = tmp_path / str(operation)
        for number, more in ((operation, ()), (operation // 2 + 1, ("--resume",))):
            killed = finished(command_killed_at(number, "compression30", COARSE, folder, *more))
            if killed.returncode == 0:
                break
            assert killed.returncode == -signal.SIGKILL
            assert_whole(folder, whole)
            n_killed += 1
        assert_goes_on(command("compression30", COARSE, folder, "--resume"), folder, whole)
        assert (folder / "report.html").is_file()
    assert n_killed >= min(len(operations), 9)  # files that are not there are not removed, and do not count


def test_ctrl_c_ends_with_what_is_done_and_the_command_to_go_on(unbroken: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out put"
    process = started(command("compression30", COARSE, folder))
    assert wait_for(process, "step 1")
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    summary = summary_of(folder)
    assert (summary["status"], summary["steps_done"] >= 1) == ("interrupted", True)
    told = err.splitlines()
    assert ["once more" in line for line in told] == [True, False]
    printed = assert_goes_on(shlex.split(told[1].split("go on with: ")[1]), folder, contents(unbroken))
    assert f"goes on with step {summary['steps_done']}" in printed
    assert "step 0" not in printed


def limited(kind: int, limit: int) -> Callable[[], None]:
    """Set a limit of the system in a process that begins."""
    return lambda: resource.setrlimit(kind, (limit, limit))


def test_a_full_disk_keeps_the_steps_before_and_the_run_goes_on_when_there_is_room(
    unbroken: Path, tmp_path: Path
) -> None:
    folder, sizes = tmp_path / "out", [path.stat().st_size for path in sorted(unbroken.glob("frames/*"))]
    limit = max(sizes[:2])
    full = next(step for step, size in enumerate(sizes) if size > limit)
    done = finished(command("compression30", COARSE, folder), limited(resource.RLIMIT_FSIZE, limit))
    assert done.returncode == 3
    assert "cannot write" in done.stderr
    assert f"step_{full:04d}.vtu" in done.stderr
    assert "Traceback" not in done.stderr
    steps = (folder / "steps.csv").read_text().splitlines()[1:]
    assert [row.split(",")[0] for row in steps] == [str(step) for step in range(full)]
    assert summary_of(folder)["status"] == "failed"
    assert_goes_on(shlex.split(done.stderr.split("go on with: ")[1]), folder, contents(unbroken))


ONLY_LINUX = pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit addresses")


@ONLY_LINUX
def test_memory_that_runs_out_is_told_with_what_the_scene_needs_and_what_to_change(tmp_path: Path) -> None:
    large = ("numerics.spacing=0.2", "growth.steps=0")
    done = finished(command("compression30", large, tmp_path / "out"), limited(resource.RLIMIT_AS, 750 * MIB))
    assert done.returncode == 3
    before, after = done.stderr.splitlines()
    assert re.match(r"warning: the run needs about \d GiB of memory", before)
    assert "and this machine has 750 MiB" in before
    assert re.match("crackgrow: out of memory: (Allocation failed|Unable to allocate) ", after)  # kernels; NumPy
    assert "a larger numerics.spacing takes less" in after
    assert "(the run takes about 89488 dofs, 1 GiB" in after
    summary = summary_of(tmp_path / "out")
    assert (summary["status"], summary["stop_reason"]) == ("failed", after.removeprefix("crackgrow: "))


@pytest.mark.parametrize(
    ("kind", "limit", "told"),
    [
        (resource.RLIMIT_AS, 300 * MIB, "307200 KiB of addresses are allowed (`ulimit -v`), the program takes"),
        (resource.RLIMIT_NOFILE, 6, "6 open files are allowed (`ulimit -n`), the program takes at least 10"),
    ],
)
def test_less_than_the_program_itself_takes_is_told_at_once(kind: int, limit: int, told: str, tmp_path: Path) -> None:
    done = finished(command("compression30", COARSE, tmp_path / "out"), limited(kind, limit))
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.startswith(f"crackgrow: {told}")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_kernels_that_are_compiled_or_loaded_give_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a kernel calls is compiled into it: else the process would take whichever version it met first."""
    monkeypatch.setitem(ENVIRONMENT, "NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    settings = ("growth.steps=1", "output.figures=false")
    for name in ("compiled", "loaded"):
        assert finished(command("compression30", settings, tmp_path / name)).returncode == 0
    assert contents(tmp_path / "compiled") == contents(tmp_path / "loaded")
