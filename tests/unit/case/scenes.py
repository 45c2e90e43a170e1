"""Small scenes as mappings, written out and loaded; YAML 1.2 as editors read it: `on` and `yes` are words."""

from __future__ import annotations

import copy
import dataclasses
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from crackgrow.case import Case, dump_case, load_case
from tests.scenes import fault_of

FILE = Path(__file__).parent / "compression30.yaml"
COMPRESSION = FILE.read_text(encoding="utf-8")
CASES = Path(__file__).parents[3] / "cases"
NAMES = sorted(path.stem for path in CASES.glob("*.yaml"))
LAW = {"friction": 0.5, "cohesion": 0}
MATERIAL = {"young": 10000, "poisson": 0.25}

EVERYTHING: dict[str, Any] = yaml.safe_load(FILE.with_name("everything.yaml").read_text(encoding="utf-8"))


def with_body(shape: dict[str, Any], **more: Any) -> dict[str, Any]:
    """One body in m, "rock", that nothing holds."""
    return {
        "title": "one body",
        "plane": "strain",
        "bodies": {"rock": {"shape": shape, "material": dict(MATERIAL), **more}},
        "supports": [],
        "numerics": {"spacing": 0.1},
    }


def blocks(**shapes: dict[str, Any]) -> dict[str, Any]:
    """Bodies in m with these shapes."""
    bodies = {name: {"shape": shape, "material": dict(MATERIAL)} for name, shape in shapes.items()}
    return {"title": "blocks", "plane": "strain", "bodies": bodies, "supports": [], "numerics": {"spacing": 0.1}}


def rectangle(x: float, y: float, width: float, height: float) -> dict[str, Any]:
    """A rectangle with its lower left corner at (x, y)."""
    return {"rectangle": {"center": [x + width / 2, y + height / 2], "width": width, "height": height}}


def joint(*names: str, contact: Any = LAW) -> list[dict[str, Any]]:
    """Interfaces between the pairs "a b"."""
    return [{"between": pair.split(), "contact": contact} for pair in names]


def held(*bodies: str) -> list[dict[str, Any]]:
    """Supports on a `bottom` that hold rectangles."""
    return [{"on": {"body": body, "edge": "bottom"}, "displacement": {"x": 0, "y": 0}} for body in bodies]


def plate(*loads: dict[str, Any], **parts: Any) -> dict[str, Any]:
    """A plate of 4 x 6 m round the origin with minimal supports."""
    return {**with_body(rectangle(-2, -3, 4, 6)), "supports": "minimal", "loads": list(loads), **parts}


def changed(scene: dict[str, Any], **parts: Any) -> dict[str, Any]:
    """A scene with whole keys replaced."""
    return {**copy.deepcopy(scene), **parts}


def text_of(scene: dict[str, Any]) -> str:
    """A scene as YAML, without aliases."""
    return yaml.safe_dump(json.loads(json.dumps(scene)), sort_keys=False)


def load(tmp_path: Path, scene: dict[str, Any], *overrides: str) -> Case:
    path = tmp_path / "scene.yaml"
    path.write_text(text_of(scene), encoding="utf-8")
    return load_case(path, overrides)


def compression(*overrides: str) -> Case:
    return load_case(FILE, overrides)


def edited(folder: Path, *edits: tuple[str, str]) -> Path:
    """A file with compression30 whose texts, which must be there once, are replaced."""
    text = COMPRESSION
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def fault(tmp_path: Path, scene: dict[str, Any], *overrides: str) -> tuple[str, str]:
    """Write a scene with one fault and return its key and message."""
    path = tmp_path / "scene.yaml"
    path.write_text(text_of(scene), encoding="utf-8")
    only = fault_of(path, *overrides)
    return only.key, only.message


def reread(case: Case, folder: Path) -> Case:
    """The case as it ran, written and loaded."""
    path = folder / f"{case.name}.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    return load_case(path)


def same(a: object, b: object) -> bool:
    """Whether two values of a model agree to the last bit."""
    if dataclasses.is_dataclass(a):
        names = [field.name for field in dataclasses.fields(a)]
        return type(a) is type(b) and all(same(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and repr(a) == repr(b)


MOST_ALIASES = 8  # editors stop at what aliases expand to


class _Core(yaml.SafeLoader):
    """Resolves plain scalars by the core schema of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}  # noqa: RUF012  (as in its base)

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.n_aliases = 0

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        self.n_aliases += self.check_event(yaml.AliasEvent)
        if self.n_aliases > MOST_ALIASES:
            raise yaml.composer.ComposerError(None, None, "too many aliases", self.peek_event().start_mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [str(key.value) for key, _ in node.value]  # as texts, whatever they look like
        if len(set(keys)) < len(keys):
            raise yaml.constructor.ConstructorError(None, None, "a key is given twice", node.start_mark)
        return {key: self.construct_object(value, deep=True) for key, (_, value) in zip(keys, node.value, strict=True)}


def _number(loader: _Core, node: yaml.ScalarNode) -> float:
    text = node.value.lower()
    return (
        float(int(text, 0))
        if text.startswith(("0x", "0o"))
        else float(text.replace(".inf", "inf").replace(".nan", "nan"))
    )


_NUMBER = (
    r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|0x[0-9a-fA-F]+|0o[0-7]+|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)"
)
for _tag, _pattern, _first in (
    ("float", _NUMBER, "-+0123456789."),
    ("bool", "true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
):
    _Core.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"^(?:{_pattern})$"), list(_first))
_Core.add_constructor("tag:yaml.org,2002:float", _number)


def read_yaml12(text: str) -> Any:
    """The document as JSON values; keys are texts. Raises yaml.YAMLError."""
    return yaml.load(text, Loader=_Core)
