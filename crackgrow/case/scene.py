"""The case format as one tree of specs: every key, what it takes, its default and a line about it."""

from __future__ import annotations

from typing import Final

from crackgrow.case.accuracy import AUTO, MOST_LEVELS, PRESETS, STANDARD, Preset
from crackgrow.case.along import LengthOrAngle
from crackgrow.case.base import OfFile
from crackgrow.case.formula import OrFormula
from crackgrow.case.outline_file import (
    MOST_CORNERS,
    OutlineFile,
    with_file_edges,
    with_file_holes,
    with_file_points,
    without_file,
)
from crackgrow.case.references import Definitions, Reference
from crackgrow.case.report import Path
from crackgrow.case.scalars import (
    NOT_NEGATIVE,
    POSITIVE,
    Bounds,
    Choice,
    Context,
    Integer,
    Number,
    Quantity,
    Share,
    Switch,
    Text,
    WordOr,
)
from crackgrow.case.schema import (
    BY_PARTS,
    OPTIONAL,
    Chosen,
    Components,
    Converted,
    Field,
    ListOf,
    Mapping,
    Named,
    OneOf,
    OneOrList,
)
from crackgrow.case.units import UNITS

LENGTH: Final = Quantity("length")
POINT: Final = ListOf(LENGTH, 2)
POINTS: Final = ListOf(POINT, at_most=MOST_CORNERS)

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

DISK: Final = Mapping(
    {"center": Field(POINT, "centre, [x, y]"), "radius": Field(Quantity("length", POSITIVE), "radius")},
)

_SIMPLE_SHAPES: Final = (
    {"rectangle": Field(RECTANGLE, "a rectangle along the axes")},
    {"polygon": Field(POINTS, "corners in drawing order, [[x, y], ...]")},
    {"disk": Field(DISK, "a disk")},
    {
        "file": Field(OutlineFile(), "a file with a polygon, or a mesh"),
        "region": Field(Text(), "name or number of a group of the mesh's cells; left out: all of them", OPTIONAL),
    },
)

HOLE: Final = Converted(OneOf(tuple(Mapping(form) for form in _SIMPLE_SHAPES)), without_file)

_HOLES: Final = Field(ListOf(HOLE, at_most=300), "holes: shapes inside of the outline", OPTIONAL)

SHAPE: Final = Converted(OneOf(tuple(Mapping({**form, "holes": _HOLES}) for form in _SIMPLE_SHAPES)), with_file_holes)

_EDGE_NUMBER: Final = Integer(NOT_NEGATIVE)

EDGES: Final = Named("edge", OneOrList(_EDGE_NUMBER))

MATERIAL: Final = Mapping(
    {
        "young": Field(Quantity("stress", POSITIVE), "Young's modulus"),
        "poisson": Field(Number(Bounds(above=-1, at_most=0.5)), "Poisson's ratio"),
        "density": Field(Quantity("density", POSITIVE), "mass density", OPTIONAL),
    }
)

MATERIALS: Final = Definitions(Named("material", MATERIAL, at_most=200))

STRENGTH: Final = Mapping(
    {
        "tension": Field(Quantity("stress", POSITIVE), "tensile strength"),
        "cohesion": Field(Quantity("stress", NOT_NEGATIVE), "cohesion of the intact rock"),
        "friction_angle": Field(Quantity("angle", Bounds(at_least=0, below=90)), "angle of internal friction"),
        "toughness": Field(
            Quantity("toughness", POSITIVE), "K_Ic, from which the averaging radius of the criterion follows", OPTIONAL
        ),
    }
)

_BODY_KEYS: Final = Mapping(
    {
        "shape": Field(SHAPE, "outline of the body"),
        "material": Field(Reference("material", "materials", MATERIAL), "elastic constants"),
        "strength": Field(STRENGTH, "strength of the rock, where cracks may grow", OPTIONAL),
        "edges": Field(EDGES, "names for edges of a polygon: a number, or a list of consecutive ones", OPTIONAL),
    }
)

