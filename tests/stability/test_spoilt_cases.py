"""Case files spoilt at random and numbers of any size are accepted or refused with a place; nothing else happens."""

from __future__ import annotations

import contextlib
import copy
import json
import re
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from jsonschema import Draft7Validator

from crackgrow import cli
from crackgrow.case import load_case
from crackgrow.case.format import CASE
from crackgrow.case.json_schema import case_schema
from crackgrow.case.reader import Table, read_file
from crackgrow.case.report import Report
from crackgrow.case.scalars import Context
from crackgrow.case.units import Units
from crackgrow.cli.command_line import declared
from crackgrow.cli.start import template_text
from crackgrow.errors import CaseError, CrackgrowError, SolveError
from crackgrow.run.loop import grow
from tests.scenes import shipped_case
from tests.unit.case.scenes import EVERYTHING, changed, read_yaml12, text_of

CASES = Path(__file__).parents[2] / "cases"
LONGEST = 5.0
"""Seconds of CPU that validation may take."""
LEAST_AGREEMENT = 0.95
"""Of the files that the reader refuses for one value alone, or as YAML: how many the JSON Schema refuses, too."""
TAGS = ["!!python/object/apply:os.system [touch, escaped]", "!!python/name:os.system", "!!binary AAAA", "!x 1",
        "!!python/object/new:subprocess.Popen [[touch, it]]", "!!set {a, b}", "!!timestamp 2001-01-01"]  # fmt: skip
NAMES = ["../escape", "..", "/tmp/x", "a/b", "CON", "x" * 65, "a\u0301", "-a", ".hidden", "a b", "0", "~", "a.b", "ü"]
VALUES = [
    "[1, 2]", "{a: 1}", "~", "", "a text", "true", "''", '"5"', "[]", "{}", "[[1]]", "5", "-", "none", "!!str 5", *TAGS,
    "3 parsec", "5 kg", "1 mm", "2 MPa", "4 deg", "2500 kg/m^3", "5mm", "mm", "5 mm mm", "1 MPa^2",
    "1e308", "-1e308", "1e400", "1e-320", "1e61", "1e-61", ".inf", "-.inf", ".nan", "0", "-0.0", "-1", "9" * 400,
    "0x10", "1_000", "017", "1e", "--1", "1.2.3", "1e+12", "1e-12", "STRAIN", "bothh", "on", "../../escape", "\u202e",
    "__import__('os').system('true')", "x**9**9**9", "(" * 200 + "x" + ")" * 200, "lambda: x", "x^2", "1e999*x",
    "{file: /etc/passwd.json}", "{file: /dev/zero}", "[" * 3000 + "1", "{a: " * 3000 + "1" + "}" * 3000, "x" * 100_000,
]  # fmt: skip
PIECES = [
    b":", b"- ", b"[", b"]", b"{", b"}", b"&a ", b"*a", b"'", b'"', b"\n", b"  ", b"? ", b"| ", b"> ", b"%", b"---\n",
    b"\xff", b"\0", b"\x1b[2J", b"\xe2\x80\xa8", b"\xed\xa0\x80", b"<<: ", b"#", b"\t", b"\r", b"\xef\xbb\xbf", b"~",
]  # fmt: skip
Span = tuple[int, int]
LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")  # of YAML 1.1


@cache
def good_cases() -> list[str]:
    """All that are shipped and whole, without a base, the templates, and one with everything in it."""
    shipped = [file.read_text(encoding="utf-8") for file in sorted(CASES.glob("*.yaml"))]
    whole = [text for text in shipped if "\nbase: " not in text]
    return [*whole, *map(template_text, declared()["words"]["templates"]), text_of(EVERYTHING)]


@cache
def spans(text: str) -> tuple[tuple[Span, Span], ...]:
    """Where keys and their values stand in a text."""

    def inside(node: yaml.Node) -> Iterator[tuple[Span, Span]]:
        for pair in node.value if isinstance(node, yaml.MappingNode) else ():
            yield tuple((part.start_mark.index, part.end_mark.index) for part in pair)  # type: ignore[misc]
        for part in node.value if isinstance(node, yaml.CollectionNode) else ():
            yield from inside(part[1] if isinstance(part, tuple) else part)

    return tuple(inside(yaml.compose(text, Loader=yaml.SafeLoader)))


