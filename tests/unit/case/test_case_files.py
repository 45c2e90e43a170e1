"""Files that are no case: always a CaseError with a place, never another exception, and never any action."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.errors import CaseError, Fault

COMPRESSION = (Path(__file__).parents[3] / "cases" / "compression30.yaml").read_bytes()


def only_fault(path: Path) -> Fault:
    with pytest.raises(CaseError) as caught:
        load_case(path)
    (fault,) = caught.value.faults
    return fault


def written(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_bytes(data)
    return path


def test_missing_file(tmp_path: Path):
    fault = only_fault(tmp_path / "nowhere.yaml")
    assert str(fault) == f"{tmp_path / 'nowhere.yaml'}: no such file"


def test_directory(tmp_path: Path):
    assert "is a directory" in only_fault(tmp_path).message


def test_pipe_does_not_block(tmp_path: Path):
    os.mkfifo(tmp_path / "pipe")
    assert "not a regular file" in only_fault(tmp_path / "pipe").message


def test_name_that_no_file_can_have():
    assert only_fault(Path("a\0b")).message
    assert only_fault(Path("a" * 5000)).message


def test_name_that_is_no_text(tmp_path: Path):
    path = tmp_path / os.fsdecode(b"rock\xff.yaml")
    path.write_bytes(COMPRESSION)
    assert only_fault(path).message == "the file's name is no text in UTF-8, and the case is named after it; rename it"


def test_huge_file(tmp_path: Path):
    assert "larger than" in only_fault(written(tmp_path, b"# " + b"x" * 3_000_000)).message


@pytest.mark.parametrize(
    ("data", "line", "words"),
    [
        (b"", 1, "the file is empty"),
        (b"# nothing\n", 1, "the file is empty"),
        (b"--- ~\n", 1, "the file is empty"),
        (b"\xff\xfe\x00", 1, "not a text in UTF-8"),
        (b"a: 1\nb: \xe9\n", 2, "not a text in UTF-8"),
        (b"a: 1\nb: \x00\n", 2, "'\\x00' is not allowed"),
        (b"a: 1\nb: [1, 2\nc: 3\n", 3, "not valid YAML"),
        (b"a: 1\n\tb: 2\n", 2, "not valid YAML"),
        (b"a: 'open\n", 2, "not valid YAML"),
        (b'a: "\\U00ffffff"\n', 1, "not valid YAML"),
        (b"%YAML 9.9\n---\na: 1\n", 1, "not valid YAML"),
        (b"plain words\n", 1, "holds no mapping"),
        (b"- a\n- b\n", 1, "holds no mapping"),
        (b"*me\n", 1, "no value before it has the anchor &me"),
        (b"!!python/object/apply:os.system ['exit 3']\n", 1, "is not allowed"),
        (b"\n" + b"[" * 100_000, 2, "nested deeper than"),
        (b"\n" + b"{a: " * 100_000, 2, "nested deeper than"),
        (b"- " * 50_000 + b"a", 1, "nested deeper than"),
    ],
)
def test_no_case(data: bytes, line: int, words: str, tmp_path: Path):
    fault = only_fault(written(tmp_path, data))
    assert words in fault.message
    assert fault.line == line


def test_second_document(tmp_path: Path):
    data = COMPRESSION + b"---\ntitle: another\n"
    fault = only_fault(written(tmp_path, data))
    assert "second YAML document" in fault.message
    assert fault.line == data[: data.index(b"---")].count(b"\n") + 1


def test_byte_order_mark_is_accepted(tmp_path: Path):
    assert load_case(written(tmp_path, b"\xef\xbb\xbf" + COMPRESSION)).plane == "strain"


def test_windows_line_ends_are_accepted(tmp_path: Path):
    data = COMPRESSION.replace(b"\n", b"\r\n")
    assert load_case(written(tmp_path, data)).growth is not None
    fault = only_fault(written(tmp_path, data.replace(b"plane: strain", b"plane: strian")))
    assert fault.line == 6


def test_harmless_tags_and_anchors_are_accepted(tmp_path: Path):
    data = COMPRESSION.replace(b"young: 10000", b"young: &E !!float 10000").replace(b"strain ", b"!!str strain ")
    assert load_case(written(tmp_path, data)).bodies[0].material.young == 1e10


@pytest.mark.parametrize("units", ["!x {length: mm}", "{length: !x mm}", "*me"])
def test_units_that_the_parser_refuses(units: str, tmp_path: Path):
    data = COMPRESSION.replace(b"{length: mm, stress: MPa}", units.encode())
    with pytest.raises(CaseError, match="units"):
        load_case(written(tmp_path, data))


def test_more_than_checks_can_take_is_refused(tmp_path: Path):
    vertices = ", ".join(f"[{x}, 0]" for x in range(5001))
    with pytest.raises(CaseError, match="a list of 5001 given; wanted: 5000 at most"):
        load_case(written(tmp_path, COMPRESSION), [f"cracks.flaw.path={{points: [{vertices}]}}"])
    with pytest.raises(CaseError, match="1001 names given; wanted: 1000 at most"):
        load_case(
            written(
                tmp_path, COMPRESSION.replace(b"  flaw:", b"".join(b"  c%d: 1\n" % k for k in range(1000)) + b"  flaw:")
            )
        )
    with pytest.raises(CaseError, match="60 unknown keys; allowed: title, "):
        load_case(written(tmp_path, COMPRESSION + b"".join(b"key%d: 1\n" % k for k in range(60))))


def test_recursive_and_exploding_aliases(tmp_path: Path):
    lines = ["a0: &a0 [x, x]", *(f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]" for n in range(1, 60))]
    assert "more than 100,000 values" in only_fault(written(tmp_path, "\n".join(lines).encode())).message
    lines = ["a0: &a0 [x]", *(f"a{n}: &a{n} [*a{n - 1}]" for n in range(1, 60))]
    assert "more than 40 levels" in only_fault(written(tmp_path, "\n".join(lines).encode())).message
    with pytest.raises(CaseError, match="no value before it has the anchor &me"):
        load_case(written(tmp_path, COMPRESSION + b"me: &me [*me]\n"))


def test_aliases_stand_for_values_of_their_own(tmp_path: Path):
    """A YAML writer makes them of what two keys share; an override of one of these leaves the other alone."""
    case = yaml.safe_load(COMPRESSION)
    contact = case["cracks"]["flaw"]["contact"]
    case["cracks"]["other"] = {"path": {"points": [[10, 10], [15, 10]]}, "contact": contact}
    shared = written(tmp_path, yaml.safe_dump(case).encode())
    assert "*id001" in shared.read_text(encoding="utf-8")
    cracks = {crack.name: crack for crack in load_case(shared, ["cracks.other.contact.friction=0.3"]).cracks}
    frictions = [crack.contact.friction for crack in cracks.values() if crack.contact]
    assert frictions == [0.0, 0.3]


def test_surrogate_halves_are_refused(tmp_path: Path):
    data = COMPRESSION.replace(b"title: Closed", b'title: "\\ud800" #')
    fault = only_fault(written(tmp_path, data))
    assert (fault.key, fault.line) == ("title", 3)
    str(fault).encode()
