"""The words of the command line: what is asked is explained, listed, completed, begun; what is wrong is refused."""

from __future__ import annotations

import json
import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft7Validator

from crackgrow import cli, grow, load_case
from crackgrow.cli.command_line import declared, groups
from crackgrow.cli.start import SCHEMA_FILE, template_text
from crackgrow.cli.tools import completion_script
from tests.unit.case.scenes import read_yaml12
from tests.verification.solutions import CASES


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_help_lists_commands_by_group_and_has_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["--help"])
    assert ended.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    first = [lines.index(f"{group}:") for group in groups()]
    assert first == sorted(first)
    for place, names in zip(first, groups().values(), strict=True):
        assert [line.split()[0] for line in lines[place + 1 : place + 1 + len(names)]] == list(names)
    for name in (name for of_group in groups().values() for name in of_group):
        with pytest.raises(SystemExit):
            cli.main([name, "--help"])
        assert "examples:" in capsys.readouterr().out, name


def explained(name: str, capsys: pytest.CaptureFixture[str]) -> list[str]:
    assert cli.main(["explain", name] if name else ["explain"]) == 0
    return capsys.readouterr().out.splitlines()


@pytest.mark.parametrize(("name", "heads"), [
    ("cracks.my_own.contact.friction", ["cracks.NAME.contact.friction"]),
    # once, though cracks, interfaces and foundations have it, too
    ("friction", ["laws.NAME.friction", "laws.NAME.wear.friction"]),
    ("interfaces.0.contact.friction", ["interfaces.N.contact.friction"]),
    ("output", ["output", "output.frames", "output.fields", "output.figures", "output.report"]),
    ("paths.csv", ["paths.csv", "crack", "vertex", "x", "y", "step"]),
    ("kink_deg", ["kink_deg"]),
    ("loading.critical", ["loading: critical"]),
    ("in_turn", ["growth.advance: in_turn"]),
    ("bonded", ["interfaces.N.contact: bonded"]),
    ("", ["keys of a case", "files of a run"]),
])  # fmt: skip
def test_names_are_found(name: str, heads: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    found = [line for line in explained(name, capsys) if not line.startswith(" ")]
    assert found[: len(heads)] == heads
    assert name == "output" or len(found) == len(heads)


def test_a_key_is_told_with_meaning_type_unit_default_and_what_is_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    facts = [line.split()[0] for line in explained("growth.tip_stress.radius", capsys)[1:]]
    assert facts == ["meaning", "type", "unit", "default", "allowed"]


def test_cases_are_listed_with_their_titles_and_templates_where_there_are_none(
    capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    assert cli.main(["list"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("templates: ")
    assert "  foundation  " in out
    (folder / "one.yaml").write_text('# a note\ntitle: "A plate: with a crack"\nplane: strain\n')
    (folder / "two.yaml").write_text("# what it is\nplane: strain\n")
    (folder / "three.yaml").write_bytes(b"title: \xff\n")
    assert cli.main(["list", str(folder)]) == 0
    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()[1:4]]
    assert lines == [[str(folder / "one.yaml"), "A plate: with a crack"],
                     [str(folder / "three.yaml"), "(cannot be read)"],
                     [str(folder / "two.yaml"), "what it is"]]  # fmt: skip


TEMPLATES = declared()["words"]["templates"]


@pytest.mark.physics
@pytest.mark.parametrize("template", sorted(path.stem for path in (Path(cli.__file__).parent / "templates").iterdir()))
def test_every_template_passes_check_and_solves_without_a_warning(
    template: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "mine", "--template", template]) == 0
    text = (folder / "mine.yaml").read_text(encoding="utf-8")
    assert text == template_text(template)
    assert text.splitlines()[0] == f"# {TEMPLATES[template]}"
    assert sum("#" in line for line in text.splitlines()) > 0.6 * len([line for line in text.splitlines() if line])
    assert cli.main(["check", "mine.yaml"]) == 0
    assert "crackgrow check mine.yaml" in capsys.readouterr().out
    assert next(grow(load_case("mine.yaml"))).warnings == ()


def test_a_case_goes_among_the_cases_and_names_the_schema_there(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "cases").mkdir()
    assert cli.main(["schema", "--out", f"cases/{SCHEMA_FILE}"]) == 0
    assert cli.main(["schema"]) == 0
    assert capsys.readouterr().out == (folder / "cases" / SCHEMA_FILE).read_text(encoding="utf-8")
    assert cli.main(["new", "my slope"]) == 0  # the next commands can be pasted
    told = "next: crackgrow check 'cases/my slope.yaml', then crackgrow run 'cases/my slope.yaml'"
    assert told in capsys.readouterr().out
    text = (folder / "cases" / "my slope.yaml").read_text(encoding="utf-8")
    assert text.startswith(f"# yaml-language-server: $schema={SCHEMA_FILE}\n")
    schema = json.loads((folder / "cases" / SCHEMA_FILE).read_text(encoding="utf-8"))
    assert "case of crackgrow" in schema["description"]
    assert Draft7Validator(schema).is_valid(read_yaml12(text))


@pytest.fixture
def script(folder: Path) -> Path:
    """The script for bash, beside some files that could be meant."""
    (folder / "cases").mkdir()
    for name in ("one.yaml", "my rock.yml", "notes.txt"):
        (folder / "cases" / name).write_text("")
    (folder / "script").write_text(completion_script("bash"))
    return folder / "script"


@pytest.mark.parametrize(("line", "offered"), [
    ("crackgrow ch", {"check"}),
    ("crackgrow --v", {"--version"}),
    ("crackgrow check --p", {"--picture"}),
    ("crackgrow run ca", {"cases"}),
    ("crackgrow run cases/", {"cases/one.yaml", "cases/my rock.yml"}),
    ("crackgrow run x.yaml --out cases/my", {"cases/my rock.yml"}),
    ("crackgrow new x --template t", {"tension"}),
    ("crackgrow compare cases/n", {"cases/notes.txt"}),
])  # fmt: skip
def test_bash_completes(line: str, offered: set[str], script: Path) -> None:
    ask = f"source ./script; COMP_WORDS=({line}); COMP_CWORD={len(line.split()) - 1}; _shtab_crackgrow; "
    ask += 'printf "%s\\n" "${COMPREPLY[@]}"'
    done = subprocess.run(["bash", "-c", ask], cwd=script.parent, capture_output=True, text=True, check=True)
    assert set(done.stdout.splitlines()) == offered


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
    group: dict[str, Any], change: Any, told: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A command of refused.yaml ends with its code and says why."""
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
    assert [words for words in ([told] if isinstance(told, str) else told) if given(words) not in said] == []
    assert code == group.get("code", 2)
    assert "Traceback" not in said
    assert group.get("hints", True) or "did you mean" not in said
    there = {str(path.relative_to(tmp_path)): path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert there == {name: given(content) for name, content in files.items()}
