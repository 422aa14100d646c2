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

#include "peridem_adapt_table.h"

#include "fix_peridem_bonds.h"
#include "pair_peridem.h"
#include "peridem_load.h"

#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "math_const.h"
#include "math_extra.h"
#include "memory.h"
#include "modify.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// of a grain, over its nodes; nothing but doubles, for MPI
struct PeridemAdaptTable::Sums {
  double volume, mass, place[3];    // the latter times mass
  double broken, nodes;             // numbers of bonds, nodes
};

// the most easily stretched and broken of its types
struct PeridemAdaptTable::Weakest {
  double young{INFINITE}, s0{INFINITE};
  double tension_only{INFINITE};    // -1 where bonds break in compression too
};

template <class T> static int doubles(const std::vector<T> &list)
{
  return static_cast<int>(list.size() * sizeof(T) / sizeof(double));
}

/* ---------------------------------------------------------------------- */

PeridemAdaptTable::PeridemAdaptTable(LAMMPS *lmp, int which, const PeridemAdaptOptions &words) :
    Pointers(lmp), igroup(which), groupbit(lmp->group->bitmask[which]), options(words)
{
  first.assign(2, 0);
}

/* ---------------------------------------------------------------------- */

PeridemAdaptTable::~PeridemAdaptTable()
{
  memory->destroy(offset);
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptTable::find_styles()
{
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
  solids = PairPeridem::find_all(lmp);
}

/* ---------------------------------------------------------------------- */

bool PeridemAdaptTable::bonded(int i) const
{
  return bonds && bonds->num[i] > 0;
}

/* ----------------------------------------------------------------------
   a rigid grain is moved by the forces on all of its nodes
------------------------------------------------------------------------- */

void PeridemAdaptTable::check_whole()
{
  tagint highest = 0;
  for (int i = 0; i < atom->nlocal; i++) highest = MAX(highest, atom->molecule[i]);
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  std::vector<int> outside(highest + 1, 0), inside(highest + 1, 0);
  for (int i = 0; i < atom->nlocal; i++) (in_group(i) ? inside : outside)[atom->molecule[i]]++;
  MPI_Allreduce(MPI_IN_PLACE, inside.data(), highest + 1, MPI_INT, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, outside.data(), highest + 1, MPI_INT, MPI_SUM, world);
  for (tagint mol = 1; mol <= highest; mol++)
    if (inside[mol] && outside[mol])
      error->all(FLERR, Error::NOLASTLINE,
                 "Fix peridem/adapt: grain {} has {} nodes in group {} and {} that are not: whole "
                 "grains only",
                 mol, inside[mol], group->names[igroup], outside[mol]);
}

/* ---------------------------------------------------------------------- */

tagint PeridemAdaptTable::highest_molecule() const
{
  tagint highest = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (in_group(i)) highest = MAX(highest, atom->molecule[i]);
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  return highest;
}

/* ----------------------------------------------------------------------
   volume, centre, moduli, strength of grains that are not in the table yet
------------------------------------------------------------------------- */

void PeridemAdaptTable::survey()
{
  grains.resize(highest_molecule() + 1, Grain());
  std::vector<Sums> sums(grains.size(), Sums());
  std::vector<Weakest> weakest(grains.size());
  for (int i = 0; i < atom->nlocal; i++) {
    if (!in_group(i)) continue;
    add_node(i, sums[atom->molecule[i]]);
    weaken(i, weakest[atom->molecule[i]]);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), doubles(sums), MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, weakest.data(), doubles(weakest), MPI_DOUBLE, MPI_MIN, world);

  for (std::size_t mol = 1; mol < grains.size(); mol++)
    if (sums[mol].mass > 0.0 && grains[mol].state == Grain::NONE)
      grains[mol] = new_grain(sums[mol], weakest[mol]);
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptTable::add_node(int i, Sums &s) const
{
  const double zero[3] = {0.0, 0.0, 0.0};
  double x[3];
  place_from(i, zero, x);
  s.volume += atom->vfrac[i];
  s.mass += atom->rmass[i];
  for (int k = 0; k < 3; k++) s.place[k] += atom->rmass[i] * x[k];
  if (bonds) s.broken += bonds->nref[i] - MAX(bonds->num[i], 0);
  s.nodes += 1.0;
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptTable::weaken(int i, Weakest &w) const
{
  const int itype = atom->type[i];
  for (const auto *solid : solids) {
    if (!solid->covers(itype)) continue;
    const auto &mat = solid->material(itype, itype);
    w.young = MIN(w.young, 9.0 * mat.bulk * mat.shear / (3.0 * mat.bulk + mat.shear));
    w.s0 = MIN(w.s0, mat.s0);
    w.tension_only = MIN(w.tension_only, mat.break_both ? -1.0 : 1.0);
  }
}

/* ---------------------------------------------------------------------- */

PeridemAdaptGrain PeridemAdaptTable::new_grain(const Sums &sums, const Weakest &weakest) const
{
  Grain grain = Grain();
  grain.state = Grain::DEFORMABLE;
  grain.patience = 1;
  grain.broken = sums.broken > 0.0;
  grain.count = static_cast<int>(sums.nodes);
  grain.volume = sums.volume;
  for (int k = 0; k < 3; k++) grain.body.x[k] = sums.place[k] / sums.mass;
  grain.young = weakest.young;
  grain.factor = weakest.tension_only < 0.0 ? PeridemLoad::FACTOR_BOTH
                                            : PeridemLoad::FACTOR_TENSION;
  grain.s0 = weakest.s0;
  grain.size = domain->dimension == 2 ? 2.0 * std::sqrt(sums.volume / MathConst::MY_PI)
                                      : std::cbrt(6.0 * sums.volume / MathConst::MY_PI);
  grain.speed = std::sqrt(force->ftm2v * weakest.young * sums.volume / sums.mass);
  set_limits(grain);
  return grain;
}

/* ----------------------------------------------------------------------
   the stretch that wakes a grain; a grain without bonds has nothing that could be stretched
------------------------------------------------------------------------- */

void PeridemAdaptTable::set_limits(Grain &grain) const
{
  grain.limit = options.stretch > 0.0 ? options.stretch : options.eta * grain.s0;
  if (!std::isfinite(grain.young)) {
    grain.limit = INFINITE;
    grain.speed = grain.size = 1.0;
  } else if (!std::isfinite(grain.s0) && options.stretch == 0.0)
    error->all(FLERR, Error::NOLASTLINE,
               "Fix peridem/adapt: there are unbreakable grains, so eta says nothing: give "
               "stretch");
}

/* ----------------------------------------------------------------------
   keeps the order that nodes have
------------------------------------------------------------------------- */

void PeridemAdaptTable::sort_nodes()
{
  const int nlocal = atom->nlocal;
  const tagint *const mol = atom->molecule;
  first.assign(grains.size() + 1, 0);
  for (int i = 0; i < nlocal; i++)
    if (in_group(i)) first[mol[i] + 1]++;
  for (std::size_t k = 1; k < first.size(); k++) first[k] += first[k - 1];
  sorted.resize(first.back());
  std::vector<int> next(first);
  for (int i = 0; i < nlocal; i++)
    if (in_group(i)) sorted[next[mol[i]]++] = i;
}

/* ---------------------------------------------------------------------- */

std::vector<tagint> PeridemAdaptTable::listed(int state) const
{
  std::vector<tagint> list;
  for (tagint mol = 1; mol <= highest(); mol++)
    if (grains[mol].state == state) list.push_back(mol);
  return list;
}

/* ---------------------------------------------------------------------- */

bool PeridemAdaptTable::any(int state) const
{
  return std::any_of(grains.begin(), grains.end(), [state](const Grain &grain) {
    return grain.state == state;
  });
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptTable::place_from(int i, const double *point, double *r) const
{
  domain->unmap(atom->x[i], atom->image[i], r);
  for (int k = 0; k < 3; k++) r[k] -= point[k];
}

/* ---------------------------------------------------------------------- */

std::vector<PeridemMoments> PeridemAdaptTable::moments(const std::vector<tagint> &which) const
{
  std::vector<PeridemMoments> all(which.size(), PeridemMoments());
  for (std::size_t k = 0; k < which.size(); k++)
    for (const int i : nodes(which[k])) {
      double r[3];
      place_from(i, grains[which[k]].body.x, r);
      all[k].add(atom->rmass[i], r, atom->v[i]);
    }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()) * PeridemMoments::SIZE,
                MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/* ---------------------------------------------------------------------- */

std::vector<double> PeridemAdaptTable::strain_energies(const std::vector<tagint> &which) const
{
  std::vector<double> strain(which.size(), 0.0);
  for (const auto *solid : solids)
    for (std::size_t k = 0; k < which.size(); k++)
      for (const int i : nodes(which[k]))
        if (solid->covers(atom->type[i])) strain[k] += solid->strain_energy(i);
  MPI_Allreduce(MPI_IN_PLACE, strain.data(), static_cast<int>(strain.size()), MPI_DOUBLE, MPI_SUM,
                world);
  return strain;
}

/* ---------------------------------------------------------------------- */

double PeridemAdaptTable::largest_stretch(tagint mol) const
{
  double **x = atom->x;
  double largest = 0.0;
  for (const int i : nodes(mol)) {
    if (!bonds || bonds->num[i] < 0) continue;
    if (bonds->num[i] < bonds->nref[i]) return INFINITE;
    for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
      const double *const xj = x[bonds->partner(i, k)];
      const double d[3] = {xj[0] - x[i][0], xj[1] - x[i][1], xj[2] - x[i][2]};
      largest = MAX(largest, std::fabs(MathExtra::len3(d) / bonds->length[k] - 1.0));
    }
  }
  return largest;
}