BODY: Final = Converted(_BODY_KEYS, with_file_edges)

_PATHS: Final = OneOf(
    (
        Mapping(
            {
                "center": Field(POINT, "midpoint of a straight crack, [x, y]"),
                "length": Field(Quantity("length", POSITIVE), "length of a straight crack"),
                "angle": Field(Quantity("angle"), "direction from start to end, counter-clockwise from x"),
            }
        ),
        Mapping({"points": Field(POINTS, "vertices from start to end, [[x, y], ...]")}),
        Mapping(
            {
                "file": Field(OutlineFile(of_cracks=True), "a file with lines, each a crack, or a mesh"),
                "curve": Field(Text(), "name or number of a group of the mesh's lines: the crack", OPTIONAL),
            }
        ),
    )
)

PATH: Final = Converted(_PATHS, with_file_points)

_AFTER_SLIP: Final = Choice(("lost", "kept"), ("none is left", "stays where the point is closed"))

_JOINT: Final = Mapping(
    {
        "normal": Field(Quantity("stiffness", POSITIVE), "pressure per closure"),
        "shear": Field(Quantity("stiffness", POSITIVE), "shear stress per elastic slip"),
    }
)

_CONTACT_KEYS: Final = Mapping(
    {
        "friction": Field(Number(NOT_NEGATIVE), "Coulomb's friction coefficient"),
        "cohesion": Field(Quantity("stress", NOT_NEGATIVE), "cohesion of the closed faces"),
        "residual_friction": Field(Number(NOT_NEGATIVE), "friction of points that have slipped or opened", OPTIONAL),
        "cohesion_after_slip": Field(_AFTER_SLIP, "cohesion of points that slipped or opened", "lost"),
        "dilation_angle": Field(Quantity("angle", Bounds(at_least=0, below=90)), "faces part by tan of it x slip", 0.0),
        "weakening_length": Field(
            Quantity("length", POSITIVE),
            "slip over which friction and cohesion fall linearly to their residual values; left out: at once",
            OPTIONAL,
        ),
        "stiffness": Field(_JOINT, "stiffness of the joint, in place of numerics.contact.stiffness", OPTIONAL),
    }
)


def _with_residual(value: object, path: Path, context: Context) -> object:
    """Return a law of contact with its residual friction, which is the friction if it is left out."""
    if not isinstance(value, dict):
        return value
    every = {"residual_friction": value.get("friction"), **value}
    return {key: every[key] for key in _CONTACT_KEYS.fields if key in every}


CONTACT: Final = Converted(_CONTACT_KEYS, _with_residual)

LAWS: Final = Definitions(Named("law", CONTACT), words=("none", "bonded"))


def _law(*words: str) -> Reference:
    """What is taken for a law of contact: some words, the law itself, or its name."""
    return Reference("law", "laws", WordOr(words, CONTACT) if words else CONTACT)


TIPS: Final = Choice(
    ("both", "start", "end", "none"),
    ("both ends", "the first point alone", "the last point alone", "it stays as it is"),
)

CRACK: Final = Mapping(
    {
        "path": Field(PATH, "where the crack runs"),
        "tips": Field(TIPS, "ends at which the crack can grow", "both"),
        "contact": Field(_law("none"), "law of the closed faces; none: they never touch each other"),
    }
)

REGION: Final = Mapping(
    {
        "body": Field(Text(), "name of a body; may be left out where there is one", OPTIONAL),
        "edge": Field(Text(), "name of one of its edges"),
        "from": Field(LengthOrAngle(), "where the part of the edge begins", OPTIONAL),
        "to": Field(LengthOrAngle(), "where the part of the edge ends", OPTIONAL),
    }
)

