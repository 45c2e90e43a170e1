"""What a run's folder holds: its files, and every column, field and key in them with its unit and its meaning.

The tables take their headers from here, and so do `crackgrow explain` and outputs/README.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table, a field of a frame, or a key of a JSON file."""

    name: str
    unit: str  # empty for counts, words and ratios
    doc: str  # a line for the user
    kind: type[float | int | str | bool] = float  # of its cells in the tables of runs and sweeps


@dataclass(frozen=True, slots=True)
class File:
    """A file, or files of one kind."""

    name: str  # relative to the folder; NAME is the case's, FIELD that of a field, NNNN the number of a step
    doc: str
    columns: tuple[Column, ...] = ()

    @property
    def header(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(column.name for column in self.columns)


PHASES: Final = ("cover", "assembly", "factorize", "contact", "criterion", "output")

_STEP: Final = Column("step", "", "number of the step, from 0: the given cracks", int)
_LOAD_FACTOR: Final = Column(
    "load_factor", "", "what all loads but the held ones are multiplied by; of stages their number, 1 for the first"
)
_SURFACE: Final = Column(
    "crack", "", "name of the crack, `first/second` of an interface, `body.edge` of a foundation", str
)

TIPS: Final = File(
    "tips.csv",
    "stress intensity factors and the criterion: a row for each step and tip",
    (
        _STEP,
        Column("crack", "", "name of the crack", str),
        Column("tip", "", "`start` or `end` of the crack", str),
        Column("x", "m", "the tip, before its advance"),
        Column("y", "m", "the tip, before its advance"),
        Column("K_I", "Pa sqrt(m)", "stress intensity factor of opening, by the interaction integral; nan where a disc "
               "has no room"),
        Column("K_II", "Pa sqrt(m)", "stress intensity factor of shear, the same way; positive where the face on the "
               "left of the tip's outward direction moves outward, and a negative one turns the crack "
               "counter-clockwise"),
        Column("sigma_1", "Pa", "major (most tensile) principal stress, averaged round the tip; nan without growth"),
        Column("sigma_3", "Pa", "minor principal stress of the same average"),
        Column("criterion", "", "branch of the criterion that is met: `tension`, `shear` or `none`", str),
        Column("kink_deg", "deg", "angle from the tip's direction to the growth direction, counter-clockwise, as the "
               "criterion gives it; in the path, `implicit` corrects it, and a segment that meets something is turned "
               "to it"),
        Column("advanced", "", "`true` where the tip grows in this step", bool),
        _LOAD_FACTOR,
        Column("K_I_error", "Pa sqrt(m)", "bound of what K_I is off by"),
        Column("K_II_error", "Pa sqrt(m)", "bound of what K_II is off by"),
        Column("K_radius", "m", "radius of the disc of the interaction integral"),
        Column("K_note", "", "why the disc is smaller than usual, or missing; empty where it is not", str),
        Column("K_I_faces", "Pa sqrt(m)", "K_I from the displacement of the faces: a coarse check"),
        Column("K_II_faces", "Pa sqrt(m)", "K_II from the displacement of the faces: a coarse check"),
        Column("K_I_spread", "Pa sqrt(m)", "difference of K_I between three discs: a part of its error, often a small "
               "one"),
        Column("K_II_spread", "Pa sqrt(m)", "difference of K_II between three discs"),
        Column("cell_size", "m", "side of the cells round the tip"),
        Column("kink_error_deg", "deg", "bound of what the direction of growth is off by, which follows from "
               "that of K, or from the criterion on other cells; with `implicit` of the increment that led to the tip"),
        Column("velocity", "m/s", "of the tip, by v = v_max (K/K_c)^n; nan but with `growth.law: subcritical`"),
        Column("K_error_expected", "Pa sqrt(m)", "error of K_I and K_II together that is expected, mostly right within "
               "a factor of two; nan where it is not measured: the spacing is given, strength is reduced, "
               "unknowns are very many, or, without a target, what was added to the crack is over twice what it was "
               "when K was measured, or what lies nearest to the tip is a third nearer than it was then"),
        Column("criticality", "", "stress of the criterion over the strength, of the branch by which the tip grows or "
               "would: 1 and more where it is met; of two tips the one with more grows first; nan without growth"),
        Column("sticks", "", "`true` where the crack sticks everywhere, and has not moved before: its K is zero, and "
               "K_I and K_II are what cells leave of that", bool),
        Column("K_growth", "Pa sqrt(m)", "K at which the tip grows: K over the criticality, of the K_I with the same "
               "largest hoop stress in tension, of |K_II| in shear. In tension the toughness, if one is given; else as "
               "if the stress round the tip rose with K in proportion. nan where K has no part in it"),
    ),
)  # fmt: skip

PATHS: Final = File(
    "paths.csv",
    "the cracks at the end: a row for each vertex. An advance after which the rock came apart or could not be solved "
    "is here, but not in `steps.csv`",
    (
        Column("crack", "", "name of the crack", str),
        Column("vertex", "", "number of the vertex, from 0 at the crack's start", int),
        Column("x", "m", "the vertex"),
        Column("y", "m", "the vertex"),
        Column("step", "", "step whose advance made the vertex; 0 in the given crack", int),
    ),
)

CONTACT: Final = File(
    "contact.csv",
    "the faces: a row for each step and contact point",
    (
        _STEP,
        _SURFACE,
        Column("s", "m", "arc length from the start of the crack or surface"),
        Column("x", "m", "the contact point"),
        Column("y", "m", "the contact point"),
        Column("normal_traction", "Pa", "traction across the faces; negative in compression"),
        Column("tangential_traction", "Pa", "traction along the faces"),
        Column("opening", "m", "jump of the displacement across the faces, at the point"),
        Column("slip", "m", "jump of the displacement along the faces, at the point"),
        Column("state", "", "`open`, `stick` or `slip`", str),
        Column("mean_opening", "m", "average of the opening round the point; the contact law holds for it"),
        Column("mean_slip", "m", "average of the slip round the point; the contact law holds for it"),
    ),
)

EVENTS: Final = File(
    "events.csv",
    "tips that have met something and end there: a row for each tip, two where two tips meet; and cracks that have "
    "started. `summary.json` has them, too",
    (
        Column("step", "", "step whose advance made the event", int),
        Column(
            "kind",
            "",
            "`coalescence` (a crack), `hole`, `break_through` (the outline), `interface` or `initiation`",
            str,
        ),
        Column("crack", "", "name of the crack", str),
        Column("tip", "", "`start` or `end` of the crack", str),
        Column("x", "m", "the place"),
        Column("y", "m", "the place"),
        Column(
            "met",
            "",
            "what was met, such as `crack 'b'` or `hole0 of body 'rock'`; of an initiation where, and the mode",
            str,
        ),
    ),
)

HISTORY: Final = File(
    "history.csv",
    "what the places of `output.points` see, and all reactions: a row for each step and increment of its loads, the "
    "states at which contact points change included (100 of a load at most); where the case names points",
    (
        _STEP,
        Column("increment", "", "number of the increment in its step, from 0", int),
        _LOAD_FACTOR,
        Column("NAME.u_x", "m", "displacement of a point"),
        Column("NAME.u_y", "m", "displacement of a point"),
        Column("NAME.stress_xx", "Pa", "stress at a point, tension positive"),
        Column("NAME.stress_yy", "Pa", "stress at a point, tension positive"),
        Column("NAME.stress_xy", "Pa", "stress at a point"),
        Column("NAME.opening", "m", "jump of displacement across a crack or an interface, at a place on it"),
        Column("NAME.slip", "m", "jump of displacement along it"),
        Column("NAME.convergence", "m", "by how much two points have come closer"),
        Column("WHERE.force_x", "N/m", "force of a support, a foundation or an interface, as in `reactions.csv`"),
        Column("WHERE.force_y", "N/m", "force of a support, a foundation or an interface, as in `reactions.csv`"),
    ),
)

REACTIONS: Final = File(
    "reactions.csv",
    "the force that each support, foundation and interface carries: a row for each step and one of them",
    (
        _STEP,
        Column("where", "", "`supports.0`, `body.edge` of a foundation, `first/second` of an interface", str),
        Column("force_x", "N/m", "force per metre of thickness on the rock; of an interface on its first body"),
        Column("force_y", "N/m", "the same along y"),
        _LOAD_FACTOR,
    ),
)

_WORK: Final = {
    "cover": "cutting cells, making patches",
    "assembly": "stiffness and loads",
    "factorize": "factorizing",
    "contact": "the contact problem",
    "criterion": "stress at tips, K, the criterion",
    "output": "meshes, error estimate, files of the step",
}

STEPS: Final = File(
    "steps.csv",
    "a row for each step: the load-displacement and load-growth curve, energies, checks, times",
    (
        _STEP,
        Column("n_dofs", "", "unknowns", int),
        Column("n_contact", "", "contact unknowns that the solver saw", int),
        Column("contact_iterations", "", "iterations of the contact solver", int),
        Column("factorizations", "", "factorizations of the stiffness", int),
        Column("residual", "", "what equilibrium misses, relative"),
        Column("penetration", "m", "largest overlap at a contact point, beyond what an elastic contact explains"),
        *(Column(f"seconds_{phase}", "s", f"wall time: {_WORK[phase]}") for phase in PHASES),
        _LOAD_FACTOR,
        Column("contact_status", "", "`none` or `solved`", str),
        Column("complementarity", "", "worst violation of the contact law, relative"),
        Column("overlap", "m", "largest overlap of closed faces anywhere, beyond what an elastic contact explains"),
        Column("work", "J/m", "work of loads and prescribed displacements"),
        Column("strain_energy", "J/m", "energy of the rock and of elastic contact"),
        Column("dissipation", "J/m", "dissipated by friction and dilation, as the law says"),
        Column("released_energy", "J/m", "released by bonds that break, and by growth under load"),
        Column("energy_error", "", "what the balance of the energies misses, over its largest term"),
        Column("load_displacement", "m", "displacement along the loads"),
        Column("crack_length", "m", "length of all cracks"),
        Column("overlap_share", "", "overlap, or a gap of pressed faces, over what is small beside jump and "
               "displacement; the run warns above 1"),
        Column("load_factor_error", "%", "bound of what a critical load factor is off by, which follows from that of "
               "K, or from the criterion on other cells; nan for other loads"),
        Column("goal_error", "%", "bound of what `numerics.goal` is off by, over its largest value; nan where that is "
               "K or the accuracy is a preset"),
        Column("time", "s", "at which the cracks have come here; nan but with `growth.law: subcritical`"),
    ),
)  # fmt: skip

_CHECKS: Final = "`residual`, `penetration`, `complementarity`, `overlap`, `energy_error`"

SUMMARY: Final = File(
    "summary.json",
    "how the run ended, what it cost, how good it is at its worst; null where there is no value",
    (
        Column("case", "", "name of the case"),
        Column("title", "", "title of the case"),
        Column("status", "", "`completed`, `arrested` (no tip meets the criterion), `broke_through` (a piece comes "
               "loose, or no tip is left), `failed`; `running` and `interrupted` until the run has ended"),
        Column("stop_reason", "", "why the run ended"),
        Column("steps_done", "", "number of the last step"),
        Column("n_solves", "", "steps that were solved"),
        Column("version", "", "version of the program"),
        Column("git_commit", "", "commit of the program; null where it does not run from a checkout"),
        Column("git_modified", "", "whether the checkout was changed since"),
        Column("n_dofs", "", "unknowns of the `first` and of the `last` step"),
        Column("wall_seconds", "s", "wall time: `total`, and `by_phase`"),
        Column("peak_memory_mb", "MB", "most memory of the process"),
        Column("resumed_with_steps", "", "steps with which the run was gone on"),
        Column("safety", "", "with `loading: strength_reduction`: the `factor` of safety, the next one tried, at which "
               "it `fails_at`, and the `mechanism`; null where it does not fail"),
        Column("time", "s", "with `growth.law: subcritical`: at which the cracks have come to the last step"),
        Column("worst_checks", "", f"worst value and its step, of {_CHECKS}"),
        Column("error_estimate", "%", "`energy_norm_percent` of the first and the last step, `K_percent_at_most`, "
               "`K_percent_expected` (where a target makes the run measure it), `K_spread_percent`, "
               "`kink_degrees_at_most` (of tips that grow), `load_factor_percent_at_most`, `goal_percent_at_most`"),
        Column("events", "", "as in `events.csv`"),
        Column("warnings", "", "a sentence for each cause with its places and steps, the important ones first"),
        Column("cautions", "", "the same as records of cause, place, size and steps"),
    ),
)  # fmt: skip

FRAMES: Final = File(
    "frames/step_NNNN.vtu",
    "the specimen for ParaView. Points are double along cracks and between bodies, so that each side has its own "
    "values; cells are small near tips; a point at a tip, where stress is infinite, has the mean of its neighbours",
    (
        Column("displacement", "m", "of points"),
        Column("stress", "Pa", "tensor, of points and in the middle of cells; tension is positive"),
        Column("sigma_1", "Pa", "major principal stress in the plane (the most tensile), of points and of cells"),
        Column("sigma_3", "Pa", "minor principal stress in the plane, of points and of cells"),
        Column("body", "", "number of the body, of cells"),
        Column("energy_error", "", "root of the estimated error's energy density over the mean energy density of the "
               "rock, of cells"),
    ),
)  # fmt: skip

CRACKS: Final = File(
    "cracks/step_NNNN.vtp",
    "the faces of cracks, interfaces and foundations for ParaView",
    (
        Column("s", "m", "arc length from the start"),
        Column("opening", "m", "jump of the displacement across the faces"),
        Column("slip", "m", "jump of the displacement along the faces"),
        Column("normal_traction", "Pa", "traction across the faces; negative in compression"),
        Column("tangential_traction", "Pa", "traction along the faces"),
        Column("state", "", "0 open, 1 stick, 2 slip"),
        Column("crack", "", "number of the line; `crack_names` of the field data has the names"),
    ),
)

RUN: Final = (
    SUMMARY,
    STEPS,
    TIPS,
    PATHS,
    CONTACT,
    REACTIONS,
    HISTORY,
    EVENTS,
    File("report.html", "all of it on one page that needs no network; `output.report: false` leaves it out"),
    File("NAME.pvd", "opens the frames of all steps in ParaView"),
    FRAMES,
    File("NAME_cracks.pvd", "opens the crack faces of all steps in ParaView"),
    CRACKS,
    File("figures/path.png", "the path on the specimen"),
    File("figures/sigma_1_first.png", "sigma_1 on the displaced specimen, first step"),
    File("figures/sigma_1_last.png", "the same, last step"),
    File("figures/contact.png", "slip and tractions along the faces"),
    File("figures/load_curve.png", "load factor over displacement and length, where it varies"),
    File("render/FIELD/step_NNNN.png", "a picture for each frame, by `crackgrow render`"),
    File("render/FIELD/animation.gif", "all of them, one after the other; `animation.mp4` with `--mp4`"),
    File(
        "export/step_NNNN.msh",
        "a frame for other programs, by `crackgrow export`; also `.inp`, `.vtk`, `.xdmf`; paths as `.geojson`, `.dxf`",
    ),
    File("case.yaml", "the case as it ran, in SI units, every default filled in"),
    File("run.log", "a line a step with unknowns, iterations and seconds; warnings; how the run ended"),
    File("checkpoint/step_NNNN.npz", "what an interrupted run goes on from"),
)
"""Files of a run, the most useful first."""
