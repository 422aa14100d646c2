"""``compute peridem/atom``: fragment, surface and the Cauchy stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.clouds import cloud, disc, join, lattice, ragged, rotated
from support.oracle import Bonds, Solid, bond_state, families
from support.runs import header, read_dump, solid_script

FLAT = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=2)
SOLID = Solid(bulk=3.0, shear=1.2, horizon=2.3, dimension=3)

# --- fragments -----------------------------------------------------------------------------------

THREE = "cut plane -2 0 0 1 0.1 0 cut plane 2.2 0 0 1 -0.2 0"


def smallest_ids(n: int, bonds: Bonds) -> list[int]:
    """Smallest atom-ID among the nodes that intact bonds connect."""
    piece = np.arange(1, n + 1)
    while True:
        before = piece.copy()
        i, j = bonds.i[bonds.intact], bonds.j[bonds.intact]
        np.minimum.at(piece, i, piece[j])
        np.minimum.at(piece, j, piece[i])
        if np.array_equal(piece, before):
            return piece.tolist()


def in_three_pieces(one) -> Bonds:
    bonds = families(one.reference, one.volume, one.molecule, FLAT)
    x = one.reference
    for point, normal in ((-2.0, (1, 0.1)), (2.2, (1, -0.2))):
        side = (x[:, 0] - point) * normal[0] + x[:, 1] * normal[1] >= 0
        bonds.intact &= side[bonds.i] == side[bonds.j]
    return bonds


def shuffled(rng, one):
    """The same nodes with their IDs in another order: the smallest is anywhere."""
    order = rng.permutation(one.n)
    for name in ("x", "reference", "volume", "density", "v"):
        setattr(one, name, getattr(one, name)[order])
    return one


@pytest.mark.parametrize(("ranks", "grid"), [(1, "1 1 1"), (2, "2 1 1"), (4, "4 1 1")])
def test_each_piece_of_a_cut_grain_bears_its_smallest_id_on_any_ranks(ranks, grid, mpi, rng):
    """The pieces lie along the cuts between ranks: IDs travel from rank to rank."""
    one = shuffled(rng, ragged(rng, (12, 5)))
    one.write(mpi.folder / "pieces.data")
    mpi(
        header(one, "pieces.data", dimension=2, extra=f"processors {grid}")
        + f"fix glue all peridem/bonds {THREE}\n{solid_script(FLAT)}"
        "compute piece all peridem/atom fragment\n"
        "dump state all custom 1 pieces.dump id c_piece\nrun 0 post no\n",
        ranks,
    )
    (frame,) = read_dump(mpi.folder / "pieces.dump")
    expected = smallest_ids(one.n, in_three_pieces(one))
    assert len(set(expected)) == 3
    assert frame["c_piece"].astype(int).tolist() == expected


def test_whole_grains_are_one_fragment_each_and_single_nodes_their_own(simulation, rng):
    grains = [ragged(rng, (4, 4), molecule=k + 1) for k in range(2)]
    grains[1].x[:, 0] += 6.0
    grains[1].reference[:, 0] += 6.0
    lonely = cloud([[3, 8], [5, 8]], molecule=[3, 0], dimension=2)
    one = join(*grains, lonely)
    sim = simulation().load(one, dimension=2)
    sim.commands(solid_script(FLAT) + "compute piece all peridem/atom fragment\nrun 0 post no")
    assert sim.compute("piece").astype(int).tolist() == [1] * 16 + [17] * 16 + [33, 34]


def test_a_grain_that_breaks_apart_becomes_fragments_and_lost_nodes_their_own(simulation):
    """Halves that fly apart, and a corner that leaves both."""
    x = lattice((6, 4))
    v = np.zeros_like(x)
    v[:, 0] = np.sign(x[:, 0])
    corner = int(np.argmax(x[:, 0] + x[:, 1]))
    v[corner] = (4.0, 4.0, 0.0)
    one = cloud(x, dimension=2, v=v, margin=20)
    solid = replace(FLAT, s0=0.02, horizon=1.5)
    sim = simulation().load(one, dimension=2)
    sim.commands(
        solid_script(solid)
        + "compute piece all peridem/atom fragment\ntimestep 0.005\nrun 0 post no"
    )
    assert set(sim.compute("piece")) == {1.0}
    sim.commands("run 200 post no")
    piece = sim.compute("piece").astype(int)
    left, right = x[:, 0] < 0, (x[:, 0] > 0) & (np.arange(one.n) != corner)
    assert piece[corner] == corner + 1
    assert not set(piece[left]) & set(piece[right])
    assert piece[left].min() == 1


# --- surface -------------------------------------------------------------------------------------


def skin_and_depth(simulation, dimension, horizon):
    """Surface flags of a block, and how deep each node lies under each pair of its faces."""
    shape = (12, 13) if dimension == 2 else (11, 12, 13)
    one = cloud(lattice(shape), dimension=dimension)
    solid = replace(FLAT if dimension == 2 else SOLID, horizon=horizon)
    sim = simulation().load(one, dimension=dimension)
    sim.commands(solid_script(solid) + "compute skin all peridem/atom surface\nrun 0 post no")
    depth = 0.5 * (np.array(shape) - 1) - np.abs(one.x[:, :dimension])
    return sim.compute("skin"), np.sort(depth, axis=1)


@pytest.mark.parametrize("horizon", [1.5, 2.01, 2.5, 3.01, 4.01, 5.01])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_surface_of_a_block_is_exactly_its_first_layer(dimension, horizon, simulation):
    """Faces, edges and corners, and nothing under them."""
    skin, depth = skin_and_depth(simulation, dimension, horizon)
    assert skin.tolist() == (depth[:, 0] < 0.5).astype(float).tolist()


@pytest.mark.parametrize("horizon", [2.01, 3.01, 4.01])
def test_the_surface_of_a_disc_of_a_lattice_is_where_a_neighbour_is_missing(horizon, simulation):
    """One of the four nearest; steps of the outline lack a diagonal only, one node further in."""
    one = cloud(disc(8.4), dimension=2)
    sim = simulation().load(one, dimension=2)
    solid = replace(FLAT, horizon=horizon)
    sim.commands(solid_script(solid) + "compute skin all peridem/atom surface\nrun 0 post no")
    distance = np.linalg.norm(one.x[:, None] - one.x[None], axis=2)
    neighbours = np.sum(distance < 1.1, axis=1) - 1
    assert 30 < np.sum(neighbours < 4) < 80
    assert sim.compute("skin").tolist() == (neighbours < 4).astype(float).tolist()


def test_rotation_and_strain_change_no_surface(simulation, rng):
    """It is that of the reference configuration."""
    one = ragged(rng, (9, 9))
    solid = replace(FLAT, horizon=3.01)
    flags = []
    for x in (one.reference, rotated(one.reference * (1.2, 1.0, 1.0), 0.7)):
        sim = simulation().load(one.moved(x), dimension=2)
        sim.commands(solid_script(solid) + "compute skin all peridem/atom surface\nrun 0 post no")
        flags.append(sim.compute("skin").tolist())
    assert flags[0] == flags[1]
    assert 20 < sum(flags[0]) < 40  # 32 nodes in the outer rows of the lattice that it is near


@pytest.mark.parametrize("factor", [2.2, 3.2, 4.2])
@pytest.mark.parametrize("shape", ["circle", "hexagon", "drum", "triangle"])
def test_the_surface_of_a_mesh_is_its_boundary(shape, factor, simulation):
    """Meshes with the volume of boundary nodes lumped: half that of others, a third at corners."""
    from peridem import cloud as meshes
    from peridem import shapes

    mesh = meshes.mesh(getattr(shapes, shape)(1.0), 0.1)
    size = np.median(mesh.cell_sizes)
    x = np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))]) / size
    one = cloud(x, volume=mesh.volumes / size**2, dimension=2)
    sim = simulation().load(one, dimension=2)
    solid = replace(FLAT, horizon=factor)
    sim.commands(solid_script(solid) + "compute skin all peridem/atom surface\nrun 0 post no")
    assert sim.compute("skin").tolist() == mesh.surface.astype(float).tolist()


def test_nodes_that_lost_a_bond_or_have_none_are_surface(simulation):
    one = join(cloud(lattice((12, 12)), dimension=2), cloud([[12, 0]], molecule=2, dimension=2))
    sim = simulation().load(one, dimension=2)
    sim.commands(
        "fix glue all peridem/bonds cut plane 0 0 0 1 0 0 radius 1.2\n"
        + solid_script(FLAT)
        + "compute skin all peridem/atom surface damage\nrun 0 post no"
    )
    skin, damaged = sim.compute("skin").T
    inside = np.abs(one.x).max(axis=1) < 5
    assert np.all(skin[damaged > 0] == 1.0)
    assert 10 < np.sum(inside & (damaged > 0)) < np.sum(inside) - 10
    assert np.all(skin[inside & (damaged == 0)] == 0.0)
    assert skin[-1] == 1.0


# --- stress --------------------------------------------------------------------------------------

NAMES = "sxx syy szz sxy sxz syz"
STRAIN_SIZE = 1e-5


def stresses(simulation, one, solid, gradient):
    """Cauchy stress of every node after x = X + gradient X."""
    sim = simulation().load(
        one.moved(one.reference @ (np.eye(3) + gradient).T), dimension=solid.dimension
    )
    sim.commands(solid_script(solid) + f"compute cauchy all peridem/atom {NAMES}\nrun 0 post no")
    return sim.compute("cauchy")


def tensor(row):
    xx, yy, zz, xy, xz, yz = row
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def hooke(solid, strain):
    """Classical stress with lambda' and G; out of plane by plane strain or stress."""
    stress = solid.lame * np.trace(strain) * np.eye(3) + 2 * solid.shear * strain
    if solid.dimension == 2 and solid.plane == "stress":
        stress[2, 2] = 0.0
    return stress


