"""Bad input stops with a message that says what was given, what is allowed, and where."""

from __future__ import annotations

import re

import numpy as np
import pytest

from support.clouds import cloud, lattice, ragged
from support.oracle import Solid
from support.runs import header, lps_words

SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2)
GOOD = "bulk 3.0 shear 1.2 horizon 2.3 unbreakable"


def fails(sim, script: str, message: str) -> None:
    """The script must stop LAMMPS with an error that contains ``message`` (plain text)."""
    with pytest.raises(Exception, match=re.escape(message)):
        sim.commands(script)


def grain(simulation, dimension=2, **options):
    shape = (4, 4) if dimension == 2 else (3, 3, 3)
    return simulation().load(
        cloud(lattice(shape), dimension=dimension), dimension=dimension, **options
    )


# --- materials: errors at once, before anything runs ---------------------------------------------

MATERIALS = {
    "no modulus": (
        "horizon 2.3 unbreakable",
        "needs two of the moduli young, bulk, shear, poisson; given: none",
    ),
    "one modulus": (
        "bulk 3.0 horizon 2.3 unbreakable",
        "needs two of the moduli young, bulk, shear, poisson; given: bulk",
    ),
    "three moduli": (
        "bulk 3.0 shear 1.2 poisson 0.25 horizon 2.3 unbreakable",
        "needs two of the moduli young, bulk, shear, poisson; given: bulk, shear, poisson",
    ),
    "incompressible": (
        "young 1.0 poisson 0.5 horizon 2.3 unbreakable",
        "poisson 0.5: must be > -1 and < 0.5",
    ),
    "Poisson's ratio -1": (
        "young 1.0 poisson -1 horizon 2.3 unbreakable",
        "poisson -1: must be > -1 and < 0.5",
    ),
    "negative modulus": ("bulk -3.0 shear 1.2 horizon 2.3 unbreakable", "bulk -3.0: must be > 0"),
    "moduli that belong together to no solid": (
        "young 9.0 shear 1.2 horizon 2.3 unbreakable",
        "belong to no stable solid",
    ),
    "negative horizon": (
        "bulk 3.0 shear 1.2 horizon -2.3 unbreakable",
        "horizon -2.3: must be > 0",
    ),
    "zero horizon": ("bulk 3.0 shear 1.2 horizon 0 unbreakable", "horizon 0: must be > 0"),
    "no horizon": ("bulk 3.0 shear 1.2 unbreakable", "needs the keyword horizon"),
    "no strength": (
        "bulk 3.0 shear 1.2 horizon 2.3",
        "needs one of the keywords gc, s0, unbreakable",
    ),
    "two strengths": (
        "bulk 3.0 shear 1.2 horizon 2.3 gc 1.0 s0 0.1",
        "takes only one of gc, s0, unbreakable: s0 is one too many",
    ),
    "negative gc": ("bulk 3.0 shear 1.2 horizon 2.3 gc -1", "gc -1: must be > 0"),
    "zero s0": ("bulk 3.0 shear 1.2 horizon 2.3 s0 0", "s0 0: must be > 0"),
    "unknown keyword": (f"{GOOD} colour red", "Unknown Pair style peridem/lps keyword colour"),
    "repeated keyword": (f"{GOOD} horizon 2.0", "Repeated Pair style peridem/lps keyword horizon"),
    "unknown influence": (
        f"{GOOD} influence cubic",
        "influence cubic: must be linear, constant, gaussian b or inverse",
    ),
    "gaussian without width": (f"{GOOD} influence gaussian", "influence needs 2 values"),
    "negative width": (f"{GOOD} influence gaussian -1", "influence gaussian -1: must be > 0"),
    "unknown plane": (f"{GOOD} plane sideways", "plane sideways: must be strain, stress or jha"),
    "unknown volume": (f"{GOOD} volume half", "volume half: must be taper [cell size] or full"),
    "unknown break": (f"{GOOD} break never", "break never: must be tension or both"),
    "negative viscosity": (f"{GOOD} viscosity -1", "viscosity -1: must be >= 0"),
    "missing value": ("bulk 3.0 shear 1.2 unbreakable horizon", "horizon needs 1 value"),
    "not a number": (
        "bulk soft shear 1.2 horizon 2.3 unbreakable",
        "instead of 'soft' in input script or data file",
    ),
    "NaN": ("bulk nan shear 1.2 horizon 2.3 unbreakable", "instead of 'nan' in input script"),
    "infinite horizon": ("bulk 3.0 shear 1.2 horizon inf unbreakable", "instead of 'inf' in input"),
}


