"""Messages that name what was meant: other names of keys, forms of which none is guessed, YAML that cannot be read."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.case.load import read_case
from crackgrow.errors import CaseError
from crackgrow.study.sweep_file import read_sweep_file

CASES = Path(__file__).parents[3] / "cases"
FILE = CASES / "compression30.yaml"


def told(*overrides: str) -> str:
    """What a shipped case with overrides is refused with."""
    with pytest.raises(CaseError) as caught:
        load_case(FILE, overrides)
    return str(caught.value)


def test_a_file_of_the_other_kind_is_told_in_a_line():
    with pytest.raises(CaseError) as caught:
        load_case(CASES / "sweeps" / "angle_friction.yaml")
    assert [fault.message.partition(":")[0] for fault in caught.value.faults] == ["this is a sweep file, not a case"]
    with pytest.raises(CaseError) as caught:
        read_sweep_file(FILE)
    assert [fault.message.partition(":")[0] for fault in caught.value.faults] == ["this is a case, not a sweep file"]


def test_no_form_is_guessed_from_a_misspelt_key():
    message = told("bodies.rock.shape={circle: {radius: 3}}")
    assert "give either {rectangle} or {polygon} or {disk} or {file}" in message
    assert "did you mean 'file'" not in message


def test_numerics_may_be_left_out_and_empty(tmp_path: Path):
    text = FILE.read_text(encoding="utf-8")
    start = text.index("numerics:")
    path = tmp_path / "scene.yaml"
    for numerics in ("", "numerics: {}\n", "numerics: {accuracy: standard}\n"):
        path.write_text(text[:start] + numerics, encoding="utf-8")
        case = load_case(path)
        assert (case.numerics.accuracy, case.numerics.spacing) == ("standard", pytest.approx(0.0031))
    allowed = "allowed: accuracy, goal, spacing, support, quadrature, refine, tip_functions, contact"
    assert allowed in told("numerics.rule=3")


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.yaml")))
def test_case_that_went_through_a_writer_of_yaml_1_1_is_the_same(name: str, monkeypatch: pytest.MonkeyPatch):
    """To PyYAML the key `on` is the boolean true."""
    file = CASES / f"{name}.yaml"
    monkeypatch.chdir(CASES)  # where the files lie that a case names
    written = yaml.safe_dump(yaml.safe_load(file.read_text(encoding="utf-8")))
    assert read_case(written, "written", name).resolved == load_case(file).resolved
