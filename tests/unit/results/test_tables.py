"""The CSV tables: the columns of the contract, and numbers that read back to the same floats."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from crackgrow.results import tables
from crackgrow.results.folder import table_of
from tests.unit.results.synthetic import make_event, make_result


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_columns_are_those_of_the_contract() -> None:
    assert ",".join(tables.HEADERS["tips"]) == (
        "step,crack,tip,x,y,K_I,K_II,sigma_1,sigma_3,criterion,kink_deg,advanced,load_factor,K_I_error,K_II_error,"
        "K_radius,K_note,K_I_faces,K_II_faces,K_I_spread,K_II_spread,"
        "cell_size,kink_error_deg,velocity,K_error_expected,criticality,sticks,K_growth"
    )
    assert ",".join(tables.HEADERS["events"]) == "step,kind,crack,tip,x,y,met"
    assert ",".join(tables.HEADERS["paths"]) == "crack,vertex,x,y,step"
    assert ",".join(tables.HEADERS["contact"]) == (
        "step,crack,s,x,y,normal_traction,tangential_traction,opening,slip,state,mean_opening,mean_slip"
    )
    assert ",".join(tables.HEADERS["steps"]) == (
        "step,n_dofs,n_contact,contact_iterations,factorizations,residual,penetration,seconds_cover,seconds_assembly,"
        "seconds_factorize,seconds_contact,seconds_criterion,seconds_output,load_factor,contact_status,complementarity,"
        "overlap,work,strain_energy,dissipation,released_energy,energy_error,load_displacement,crack_length,"
        "overlap_share,load_factor_error,goal_error,time,slip_error,reaction_error"
    )


def test_step_row_adds_the_frames_to_the_output_phase(tmp_path: Path) -> None:
    table = tables.Table(tmp_path / "steps.csv", tables.HEADERS["steps"])
    table.extend([tables.step_row(make_result(0), 0.0), tables.step_row(make_result(1), 0.25)])
    table.replace_last(tables.step_row(make_result(1), 0.5))
    table.write()
    first, second = read(table.path)
    assert (first["step"], second["step"]) == ("0", "1")
    assert float(first["seconds_output"]) == 0.0625
    assert float(second["seconds_output"]) == 0.5625
    assert (second["contact_status"], second["n_dofs"]) == ("solved", "408")
    assert float(second["complementarity"]) == 1e-10
    energies = ("work", "strain_energy", "dissipation", "released_energy", "energy_error")
    assert [float(second[name]) for name in energies] == [5.0, 3.0, 0.5, 0.25, 5e-7]
    assert float(second["load_displacement"]) == 2e-5
    assert float(second["crack_length"]) == pytest.approx(0.02 + np.hypot(0.002, 0.002))


def test_events_round_trip(tmp_path: Path) -> None:
    table = tables.Table(tmp_path / "events.csv", tables.HEADERS["events"])
    events = [make_event(2), make_event(2, kind="hole", tip="start", met="hole0 of body 'rock'")]
    table.extend(tables.event_rows(events))
    table.write()
    first, second = read(table.path)
    assert (first["step"], first["kind"], first["crack"], first["tip"]) == ("2", "coalescence", "flaw", "end")
    assert (first["met"], second["met"]) == ("crack 'b, the second'", "hole0 of body 'rock'")
    assert (float(first["x"]), float(first["y"])) == tuple(events[0].point)
    assert (second["kind"], second["tip"]) == ("hole", "start")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.1 + 0.2, "0.30000000000000004"),
        (np.float64(1) / 3, "0.3333333333333333"),
        (float("nan"), "nan"),
        (np.int64(3), "3"),
        (True, "true"),
        ("plain", "plain"),
        ('a,"b"', '"a,""b"""'),
    ],
)
def test_format_value(value: tables.Value, text: str) -> None:
    assert tables.format_value(value) == text


def test_rows_are_appended_and_a_file_that_is_gone_or_changed_in_its_last_row_is_whole_again(tmp_path: Path) -> None:
    table = tables.Table(tmp_path / "a.csv", ("x", "y"))
    path = table.path
    table.write()
    inode = path.stat().st_ino
    table.extend([(1, 2.5), (3, 4.5)])
    table.write()
    assert path.read_text() == "x,y\n1,2.5\n3,4.5\n"
    assert path.stat().st_ino == inode  # the same file, not a new one
    table.replace_last((3, 5.5))
    table.write()
    assert path.read_text() == "x,y\n1,2.5\n3,5.5\n"
    path.unlink()
    table.extend([(6, 7.5)])
    table.write()
    assert path.read_text() == "x,y\n1,2.5\n3,5.5\n6,7.5\n"


def test_rows_from_a_step_on_are_dropped_and_a_row_that_a_kill_cut_off(tmp_path: Path) -> None:
    """An event comes with the step after its own; "1" may be the begin of a row of step 12."""
    for name, last in (("tips", 2), ("events", 1)):
        table = tables.Table(tmp_path / f"{name}.csv", tables.HEADERS[name])
        table.extend([(step, "flaw") for step in (0, 1, 1, 2, 3)])
        table.write()
        whole = table.path.read_text()
        table.path.write_text(whole + "1")
        table.drop_from(3)
        assert table.path.read_text() == whole[: whole.index(f"\n{last + 1},") + 1]
        assert len(table) == {"tips": 4, "events": 3}[name]


def test_a_whole_table_reads_back_and_has_no_nan() -> None:
    rows = [("a, b", 0.1, 3), ('say "so"', float("nan"), None), ("", 1e-300, True)]
    table = table_of(tables.csv_text(("name", "value", "count"), rows), Path("table.csv"))
    assert table.words("name") == ["a, b", 'say "so"', ""]
    assert table.words("value") == ["0.1", "", "1e-300"]
    assert table.words("count") == ["3", "", "true"]
