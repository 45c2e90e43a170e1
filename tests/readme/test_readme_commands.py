"""What is taken for a command of a README, and that the lists of those not run name nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.readme.commands import Command, commands
from tests.readme.run import EXIT_CODES, NEEDS_A_WINDOW, READMES, ROOT, all_commands, fault_of, run_beside


def test_indented_lines_are_shell_commands() -> None:
    block = "    make run CASE=a   # first\n    crackgrow trade a \\\n        --axis b=1\n"
    text = f"Text\n\n{block}\n- item\n    that goes on\n"
    assert commands(text) == [
        Command("make run CASE=a", 3, "sh"),
        Command("crackgrow trade a --axis b=1", 4, "sh"),
    ]


def test_fenced_blocks_say_what_they_are() -> None:
    text = "```console\n$ a b\n  1 2\n$ c\n```\n\n```python\nx = 1\n\nprint(x)\n```\n\n```bibtex\n@a\n```\n"
    assert commands(text) == [
        Command("a b", 2, "sh", ("  1 2",)),
        Command("c", 4, "sh"),
        Command("x = 1\n\nprint(x)", 8, "python"),
    ]


@pytest.mark.parametrize("text", ["```ruby\nputs 1\n```\n", "\n    make run \\\n"])
def test_blocks_that_cannot_be_run_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"README\.md:"):
        commands(text)


@pytest.mark.parametrize(
    ("command", "fault"),
    [
        (Command("echo 'a   b'; echo c", 1, "sh", ("a b", "c")), ""),
        (Command("echo 'a  -0.25 (1e-9, 3)'", 1, "sh", ("a 10.5 (2.0, 41)",)), ""),
        (Command("echo a", 1, "sh", ("b",)), "it does not print 'b'"),
        (Command("echo told >&2; exit 3", 1, "sh"), "exit code 3 instead of 0\ntold"),
    ],
)
def test_faults_of_a_command(tmp_path: Path, command: Command, fault: str) -> None:
    found = fault_of(command, tmp_path)
    assert found.startswith(fault)
    assert bool(found) == bool(fault)


def test_command_beside_others_runs_until_they_are_done(tmp_path: Path) -> None:
    with run_beside(Command("sleep 60 &", 1, "sh"), tmp_path):
        assert fault_of(Command("pgrep -P $PPID sleep", 2, "sh"), tmp_path) == ""
    assert fault_of(Command("pgrep -P $PPID sleep", 2, "sh"), tmp_path).startswith("exit code 1")
    with (
        pytest.raises(RuntimeError, match=r"README\.md:1: ended with exit code 0: true &"),
        run_beside(Command("true &", 1, "sh"), tmp_path),
    ):
        fault_of(Command("sleep 0.5", 2, "sh"), tmp_path)


def test_lists_name_commands_of_the_readmes() -> None:
    shown = {command.text for command in all_commands()}
    assert {*NEEDS_A_WINDOW, *EXIT_CODES} - shown == set()


def test_every_readme_is_run() -> None:
    files = (path.relative_to(ROOT) for path in ROOT.rglob("README.md"))
    written = {str(f) for f in files if f.parts[0] != "build" and not any(part.startswith(".") for part in f.parts)}
    assert written <= set(READMES)


def test_most_commands_are_run() -> None:
    shown = all_commands()
    assert {"make run CASE=compression30"} <= {command.text for command in shown}
    assert len(shown) > 2 * len(NEEDS_A_WINDOW)
