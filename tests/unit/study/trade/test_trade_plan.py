"""What a trade is going to run: axes, grid, presets, reference, and what is refused before anything runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from crackgrow import cli
from crackgrow.case.accuracy import TARGETS
from crackgrow.errors import CaseError
from crackgrow.study.setting import CaseFile
from crackgrow.study.trade.plan import chosen_axes, finest, plan_trade, settings_of, with_length

CASES = Path(__file__).parents[4] / "cases"
COMPRESSION = CaseFile(CASES / "compression30.yaml")
INTERFACE = CaseFile(CASES / "interface_friction04.yaml")


def test_grid_is_every_combination_after_the_presets():
    settings = settings_of({"spacing": ("3", "2 mm"), "support": ("1.5", "2")})
    assert [setting.preset for setting in settings] == [*TARGETS, "", "", "", ""]
    assert [setting.name for setting in settings[3:]] == [
        "spacing=3 support=1.5",
        "spacing=3 support=2",
        "spacing=2 mm support=1.5",
        "spacing=2 mm support=2",
    ]
    assert settings[-1].overrides == ("numerics.spacing=2 mm", "numerics.support=2")
    assert len({setting.name for setting in settings}) == len(settings)


@pytest.mark.parametrize("name", list(TARGETS))
def test_preset_of_the_grid_has_all_that_it_sets_although_the_case_has_keys_of_its_own(name: str):
    (setting,) = settings_of({"support": ("2",)}, [name])[:1]
    given = CaseFile(CASES / "block_rigid.yaml")  # its spacing and support are given
    numerics = given.load(*setting.overrides).numerics
    assert (numerics.accuracy, numerics.support, numerics.quadrature) == (name, 2.0, 3)
    assert numerics.contact.spacing == 1.25
    assert numerics.auto_rule is not None


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.yaml")))
def test_default_axes_suit_every_shipped_case(name: str):
    file = CaseFile(CASES / f"{name}.yaml")
    axes = chosen_axes(file, ())
    settings = settings_of(axes)
    assert len(settings) >= 40
    for setting in settings[: len(TARGETS)] + settings[len(TARGETS) :: 7]:
        file.load(*setting.overrides)  # raises where a value does not fit
    assert ("contact_spacing" in axes) == (name not in ("edge_tension", "junction_static"))  # their faces never touch


def test_reference_is_twice_as_fine_as_everything():
    axes = {"spacing": ("3", "1.5"), "increment": ("2", "1")}
    settings = settings_of(axes)
    reference = COMPRESSION.load(*finest(COMPRESSION, settings, axes))
    spacings = [COMPRESSION.load(*setting.overrides).numerics.spacing for setting in settings]
    assert reference.numerics.spacing == pytest.approx(min(spacings) / 2, rel=1e-15)
    assert reference.growth is not None
    assert reference.growth.increment == 0.001
    assert reference.numerics.support == 2.0


@pytest.mark.parametrize(("increment", "steps"), [("2", 6), ("1", 12), ("4", 3), ("5 mm", 3), ("0.3", 40)])
def test_shorter_increments_take_more_steps_to_the_same_length(increment: str, steps: int):
    run = COMPRESSION.load(*with_length(COMPRESSION, (f"growth.increment={increment}",), 6))
    assert run.growth is not None
    assert run.growth.steps == steps
    assert (run.output.frames, run.output.figures, run.output.report) == ("none", False, False)


def test_static_case_has_no_steps():
    assert INTERFACE.load(*with_length(INTERFACE, ("numerics.support=1.5",), None)).growth is None


@pytest.mark.parametrize(
    ("file", "texts", "messages"),
    [
        (COMPRESSION, ["spacng=3"], ["spacng: no such axis; did you mean 'spacing'?; there are spacing, support"]),
        (COMPRESSION, ["spacing"], ["spacing: 'spacing' given; wanted: values with commas between, spacing=A,B,C"]),
        (COMPRESSION, ["spacing=3,"], ["spacing: 'spacing=3,' given; wanted: values"]),
        (COMPRESSION, ["spacing=3,2,3"], ["spacing: '3,2,3' has a value twice"]),
        (COMPRESSION, ["support=2", "support=3"], ["support: given twice"]),
        (COMPRESSION, ["spacing=3,long"], ["spacing: 'long' given; wanted: auto | a length > 0"]),
        (COMPRESSION, ["support=2.1", "solver=lemk"], ["support: '2.1' given", "did you mean 'lemke'?"]),
        (COMPRESSION, ["spacing=30"], ["spacing: 30 mm is too coarse; at most half the smaller side of body 'rock'"]),
        (INTERFACE, ["increment=2"], ["increment: the case has no `growth`"]),
    ],
)
def test_bad_axes_are_told_together(file: CaseFile, texts: list[str], messages: list[str]):
    with pytest.raises(CaseError) as caught:
        chosen_axes(file, texts)
    faults = [str(fault) for fault in caught.value.faults]
    assert len(faults) == len(messages)
    for fault, message in zip(faults, messages, strict=True):
        assert fault.startswith("--axis: ")
        assert message in fault


def test_reference_must_be_results_or_settings(tmp_path: Path):
    with pytest.raises(CaseError, match=r"is no result folder of a run: it has no case\.yaml, tips\.csv"):
        plan_trade(COMPRESSION, tmp_path, reference=[str(tmp_path)])
    with pytest.raises(CaseError, match=r"numerics\.support: '2\.1' given"):
        plan_trade(COMPRESSION, tmp_path, reference=["numerics.support=2.1"])
    plan = plan_trade(COMPRESSION, tmp_path, reference=["numerics.spacing=1", "numerics.support=3"])
    assert plan.reference == ("numerics.spacing=1", "numerics.support=3")


def test_command_line_refuses_before_anything_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "out"
    case = str(INTERFACE.path)
    assert cli.main(["trade", case, "--axis", "spacing=0.1", "speed=2", "--out", str(out)]) == 2
    assert "--axis: speed: no such axis" in capsys.readouterr().err
    assert cli.main(["trade", case, "--steps", "3", "--out", str(out)]) == 2
    assert "--steps: 3 given; the case has no `growth`" in capsys.readouterr().err
    assert cli.main(["trade", case, "--resume", "--out", str(out)]) == 2
    assert "holds no trade to go on with" in capsys.readouterr().err
    assert not out.exists()
