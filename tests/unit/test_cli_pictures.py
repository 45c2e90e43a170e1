"""The commands that show a run: their arguments, what they print, exit codes."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow import cli
from tests.report_runs import make_run


def test_report_prints_where_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make_run(tmp_path, ["growth.steps=0", "output.report=false"])
    assert cli.main(["report", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'report.html'}\n"
    assert (tmp_path / "report.html").is_file()


@pytest.mark.parametrize("command", ["report", "render"])
def test_a_folder_without_results_ends_with_three(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    assert cli.main([command, str(tmp_path)]) == 3
    assert capsys.readouterr().err.startswith(f"crackgrow: {tmp_path} is not a folder of results: summary.json")


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["--warp", "much"], "'much': auto, or a number from 0 on is wanted"),
        (["--warp", "-1"], "'-1': auto, or a number from 0 on is wanted"),
        (["--warp", "nan"], "'nan': auto, or a number from 0 on is wanted"),
        (["--steps", "3-1"], "'3-1': a step such as 4, or a span such as 4-10 is wanted"),
        (["--steps", "1", "x"], "'x': a step such as 4"),
        (["--size", "99x300"], "'99x300': WIDTHxHEIGHT in pixels, each from 100 to 8000, is wanted"),
        (["--size", "300"], "'300': WIDTHxHEIGHT"),
        (["--gif", "--mp4"], "not allowed with argument"),
    ],
)
def test_bad_arguments_are_refused(capsys: pytest.CaptureFixture[str], arguments: list[str], wanted: str) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["render", "somewhere", *arguments])
    assert ended.value.code == 2
    assert wanted in capsys.readouterr().err


def test_mp4_without_ffmpeg_is_refused_before_anything_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cli.main(["render", str(tmp_path), "--mp4"]) == 3
    assert "an MP4 needs ffmpeg" in capsys.readouterr().err