@pytest.mark.parametrize("case", MATERIALS)
def test_bad_material(case, simulation):
    words, message = MATERIALS[case]
    sim = grain(simulation).commands("pair_style peridem/lps")
    fails(sim, f"pair_coeff * * {words}", message)


def test_the_message_shows_the_input_line_and_the_place(simulation):
    sim = grain(simulation).commands("pair_style peridem/lps")
    with pytest.raises(Exception) as caught:
        sim.commands("pair_coeff * * bulk 3.0 shear 1.2 horizon -2.3 unbreakable")
    text = str(caught.value)
    line, marker = text.splitlines()[-2:]
    assert line.rstrip().endswith("pair_coeff * * bulk 3.0 shear 1.2 horizon -2.3 unbreakable")
    assert marker.index("^") == line.index("-2.3")


def test_the_place_is_right_under_hybrid_too(simulation):
    sim = grain(simulation).commands("pair_style hybrid/overlay peridem/lps peridem/contact")
    with pytest.raises(Exception) as caught:
        sim.commands("pair_coeff * * peridem/lps bulk 3.0 shear 1.2 horizon -2.3 unbreakable")
    line, marker = str(caught.value).splitlines()[-2:]
    assert marker.index("^") == line.index("-2.3")


def test_plane_in_3d(simulation):
    sim = grain(simulation, dimension=3).commands("pair_style peridem/lps")
    fails(sim, f"pair_coeff * * {GOOD} plane strain", "plane is for 2d simulations only")


def test_pair_style_arguments(simulation):
    fails(grain(simulation), "pair_style peridem/pmb 3.0", "takes no arguments; given: 3.0")


def test_pair_coeff_missing_for_a_type(simulation):
    one = cloud(lattice((4, 4)), types=np.repeat([1, 2], 8), dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(f"pair_style peridem/lps\npair_coeff 1 1 {GOOD}")
    )
    with pytest.raises(Exception, match=r"pair_coeff 2 2 is not set|pair coeffs are not set"):
        sim.commands("run 0 post no")


def test_horizon_smaller_than_the_node_spacing_counts_and_names_the_lonely_nodes(simulation):
    sim = grain(simulation).commands("pair_style peridem/lps")
    sim.commands("pair_coeff * * bulk 3.0 shear 1.2 horizon 0.9 unbreakable")
    fails(
        sim,
        "run 0 post no",
        "16 nodes have no other node of their grain within the horizon (the first is atom-ID 1): "
        "the horizon must be larger than the node spacing",
    )


def test_horizon_absurdly_small(simulation):
    """Blocks of horizons cannot be counted any more: once an endless loop."""
    sim = grain(simulation).commands("pair_style peridem/lps")
    sim.commands("pair_coeff * * bulk 3.0 shear 1.2 horizon 1e-30 unbreakable")
    fails(sim, "run 0 post no", "too far away to be counted in horizons of 1e-30")


def test_horizon_absurdly_large(simulation):
    """More ghosts than LAMMPS can count: once an abort of MPI without a message."""
    sim = grain(simulation).commands("pair_style peridem/lps")
    sim.commands("pair_coeff * * bulk 3.0 shear 1.2 horizon 1e30 unbreakable")
    fails(
        sim,
        "run 0 post no",
        "The horizon is 1e+30 and the box only 13 long: is that the right unit",
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("radius 1e30 stiffness 5", "radius 1e+30, and the box is only"),
        ("radius 1 modulus 3 form jha2021 horizon 1e150", "horizon 1e+150: is that the right unit"),
        ("radius 1e-320 stiffness 5", "are these the right units?"),
    ],
)
def test_contacts_that_nothing_can_be_computed_with(words, message, simulation):
    sim = grain(simulation).commands(f"pair_style peridem/contact\npair_coeff * * {words}")
    fails(sim, "run 0 post no", message)


