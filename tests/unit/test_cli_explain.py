"""`crackgrow explain` and `crackgrow list`: what they print, and what they say where there is nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow import cli


def explained(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(["explain", name] if name else ["explain"]) == 0
    return capsys.readouterr().out


def test_a_key_is_told_with_meaning_type_unit_default_and_what_is_allowed(capsys: pytest.CaptureFixture[str]) -> None:
    assert explained("growth.tip_stress.radius", capsys).splitlines() == [
        "growth.tip_stress.radius",
        "  meaning  Shepard averaging radius, a material length",
        "  type     length",
        "  unit     m, cm, mm, um, km; bare: that of units.length",
        "  default  required",
        "  allowed  > 0",
    ]


@pytest.mark.parametrize(("name", "heads"), [
    ("cracks.my_own.contact.friction", ["cracks.NAME.contact.friction"]),
    # once, though cracks, interfaces and foundations have it, too; and of lines of a map by an attribute
    ("friction", ["laws.NAME.friction", "laws.NAME.wear.friction", "cracks.NAME.contact_by.NAME.NAME.friction"]),
    ("interfaces.0.contact.friction", ["interfaces.N.contact.friction"]),
    ("output", ["output", "output.frames", "output.fields", "output.figures", "output.report"]),
    ("paths.csv", ["paths.csv", "crack", "vertex", "x", "y", "step"]),
    ("kink_deg", ["kink_deg"]),
    ("loading.critical", ["loading: critical"]),
    ("in_turn", ["growth.advance: in_turn"]),
    ("bonded", ["interfaces.N.contact: bonded"]),
])  # fmt: skip
def test_names_are_found(name: str, heads: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    found = [line for line in explained(name, capsys).splitlines() if not line.startswith(" ")]
    assert found[: len(heads)] == heads
    assert name == "output" or len(found) == len(heads)


def test_without_a_name_the_first_keys_and_the_files_are_told_a_line_each(capsys: pytest.CaptureFixture[str]) -> None:
    lines = explained("", capsys).splitlines()
    assert [line for line in lines if not line.startswith("  ")] == ["keys of a case", "files of a run"]
    names = [line.split()[0] for line in lines if line.startswith("  ")]
    assert len(set(names)) == len(names)
    assert {"title", "numerics", "tips.csv", "report.html"} <= set(names)


@pytest.mark.parametrize("columns", [50, 80, 140])
@pytest.mark.parametrize("name", ["", "growth.criterion", "tips.csv"])
def test_lines_are_as_long_as_the_terminal_is_wide_and_lose_no_word(
    name: str, columns: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "10000")
    whole = explained(name, capsys)
    monkeypatch.setenv("COLUMNS", str(columns))
    wrapped = explained(name, capsys)
    assert max(map(len, whole.splitlines())) > columns
    assert max(map(len, wrapped.splitlines())) <= columns
    assert not name or wrapped.split() == whole.split()


def test_an_unknown_name_is_a_fault_with_what_may_be_meant(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["explain", "frction"]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert "did you mean friction" in told.err


def test_cases_are_listed_with_their_titles(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "one.yaml").write_text('# a note\ntitle: "A plate: with a crack"\nplane: strain\n')
    (tmp_path / "two.yaml").write_text("# what it is\nplane: strain\n")
    (tmp_path / "three.yaml").write_bytes(b"title: \xff\n")
    assert cli.main(["list", str(tmp_path)]) == 0
    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()[1:4]]
    assert lines == [[str(tmp_path / "one.yaml"), "A plate: with a crack"],
                     [str(tmp_path / "three.yaml"), "(cannot be read)"],
                     [str(tmp_path / "two.yaml"), "what it is"]]  # fmt: skip


def test_templates_are_listed_where_there_are_no_cases(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["list"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("templates: ")
    assert "  foundation  " in out
    assert cli.main(["list", "nowhere"]) == 2
    assert capsys.readouterr().err == "nowhere: is no folder\n"
