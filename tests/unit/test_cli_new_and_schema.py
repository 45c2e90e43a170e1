"""`crackgrow new` and `crackgrow schema`: files for people and editors, and nothing overwritten."""

from __future__ import annotations

import json
import resource
import signal
from pathlib import Path

import pytest
from jsonschema import Draft7Validator

from crackgrow import cli, grow, load_case
from crackgrow.cli.start import SCHEMA_FILE, template_text, templates
from tests.yaml12 import read_yaml12


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("template", sorted(templates()))
def test_every_template_passes_check_and_solves_without_a_warning(
    template: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "mine", "--template", template]) == 0
    assert (folder / "mine.yaml").read_text(encoding="utf-8") == template_text(template)
    assert cli.main(["check", "mine.yaml"]) == 0
    assert "crackgrow check mine.yaml" in capsys.readouterr().out
    first = next(grow(load_case("mine.yaml")))
    assert first.warnings == ()


@pytest.mark.parametrize("template", sorted(templates()))
def test_every_key_of_a_template_is_commented_where_it_first_stands(template: str) -> None:
    lines = template_text(template).splitlines()
    assert sum("#" in line for line in lines) > 0.6 * len([line for line in lines if line])


def test_a_case_goes_among_the_cases_and_names_the_schema_there(folder: Path) -> None:
    (folder / "cases").mkdir()
    assert cli.main(["schema", "--out", f"cases/{SCHEMA_FILE}"]) == 0
    assert cli.main(["new", "mine"]) == 0
    text = (folder / "cases" / "mine.yaml").read_text(encoding="utf-8")
    assert text.startswith(f"# yaml-language-server: $schema={SCHEMA_FILE}\n")
    schema = json.loads((folder / "cases" / SCHEMA_FILE).read_text(encoding="utf-8"))
    assert Draft7Validator(schema).is_valid(read_yaml12(text))


@pytest.mark.parametrize(("name", "file"), [("a.b", "a.b.yaml"), ("x/y.yml", "x/y.yml"), ("x/y", "x/y.yaml")])
def test_where_a_case_goes(name: str, file: str, folder: Path) -> None:
    assert cli.main(["new", name]) == 0
    assert (folder / file).is_file()


@pytest.mark.parametrize("name", ["", ".", "/"])
def test_a_case_without_a_name_is_refused(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", name]) == 2
    assert capsys.readouterr().err == f"'{name}': is no name of a case; allowed are those such as my_slope\n"
    assert list(folder.iterdir()) == []


def test_the_next_commands_can_be_pasted(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", "my slope"]) == 0
    assert "next: crackgrow check 'my slope.yaml', then crackgrow run 'my slope.yaml'" in capsys.readouterr().out


def test_half_a_case_is_not_left_behind(folder: Path) -> None:
    room = 1000  # bytes, less than the case
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # else the process ends
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
    try:
        assert cli.main(["new", "mine"]) == 2
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert list(folder.iterdir()) == []


def test_nothing_is_overwritten(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "mine.yaml").write_text("precious")
    assert cli.main(["new", "mine"]) == 2
    assert capsys.readouterr().err == "mine.yaml: exists already, and is left as it is\n"
    assert (folder / "mine.yaml").read_text() == "precious"


def test_a_case_that_cannot_be_written_exits_2(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "file").write_text("")
    assert cli.main(["new", "file/mine"]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert cli.main(["new", "a\0b"]) == 2


def test_schema_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "crackgrow case"


@pytest.mark.parametrize("name", ["..yaml", "...yaml"])
def test_a_case_without_a_name_of_its_own_is_refused(
    name: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / name).write_text(template_text("tension"))
    assert cli.main(["run", name]) == 2
    assert "the file has no name of its own" in capsys.readouterr().err
    assert sorted(path.name for path in folder.iterdir()) == [name]