def test_a_critical_stretch_that_nothing_can_be_computed_with(simulation):
    sim = grain(simulation).commands("pair_style peridem/lps")
    sim.commands("pair_coeff * * bulk 1e-200 shear 1e-200 horizon 1 gc 1e200")
    fails(sim, "run 0 post no", "gives a critical stretch of inf: are these the right units?")


def test_speeds_beyond_all_bounds(simulation):
    one = cloud(lattice((4, 4)), dimension=2)
    one.v[3, 0] = 1e300
    sim = simulation().load(one, dimension=2)
    sim.commands(
        "pair_style hybrid/overlay peridem/lps peridem/contact\n"
        f"pair_coeff * * peridem/lps {GOOD}\n"
        "pair_coeff * * peridem/contact radius 0.9\nfix motion all nve"
    )
    fails(sim, "run 0 post no", "The speed of a node is no number any more, or beyond all bounds")


def test_horizon_whose_powers_cannot_be_computed(simulation):
    sim = grain(simulation).commands("pair_style peridem/lps")
    fails(sim, "pair_coeff * * bulk 3 shear 1 horizon 1e-320 gc 5", "horizon 1e-320: is that the")


def test_a_bonds_fix_without_a_solid_says_so_and_runs(simulation):
    one = cloud(lattice((4, 4)), dimension=2)
    sim = simulation().load(one, dimension=2)
    sim.commands("pair_style peridem/contact\npair_coeff * * radius 0.9 stiffness 5")
    sim.commands("fix bonds all peridem/bonds\nfix motion all nve\nrun 5 post no")
    assert np.all(sim.atoms("f") == 0.0)
    assert "no pair style of a peridem solid is defined, so no bonds" in sim.printed()


def test_only_the_nodes_left_without_a_family_are_counted(simulation):
    x = np.array([[0.0, 0], [1, 0], [2, 0], [9, 0]])
    one = cloud(x, dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(f"pair_style peridem/lps\npair_coeff * * {GOOD}")
    )
    fails(
        sim,
        "run 0 post no",
        "1 nodes have no other node of their grain within the horizon (the first is atom-ID 4)",
    )


def test_a_grain_of_a_single_node_is_allowed(simulation):
    one = cloud([[0, 0], [5, 0]], molecule=[1, 2], dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(f"pair_style peridem/lps\npair_coeff * * {GOOD}\nrun 0 post no")
    )
    assert np.all(sim.atoms("f") == 0.0)


# --- data files ----------------------------------------------------------------------------------


def one_line(simulation, line: str, words: str = ""):
    sim = simulation()
    data = sim.folder / "bad.data"
    data.write_text(
        "bad\n\n2 atoms\n1 atom types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\n"
        f"Atoms # peridem\n\n1 1 1 1.0 2.0 5 5 5\n{line}\n"
    )
    return sim, f"atom_style peridem {words}\nread_data {data}"


@pytest.mark.parametrize("volume", ["0.0", "-1.5"])
def test_volume_not_positive_in_a_data_file(volume, simulation):
    sim, script = one_line(simulation, f"2 1 1 {volume} 2.0 6 5 5")
    fails(sim, script, "Node 2 in Atoms section of data file has volume")


@pytest.mark.parametrize("density", ["0.0", "-1.5"])
def test_density_not_positive_in_a_data_file(density, simulation):
    sim, script = one_line(simulation, f"2 1 1 1.0 {density} 6 5 5")
    fails(sim, script, "Node 2 in Atoms section of data file has density")


