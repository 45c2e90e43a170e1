"""The case format as one tree of specs: every key, what it takes, its default and a line about it."""

from __future__ import annotations

from typing import Final

from crackgrow.case.scalars import (
    NOT_NEGATIVE,
    POSITIVE,
    Bounds,
    Choice,
    Integer,
    Number,
    Quantity,
    Switch,
    Text,
    WordOr,
)
from crackgrow.case.schema import BY_PARTS, OPTIONAL, Field, ListOf, Mapping, Named, OneOf
from crackgrow.case.units import UNITS

# Keys and words of the format that this version refuses as not supported. The only such list.
LATER: Final = {
    "case": ("interfaces",),
    "shape": ("polygon", "disk", "file"),
    "rectangle form": ("holes",),
    "body": ("edges",),
    "support": ("contact",),
    "load": ("gravity", "crack", "pressure", "stress"),
    "numerics": ("accuracy",),
    "criterion": ("max_hoop_stress",),
}

LENGTH: Final = Quantity("length")
POINT: Final = ListOf(LENGTH, 2)

UNITS_SPEC: Final = Mapping(
    {
        "length": Field(Choice(tuple(UNITS["length"])), "unit of bare lengths", "m"),
        "stress": Field(Choice(tuple(UNITS["stress"])), "unit of bare stresses, tractions and moduli", "Pa"),
    }
)

RECTANGLE: Final = Mapping(
    {
        "center": Field(POINT, "centre, [x, y]"),
        "width": Field(Quantity("length", POSITIVE), "size along x"),
        "height": Field(Quantity("length", POSITIVE), "size along y"),
    }
)

SHAPE: Final = OneOf(
    (Mapping({"rectangle": Field(RECTANGLE, "a rectangle along the axes")}, LATER["rectangle form"]),), LATER["shape"]
)

MATERIAL: Final = Mapping(
    {
        "young": Field(Quantity("stress", POSITIVE), "Young's modulus"),
        "poisson": Field(Number(Bounds(above=-1, at_most=0.5)), "Poisson's ratio"),
        "density": Field(Quantity("density", POSITIVE), "mass density", OPTIONAL),
    }
)

STRENGTH: Final = Mapping(
    {
        "tension": Field(Quantity("stress", POSITIVE), "tensile strength"),
        "cohesion": Field(Quantity("stress", NOT_NEGATIVE), "cohesion of the intact rock"),
        "friction_angle": Field(Quantity("angle", Bounds(at_least=0, below=90)), "angle of internal friction"),
    }
)

BODY: Final = Mapping(
    {
        "shape": Field(SHAPE, "outline of the body"),
        "material": Field(MATERIAL, "elastic constants"),
        "strength": Field(STRENGTH, "strength of the rock, where cracks may grow", OPTIONAL),
    },
    LATER["body"],
)

PATH: Final = OneOf(
    (
        Mapping(
            {
                "center": Field(POINT, "midpoint of a straight crack, [x, y]"),
                "length": Field(Quantity("length", POSITIVE), "length of a straight crack"),
                "angle": Field(Quantity("angle"), "direction from start to end, counter-clockwise from x"),
            }
        ),
        Mapping({"points": Field(ListOf(POINT), "vertices from start to end, [[x, y], ...]")}),
    )
)

CONTACT: Final = Mapping(
    {
        "friction": Field(Number(NOT_NEGATIVE), "Coulomb's friction coefficient"),
        "cohesion": Field(Quantity("stress", NOT_NEGATIVE), "cohesion of the closed faces"),
    }
)

CRACK: Final = Mapping(
    {
        "path": Field(PATH, "where the crack runs"),
        "tips": Field(Choice(("both", "start", "end", "none")), "ends at which the crack can grow", "both"),
        "contact": Field(WordOr(("none",), CONTACT), "law of the closed faces; none: they never touch each other"),
    }
)

REGION: Final = Mapping(
    {
        "body": Field(Text(), "name of a body"),
        "edge": Field(Text(), "name of an edge of its outline"),
        "from": Field(LENGTH, "where the part of the edge begins", OPTIONAL),
        "to": Field(LENGTH, "where the part of the edge ends", OPTIONAL),
    }
)

_COMPONENT: Final = Quantity("length", note="; formulas are not supported in this version")

