"""Fields of the model as keys of the format: what they take, and the way there and back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import pytest

from crackgrow.case import load_case, model
from crackgrow.case.declared import Doc, keys_of, made, mapping_of, written
from crackgrow.case.keys import case_keys
from crackgrow.case.scalars import POSITIVE, Choice, Quantity, WordOr
from crackgrow.case.schema import BY_PARTS, OPTIONAL, REQUIRED, Field, Mapping, Same

CASES = sorted((Path(__file__).parents[3] / "cases").glob("*.yaml"))
SIZE = Quantity("length", POSITIVE)


@dataclass(frozen=True)
class Inner:
    n: Annotated[int, Doc("how many")] = 3


@dataclass(frozen=True)
class Sample:
    word: Annotated[Literal["a", "b"], Doc("which", ("first", "second"))]
    length: Annotated[float, SIZE, Doc("how long", key="size")]
    again: Annotated[float, SIZE, Doc("the same", default=Same("size"))]
    computed: float
    none: Annotated[float | None, WordOr(("auto",), SIZE), Doc("auto or not")] = None
    pair: Annotated[tuple[float, float] | None, Mapping({"x": Field(SIZE, "x"), "y": Field(SIZE, "y")}), Doc("two")] = (
        None
    )
    kept: Annotated[bool, Choice(("lost", "kept")), Doc("what stays")] = False
    inner: Annotated[Inner, Doc("inside")] = Inner()


def test_keys_have_the_defaults_and_specs_of_their_fields():
    found = {key: (field.doc, field.default) for key, field in keys_of(Sample).items()}
    assert found == {
        "word": ("which", REQUIRED),
        "size": ("how long", REQUIRED),
        "again": ("the same", Same("size")),
        "none": ("auto or not", "auto"),
        "pair": ("two", OPTIONAL),
        "kept": ("what stays", "lost"),
        "inner": ("inside", BY_PARTS),
    }
    assert keys_of(Sample)["word"].spec == Choice(("a", "b"), ("first", "second"))
    assert keys_of(Sample)["inner"].spec is mapping_of(Inner)
    assert list(keys_of(Sample, last="size"))[-1] == "size"


@pytest.mark.parametrize(
    ("values", "fields_of_it"),
    [
        ({"none": "auto", "kept": "lost"}, {"none": None, "pair": None, "kept": False, "inner": Inner()}),
        ({"none": 2.0, "kept": "kept", "inner": {"n": 5}}, {"none": 2.0, "kept": True, "inner": Inner(5)}),
        ({"pair": {"x": 1.0, "y": 2.0}}, {"pair": (1.0, 2.0)}),
    ],
)
def test_an_instance_is_made_of_values_and_written_as_them(values: dict[str, Any], fields_of_it: dict[str, Any]):
    given = {"word": "b", "size": 1.0, "again": 2.0, **values}
    sample = made(Sample, given, computed=7.0)
    assert (sample.word, sample.length, sample.again, sample.computed) == ("b", 1.0, 2.0, 7.0)
    assert {name: getattr(sample, name) for name in fields_of_it} == fields_of_it
    assert written(sample).items() >= given.items()
    assert made(Sample, written(sample), computed=7.0) == sample


def parts_of(value: Any) -> Iterator[Any]:
    if is_dataclass(value):
        yield value
        for part in fields(value):
            yield from parts_of(getattr(value, part.name))
    for inner in value if isinstance(value, tuple) else ():
        yield from parts_of(inner)


@pytest.mark.parametrize("file", CASES, ids=lambda file: file.stem)
def test_settings_of_shipped_cases_come_back_from_what_is_written(file: Path):
    case = load_case(file)
    for part in (*parts_of(case.growth), *parts_of(case.numerics), *(body.material for body in case.bodies)):
        assert repr(made(type(part), written(part))) == repr(part)


def test_every_declared_field_is_a_key_of_the_format_with_its_line():
    told = {key.name.rpartition(".")[2] for key in case_keys()}
    classes = [cls for cls in vars(model).values() if is_dataclass(cls) and cls.__module__ == model.__name__]
    offered = {key for cls in classes for key, field in keys_of(cls).items() if field.offered}
    assert len(offered) > 60
    assert offered - told == set()
