"""Run the commands of all READMEs, in their order, in a copy of the checkout. Exit code 1: one of them fails.

python -m tests.readme.run [--only FILE ...]

An indented block holds shell commands, one a line, or longer with a backslash at the end. A fenced block says what it
is: `sh` the same, `console` commands after `$ ` with what they print below, `python` a program; other words are text.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

READMES = (
    "README.md", "cases/README.md", "cases/MODEL.md", "cases/CONTACT.md", "cases/LOADS.md", "cases/GROWTH.md",
    "cases/STARTS.md", "cases/ACCURACY.md", "cases/KEYS.md", "cases/PYTHON.md", "cases/GLOSSARY.md", "cases/MAPS.md",
    "cases/sweeps/README.md",
    "outputs/README.md", "crackgrow/README.md", "tests/README.md", "tests/verification/README.md",
    "tests/benchmarks/README.md", "tests/stability/README.md", "tests/experiments/README.md",
)  # fmt: skip
"""All that is written for people, in the order in which one may read it; later ones use results of earlier ones."""

NEEDS_A_WINDOW = ("paraview outputs/compression30/compression30.pvd", "paraview outputs/my_rock/my_rock.pvd")
"""Never run: the program is none of ours, and waits for its user."""

EXIT_CODES = {"crackgrow trade cases/compression30.yaml --steps 4": 4}
"""Of commands that are meant to end otherwise than with 0."""

BESIDE = " &"
"""How a command ends that the next ones need running: it must run until all are done."""

COPIED = (
    "Makefile", "README.md", "pyproject.toml", ".requirements.lock", "cases", "tests", "outputs/README.md",
)  # fmt: skip
TIMEOUT = 1800  # s
SHOWN_LINES = 30  # of a command that fails, its last ones
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$|(?<=\n\n)((?:    [^\n]*\n)+)", re.MULTILINE | re.DOTALL)
"""A fenced block, its language first, or an indented one."""

SHELL = {"sh": re.compile(r"(?:.*\\\n)*.+"), "console": re.compile(r"(?<=^\$ ).*(?:\n(?!\$ ).+)*", re.MULTILINE)}
"""A command in such a block: its lines, and for `console` what it prints."""

TEXTS = ("bibtex", "yaml", "text")
COMMENT = re.compile(r"\s+# .*$")
NUMBER = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the commands; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=READMES, metavar="FILE", help="the commands of these alone")
    arguments = parser.parse_args(argv)
    failed, n_run = 0, 0
    with tempfile.TemporaryDirectory() as name, ExitStack() as beside:
        folder = checkout(Path(name))
        for command in all_commands(arguments.only or READMES):
            if command.text in NEEDS_A_WINDOW:
                print(f"{command.place}: left out: {command.text}", flush=True)
                continue
            if command.text.endswith(BESIDE):
                print(f"{command.place}: runs beside the next ones: {command.text}", flush=True)
                beside.enter_context(run_beside(command, folder))
                continue
            started = time.perf_counter()
            fault = fault_of(command, folder)
            words = f"FAILED, {fault}" if fault else "done"
            print(f"{command.place}: {time.perf_counter() - started:.0f} s, {words}: {command.text}", flush=True)
            failed, n_run = failed + bool(fault), n_run + 1
    print(f"{n_run - failed} passed, {failed} failed")
    return 1 if failed else 0


@dataclass(frozen=True, slots=True)
class Command:
    """A command of a README."""

    text: str
    place: str
    language: str  # sh | python
    prints: tuple[str, ...] = ()  # lines that the README shows of its output


def commands(text: str, file: str) -> Iterator[Command]:
    """All commands of a README, in order; raises ValueError for a block that is none of those above."""
    for block in BLOCK.finditer(text):
        fenced = block[3] is None
        language, inner = (block[1], block[2]) if fenced else ("sh", block[3])
        first = text[: block.start(2 if fenced else 3)].count("\n") + 1
        if language == "python":
            yield Command(inner.rstrip("\n"), f"{file}:{first}", language)
        elif language in SHELL:
            for found in SHELL[language].finditer(inner):
                place = f"{file}:{first + inner[: found.start()].count(chr(10))}"
                command, *prints = found[0].splitlines() if language == "console" else [joined(found[0])]
                yield Command(command, place, "sh", tuple(prints))
        elif language not in TEXTS:
            raise ValueError(f"{file}:{first}: a block of {language!r}: wanted is sh, console, python, {TEXTS}")


def joined(lines: str) -> str:
    """A command that goes on over several lines as one, without comments."""
    return "".join(COMMENT.sub("", line.strip()).removesuffix("\\") for line in lines.splitlines())


def all_commands(files: Sequence[str] = READMES) -> list[Command]:
    """The commands of some READMEs, in order."""
    return [command for file in files for command in commands((ROOT / file).read_text(encoding="utf-8"), file)]


def checkout(folder: Path) -> Path:
    """A copy of what commands read and write, with the environment of the checkout, which has the package itself."""
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            (folder / name).parent.mkdir(exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)  # with its time, which says whether the environment is up to date
    (folder / ".venv").symlink_to(ROOT / ".venv")
    return folder


def fault_of(command: Command, folder: Path) -> str:
    """Run a command; what is wrong with how it ends or what it prints, empty if nothing is."""
    shell = {"sh": ["bash", "-c"], "python": [str(ROOT / ".venv/bin/python"), "-c"]}[command.language]
    done = subprocess.run(
        [*shell, command.text], cwd=folder, env=environment(folder), stdin=subprocess.DEVNULL, capture_output=True,
        text=True, timeout=TIMEOUT, check=False,
    )  # fmt: skip
    wanted = EXIT_CODES.get(command.text, 0)
    if done.returncode != wanted:
        said = f"{done.stdout}{done.stderr}".splitlines()[-SHOWN_LINES:]
        return "\n".join([f"exit code {done.returncode} instead of {wanted}", *said, ""])
    printed = {without_numbers(line) for line in done.stdout.splitlines()}
    missing = [line for line in command.prints if without_numbers(line) not in printed]
    return f"it does not print {missing[0]!r} but\n{done.stdout}" if missing else ""


@contextmanager
def run_beside(command: Command, folder: Path) -> Iterator[None]:
    """Have a command run for as long as the context lasts; raises RuntimeError if it ends before."""
    process = subprocess.Popen(
        ["bash", "-c", f"exec {command.text.removesuffix(BESIDE)}"], cwd=folder, env=environment(folder),
        stdin=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip
    try:
        yield
        if process.poll() is not None:
            raise RuntimeError(f"{command.place}: ended with exit code {process.returncode}: {command.text}")
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGTERM)  # with the processes it has begun
        process.wait()


def environment(folder: Path) -> dict[str, str]:
    """That of the commands: programs of the checkout's environment, tests of the copy."""
    path = os.pathsep.join([str(ROOT / ".venv/bin"), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(folder)}


def without_numbers(line: str) -> str:
    """A line's words: its numbers may be those of another version or machine, its blanks follow from them."""
    return " ".join(NUMBER.sub("#", line).split())


if __name__ == "__main__":
    sys.exit(main())
