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
static constexpr int NSUMS = 7;    // volume, mass, three of place, broken bonds, nodes
static constexpr int NWEAKEST =
    3;    // Young's modulus, critical stretch, -1 where both signs break

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
  const auto n = grains.size();
  std::vector<double> sum(NSUMS * n, 0.0), weakest(NWEAKEST * n, INFINITE);
  const double zero[3] = {0.0, 0.0, 0.0};
  for (int i = 0; i < atom->nlocal; i++) {
    if (!in_group(i)) continue;
    double x[3], *const s = &sum[NSUMS * atom->molecule[i]];
    double *const w = &weakest[NWEAKEST * atom->molecule[i]];
    place_from(i, zero, x);
    s[0] += atom->vfrac[i];
    s[1] += atom->rmass[i];
    for (int k = 0; k < 3; k++) s[2 + k] += atom->rmass[i] * x[k];
    s[6] += 1.0;
    if (bonds) s[5] += bonds->nref[i] - MAX(bonds->num[i], 0);
    const int itype = atom->type[i];
    for (const auto *solid : solids) {
      if (!solid->covers(itype)) continue;
      const auto &mat = solid->material(itype, itype);
      w[0] = MIN(w[0], 9.0 * mat.bulk * mat.shear / (3.0 * mat.bulk + mat.shear));
      w[1] = MIN(w[1], mat.s0);
      w[2] = MIN(w[2], mat.break_both ? -1.0 : 1.0);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), static_cast<int>(sum.size()), MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, weakest.data(), static_cast<int>(weakest.size()), MPI_DOUBLE, MPI_MIN,
                world);

  for (std::size_t mol = 1; mol < n; mol++)
    if (sum[NSUMS * mol + 1] > 0.0 && grains[mol].state == Grain::NONE)
      grains[mol] = new_grain(&sum[NSUMS * mol], &weakest[NWEAKEST * mol]);
}

/* ---------------------------------------------------------------------- */

PeridemAdaptGrain PeridemAdaptTable::new_grain(const double *sum, const double *weakest) const
{
  Grain grain = Grain();
  grain.state = Grain::DEFORMABLE;
  grain.patience = 1;
  grain.broken = sum[5] > 0.0;
  grain.count = static_cast<int>(sum[6]);
  grain.volume = sum[0];
  for (int k = 0; k < 3; k++) grain.body.x[k] = sum[2 + k] / sum[1];
  grain.young = weakest[0];
  grain.factor = weakest[2] < 0.0 ? PeridemLoad::FACTOR_BOTH : PeridemLoad::FACTOR_TENSION;
  grain.s0 = weakest[1];
  grain.size = domain->dimension == 2 ? 2.0 * std::sqrt(sum[0] / MathConst::MY_PI)
                                      : std::cbrt(6.0 * sum[0] / MathConst::MY_PI);
  grain.speed = std::sqrt(force->ftm2v * weakest[0] * sum[0] / sum[1]);
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
      const double *const xj = x[bonds->partner[k]];
      const double d[3] = {xj[0] - x[i][0], xj[1] - x[i][1], xj[2] - x[i][2]};
      largest = MAX(largest, std::fabs(MathExtra::len3(d) / bonds->length[k] - 1.0));
    }
  }
  return largest;
}
