"""Messages that name what was meant: other names of keys, forms of which none is guessed, YAML that cannot be read."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.case.load import read_case
from crackgrow.errors import CaseError
from crackgrow.study.sweep.sweep_file import read_sweep_file

CASES = Path(__file__).parents[3] / "cases"
FILE = CASES / "compression30.yaml"


def told(*overrides: str) -> str:
    """What a shipped case with overrides is refused with."""
    with pytest.raises(CaseError) as caught:
        load_case(FILE, overrides)
    return str(caught.value)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("bodies.rock.shape={circle: {radius: 3}}", "polygon, disk, file, region, units, origin; did you mean 'disk'?"),
        ("supports=[{point: [0, 0], displacement: {x: 0}}]", "did you mean 'at'?"),
        ("supports=[{at: [0, 0], displacment: {x: 0}}]", "did you mean 'displacement'?"),
        ("bodies.rock.material={E: 1, poisson: 0.2}", "did you mean 'young'?"),
        ("bodies.rock.material={young: 1, nu: 0.2}", "did you mean 'poisson'?"),
        ("bodies.rock.material={young: 1, poisson: 0.2, rho: 2500}", "did you mean 'density'?"),
        ("cracks.flaw.contact={mu: 0.3, cohesion: 0}", "did you mean 'friction'?"),
        ("bodies.rock.strength={tension: 1, cohesion: 2, phi: 30}", "did you mean 'friction_angle'?"),
        ("spacing=3", "did you mean 'numerics.spacing'?"),
        ("support=minimal", "did you mean 'supports'?"),  # not numerics.support
        ("load=[]", "did you mean 'loads'?"),
        ("numerics.tip_functions=gather", "auto | patch | gathered; did you mean 'gathered'?"),
        ("supports[0].at=[0, 0]", "is written with its number, as in 'supports.0.at'"),
        ("numerics.spacing=0.01", "lattice nodes; at most 4e+06 are allowed; wanted: 0."),
        ("cracks.flaw.path.points=[[0, 0], [5, 5]]", "--set cracks.flaw.path.points: does not go with center, length, "
         "angle; give either {center, length, angle} or {points} or {file}; --set "
         "'cracks.flaw.path={points: ...}' takes"),
        ("loads.0={crack: flaw, pressure: 100, traction: [0, 1]}", "--set loads.0: traction: does not go with crack"),
        ("numerics.contact.stiffness=1e14 N/m^3", "rigid | a number > 0, kappa of k = kappa E / h without a unit"),
        ("bodies.rock.strength.compression=50", "strength C gives cohesion = C (1 - sin phi) / (2 cos phi)"),
        ("loads.0.factor=3", "loads have the factors of `loading`, such as {history: [0.5, 1]}"),
        ("bodies.rock.shape={circle: {radius: 3}}", "--set bodies.rock.shape: circle: unknown key"),
    ],
)  # fmt: skip
def test_what_was_meant_is_offered(override: str, words: str):
    assert words in told(override)


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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title: a\nbodies:\n\trock: 3\n", "found character '\\t' that cannot start any token: indent with spaces"),
        ("title: a\nbodies:\n  rock: 3\n plane: strain\n", "which begins in line 1, stand in one column"),
        ("title: Closed: a crack\n", "a text with ': ' in it stands in quotes"),
        ("title: a\nbodies: {a: 3\nplane: strain\n", "that opens in line 2 is not closed"),
    ],
)
def test_yaml_that_cannot_be_read_tells_the_cause_and_the_remedy(text: str, words: str):
    with pytest.raises(CaseError) as caught:
        read_case(text, "scene.yaml", "scene")
    (fault,) = caught.value.faults
    assert words in fault.message
    assert "..." not in fault.message