INTERFACE: Final = Mapping(
    {
        "between": Field(ListOf(Text(), 2), "names of two bodies that share a boundary"),
        "contact": Field(_law("bonded"), "law of the common faces; bonded: they never part or slip"),
    }
)

DISPLACEMENT: Final = Components(
    Mapping(
        {
            "x": Field(OrFormula(), "displacement along x; left out: free", OPTIONAL),
            "y": Field(OrFormula(), "displacement along y; left out: free", OPTIONAL),
        },
        at_least_one=True,
    ),
    as_list=False,
)

TRACTION: Final = Components(
    Mapping(
        {
            "x": Field(OrFormula("stress"), "force per area along x"),
            "y": Field(OrFormula("stress"), "force per area along y"),
        }
    ),
    as_list=True,
)

_ON: Final = Field(REGION, "an edge or a part of one", also=("true",))  # what writers of YAML 1.1 make of `on`
_DISPLACEMENT_FIELD: Final = Field(DISPLACEMENT, "prescribed displacement")
_BODY_NAME: Final = Field(Text(), "name of a body; may be left out where there is one", OPTIONAL)
_OF_BODY: Final = Field(Text(), "the body, if the point lies on more than one", OPTIONAL)

SUPPORT: Final = OneOf(
    (
        Mapping(
            {
                "at": Field(POINT, "a point, [x, y]"),
                "displacement": _DISPLACEMENT_FIELD,
                "body": _OF_BODY,
            }
        ),
        Mapping({"on": _ON, "displacement": _DISPLACEMENT_FIELD}),
        Mapping({"on": _ON, "contact": Field(_law(), "law of the contact with a rigid foundation")}),
    )
)

MINIMAL: Final = "minimal"

SUPPORTS: Final = WordOr(
    (MINIMAL,),
    ListOf(SUPPORT),
    ("three constraints at points of the outline, which take no force: for loads that balance",),
)

_HELD: Final = Field(Switch(), "acts in full at every load factor", False)
_LOAD_NAME: Final = Field(Text(), "name, by which stages give it factors of its own; loads may share one", OPTIONAL)

LOAD: Final = OneOf(
    (
        Mapping(
            {
                "on": _ON,
                "traction": Field(TRACTION, "force per area, [x, y]"),
                "held": _HELD,
                "name": _LOAD_NAME,
            }
        ),
        Mapping(
            {
                "body": _BODY_NAME,
                "gravity": Field(ListOf(Quantity("acceleration"), 2), "acceleration, [x, y]"),
                "held": _HELD,
                "name": _LOAD_NAME,
            }
        ),
        Mapping(
            {
                "crack": Field(Text(), "name of a crack"),
                "pressure": Field(OrFormula("stress"), "pressure of a fluid on both faces"),
                "held": _HELD,
                "name": _LOAD_NAME,
            }
        ),
        Mapping(
            {
                "body": _BODY_NAME,
                "stress": Field(ListOf(OrFormula("stress"), 3), "in-situ stress, [xx, yy, xy]"),
                "held": _HELD,
                "name": _LOAD_NAME,
            }
        ),
        Mapping(
            {
                "at": Field(POINT, "a point, [x, y]"),
                "force": Field(ListOf(Quantity("force"), 2), "force per thickness, [x, y]"),
                "body": _OF_BODY,
                "held": _HELD,
                "name": _LOAD_NAME,
            }
        ),
        Mapping(
            {
                "interface": Field(ListOf(Text(), 2), "names of two bodies with an interface that is not bonded"),
                "pressure": Field(OrFormula("stress"), "pressure of a fluid on both faces"),
                "held": _HELD,
                "name": _LOAD_NAME,
            }
        ),
    )
)