def test_negative_molecule_in_a_data_file(simulation):
    sim, script = one_line(simulation, "2 -1 1 1.0 2.0 6 5 5")
    fails(sim, script, "Node 2 in Atoms section of data file has molecule-ID -1: it must be >= 0")


@pytest.mark.parametrize("contact", ["", "radius 1.01 stiffness 5 restitution 0.5"])
def test_the_largest_molecule_ids_are_no_larger_a_table(contact, simulation):
    """Once tables by molecule-ID were made: they could not hold this one."""
    one = cloud(lattice((4, 4)), molecule=np.repeat([7, 2147483647], 8), dimension=2)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        f"""
        pair_style hybrid/overlay peridem/lps {"peridem/contact" if contact else ""}
        pair_coeff * * peridem/lps {GOOD}
        {f"pair_coeff * * peridem/contact {contact}" if contact else ""}
        fix motion all nve
        run 0 post no
        """
    )
    assert "16 nodes in 2 grains" in sim.printed()


@pytest.mark.parametrize(
    ("word", "line"),
    [
        ("nan", "2 1 1 nan 2.0 6 5 5"),
        ("nan", "2 1 1 1.0 nan 6 5 5"),
        ("nan", "2 1 1 1.0 2.0 nan 5 5"),
        ("inf", "2 1 1 inf 2.0 6 5 5"),
        ("big", "2 1 1 big 2.0 6 5 5"),
    ],
)
def test_words_in_a_data_file_that_are_no_numbers(word, line, simulation):
    sim, script = one_line(simulation, line)
    fails(sim, script, f"instead of '{word}' in input script or data file")


def test_nan_reference_position_in_a_data_file(simulation):
    sim = simulation()
    data = sim.folder / "bad.data"
    data.write_text(
        "bad\n\n2 atoms\n1 atom types\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n\n"
        "Atoms # peridem\n\n1 1 1 1.0 2.0 5 5 5 5 5 5\n2 1 1 1.0 2.0 6 5 5 6 nan 5\n"
    )
    fails(sim, f"atom_style peridem reference\nread_data {data}", "instead of 'nan' in input")


def test_a_data_file_without_the_columns_that_reference_asks_for(simulation):
    sim, script = one_line(simulation, "2 1 1 1.0 2.0 6 5 5", "reference")
    fails(sim, script, "Incorrect format in Atoms section of data file")


def test_unknown_atom_style_argument(simulation):
    fails(
        simulation(),
        "atom_style peridem colour",
        "Unknown atom_style peridem argument colour: only 'reference' is known",
    )


# --- styles in the wrong place -------------------------------------------------------------------


@pytest.mark.parametrize(
    "script",
    [
        f"pair_style peridem/lps\npair_coeff * * {GOOD}",
        "pair_style peridem/contact\npair_coeff * * radius 1.0 stiffness 5.0",
        "fix bonds all peridem/bonds",
        "fix floor all peridem/wall plane 0 0 0 0 1 0 radius 1.0 stiffness 5.0",
        "compute node all peridem/atom damage",
    ],
    ids=["lps", "contact", "bonds", "wall", "compute"],
)
def test_peridem_styles_need_the_atom_style(script, simulation):
    sim = simulation().commands(
        """
        dimension 2
        atom_style atomic
        lattice sq 1.0
        region box block 0 6 0 6 -0.5 0.5
        create_box 1 box
        create_atoms 1 box
        mass 1 1.0
        """
    )
    fails(sim, f"{script}\nrun 0 post no", "requires atom style peridem; the atom style is atomic")


def test_a_ghost_cutoff_too_small_for_the_bonds(simulation):
    sim = grain(simulation).commands(f"pair_style peridem/lps\npair_coeff * * {GOOD}")
    fails(
        sim,
        "comm_modify cutoff 1.5\nrun 0 post no",
        "Ghost cutoff too small: comm_modify cutoff is 1.5, bonds need 2.3",
    )


def test_the_ghost_cutoff_is_set_and_said_when_nobody_asked_for_one(simulation):
    sim = grain(simulation).commands(
        f"pair_style peridem/lps\npair_coeff * * {GOOD}\nrun 0 post no"
    )
    assert "ghost cutoff set to 2.3" in sim.printed()


