"""A system that gives little: memory that runs out, few open files. It is told in a sentence, and results are kept."""

from __future__ import annotations

import json
import re
import resource
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.properties.broken_off import command, contents, finished

MIB = 2**20
COARSE = ("numerics.spacing=3", "growth.steps=1")


def limited(kind: int, limit: int) -> Callable[[], None]:
    """Set a limit of the system in a process that begins."""
    return lambda: resource.setrlimit(kind, (limit, limit))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit addresses")
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
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["status"], summary["stop_reason"]) == ("failed", after.removeprefix("crackgrow: "))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not limit addresses")
@pytest.mark.parametrize("mib", [600, 605, 610, 615, 620, 630, 640, 650, 660, 680])
def test_steps_are_kept_where_there_is_no_room_for_pictures(mib: int, tmp_path: Path) -> None:
    """Libraries that do not load for want of memory are such as well."""
    scarce = finished(command("compression30", COARSE, tmp_path / "out"), limited(resource.RLIMIT_AS, mib * MIB))
    told = re.sub("Exception ignored in: .*\nTraceback", "", scarce.stderr)  # matplotlib's own, whom nobody can ask
    assert "Traceback" not in told
    assert scarce.returncode in (0, 3)
    if scarce.returncode == 3:
        assert "crackgrow: out of memory" in scarce.stderr
        assert json.loads((tmp_path / "out" / "summary.json").read_text())["status"] == "failed"
        assert finished(command("compression30", COARSE, tmp_path / "out", "--resume")).returncode == 0
    finished(command("compression30", COARSE, tmp_path / "alone"))
    assert contents(tmp_path / "out") == contents(tmp_path / "alone")


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
