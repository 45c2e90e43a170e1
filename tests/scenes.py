"""Scenes as documents of a case: specimens and plates with flaws, for tests and benchmarks."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import Case, load_case
from crackgrow.errors import CaseError, Fault
from tests.verification.solutions import CASES

MPA = 1e6


def shipped_case(name: str, settings: Iterable[str] = ()) -> Case:
    """A shipped case with settings."""
    return load_case(CASES / f"{name}.yaml", list(settings))


def shipped(name: str) -> dict[str, Any]:
    """A shipped scene for one static solve."""
    scene: dict[str, Any] = yaml.safe_load((CASES / f"{name}.yaml").read_text().replace(" on:", " 'on':").replace(
        "{on:", "{'on':"))  # fmt: skip
    return {key: value for key, value in scene.items() if key not in ("growth", "loading")}


def plate(points: list[list[float]], size: float, axial: float, lateral: float, friction: float) -> dict[str, Any]:
    """A square plate under compression (MPa) with one flaw (mm), loaded by tractions."""
    edges = {"left": [lateral, 0], "right": [-lateral, 0], "top": [0, -axial], "bottom": [0, axial]}
    corner = 0.5 * size
    return {
        "title": "a closed flaw with wings",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": size, "height": size}},
                "material": {"young": 20000, "poisson": 0.25},
            }
        },
        "cracks": {"flaw": {"path": {"points": points}, "contact": {"friction": friction, "cohesion": 0}}},
        "supports": [
            {"at": [-corner, -corner], "displacement": {"x": 0, "y": 0}},
            {"at": [corner, -corner], "displacement": {"y": 0}},
        ],
        "loads": [{"on": {"body": "rock", "edge": edge}, "traction": force} for edge, force in edges.items()],
        "numerics": {"spacing": 1},
    }


def specimen(
    cracks: dict[str, Any], size: tuple[float, float] = (31.0, 55.0), sigma: float = 1.0, **more: Any
) -> dict[str, Any]:
    """A plate (mm) that is pulled along y (MPa), held where it takes no force, of rock in which cracks may grow."""
    x, y = 0.5 * size[0], 0.5 * size[1]
    return {
        "title": "plate",
        "units": {"length": "mm", "stress": "MPa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0, 0], "width": size[0], "height": size[1]}},
                "material": {"young": 10000, "poisson": 0.25},
                "strength": {"tension": 0.5, "cohesion": 10, "friction_angle": 40},
            }
        },
        "cracks": cracks,
        "supports": [
            {"at": [-x, -y], "displacement": {"y": 0}},
            {"at": [x, -y], "displacement": {"y": 0}},
            {"at": [0, -y], "displacement": {"x": 0}},
        ],
        "loads": [
            {"on": {"body": "rock", "edge": "top"}, "traction": [0, sigma]},
            {"on": {"body": "rock", "edge": "bottom"}, "traction": [0, -sigma]},
        ],
        "output": {"frames": "none", "figures": False},
        **more,
    }


def winged(half: float, angle: float, wing: float, turn: float) -> list[list[float]]:
    """Vertices of a flaw with straight wings, symmetric by point reflection; degrees."""
    inner = half * np.exp(1j * np.deg2rad(angle))
    outer = inner + wing * np.exp(1j * np.deg2rad(angle + turn))
    return [[float(z.real), float(z.imag)] for z in (-outer, -inner, inner, outer)]


def fault_of(file: Path, *settings: str) -> Fault:
    """The only fault of a case file with settings."""
    with pytest.raises(CaseError) as caught:
        load_case(file, settings)
    (fault,) = caught.value.faults
    return fault


def told(warnings: Iterable[str]) -> list[str]:
    """Warnings but the one that cells by hand have no error."""
    return [text for text in warnings if "no error is measured" not in text]
