"""What is taken for a command of a README, and that the lists of those not run name nothing else."""

from __future__ import annotations

from tests.readme.run import EXIT_CODES, NEEDS_A_WINDOW, READMES, ROOT, all_commands


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
