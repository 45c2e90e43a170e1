"""Completion scripts: bash is asked what it would complete; the others name every command and option."""

from __future__ import annotations

import os
import pty
import subprocess
from pathlib import Path

import pytest

from crackgrow.cli.command_line import command_line
from crackgrow.cli.tools import SHELLS, completion_script


def completed(line: list[str], folder: Path) -> set[str]:
    """What bash offers for the last word of a command line."""
    (folder / "script").write_text(completion_script(command_line(), "bash"))
    words = " ".join(f"'{word}'" for word in line)
    ask = f"source ./script; COMP_WORDS=({words}); COMP_CWORD={len(line) - 1}; _shtab_crackgrow; "
    ask += 'printf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(["bash", "-c", ask], cwd=folder, capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "one.yaml").write_text("")
    (tmp_path / "cases" / "my rock.yml").write_text("")
    (tmp_path / "cases" / "notes.txt").write_text("")
    return tmp_path


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        (["crackgrow", "ch"], {"check"}),
        (["crackgrow", "--v"], {"--version"}),
        (["crackgrow", "check", "--p"], {"--picture"}),
        (["crackgrow", "run", "ca"], {"cases"}),
        (["crackgrow", "run", "cases/"], {"cases/one.yaml", "cases/my rock.yml"}),
        (["crackgrow", "run", "x.yaml", "--out", "cases/my"], {"cases/my rock.yml"}),
        (["crackgrow", "new", "x", "--template", "t"], {"tension"}),
        (["crackgrow", "completion", "z"], {"zsh"}),
        (["crackgrow", "compare", "cases/n"], {"cases/notes.txt"}),
        (["crackgrow", "compare", "--tip", "s"], {"start"}),
    ],
)
def test_bash_completes(line: list[str], offered: set[str], folder: Path) -> None:
    assert completed(line, folder) == offered


def test_bash_escapes_spaces_in_names_as_they_are_typed(folder: Path) -> None:
    (folder / "script").write_text(completion_script(command_line(), "bash"))
    (folder / "shown").write_text("crackgrow() { printf '<%s>' \"$@\"; echo ' shown'; }\n")
    typed = b". ./script; . ./shown\ncrackgrow run cases/my\t\nexit\n"
    controller, terminal = pty.openpty()
    command = ["timeout", "--foreground", "--signal=KILL", "20", "bash", "--norc", "--noprofile", "-i"]
    with subprocess.Popen(command, cwd=folder, stdin=terminal, stdout=terminal, stderr=terminal):
        os.close(terminal)
        os.write(controller, typed)
        seen = b""
        while b"> shown" not in seen:
            seen += os.read(controller, 4096)  # an error where bash has ended
    os.close(controller)
    assert b"<run><cases/my rock.yml> shown" in seen


@pytest.mark.parametrize("shell", SHELLS)
def test_every_command_and_option_is_there(shell: str) -> None:
    script = completion_script(command_line(), shell)
    for word in ("run", "check", "compare", "new", "schema", "completion", "resume", "picture", "template", "version"):
        assert word in script


def test_every_command_has_examples_or_is_plain(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("run", "check", "compare", "sweep", "trade", "new", "schema", "completion"):
        with pytest.raises(SystemExit):
            command_line().parse_args([name, "--help"])
        assert "examples:" in capsys.readouterr().out, name