STAGE: Final = Mapping(
    {
        "name": Field(Text(), "name of the stage", OPTIONAL),
        "factor": Field(
            Number(), "of given displacements and of loads without a factor of their own; left out: as before", OPTIONAL
        ),
        "loads": Field(Named("load", Number()), "factors of loads by their name, from this stage on", OPTIONAL),
        "excavate": Field(OneOrList(Text()), "bodies that are taken out", OPTIONAL),
        "release": Field(
            Number(Bounds(at_least=0, at_most=1)),
            "share of what rock that is gone did on the rest that is taken away by the end; left out: 1 of a stage "
            "that excavates, else as before",
            OPTIONAL,
        ),
    }
)

_HISTORY: Final = Mapping(
    {
        "history": Field(ListOf(Number()), "load factors applied in turn; left out: [1], or stages", OPTIONAL),
        "stages": Field(ListOf(STAGE), "stages of a construction, in turn", OPTIONAL),
    }
)


def _history_or_stages(value: object, path: Path, context: Context) -> object:
    """Return a history, [1] where there is neither that nor stages; report both."""
    if isinstance(value, dict) and len(value) > 1:
        context.report.fault(path, "has a history and stages; give one of them: a stage has a `factor`, too")
    return value or {"history": [1.0]}


LOADING: Final = WordOr(("critical", "strength_reduction"), Converted(_HISTORY, _history_or_stages))

TIP_STRESS: Final = Mapping(
    {"radius": Field(Quantity("length", POSITIVE), "Shepard averaging radius, a material length")},
)

CRITERION: Final = Choice(
    ("strength", "directional_strength", "max_hoop_stress"),
    (
        "averaged stress of the tip: across its major principal stress, else on a Mohr-Coulomb plane",
        "hoop tension and shear on every ray from the tip; follows the path of K_II = 0 better",
        "direction of the largest hoop stress, from K_I and K_II",
    ),
)

ADVANCE: Final = Choice(
    ("most_critical", "in_turn", "all"),
    ("one tip a step", "one tip a step, of those that have grown least", "every tip that meets the criterion"),
)

DIRECTION: Final = Choice(
    ("explicit", "implicit"), ("that at the old tip", "corrected until K_II vanishes at the new tip; max_hoop_stress")
)

INITIATION: Final = Mapping(
    {
        "at": Field(
            Choice(
                ("tips", "cracks", "outlines", "anywhere"),
                (
                    "nowhere new: cracks go on at their tips",
                    "also between cracks: at kinks, beside wings, behind a crack that another one ends on",
                    "also at outlines and holes",
                    "also within the rock",
                ),
            ),
            "where cracks may start, by the criterion of growth",
            "tips",
        ),
        "spacing": Field(
            WordOr((AUTO,), Quantity("length", POSITIVE)),
            "distance of the places on outlines and in the rock; auto: the larger of increment and averaging radius",
            AUTO,
        ),
    }
)

LAW: Final = Choice(
    ("critical", "subcritical"),
    ("a tip grows where the criterion is met", "every tip grows with a velocity that follows from K over K_c"),
)

SUBCRITICAL: Final = Mapping(
    {
        "velocity": Field(Quantity("velocity", POSITIVE), "v_max in v = v_max (K/K_c)^n: that at the toughness"),
        "exponent": Field(Number(Bounds(at_least=0, at_most=200)), "n"),
        "threshold": Field(Number(Bounds(at_least=0, below=1)), "K over K_c up to which a tip stands still", 0.0),
    }
)

