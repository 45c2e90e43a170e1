"""The case format as one tree of specs: the keys of the model's fields, and what no field of the model is."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from crackgrow.case import model
from crackgrow.case.declared import keys_of, mapping_of
from crackgrow.case.outline_file import with_file_edges
from crackgrow.case.overrides import OfFile
from crackgrow.case.references import Definitions
from crackgrow.case.report import Path
from crackgrow.case.scalars import NOT_NEGATIVE, Bounds, Choice, Context, Integer, Number, Quantity, Text, WordOr
from crackgrow.case.schema import (
    BY_PARTS,
    OPTIONAL,
    Converted,
    Field,
    ListOf,
    Mapping,
    Named,
    OneOf,
    OneOrList,
)
from crackgrow.case.spellings import PAIR
from crackgrow.case.units import UNITS

UNITS_SPEC: Final = Mapping(
    {
        "length": Field(Choice(tuple(UNITS["length"])), "unit of bare lengths", "m"),
        "stress": Field(Choice(tuple(UNITS["stress"])), "unit of bare stresses, tractions and moduli", "Pa"),
        "origin": Field(
            ListOf(Quantity("length"), 2),
            "a round place near the scene, for coordinates of a map",
            OPTIONAL,
        ),
    }
)

EDGES: Final = Named("edge", OneOrList(Integer(NOT_NEGATIVE)))

BODY: Final = Converted(
    Mapping(
        {
            **keys_of(model.Body),
            "edges": Field(EDGES, "names for edges of a polygon, by number", OPTIONAL),
        }
    ),
    with_file_edges,
)

TIPS: Final = Choice(
    ("both", "start", "end", "none"),
    ("both ends", "the first point", "the last point", "it does not grow"),
)

_CRACK_KEYS: Final = keys_of(model.Crack)
CRACK: Final = Mapping(
    {
        "path": _CRACK_KEYS["path"],
        "tips": Field(TIPS, "ends at which the crack can grow", "both"),
        "contact": _CRACK_KEYS["contact"],
        "contact_by": Field(
            Named("attribute", Named("value", _CRACK_KEYS["contact"].spec, any_name=True), at_most=1, any_name=True),
            "laws by an attribute of the map's lines",
            OPTIONAL,
        ),
    }
)

OUTLINE: Final = Field(
    Choice(("fixed", "rollers"), ("no displacement", "none across it, on sides along x or y")),
    "how the whole outline is held",
)

SUPPORT: Final = OneOf(
    (
        Mapping(keys_of(model.PointSupport, last="body")),
        mapping_of(model.EdgeSupport),
        mapping_of(model.ContactSupport),
        Mapping({"outline": OUTLINE, "body": Field(Text(), "name of a body; left out: all of them", OPTIONAL)}),
    )
)

MINIMAL: Final = "minimal"

SUPPORTS: Final = WordOr(
    (MINIMAL,),
    ListOf(SUPPORT),
    ("three constraints that take no force, for loads that balance",),
)

_PRESSURE: Final = keys_of(model.FluidPressure)
_PRESSED: Final = Field(PAIR, "names of two bodies, not bonded")

LOAD: Final = OneOf(
    (
        mapping_of(model.EdgeTraction),
        mapping_of(model.EdgePressure),
        mapping_of(model.FarField),
        mapping_of(model.Gravity),
        Mapping({"crack": Field(Text(), "name of a crack"), **_PRESSURE}),
        mapping_of(model.InSituStress),
        mapping_of(model.PointForce),
        Mapping({"interface": _PRESSED, **_PRESSURE}),
    )
)

STAGE: Final = Mapping(
    {
        "name": Field(Text(), "name of the stage", OPTIONAL),
        "factor": Field(Number(), "of given displacements and all other loads; left out: as before", OPTIONAL),
        "loads": Field(Named("load", Number()), "factors of loads by their name, from this stage on", OPTIONAL),
        "excavate": Field(OneOrList(Text()), "bodies that are taken out", OPTIONAL),
        "release": Field(
            Number(Bounds(at_least=0, at_most=1)),
            "share of the removed rock's action that ends; left out: 1 where it excavates, else as before",
            OPTIONAL,
        ),
    }
)

EVENTS: Final = "events"

_HISTORY: Final = Mapping(
    {
        "history": Field(ListOf(Number()), "load factors applied in turn; left out: [1], or stages", OPTIONAL),
        "stages": Field(ListOf(STAGE), "stages of a construction, in turn", OPTIONAL),
        "follow": Field(
            WordOr(
                (EVENTS,),
                Integer(Bounds(at_least=1, at_most=10_000)),
                ("from one change of contact status to the next",),
            ),
            "load path; a number: in so many equal increments",
            OPTIONAL,
        ),
    },
    short="history",
)


def _history_or_stages(value: object, path: Path, context: Context) -> object:
    """Return a history, [1] where there is neither that nor stages; report both."""
    if not isinstance(value, dict):
        return value
    if "stages" not in value:
        return {"history": [1.0], **{key: what for key, what in value.items() if what != EVENTS}}
    for key in sorted(value.keys() & {"history", "follow"}):
        why = "give one of them: a stage has a `factor`, too" if key == "history" else "stages follow events"
        context.report.fault(path, f"has {'a ' * (key == 'history')}{key} and stages; {why}")
    return value


LOADING: Final = WordOr(
    ("critical", "strength_reduction"),
    Converted(_HISTORY, _history_or_stages),
    (
        "each step finds the load factor at which the criterion is just met",
        "the factor of safety: friction and cohesion divided by a factor until the scene fails",
    ),
)


_ON_A_CRACK: Final = Field(Text(), "name of a crack: its opening and slip")
_ON_AN_INTERFACE: Final = Field(PAIR, "names of two bodies: opening and slip between them")

HISTORY_POINT: Final = OneOf(
    (
        mapping_of(model.RockPoint),
        Mapping({"crack": _ON_A_CRACK, **keys_of(model.FacePoint)}),
        Mapping({"interface": _ON_AN_INTERFACE, **keys_of(model.FacePoint)}),
        mapping_of(model.PointPair),
    )
)

OUTPUT: Final = Mapping(
    {
        **keys_of(model.Output),
        "points": Field(Named("point", HISTORY_POINT), "places for history.csv", OPTIONAL),
    }
)

MATERIALS: Final = Definitions(Named("material", mapping_of(model.Material), at_most=200))
LAWS: Final = Definitions(Named("law", mapping_of(model.CoulombContact)), words=("none", "bonded"))
DEFINITIONS: Final = ("materials", "laws")  # of the case; resolved cases hold none

_CASE_KEYS: Final = keys_of(model.Case)

CASE: Final = Mapping(
    {
        "title": _CASE_KEYS["title"],
        "source": _CASE_KEYS["source"],
        "units": Field(UNITS_SPEC, "what bare numbers mean", BY_PARTS),
        "plane": _CASE_KEYS["plane"],
        "materials": Field(MATERIALS, "elastic constants by name", OPTIONAL),
        "laws": Field(LAWS, "laws of contact by name", OPTIONAL),
        "bodies": Field(Named("body", BODY, at_most=200), "the pieces of rock"),
        "cracks": Field(Named("crack", CRACK), "cracks at the start", {}),
        "interfaces": Field(ListOf(mapping_of(model.Interface)), "contact between bodies that share a boundary", []),
        "supports": Field(SUPPORTS, "prescribed displacements and rigid foundations", []),
        "loads": Field(ListOf(LOAD), "loads", []),
        "loading": Field(LOADING, "how the loads are applied in time", {"history": [1.0]}),
        "growth": _CASE_KEYS["growth"],
        "numerics": _CASE_KEYS["numerics"],
        "output": replace(_CASE_KEYS["output"], spec=OUTPUT),
        "base": Field(OfFile("a case file"), "the case that this one changes", OPTIONAL),
        "set": Field(OfFile("a mapping"), "keys of the base that differ, such as growth.steps: 3", OPTIONAL),
    }
)