CASES = {
    "3D": SOLID,
    "3D, constant influence": replace(SOLID, influence="constant"),
    "plane strain": FLAT,
    "plane stress": replace(FLAT, plane="stress"),
}


def block(dimension):
    return cloud(lattice((11, 11) if dimension == 2 else (9, 9, 9)), dimension=dimension)


def middle(one):
    return int(np.argmin(np.linalg.norm(one.reference, axis=1)))


@pytest.mark.parametrize("name", CASES)
def test_uniform_dilation_of_a_lattice_gives_the_classical_stress(name, simulation):
    """No error of the lattice here: m is the sum that the stress is divided by.

    What is left is the second order of the strain, a few times 1e-5.
    """
    solid = CASES[name]
    d = solid.dimension
    strain = np.diag([STRAIN_SIZE] * d + [0.0] * (3 - d))
    one = block(d)
    got = tensor(stresses(simulation, one, solid, strain)[middle(one)])
    expected = hooke(solid, strain)
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("name", CASES)
def test_any_uniform_strain_gives_the_classical_stress_within_the_error_of_the_lattice(
    name, simulation, rng
):
    """The family of a lattice is no ball: its fourth moments are off the isotropic ones.

    What they must be for Hooke's law is d (d+2)/m sum w R^2 v V n n n n = the isotropic tensor; by
    how much the sums of this lattice miss it, times G and the strain, is the error allowed,
    plus the second order of the strain.
    """
    solid = CASES[name]
    d = solid.dimension
    strain = np.zeros((3, 3))
    strain[:d, :d] = rng.uniform(-1, 1, (d, d)) * STRAIN_SIZE
    strain = 0.5 * (strain + strain.T)
    one = block(d)
    at = middle(one)
    bonds = families(one.reference, one.volume, one.molecule, solid)
    mine = (bonds.i == at) | (bonds.j == at)
    n = ((one.reference[bonds.j] - one.reference[bonds.i]) / bonds.length[:, None])[mine]
    share = (bonds.weight * bonds.length**2 * bonds.part)[mine] / bonds.m[at]
    fourth = d * (d + 2) * np.einsum("p,pa,pb,pc,pe->abce", share, n, n, n, n)
    eye = np.diag([1.0] * d + [0.0] * (3 - d))
    isotropic = (
        np.einsum("ab,ce->abce", eye, eye)
        + np.einsum("ac,be->abce", eye, eye)
        + np.einsum("ae,bc->abce", eye, eye)
    )
    missing = solid.shear * np.einsum("abce,ce->ab", fourth - isotropic, strain)
    expected = hooke(solid, strain)
    if solid.dimension == 2 and solid.plane == "strain":  # szz = nu (sxx + syy)
        nu = solid.lame / (2 * (solid.lame + solid.shear))
        missing[2, 2] = nu * np.trace(missing)
    got = tensor(stresses(simulation, one, solid, strain)[at])
    scale = np.abs(expected).max()
    assert np.abs(missing).max() < 0.3 * scale  # the law is to be seen through the error
    np.testing.assert_allclose(got, expected + missing, rtol=0, atol=1e-4 * scale)


