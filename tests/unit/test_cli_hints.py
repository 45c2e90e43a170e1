"""The command line as a user meets it: groups, hints for what is mistyped, JSON, exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.cli.parser import GROUPS

CASE = str(Path(__file__).parents[2] / "cases" / "compression30.yaml")


def refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(("words", "hint"), [
    (["rnu", CASE], "did you mean run?"),
    (["chek"], "did you mean check?"),
    (["run", CASE, "--ressume"], "did you mean --resume?"),
    (["run", "--hlep"], "CASE.yaml; unknown: --hlep; did you mean --help?"),
    (["run", CASE, "--spacing", "3"], "did you mean --set numerics.spacing=3?"),
    (["run", CASE, "--steps=4"], "did you mean --set growth.steps=4?"),
    (["check", CASE, "--set", "growth.steps", "4"], "did you mean --set growth.steps=4?"),
    (["new", "a", "--template", "tensio"], "did you mean tension?"),
    (["compare", "a", "b", "--tip", "strat"], "did you mean start?"),
])  # fmt: skip
def test_what_was_meant_is_offered(words: list[str], hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    told = refused(words, capsys)
    assert hint in told
    assert f"`crackgrow{f' {words[0]}' if words[0] in ('run', 'check', 'new', 'compare') else ''} --help`" in told


@pytest.mark.parametrize("words", [["frobnicate"], ["run", CASE, "--frobnicate"], ["run", CASE, "more"], []])
def test_nothing_is_offered_where_nothing_is_near(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    told = refused(words, capsys)
    assert "did you mean" not in told
    assert "--help` has all options" in told


def test_help_lists_commands_by_group(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["--help"])
    assert ended.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    first = [lines.index(f"{group}:") for group in GROUPS]
    assert first == sorted(first)
    for place, names in zip(first, GROUPS.values(), strict=True):
        assert [line.split()[0] for line in lines[place + 1 : place + 1 + len(names)]] == list(names)


def test_check_tells_its_plan_as_json(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    picture = tmp_path / "scene.svg"
    words = ["check", CASE, "--set", "numerics.spacing=4", "--set", "cracks.flaw.contact.friction=0.3"]
    assert cli.main([*words, "--json", "--unique", "--picture", str(picture)]) == 0
    plan = json.loads(capsys.readouterr().out)
    assert (plan["case"], plan["spacing"]) == ("compression30", 0.004)
    assert plan["model"]["n_tips"] == 2
    assert plan["model"]["surfaces"] == [
        {"name": "flaw", "n_points": plan["model"]["n_contact"], "bonded": False, "touching": True, "rough": True}
    ]
    assert set(plan["cost"]) == {"seconds", "memory", "n_dofs"}
    assert plan["cost"]["n_dofs"] == plan["model"]["n_dofs"]
    assert all(isinstance(text, str) for text in [*plan["warnings"], *plan["unique"]])
    assert picture.is_file()


def written(folder: Path, name: str, y: float) -> str:
    path = folder / name
    path.write_text(f"crack,vertex,x,y,step\nflaw,0,0.0,0.0,0\nflaw,1,0.01,0.0,0\nflaw,2,0.02,{y},1\n")
    return str(path)


@pytest.mark.parametrize(("tolerance", "code"), [("0.2 mm", 0), ("0.05 mm", 4)])
def test_compare_tells_all_of_it_as_json(
    tolerance: str, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    a, b = written(tmp_path, "a.csv", 0.0), written(tmp_path, "b.csv", 1e-4)
    assert cli.main(["compare", a, b, "--tolerance", tolerance, "--json"]) == code
    found = json.loads(capsys.readouterr().out)
    assert (found["a"]["source"], found["agrees"]) == (a, code == 0)
    assert max(part["hausdorff"] for part in found["parts"]) == pytest.approx(1e-4)
    assert [part["beyond"] for part in found["parts"]].count(True) == (code == 4)
    assert found["only_in_a"] == found["only_in_b"] == []
