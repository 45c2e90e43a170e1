"""Commands that are refused: each with its exit code, words that say what is wrong, and nothing made or changed."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest
import yaml

from crackgrow import cli
from tests.verification.solutions import CASES

TABLE = yaml.safe_load(Path(__file__).with_name("refused.yaml").read_text(encoding="utf-8"))


def given(text: str) -> str:
    """A text of the table with the names that it stands for."""
    return text.replace("CASES", str(CASES)).replace("LONG", 300 * "n")


@pytest.mark.parametrize(("group", "change", "told"), [
    pytest.param(group, *row, id=f"{group['about']}: {row[0]}".encode("ascii", "replace").decode()[:150])
    for group in TABLE["groups"]
    for row in group["rows"]
])  # fmt: skip
def test_refused(
    group: dict[str, Any], change: Any, told: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """A command of refused.yaml ends with its code and says why."""
    monkeypatch.chdir(tmp_path)
    words, files = group.get("command", ""), dict(group.get("files", {}))
    if "write" in group:
        keys = change if isinstance(change, str) else group["keys"] | change
        files[group["write"]] = keys if isinstance(keys, str) else "".join(f"{k}: {v}\n" for k, v in keys.items())
    elif isinstance(change, str):
        words = f"{words} {change}"
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(given(content), encoding="utf-8")
    try:
        code: object = cli.main(change if isinstance(change, list) else shlex.split(given(words)))
    except SystemExit as ended:
        code = ended.code
    said = capsys.readouterr().err
    assert given(told) in said
    assert code == group.get("code", 2)
    assert "Traceback" not in said
    assert group.get("hints", True) or "did you mean" not in said
    there = {str(path.relative_to(tmp_path)): path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert there == {name: given(content) for name, content in files.items()}