GROWTH: Final = Mapping(
    {
        "steps": Field(Integer(Bounds(at_least=0, at_most=10000)), "growth steps; 0: the criterion is only judged"),
        "increment": Field(Quantity("length", POSITIVE), "length added to a tip in one step"),
        "advance": Field(ADVANCE, "tips that advance in a step"),
        "criterion": Field(CRITERION, "when and where a tip grows"),
        "direction": Field(
            DIRECTION, "left out: implicit for max_hoop_stress in rock with a toughness, else explicit", OPTIONAL
        ),
        "tip_stress": Field(TIP_STRESS, "how the stress at a tip is taken where rock has no toughness", OPTIONAL),
        "unload_between_steps": Field(
            Switch(), "start every step from the unloaded state; false: friction remembers", True
        ),
        "initiation": Field(INITIATION, "where new cracks start", BY_PARTS),
        "link_distance": Field(
            WordOr((AUTO,), Quantity("length", POSITIVE)),
            "a segment that heads for another crack and comes this close links up with it; auto: a tenth of increment",
            AUTO,
        ),
        "law": Field(LAW, "what lets a tip grow", "critical"),
        "subcritical": Field(SUBCRITICAL, "how fast tips grow, with law: subcritical", OPTIONAL),
    }
)

_ACCURACY: Final = WordOr(
    tuple(PRESETS),
    Share(Bounds(at_least=0.001, at_most=0.2)),
    tuple(f"spacing auto: a crack of {p.per_crack:g} spacings or more" for p in PRESETS.values()),
)
_GOAL: Final = Choice(
    ("K", "slip", "reaction", "load_factor"),
    ("stress intensity", "the jump of all faces", "forces of supports and surfaces", "the critical load factor"),
)
_DISCRETIZATION: Final = Choice(
    ("mortar", "gauss"), ("on average round nodes along the faces", "at Gauss points; wants a finite stiffness")
)
_SOLVER: Final = Choice(("newton", "lemke"), ("semismooth Newton", "complementary pivots; slow with many points"))
_KAPPA: Final = Number(
    POSITIVE, note=", kappa of k = kappa E / h without a unit; that of a joint in Pa/m is `stiffness` of its contact"
)
_CONTACT_STIFFNESS: Final = WordOr(("rigid",), _KAPPA)
_SUPPORT_WIDTH: Final = Number(Bounds(at_least=1.25, at_most=4), 0.25)
_GAUSS_POINTS: Final = Integer(Bounds(at_least=2, at_most=10))
_LEVELS: Final = WordOr((AUTO,), Integer(Bounds(at_least=0, at_most=MOST_LEVELS)))
_TIP_FUNCTIONS: Final = Choice(
    (AUTO, "patch", "gathered"),
    ("gathered where refine.tips is not 0", "a set on every patch that a tip lies in", "one set a tip, if it has room"),
)
_REFINE: Final = Mapping(
    {
        "tips": Field(_LEVELS, "halvings of the cells at crack tips; auto: what accuracy asks for", OPTIONAL),
        "kinks": Field(_LEVELS, "the same at kinks, meetings and ends of cracks", OPTIONAL),
        "corners": Field(
            _LEVELS,
            "at re-entrant corners, point supports, ends of loaded and supported parts; auto: also at holes, narrow "
            "rock and along these parts",
            OPTIONAL,
        ),
        "rings": Field(Number(Bounds(at_least=2, at_most=8)), "cells of each size on every side of these", 2.0),
    }
)


def _numerics(preset: Preset, spacing: object) -> Mapping:
    """The settings of the discretization with the defaults of a preset, `spacing` being that of the spacing."""
    contact = Mapping(
        {
            "stiffness": Field(_CONTACT_STIFFNESS, "rigid, or kappa in k = kappa E / h", "rigid"),
            "discretization": Field(_DISCRETIZATION, "where contact is enforced", "mortar"),
            "solver": Field(_SOLVER, "how the contact problem is solved", "newton"),
            "spacing": Field(
                Number(Bounds(at_least=0.5, at_most=4)), "least distance of contact nodes, in h", preset.contact_spacing
            ),
        }
    )
    return Mapping(
        {
            "accuracy": Field(_ACCURACY, "preset of what is left out here, or what the goal may be off by", STANDARD),
            "goal": Field(_GOAL, "what an accuracy in percent is of; presets take no notice of it", "K"),
            "spacing": Field(WordOr((AUTO,), Quantity("length", POSITIVE)), "lattice spacing h", spacing),
            "auto_rule": Field(Text(), "what gave an automatic spacing", OPTIONAL, offered=False),
            "support": Field(_SUPPORT_WIDTH, "half width of a patch, in spacings", preset.support),
            "quadrature": Field(_GAUSS_POINTS, "Gauss points per direction on an uncut cell", preset.quadrature),
            "refine": Field(_REFINE, "how often cells are halved, and where", BY_PARTS),
            "tip_functions": Field(_TIP_FUNCTIONS, "functions that follow the singular stress at tips", AUTO),
            "contact": Field(contact, "how contact is discretized and solved", BY_PARTS),
        }
    )


