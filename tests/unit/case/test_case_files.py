"""Files that are no case, each with a place and no action, and cases that are another one changed (`base`, `set`)."""

from __future__ import annotations

import json
import os
from pathlib import Path

import jsonschema
import pytest

from crackgrow.case import dump_case, load_case
from crackgrow.case.json_schema import case_schema
from tests.scenes import fault_of
from tests.unit.case.scenes import FILE, held, rectangle, text_of, with_body

COMPRESSION = FILE.read_bytes()


def written(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "scene.yaml"
    path.write_bytes(data)
    return path


def test_what_is_no_file(tmp_path: Path):
    """A pipe does not block."""
    assert str(fault_of(tmp_path / "nowhere.yaml")) == f"{tmp_path / 'nowhere.yaml'}: no such file"
    assert "is a directory" in fault_of(tmp_path).message
    os.mkfifo(tmp_path / "pipe")
    assert "not a regular file" in fault_of(tmp_path / "pipe").message
    assert fault_of(Path("a\0b")).message
    assert fault_of(Path("a" * 5000)).message
    path = tmp_path / os.fsdecode(b"rock\xff.yaml")
    path.write_bytes(COMPRESSION)
    assert fault_of(path).message == "the file's name is no text in UTF-8, and the case is named after it; rename it"


PAIRS = b"".join(b"a%d: &a%d [*a%d, *a%d]\n" % (n, n, n - 1, n - 1) for n in range(1, 60))
DEEP = b"".join(b"a%d: &a%d [*a%d]\n" % (n, n, n - 1) for n in range(1, 60))


@pytest.mark.parametrize(("data", "line", "words"), [
    (b"\xff\xfe\x00", 1, "not a text in UTF-8"),
    (b"a: 1\nb: \xe9\n", 2, "not a text in UTF-8"),
    (b"!!python/object/apply:os.system ['exit 3']\n", 1, "is not allowed"),
    (b"\n" + b"[" * 10_000, 2, "nested deeper than"),
    (b"a0: &a0 [x, x]\n" + PAIRS, None, "more than 100,000 values"),
    (b"a0: &a0 [x]\n" + DEEP, None, "deeper than 40 levels"),
    (b"# " + b"x" * 3_000_000, None, "larger than"),
    (COMPRESSION + b"---\ntitle: another\n", 59, "another document: a case file holds one"),
    (COMPRESSION.replace(b"\n", b"\r\n").replace(b"plane: strain", b"plane: strian"), 6, "did you mean 'strain'?"),
    (COMPRESSION.replace(b"title: Closed", b'title: "\\ud800" #'), 3, "title"),
    (COMPRESSION + b"".join(b"key%d: 1\n" % k for k in range(60)), None, "60 unknown keys; allowed: title, "),
    (
        COMPRESSION.replace(b"  flaw:", b"".join(b"  c%d: 1\n" % k for k in range(1000)) + b"  flaw:"),
        None,
        "1001 names given; wanted: 1000 at most",
    ),
])  # fmt: skip
def test_no_case(data: bytes, line: int | None, words: str, tmp_path: Path):
    fault = fault_of(written(tmp_path, data))
    assert words in str(fault)
    assert line is None or fault.line == line
    str(fault).encode()  # no half of a surrogate pair


@pytest.mark.parametrize("data", [
    b"\xef\xbb\xbf" + COMPRESSION,  # a byte order mark
    COMPRESSION.replace(b"\n", b"\r\n"),
    COMPRESSION.replace(b"young: 10000", b"young: &E !!float 10000").replace(b"strain ", b"!!str strain "),
], ids=["mark", "windows", "tags"])  # fmt: skip
def test_what_editors_and_writers_make_of_a_file_is_accepted(data: bytes, tmp_path: Path):
    case = load_case(written(tmp_path, data))
    assert dump_case(case) == dump_case(load_case(FILE))


def test_aliases_stand_for_values_of_their_own(tmp_path: Path):
    """An override of one of these leaves the other alone."""
    other = b"  other: {path: {points: [[10, 10], [15, 10]]}, contact: *law}\nsupports:"
    shared = COMPRESSION.replace(b"contact:   ", b"contact: &law  ").replace(b"supports:", other)
    cracks = load_case(written(tmp_path, shared), ["cracks.other.contact.friction=0.3"]).cracks
    assert [crack.contact.friction for crack in cracks] == [0.0, 0.3]


# --- `base` and `set` ------------------------------------------------------------------------------------------------

SCENE = {**with_body(rectangle(0, 0, 4, 6)), "supports": held("rock"), "loads": [{"stress": [-1, -2, 0]}]}


def write(folder: Path, **files: str) -> Path:
    """The plate in base.yaml, and files beside it; the last one's path."""
    for name, text in {"base": text_of(SCENE), **files}.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    return folder / f"{name}.yaml"


def test_a_base_with_settings_is_the_case_with_these_overrides(tmp_path: Path):
    """Those of the last file win, and those of the command line after them."""
    middle = "base: base.yaml\ntitle: other\nset: {numerics.spacing: 0.4, 'loads.0.stress': [0, 1, 2]}"
    path = write(tmp_path, middle=middle, changed="base: middle.yaml\nset: {numerics.spacing: 50 cm}")
    case = load_case(path)
    wanted = load_case(tmp_path / "base.yaml", ["title=other", "numerics.spacing=50 cm", "loads.0.stress=[0, 1, 2]"])
    assert dump_case(case) == dump_case(wanted)
    assert case.name == "changed"
    assert "base" not in dump_case(case)
    assert load_case(path, ["numerics.spacing=0.2"]).numerics.spacing == 0.2


def test_files_are_relative_to_the_file_that_names_them(tmp_path: Path):
    for folder in ("plates", "mine"):
        (tmp_path / folder).mkdir()
    square = {"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]]}
    (tmp_path / "plates" / "square.geojson").write_text(json.dumps(square))
    scene = with_body({"file": "square.geojson"})
    scene["supports"] = [{"on": {"edge": "0"}, "displacement": [0, 0]}]
    write(tmp_path / "plates", base=text_of(scene))
    case = load_case(write(tmp_path / "mine", own="base: ../plates/base.yaml\nset: {plane: stress}"))
    assert (case.plane, len(case.bodies[0].outline)) == ("stress", 4)


def test_the_schema_takes_a_case_with_a_base_and_no_half_case():
    schema = jsonschema.Draft7Validator(json.loads(case_schema()))
    assert schema.is_valid({"base": "a.yaml", "title": "b", "set": {"growth.steps": 3, "loads.0.traction": [0, 1]}})
    assert not schema.is_valid({"base": "a.yaml", "plane": "strain"})
    assert not schema.is_valid({"title": "b", "plane": "strain"})