def test_plane_strain_is_pressed_out_of_the_plane_and_plane_stress_is_not(simulation):
    strain = np.diag([STRAIN_SIZE, 0.0, 0.0])
    one = block(2)
    nu = FLAT.lame / (2 * (FLAT.lame + FLAT.shear))
    inside = stresses(simulation, one, FLAT, strain)
    # by definition, to rounding
    np.testing.assert_allclose(inside[:, 2], nu * (inside[:, 0] + inside[:, 1]), rtol=1e-12)
    free = stresses(simulation, one, replace(FLAT, plane="stress"), strain)
    assert np.all(free[:, 2] == 0.0)


@pytest.mark.parametrize("name", ["3D", "plane strain"])
def test_the_stress_turns_with_the_grain(name, simulation):
    """Strained by a tenth and turned by 50 degrees: Q sigma Q^T, to rounding."""
    solid = CASES[name]
    d = solid.dimension
    strain = np.diag([0.1, -0.05, 0.02 if d == 3 else 0.0])
    axis = (1.0, 2.0, 3.0) if d == 3 else (0.0, 0.0, 1.0)
    turn = rotated(np.eye(3), 0.9, axis).T
    one = block(d)
    straight = stresses(simulation, one, solid, strain)
    turned = stresses(simulation, one, solid, turn @ (np.eye(3) + strain) - np.eye(3))
    scale = np.abs(straight).max()
    for before, after in zip(straight, turned, strict=True):
        np.testing.assert_allclose(
            tensor(after), turn @ tensor(before) @ turn.T, rtol=0, atol=1e-12 * scale
        )


def test_a_rigid_motion_has_no_stress(simulation):
    one = block(3)
    turn = rotated(np.eye(3), 2.0, (1, 1, 0)).T
    # rounding of lengths of order one, times moduli of order one
    assert np.abs(stresses(simulation, one, SOLID, turn - np.eye(3))).max() < 1e-12


def test_the_work_of_the_stress_is_the_energy(simulation):
    """Half of stress times strain, over the volume, for a node with a whole family."""
    strain = np.diag([1.0, -0.4, 0.7]) * STRAIN_SIZE
    one = block(3)
    at = middle(one)
    sigma = tensor(stresses(simulation, one, SOLID, strain)[at])
    bonds = families(one.reference, one.volume, one.molecule, SOLID)
    energy = bond_state(bonds, one.reference @ (np.eye(3) + strain)).energy[at]
    # second order of the strain, and rounding of 1e-15 over extensions of 1e-5
    assert 0.5 * np.sum(sigma * strain) == pytest.approx(energy, rel=1e-4)