def spoilt(number: int) -> bytes:
    """A good case in which a key or a value is another one, left out, twice there or cut off, or bytes are others'."""
    rng = np.random.default_rng([1, number])
    good = good_cases()
    text = good[rng.integers(len(good))]
    some = spans(text)
    (key, key_end), (start, end) = some[rng.integers(len(some))]
    kind, name = number % 8, text[key:key_end]
    if kind < 3:
        value = VALUES[rng.integers(len(VALUES))] + "\n" * ("\n" in text[start:end])
        return (text[:start] + value + text[end:]).encode()
    if kind == 3:
        at = rng.integers(len(name))
        names = [name[:at] + name[at + 1 :], f"{name[:at]}q{name[at + 1 :]}", f'"{NAMES[at % len(NAMES)]}"']
        return (text[:key] + names[rng.integers(3)] + text[key_end:]).encode()
    if kind == 4:
        return (text[:key] + text[end:].lstrip(", ")).encode()
    if kind == 5:
        aliases = "\n".join(["a0: &a0 [x, x]", *(f"a{n}: &a{n} [*a{n - 1}, *a{n - 1}]" for n in range(1, 30))])
        return f"{aliases}\n{text}".encode() if rng.random() < 0.1 else (text[:end] + ", " + text[key:]).encode()
    data = bytearray(text.encode())
    if kind == 6:
        return bytes(data[: rng.integers(len(data))])
    for _ in range(rng.integers(1, 4)):
        place = int(rng.integers(len(data)))
        piece = PIECES[rng.integers(len(PIECES))] * int(rng.integers(4)) if rng.random() < 0.9 else rng.bytes(50)
        data[place : place + int(rng.integers(12))] = piece
    return bytes(data)


def is_wrong_alone(path: Path) -> bool:
    """Whether reading keys and values finds faults, before any of them is held against another, or against a file."""
    report = Report(str(path))
    root = read_file(path, report)
    if isinstance(root, Table):
        CASE.read(root, (), Context(report, Units(), path.parent))
    return root is None or any(not fault.key.endswith(".file") for fault in report.faults)


@pytest.mark.parametrize("numbers", [range(80), pytest.param(range(80, 20_000), marks=pytest.mark.slow)])
def test_spoilt_cases_are_accepted_or_refused_with_a_place(numbers: range, tmp_path: Path) -> None:
    """An editor with the JSON Schema refuses nothing that the reader takes, and nearly all that is wrong alone."""
    schema, path = Draft7Validator(json.loads(case_schema())), tmp_path / "scene.yaml"
    refused, alone, alike = 0, 0, 0
    for number in numbers:
        data = spoilt(number)
        path.write_bytes(data)
        start, accepted = time.process_time(), False
        try:
            load_case(path)
            accepted = True
        except CaseError as error:
            n_lines = len(LINE_BREAK.findall(data.decode(errors="replace"))) + 1
            for fault in error.faults:
                assert fault.source == str(path), number
                assert fault.message, number
                assert fault.line is not None, number
                assert 1 <= fault.line <= n_lines, number
                str(fault).encode()
        assert time.process_time() - start < LONGEST, number
        try:
            valid = schema.is_valid(read_yaml12(data.decode("utf-8-sig")))
        except (UnicodeDecodeError, yaml.YAMLError, RecursionError, ValueError):
            valid = False
        assert valid or not accepted, number
        refused += not accepted
        if not accepted and is_wrong_alone(path):
            alone, alike = alone + 1, alike + (not valid)
    assert 0.5 < refused / len(numbers) < 1.0
    assert alike >= LEAST_AGREEMENT * alone


@pytest.mark.parametrize("name", NAMES)
def test_names_cannot_lead_out_of_the_folder_of_the_results(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "inner").mkdir()
    monkeypatch.chdir(tmp_path / "inner")
    text = template_text("tension").replace("notch:", f'"{name}":').replace("steps: 6", "steps: 0")
    Path("scene.yaml").write_text(text, encoding="utf-8")
    code = cli.main(["run", "scene.yaml", "--quiet", "--set", "numerics.spacing=6", "--set", "output.figures=false"])
    assert code in (0, 2)
    assert [path.name for path in tmp_path.iterdir()] == ["inner"]
    assert {path.name for path in Path().iterdir()} <= {"scene.yaml", "outputs"}
    assert [path.name for path in Path("outputs").glob("*")] == ([] if code else ["scene"])


Key = tuple[str | int, ...]