def test_a_periodic_box_shorter_than_two_horizons(simulation):
    one = cloud(lattice((4, 4)), dimension=2)
    one.box[0], one.periodic = (-2.0, 2.0), (True, False, False)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(f"pair_style peridem/lps\npair_coeff * * {GOOD}")
    )
    fails(sim, "run 0 post no", "Periodic box is 4 long in x: it must be at least twice")


def test_changing_the_horizon_after_the_families_are_built(simulation):
    sim = grain(simulation).commands(
        f"pair_style peridem/lps\npair_coeff * * {GOOD}\nrun 0 post no"
    )
    sim.commands(f"pair_coeff * * {lps_words(SOLID).replace('2.2999999999999998', '1.5')}")
    fails(sim, "run 0 post no", "were built with horizon 2.3: horizon (now 1.5)")


def test_initial_overlap_of_grains_is_a_warning_with_numbers(simulation):
    one = cloud([[0, 0], [0.6, 0]], molecule=[1, 2], dimension=2)
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            "pair_style peridem/contact\npair_coeff * * radius 1.0 stiffness 5.0\nrun 0 post no"
        )
    )
    assert "1 pairs of nodes of different grains overlap at the start, the deepest by 40.0 %" in (
        sim.printed()
    )


# --- contact and walls ---------------------------------------------------------------------------

CONTACTS = {
    "negative radius": ("radius -1 stiffness 5", "radius -1: must be > 0"),
    "negative stiffness": ("radius 1 stiffness -5", "stiffness -5: must be > 0"),
    "stiffness and modulus": (
        "radius 1 stiffness 5 modulus 2",
        "takes either modulus or stiffness, not both",
    ),
    "damping and restitution": (
        "radius 1 stiffness 5 damping 1 restitution 0.9",
        "takes either restitution or damping, not both",
    ),
    "restitution above 1": (
        "radius 1 stiffness 5 restitution 1.5",
        "restitution 1.5: must be > 0 and <= 1",
    ),
    "restitution 0": ("radius 1 stiffness 5 restitution 0", "restitution 0: must be > 0 and <= 1"),
    "negative damping": ("radius 1 stiffness 5 damping -1", "damping -1: must be >= 0"),
    "negative onset": ("radius 1 stiffness 5 onset -0.1", "onset -0.1: must be >= 0 and < 1"),
    "onset 1": ("radius 1 stiffness 5 onset 1", "onset 1: must be >= 0 and < 1"),
    "negative friction": ("radius 1 stiffness 5 friction -0.3", "friction -0.3: must be >= 0"),
    "unknown form": (
        "radius 1 modulus 5 form cubic",
        "form cubic: must be bulk [alpha] or jha2021",
    ),
    "unknown tangential": ("radius 1 stiffness 5 tangential glue", "tangential glue: must be"),
    "fragments maybe": ("radius 1 stiffness 5 fragments maybe", "boolean"),
    "repeated": (
        "radius 1 radius 2 stiffness 5",
        "Repeated pair style peridem/contact keyword radius",
    ),
}


@pytest.mark.parametrize("case", CONTACTS)
def test_bad_contact(case, simulation):
    words, message = CONTACTS[case]
    sim = grain(simulation).commands("pair_style peridem/contact")
    fails(sim, f"pair_coeff * * {words}", message)


def test_unknown_contact_keyword_lists_the_known_ones(simulation):
    sim = grain(simulation).commands("pair_style peridem/contact")
    fails(sim, "pair_coeff * * radius 1 stiffness 5 glue 3", "keyword glue: known are radius, ")


def test_contact_without_a_stiffness_or_a_solid(simulation):
    sim = grain(simulation).commands("pair_style peridem/contact\npair_coeff * * radius 1.0")
    fails(sim, "run 0 post no", "no solid says how stiff the contact is: give modulus or stiffness")


