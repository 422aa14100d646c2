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

#include "atom.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

enum { DAMAGE, STRETCH, DILATATION, ENERGY, BONDS };
static const std::vector<std::string> field_names = {"damage", "stretch", "dilatation", "energy",
                                                     "bonds"};

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
               "Compute {} {} needs a pair style of a peridem solid, such as peridem/lps", id, style);
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
  const auto *mine = solid(i);
  if (!mine) return 0.0;
  switch (field) {
    case DAMAGE:
      return damage(i);
    case STRETCH:
      return bonds->maxstretch[i];
    case DILATATION:
      return mine->dilatation(i);
    case ENERGY:
      return mine->strain_energy(i);
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

/* ---------------------------------------------------------------------- */

double ComputePeridemAtom::memory_usage()
{
  return static_cast<double>(nmax) * fields.size() * sizeof(double);
}
