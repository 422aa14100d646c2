/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Contributing author: the PERIDEM developers
------------------------------------------------------------------------- */

#include "compute_peridem_atom.h"

#include "fix_peridem_bonds.h"
#include "pair_peridem.h"
#include "peridem_compat.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "math_const.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;
using MathConst::MY_2PI;
using MathConst::MY_PI;

// the six stresses come last, in the order of PairPeridem::stress()
enum { DAMAGE, STRETCH, DILATATION, ENERGY, BONDS, SURFACE, FRAGMENT, SXX };
static const std::vector<std::string> field_names = {
    "damage", "stretch", "dilatation", "energy", "bonds", "surface", "fragment",
    "sxx",    "syy",     "szz",        "sxy",    "sxz",   "syz"};

// A node belongs to the surface when there is a direction without a near node of its family within
// 60 degrees. Near is what is closer than 1.8 cells: the diagonals of a cubic lattice, the first
// ring or two of a mesh. The widest such angle is 67 degrees or more at nodes of faces, edges and
// corners of lattices and meshes, at most 53 at others, re-entrant corners of lattices 45.
static constexpr double NEAR = 1.8;
static constexpr double COS_OPEN = 0.5;

// how many directions are tried: every one is within 3 (2d) or 10 (3d) degrees of one of them
static constexpr int DIRECTIONS_2D = 72;
static constexpr int DIRECTIONS_3D = 200;

/* ---------------------------------------------------------------------- */

ComputePeridemAtom::ComputePeridemAtom(LAMMPS *lmp, int narg, char **arg) : Compute(lmp, narg, arg)
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, 2, "Compute {} requires atom style peridem; the atom style is {}", style,
               atom->get_style());
  if (narg < 4)
    error->all(FLERR, Error::ARGZERO, "Compute {} needs at least one of: {}", style,
               utils::join_words(field_names, " "));

  for (int iarg = 3; iarg < narg; iarg++) {
    const auto it = std::find(field_names.begin(), field_names.end(), arg[iarg]);
    if (it == field_names.end())
      error->all(FLERR, iarg, "Unknown compute {} keyword {}: known are {}", style, arg[iarg],
                 utils::join_words(field_names, ", "));
    const int field = static_cast<int>(it - field_names.begin());
    if (std::find(fields.begin(), fields.end(), field) != fields.end())
      error->all(FLERR, iarg, "Repeated compute {} keyword {}", style, arg[iarg]);
    fields.push_back(field);
  }
  comm_forward = 1;
  peratom_flag = 1;
  size_peratom_cols = fields.size() == 1 ? 0 : static_cast<int>(fields.size());
}

/* ---------------------------------------------------------------------- */

ComputePeridemAtom::~ComputePeridemAtom()
{
  memory->destroy(vector_atom);
  memory->destroy(array_atom);
}

/* ---------------------------------------------------------------------- */

void ComputePeridemAtom::init()
{
  if (wants(SURFACE)) spread_directions();
  solids = PairPeridem::find_all(lmp);
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
  if (solids.empty() || !bonds)
    error->all(FLERR, Error::NOLASTLINE,
               "Compute {} {} needs a pair style of a peridem solid, such as peridem/lps", id,
               style);
}

/* ---------------------------------------------------------------------- */

void ComputePeridemAtom::compute_peratom()
{
  invoked_peratom = update->ntimestep;

  const int ncols = static_cast<int>(fields.size());
  if (atom->nmax > nmax) {
    nmax = atom->nmax;
    if (ncols == 1) {
      memory->destroy(vector_atom);
      memory->create(vector_atom, nmax, "peridem/atom:vector");
    } else {
      memory->destroy(array_atom);
      memory->create(array_atom, nmax, ncols, "peridem/atom:array");
    }
  }

  if (wants(FRAGMENT)) find_fragments();
  for (int i = 0; i < atom->nlocal; i++) {
    const bool in_group = atom->mask[i] & groupbit;
    for (int c = 0; c < ncols; c++) {
      const double what = in_group ? value(fields[c], i) : 0.0;
      if (ncols == 1)
        vector_atom[i] = what;
      else
        array_atom[i][c] = what;
    }
  }
}

/* ---------------------------------------------------------------------- */

const PairPeridem *ComputePeridemAtom::solid(int i) const
{
  for (const auto *one : solids)
    if (one->covers(atom->type[i])) return one;
  return nullptr;
}

/* ---------------------------------------------------------------------- */

double ComputePeridemAtom::value(int field, int i) const
{
  if (field == FRAGMENT) return piece[i];
  const auto *mine = solid(i);
  if (!mine) return 0.0;
  if (field >= SXX) {
    double sigma[6];
    mine->stress(i, sigma);
    return sigma[field - SXX];
  }
  switch (field) {
    case DAMAGE:
      return damage(i);
    case STRETCH:
      return bonds->maxstretch[i];
    case DILATATION:
      return mine->dilatation(i);
    case ENERGY:
      return mine->strain_energy(i);
    case SURFACE:
      return surface(i);
    default:
      return bonds->num[i];
  }
}

/* ----------------------------------------------------------------------
   broken fraction of the family, by volume
------------------------------------------------------------------------- */

