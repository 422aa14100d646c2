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
#include "memory.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

// the six stresses come last, in the order of PairPeridem::stress()
enum { DAMAGE, STRETCH, DILATATION, ENERGY, BONDS, SURFACE, FRAGMENT, SXX };
static const std::vector<std::string> field_names = {
    "damage", "stretch", "dilatation", "energy", "bonds", "surface", "fragment",
    "sxx",    "syy",     "szz",        "sxy",    "sxz",   "syz"};

// A node belongs to the surface when the mean direction to the nodes of its family is at least this
// long. On square and cubic lattices with horizons of 2 to 4 spacings it is 0.43 to 0.53 (2d) and
// 0.32 to 0.41 (3d) in the first layer of a flat face, more on edges, and at most 0.31 (2d) and
// 0.22 (3d) in the second layer.
static constexpr double ONE_SIDED_2D = 0.38;
static constexpr double ONE_SIDED_3D = 0.28;

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
  double **X = atom->x0;
  double mean[3] = {0.0, 0.0, 0.0};
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const double *const Xj = X[bonds->partner[k]];
    double d[3] = {Xj[0] - X[i][0], Xj[1] - X[i][1], Xj[2] - X[i][2]};
    PeridemCompat::minimum_image(domain, d);
    for (int m = 0; m < 3; m++) mean[m] += d[m] / bonds->length[k];
  }
  const double length =
      std::sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]) / bonds->num[i];
  return length > (domain->dimension == 2 ? ONE_SIDED_2D : ONE_SIDED_3D) ? 1.0 : 0.0;
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
  bool changed = false;
  for (int i = 0; i < atom->nlocal; i++) {
    double least = piece[i];
    const bigint begin = bonds->start[i], end = begin + MAX(bonds->num[i], 0);
    for (bigint k = begin; k < end; k++) least = MIN(least, piece[bonds->partner[k]]);
    if (least < piece[i]) {
      piece[i] = least;
      changed = true;
    }
    for (bigint k = begin; k < end; k++) {
      const int j = bonds->partner[k];
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
