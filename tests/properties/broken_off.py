"""Runs of the command line in processes of their own, that are killed or run out of disk, and what they must leave."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "cases"
TABLES = ("tips.csv", "contact.csv", "reactions.csv", "steps.csv", "events.csv")
TIMES = ("wall_seconds", "cpu_seconds", "peak_memory_mb", "resumed_with_steps", "git_commit", "git_modified")
"""Of the summary."""

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def command(case: str, settings: Sequence[str], folder: Path, *more: str) -> list[str]:
    """The command line of a run."""
    words = [word for setting in settings for word in ("--set", setting)]
    return [sys.executable, "-m", "crackgrow", "run", str(CASES / f"{case}.yaml"), "--out", str(folder), *words, *more]


KILLED_AT = """
import os, signal, sys
from crackgrow import cli

folder, left = sys.argv[1], int(sys.argv[2])

def look(event, arguments):
    global left
    changes = event in ("os.rename", "os.remove", "os.truncate", "os.mkdir")
    if (changes or event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR)) and folder in str(arguments[0]):
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)

sys.addaudithook(look)
sys.exit(cli.main(sys.argv[3:]))
"""


def command_killed_at(operation: int, case: str, settings: Sequence[str], folder: Path, *more: str) -> list[str]:
    """The same of a run that is killed when it is about to change the files of its folder for the n-th time."""
    python, _, _, *words = command(case, settings, folder, *more)
    return [python, "-c", KILLED_AT, str(folder), str(operation), *words]


def finished(words: Sequence[str], before: Callable[[], None] | None = None) -> subprocess.CompletedProcess[str]:
    """The process, run to its end."""
    return subprocess.run(
        words, capture_output=True, text=True, check=False, env=ENVIRONMENT, preexec_fn=before, timeout=600
    )


def started(words: Sequence[str]) -> subprocess.Popen[str]:
    """The process, whose lines can be read as they come."""
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)


def wait_for(process: subprocess.Popen[str], start: str) -> bool:
    """Read lines until one begins with `start`; whether one did."""
    assert process.stdout is not None
    return any(line.startswith(start) for line in process.stdout)


def contents(folder: Path) -> dict[str, object]:
    """What files of a run hold, but for times, pictures, the log, the report and checkpoints."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_dir() or name in ("run.log", "report.html") or name.startswith("checkpoint/"):
            continue
        if name == "steps.csv":
            found[name] = without_times(path.read_text())
        elif name == "summary.json":
            found[name] = {key: value for key, value in json.loads(path.read_text()).items() if key not in TIMES}
        else:
            found[name] = b"a picture" if path.suffix == ".png" else path.read_bytes()
    return found


def without_times(table: str) -> str:
    """steps.csv without its seconds."""
    rows = list(csv.reader(io.StringIO(table)))
    kept = [number for number, name in enumerate(rows[0]) if not name.startswith("seconds_")]
    return "\n".join(",".join(row[number] for number in kept) for row in rows)


def assert_whole(folder: Path, whole: dict[str, object]) -> None:
    """Each file that there is under its own name is complete: tables, frames are a part of the whole run's."""
    for name in TABLES:
        path = folder / name
        if not path.is_file():
            continue
        table = path.read_text()
        assert table.endswith("\n"), name
        mine = without_times(table) if name == "steps.csv" else table.encode()
        assert whole[name].startswith(mine), name  # type: ignore[attr-defined]
    for path in (*folder.glob("frames/step_*"), *folder.glob("cracks/step_*")):
        assert path.read_bytes() == whole[str(path.relative_to(folder))], path
    for path in folder.glob("[!.]*.pvd"):
        listed = re.findall('file="([^"]+)"', path.read_text())
        assert path.read_text().endswith("</VTKFile>\n")
        assert all((folder / name).is_file() for name in listed), path
    if (folder / "summary.json").is_file():
        assert json.loads((folder / "summary.json").read_text())["status"] in ("running", "completed")