double ComputePeridemAtom::damage(int i) const
{
  if (bonds->num[i] == bonds->nref[i] || !(bonds->famvolume[i] > 0.0)) return 0.0;
  if (bonds->num[i] == 0) return 1.0;
  return 1.0 - bonds->intact_volume(i) / bonds->famvolume[i];
}

/* ----------------------------------------------------------------------
   1 where the family lacks a side, or bonds are broken
------------------------------------------------------------------------- */

double ComputePeridemAtom::surface(int i) const
{
  if (bonds->num[i] < bonds->nref[i] || bonds->num[i] == 0) return 1.0;
  const auto around = near_directions(i);
  for (const auto &u : directions) {
    bool open = true;
    for (const auto &n : around)
      if (u[0] * n[0] + u[1] * n[1] + u[2] * n[2] > COS_OPEN) {
        open = false;
        break;
      }
    if (open) return 1.0;
  }
  return 0.0;
}

/* ----------------------------------------------------------------------
   unit vectors to the near nodes of a family, in the reference configuration
------------------------------------------------------------------------- */

std::vector<std::array<double, 3>> ComputePeridemAtom::near_directions(int i) const
{
  const bigint begin = bonds->start[i], end = begin + bonds->num[i];
  const double power = 1.0 / domain->dimension;
  const double cell = std::pow(atom->vfrac[i], power);
  double nearest = bonds->length[begin];
  for (bigint k = begin; k < end; k++) nearest = MIN(nearest, bonds->length[k]);

  std::vector<std::array<double, 3>> around;
  double **X = atom->x0;
  for (bigint k = begin; k < end; k++) {
    const int j = bonds->partner(i, k);
    const double mean = 0.5 * (cell + std::pow(atom->vfrac[j], power));
    const double R = bonds->length[k];
    if (R > NEAR * MAX(mean, nearest)) continue;
    double d[3] = {X[j][0] - X[i][0], X[j][1] - X[i][1], X[j][2] - X[i][2]};
    PeridemCompat::minimum_image(domain, d);
    around.push_back({d[0] / R, d[1] / R, d[2] / R});
  }
  return around;
}

/* ----------------------------------------------------------------------
   unit vectors all around: on a circle, or on a spiral over the sphere
------------------------------------------------------------------------- */

void ComputePeridemAtom::spread_directions()
{
  directions.clear();
  const bool flat = domain->dimension == 2;
  const int n = flat ? DIRECTIONS_2D : DIRECTIONS_3D;
  for (int k = 0; k < n; k++) {
    const double part = (k + 0.5) / n;
    const double z = flat ? 0.0 : 1.0 - 2.0 * part;
    const double turn = flat ? MY_2PI * part : MY_PI * (1.0 + std::sqrt(5.0)) * (k + 0.5);
    const double r = std::sqrt(1.0 - z * z);
    directions.push_back({r * std::cos(turn), r * std::sin(turn), z});
  }
}

/* ---------------------------------------------------------------------- */

bool ComputePeridemAtom::wants(int field) const
{
  return std::find(fields.begin(), fields.end(), field) != fields.end();
}

/* ----------------------------------------------------------------------
   nodes that intact bonds connect share the smallest ID among them; IDs spread over a rank until
   nothing changes, then to the other ranks, until nothing changes anywhere
------------------------------------------------------------------------- */

void ComputePeridemAtom::find_fragments()
{
  const int nall = atom->nlocal + atom->nghost;
  piece.resize(nall);
  for (int i = 0; i < nall; i++) piece[i] = static_cast<double>(atom->tag[i]);
  int mine = 1, any = 1;
  while (any) {
    comm->forward_comm(this);
    mine = 0;
    while (sweep_fragments()) mine = 1;
    MPI_Allreduce(&mine, &any, 1, MPI_INT, MPI_MAX, world);
  }
}

/* ---------------------------------------------------------------------- */

bool ComputePeridemAtom::sweep_fragments()
{
  const PeridemLookup find(atom);
  bool changed = false;
  for (int i = 0; i < atom->nlocal; i++) {
    double least = piece[i];
    const bigint begin = bonds->start[i], end = begin + MAX(bonds->num[i], 0);
    for (bigint k = begin; k < end; k++) least = MIN(least, piece[find(bonds->ptag[k])]);
    if (least < piece[i]) {
      piece[i] = least;
      changed = true;
    }
    for (bigint k = begin; k < end; k++) {
      const int j = find(bonds->ptag[k]);
      if (j < atom->nlocal && piece[j] > least) {
        piece[j] = least;
        changed = true;
      }
    }
  }
  return changed;
}

/* ---------------------------------------------------------------------- */

int ComputePeridemAtom::pack_forward_comm(int n, int *list, double *buf, int, int *)
{
  for (int m = 0; m < n; m++) buf[m] = piece[list[m]];
  return n;
}

/* ---------------------------------------------------------------------- */

void ComputePeridemAtom::unpack_forward_comm(int n, int first, double *buf)
{
  for (int m = 0; m < n; m++) piece[first + m] = buf[m];
}

/* ---------------------------------------------------------------------- */

double ComputePeridemAtom::memory_usage()
{
  return static_cast<double>(nmax) * fields.size() * sizeof(double);
}
