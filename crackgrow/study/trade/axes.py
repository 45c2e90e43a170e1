"""The settings that a trade varies: their keys in a case, the values asked for, and those that suit a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from crackgrow.case import Case
from crackgrow.case.accuracy import STANDARD
from crackgrow.case.model import ContactSupport
from crackgrow.case.report import did_you_mean, quoted
from crackgrow.errors import CaseError, Fault
from crackgrow.results.units import length_text
from crackgrow.study.setting import CaseFile

Axes = Mapping[str, tuple[str, ...]]

KEYS: Final[Mapping[str, str]] = {
    "spacing": "numerics.spacing",
    "support": "numerics.support",
    "quadrature": "numerics.quadrature",
    "contact_spacing": "numerics.contact.spacing",
    "stiffness": "numerics.contact.stiffness",
    "solver": "numerics.contact.solver",
    "tip_radius": "growth.tip_stress.radius",
    "increment": "growth.increment",
    "accuracy": "numerics.accuracy",
    "tips": "numerics.refine.tips",
    "kinks": "numerics.refine.kinks",
    "corners": "numerics.refine.corners",
    "tip_functions": "numerics.tip_functions",
}
"""The key of the case that an axis sets."""

SPACINGS: Final = (2.0, 1.5, 1.0, 0.7, 0.5)  # of the automatic spacing of cells of one size at standard accuracy
ONE_SIZE: Final = "numerics.refine={tips: 0, kinks: 0, corners: 0}"


def chosen_axes(file: CaseFile, texts: Sequence[str]) -> Axes:
    """The axes asked for, such as "spacing=3,2,1.5", or else those that suit the case.

    Raises CaseError with all faults: unknown axes, values that the case does not allow.
    """
    case = file.load()
    if not texts:
        return default_axes(file, case)
    faults: list[Fault] = []
    axes: dict[str, tuple[str, ...]] = {}
    for text in texts:
        name, equals, listed = text.partition("=")
        values = tuple(value.strip() for value in listed.split(","))
        if name not in KEYS:
            hint = did_you_mean(name, KEYS)
            faults.append(_fault(name, f"no such axis{hint}; there are {', '.join(KEYS)}"))
        elif not equals or not all(values):
            faults.append(_fault(name, f"{quoted(text)} given; wanted: values with commas between, {name}=A,B,C"))
        elif name in axes:
            faults.append(_fault(name, "given twice; write all its values in one"))
        elif len(set(values)) < len(values):
            faults.append(_fault(name, f"{quoted(listed)} has a value twice"))
        elif KEYS[name].startswith("growth.") and case.growth is None:
            faults.append(_fault(name, f"the case has no `growth`, so no {KEYS[name]}"))
        else:
            axes[name] = values
            faults.extend(fault for value in values for fault in _faults_of(file, name, value))
    if faults:
        raise CaseError(faults)
    return axes


def default_axes(file: CaseFile, case: Case) -> Axes:
    """Spacings round the automatic one, patches, quadrature, and the distance of contact nodes where faces touch."""
    automatic = file.load("numerics.spacing=auto", f"numerics.accuracy={STANDARD}", ONE_SIZE).numerics.spacing
    touching = [crack.contact for crack in case.cracks] + [
        None if interface.contact == "bonded" else interface.contact for interface in case.interfaces
    ]
    axes = {"spacing": tuple(length_text(automatic * part) for part in SPACINGS), "support": ("1.5", "2")}
    if any(touching) or any(isinstance(support, ContactSupport) for support in case.supports):
        return {**axes, "quadrature": ("3", "4"), "contact_spacing": ("1.25", "2")}
    return {**axes, "support": ("1.5", "2", "2.5"), "quadrature": ("2", "3", "4")}


def _faults_of(file: CaseFile, name: str, value: str) -> list[Fault]:
    """What the case says of one value; faults that are not the value's own keep their words."""
    try:
        file.load(f"{KEYS[name]}={value}")
    except CaseError as error:
        return [_fault(name, fault.message) if fault.key == KEYS[name] else fault for fault in error.faults]
    return []


def _fault(name: str, message: str) -> Fault:
    return Fault("--axis", None, name, message)