WALLS = {
    "no surface": ("", "needs a surface: plane x y z nx ny nz"),
    "unknown surface": ("sphere 0 0 0 1", "Unknown fix peridem/wall surface sphere"),
    "short plane": ("plane 0 0 0 0 1", "plane needs six numbers"),
    "zero normal": ("plane 0 -9 0 0 0 0", "the normal is zero"),
    "normal out of the plane in 2d": ("plane 0 -9 0 0 1 1", "nz must be 0 in a 2d simulation"),
    "velocity out of the plane in 2d": (
        "plane 0 -9 0 0 1 0 velocity 0 0 1",
        "velocity in z must be 0 in a 2d simulation",
    ),
    "unknown keyword": (
        "plane 0 -9 0 0 1 0 colour red",
        "Unknown fix peridem/wall keyword colour: known are velocity, radius",
    ),
    "infinite": ("plane 0 inf 0 0 1 0", "instead of 'inf' in input script"),
    "bad coefficient": ("plane 0 -9 0 0 1 0 friction -1", "friction -1: must be >= 0"),
    "fragments": ("plane 0 -9 0 0 1 0 fragments no", "Fix peridem/wall takes no fragments"),
}


@pytest.mark.parametrize("case", WALLS)
def test_bad_wall(case, simulation):
    words, message = WALLS[case]
    fails(grain(simulation), f"fix floor all peridem/wall {words}", message)


def test_nodes_behind_the_wall_at_the_start(simulation):
    sim = grain(simulation).commands("pair_style zero 2.0\npair_coeff * *")
    sim.commands("fix floor all peridem/wall plane 0 -9 0 0 -1 0 radius 1.0 stiffness 5.0")
    fails(
        sim,
        "run 0 post no",
        "16 nodes start behind the plane (the first is atom-ID 1): its "
        "normal must point to the side where the grains are",
    )


def test_a_wall_across_a_periodic_direction(simulation):
    one = cloud(lattice((4, 4)), dimension=2)
    one.periodic = (True, False, False)
    sim = simulation().load(one, dimension=2)
    fails(
        sim,
        "fix side all peridem/wall plane -4 0 0 1 0 0 radius 1.0 stiffness 5.0",
        "the box is periodic in x",
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "needs at least one of: damage stretch dilatation energy bonds"),
        ("colour", "Unknown compute peridem/atom keyword colour: known are damage, stretch"),
        ("damage damage", "Repeated compute peridem/atom keyword damage"),
    ],
)
def test_bad_compute(words, message, simulation):
    fails(grain(simulation), f"compute node all peridem/atom {words}", message)


def test_compute_without_a_solid(simulation):
    sim = grain(simulation).commands("pair_style zero 2.0\npair_coeff * *")
    with pytest.raises(Exception, match="needs a pair style of a peridem solid"):
        sim.commands("compute node all peridem/atom damage\nrun 0 post no")


def test_unknown_bonds_keyword(simulation):
    fails(
        grain(simulation),
        "fix bonds all peridem/bonds colour",
        "Unknown fix peridem/bonds keyword colour",
    )


def test_two_bonds_fixes(simulation):
    fails(
        grain(simulation), "fix a all peridem/bonds\nfix b all peridem/bonds", "only one is allowed"
    )


def test_types_of_one_grain_that_differ_in_influence_need_their_own_pair_coeff(simulation, rng):
    one = ragged(rng, (4, 4), types=np.repeat([1, 2], 8))
    sim = (
        simulation()
        .load(one, dimension=2)
        .commands(
            f"pair_style peridem/lps\npair_coeff 1 1 {GOOD}\n"
            f"pair_coeff 2 2 {GOOD} influence constant"
        )
    )
    fails(sim, "run 0 post no", "differ in influence, volume or break; say with 'pair_coeff 1 2'")


def test_header_is_what_the_manual_shows(tmp_path):
    """The helper of all these tests writes commands a user would write."""
    one = cloud(lattice((4, 4)), dimension=2)
    text = header(one, tmp_path / "x.data", dimension=2, with_reference=False)
    assert "atom_style peridem\n" in text