LAW = {"friction": 0.3, "cohesion": 0.1, "residual_friction": 0.2, "dilation_angle": 5}
NUMBERED: dict[str, Any] = changed(
    EVERYTHING,
    cracks={"flaw": {"path": {"points": [[-2, 15], [0, 16], [2, 17]]}, "contact": LAW}},
    loading={"history": [0.5, 1.0]},
    growth={**EVERYTHING["growth"], "criterion": "strength", "direction": "explicit", "steps": 1},
    numerics={"spacing": 1, "support": 2.0, "quadrature": 3, "contact": {"stiffness": 100, "spacing": 1.25}},
    output={"frames": "none", "figures": False},
)
"""Every key that takes a number."""


def numbers(value: Any, key: Key = ()) -> Iterator[Key]:
    """The keys of all numbers in a document."""
    if isinstance(value, dict | list):
        for inner, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from numbers(part, (*key, inner))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield key


KEYS = tuple(numbers(NUMBERED))
DISPLACEMENT: Key = ("supports", 1, "displacement", "y")


def written(folder: Path, changes: dict[Key, str]) -> Path:
    """The document as a file, with other numbers at some keys."""
    document = copy.deepcopy(NUMBERED)
    for number, key in enumerate(changes):
        place = document
        for part in key[:-1]:
            place = place[part]
        place[key[-1]] = f"@{number}@"
    text = text_of(document)
    for number, value in enumerate(changes.values()):
        text = text.replace(f"'@{number}@'", value)
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def name_of(key: Key) -> str:
    return ".".join(str(part) for part in key)


def solved_to_the_end(path: Path) -> None:
    """Every number of a result that must be one is finite."""
    for result in grow(load_case(path)):
        energy = result.energy
        found = [result.residual, result.penetration, result.complementarity, result.overlap, result.load_displacement]
        found += [energy.work, energy.strain, energy.dissipated, energy.released, energy.error, result.crack_length]
        assert np.isfinite(found).all()
        for values in (result.contact.normal_traction, result.contact.tangential_traction, result.contact.opening):
            assert np.isfinite(values).all()


@pytest.mark.parametrize("value", [".nan", "-.inf", "1e400", "-1e300", "1e-300"])
def test_numbers_that_none_can_mean_are_refused_where_they_stand(tmp_path: Path, value: str) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(written(tmp_path, dict.fromkeys(KEYS, value)))
    assert {name_of(key) for key in KEYS} <= {fault.key for fault in caught.value.faults if value in fault.message}


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS, ids=name_of)
def test_numbers_that_can_be_read_are_solved_or_refused(tmp_path: Path, key: Key) -> None:
    """No warning and no other kind of error, whatever the size: `filterwarnings` makes errors of warnings."""
    solved_to_the_end(written(tmp_path, {}))
    for value in ("1e50", "-1e50", "1e20", "1e-20", "1e-50"):
        with contextlib.suppress(CrackgrowError):
            solved_to_the_end(written(tmp_path, {key: value}))


def test_an_increment_far_larger_than_the_specimen_ends_at_its_outline() -> None:
    ends = []
    for increment in ("200 mm", "1e12 m", "1e50 m"):
        settings = ["growth.steps=1", f"growth.increment={increment}", "output.frames=none", "numerics.spacing=4"]
        *_, last = grow(shipped_case("compression30", settings))
        assert [event.kind for event in last.events] == ["break_through"]
        ends.append(last.cracks[0].points)
    assert len(ends[0]) == 3
    assert np.array_equal(ends[1], ends[0])
    assert np.array_equal(ends[2], ends[0])


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({("loads", 2, "gravity", 1): "-1e59", ("bodies", "block", "material", "density"): "1e59"}, "loads"),
        (
            {("loads", 0, "traction", 1): "-1e53"}
            | {("bodies", body, "material", "young"): "1e-29" for body in ("block", "foundation", "plug")},
            "displacements",
        ),
        ({DISPLACEMENT: "1e59", ("loading", "history", 0): "1e20"}, "prescribed displacements"),
        ({DISPLACEMENT: '"1e300*y"', ("loading", "history", 0): "1e50"}, "prescribed displacements"),
    ],
    ids=["loads", "displacements", "prescribed displacements", "by a formula"],
)
def test_fields_that_leave_all_bounds_are_named(tmp_path: Path, changes: dict[Key, str], field: str) -> None:
    with pytest.raises(SolveError, match=f"^{field}.*: a value is .*wanted: finite, at most"):
        solved_to_the_end(written(tmp_path, changes))