NUMERICS: Final = Chosen(
    "accuracy",
    {name: _numerics(preset, AUTO) for name, preset in PRESETS.items()},
    _numerics(PRESETS[STANDARD], AUTO),
)

HISTORY_POINT: Final = OneOf(
    (
        Mapping({"at": Field(POINT, "a point of the rock, [x, y]: its displacement and stress"), "body": _OF_BODY}),
        Mapping(
            {
                "crack": Field(Text(), "name of a crack: its opening and slip"),
                "at": Field(POINT, "where on it, [x, y]; at its mouth the crack-mouth opening"),
            }
        ),
        Mapping(
            {
                "interface": Field(ListOf(Text(), 2), "names of two bodies: opening and slip of what is between them"),
                "at": Field(POINT, "where on it, [x, y]"),
            }
        ),
        Mapping({"between": Field(ListOf(POINT, 2), "two points of the rock: how much closer they come")}),
    )
)

OUTPUT: Final = Mapping(
    {
        "frames": Field(Choice(("every_step", "first_and_last", "none")), "steps written as frames", "every_step"),
        "fields": Field(ListOf(Choice(("displacement", "stress"))), "fields in a frame", ["displacement", "stress"]),
        "figures": Field(Switch(), "draw pictures and plots", True),
        "report": Field(Switch(), "write report.html at the end", True),
        "points": Field(
            Named("point", HISTORY_POINT), "places whose course history.csv tells, with reactions", OPTIONAL
        ),
    }
)

PLANE: Final = Choice(("strain", "stress"), ("a long body, no strain across", "a thin plate, no stress across"))

DEFINITIONS: Final = ("materials", "laws")  # of the case; resolved cases hold none

CASE: Final = Mapping(
    {
        "title": Field(Text(), "what the scene is"),
        "source": Field(Text(may_be_empty=True), "where the scene comes from", ""),
        "units": Field(UNITS_SPEC, "what bare numbers mean", BY_PARTS),
        "plane": Field(PLANE, "plane strain or plane stress"),
        "materials": Field(MATERIALS, "elastic constants that bodies refer to by name", OPTIONAL),
        "laws": Field(LAWS, "laws of contact that cracks, interfaces and foundations refer to by name", OPTIONAL),
        "bodies": Field(Named("body", BODY, at_most=200), "the pieces of rock"),
        "cracks": Field(Named("crack", CRACK), "cracks at the start", {}),
        "interfaces": Field(ListOf(INTERFACE), "contact between bodies that share a boundary", []),
        "supports": Field(SUPPORTS, "prescribed displacements and rigid foundations", []),
        "loads": Field(ListOf(LOAD), "loads", []),
        "loading": Field(LOADING, "how the loads are applied in time", {"history": [1.0]}),
        "growth": Field(GROWTH, "how cracks grow; left out: one static solve", OPTIONAL),
        "numerics": Field(NUMERICS, "settings of the discretization", BY_PARTS),
        "output": Field(OUTPUT, "what is written", BY_PARTS),
        "base": Field(OfFile("a case file"), "the case that this one is, but for `set`, title and source", OPTIONAL),
        "set": Field(OfFile("a mapping"), "keys of the base that differ, such as growth.steps: 3", OPTIONAL),
    }
)