DISPLACEMENT: Final = Mapping(
    {
        "x": Field(_COMPONENT, "displacement along x; left out: free", OPTIONAL),
        "y": Field(_COMPONENT, "displacement along y; left out: free", OPTIONAL),
    },
    at_least_one=True,
)

_DISPLACEMENT_FIELD: Final = Field(DISPLACEMENT, "prescribed displacement")

SUPPORT: Final = OneOf(
    (
        Mapping({"at": Field(POINT, "a point, [x, y]"), "displacement": _DISPLACEMENT_FIELD}),
        Mapping({"on": Field(REGION, "an edge or a part of one"), "displacement": _DISPLACEMENT_FIELD}),
    ),
    LATER["support"],
)

LOAD: Final = OneOf(
    (
        Mapping(
            {
                "on": Field(REGION, "an edge or a part of one"),
                "traction": Field(ListOf(Quantity("stress"), 2), "force per area, [x, y]"),
            }
        ),
    ),
    LATER["load"],
)

LOADING: Final = Mapping(
    {"history": Field(ListOf(Number()), "load factors applied in turn; exactly one in this version", [1.0])}
)

TIP_STRESS: Final = Mapping(
    {"radius": Field(Quantity("length", POSITIVE), "Shepard averaging radius, a material length")},
)

CRITERION: Final = Choice(("strength", "directional_strength"), LATER["criterion"])

GROWTH: Final = Mapping(
    {
        "steps": Field(Integer(Bounds(at_least=1, at_most=10000)), "growth steps"),
        "increment": Field(Quantity("length", POSITIVE), "length added to a tip in one step"),
        "advance": Field(Choice(("most_critical", "in_turn", "all")), "tips that advance in a step"),
        "criterion": Field(CRITERION, "when and where a tip grows"),
        "tip_stress": Field(TIP_STRESS, "how the stress at a tip is taken"),
        "unload_between_steps": Field(Switch(), "start every step from the unloaded state", True),
    }
)

CONTACT_NUMERICS: Final = Mapping(
    {
        "stiffness": Field(WordOr(("rigid",), Number(POSITIVE)), "rigid, or kappa in k = kappa E / h", "rigid"),
        "discretization": Field(Choice(("mortar", "gauss")), "where contact is enforced", "mortar"),
        "solver": Field(Choice(("newton", "lemke")), "how the contact problem is solved", "newton"),
        "spacing": Field(Number(Bounds(at_least=0.5, at_most=4)), "distance of contact nodes, in spacings h", 1.0),
    }
)

NUMERICS: Final = Mapping(
    {
        "spacing": Field(Quantity("length", POSITIVE), "lattice spacing h"),
        "support": Field(Number(Bounds(at_least=1.25, at_most=4), 0.25), "half width of a patch, in spacings", 2.0),
        "quadrature": Field(Integer(Bounds(at_least=2, at_most=10)), "Gauss points per direction on an uncut cell", 4),
        "contact": Field(CONTACT_NUMERICS, "how contact is discretized and solved", BY_PARTS),
    },
    LATER["numerics"],
)

OUTPUT: Final = Mapping(
    {
        "frames": Field(Choice(("every_step", "first_and_last", "none")), "steps written as frames", "every_step"),
        "fields": Field(ListOf(Choice(("displacement", "stress"))), "fields in a frame", ["displacement", "stress"]),
        "figures": Field(Switch(), "draw pictures and plots", True),
    }
)

CASE: Final = Mapping(
    {
        "title": Field(Text(), "what the scene is"),
        "source": Field(Text(may_be_empty=True), "where the scene comes from", ""),
        "units": Field(UNITS_SPEC, "what bare numbers mean", BY_PARTS),
        "plane": Field(Choice(("strain", "stress")), "plane strain or plane stress"),
        "bodies": Field(Named("body", BODY), "the pieces of rock"),
        "cracks": Field(Named("crack", CRACK), "cracks at the start", {}),
        "supports": Field(ListOf(SUPPORT), "prescribed displacements", []),
        "loads": Field(ListOf(LOAD), "loads", []),
        "loading": Field(LOADING, "how the loads are applied in time", BY_PARTS),
        "growth": Field(GROWTH, "how cracks grow; left out: one static solve", OPTIONAL),
        "numerics": Field(NUMERICS, "settings of the discretization"),
        "output": Field(OUTPUT, "what is written", BY_PARTS),
    },
    LATER["case"],
)
