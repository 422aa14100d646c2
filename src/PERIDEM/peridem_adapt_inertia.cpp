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

#include "peridem_adapt_inertia.h"

#include "atom.h"
#include "domain.h"
#include "fix_setforce.h"
#include "modify.h"

#include <limits>

using namespace LAMMPS_NS;

static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// Stable is not exact: the bonds keep the steps of deformable grains short, the collisions of rigid
// ones are resolved by taking them for lighter than they are, so with twice the steps
static constexpr double RESOLVED = 4.0;

/* ---------------------------------------------------------------------- */

PeridemAdaptInertia::PeridemAdaptInertia(LAMMPS *lmp, const PeridemAdaptTable &grains) :
    Pointers(lmp), table(grains)
{
}

/* ----------------------------------------------------------------------
   nodes that no fix integrates stay; those of fix move and nve/noforce go their way; so do those of a
   fix setforce that leaves no direction to the forces of others
------------------------------------------------------------------------- */

void PeridemAdaptInertia::find_prescribed()
{
  free_bits = held_bits = 0;
  for (const auto *fix : modify->get_fix_list()) {
    const bool told = utils::strmatch(fix->style, "^move") ||
        utils::strmatch(fix->style, "^nve/noforce");
    if (fix->time_integrate && !told) free_bits |= fix->groupbit;
    if (holds(fix)) held_bits |= fix->groupbit;
  }
}

/* ---------------------------------------------------------------------- */

namespace {

struct SetForce : public FixSetForce {    // names what is protected in the fix
  static bool all(const FixSetForce &fix, int dimension)
  {
    return fix.*(&SetForce::xstyle) && fix.*(&SetForce::ystyle) &&
        (dimension == 2 || fix.*(&SetForce::zstyle)) && !(fix.*(&SetForce::idregion));
  }
};

}    // namespace

bool PeridemAdaptInertia::holds(const Fix *fix) const
{
  if (utils::strmatch(fix->style, "^freeze")) return true;
  const auto *const setter = dynamic_cast<const FixSetForce *>(fix);
  return setter && SetForce::all(*setter, domain->dimension);
}

/* ---------------------------------------------------------------------- */

double PeridemAdaptInertia::felt_mass(int i) const
{
  if (table.rigid(i))
    return table.grains[atom->molecule[i]].felt_mass(domain->dimension) / RESOLVED;
  return prescribed(i) ? INFINITE : atom->rmass[i];
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptInertia::find_lightest()
{
  lightest_of.assign(atom->ntypes + 1, INFINITE);
  for (int i = 0; i < atom->nlocal; i++) {
    double &least = lightest_of[atom->type[i]];
    least = MIN(least, felt_mass(i));
  }
  MPI_Allreduce(MPI_IN_PLACE, lightest_of.data(), atom->ntypes + 1, MPI_DOUBLE, MPI_MIN, world);
}

/* ----------------------------------------------------------------------
   as Gershgorin's bound for nodes: twice all springs at a body over what it weighs where they push;
   half as much again for the contacts that come before the next look
------------------------------------------------------------------------- */

double PeridemAdaptInertia::largest_frequency_sq() const
{
  std::vector<double> all(springs);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, world);
  double largest = 0.0;
  for (std::size_t mol = 0; mol < all.size(); mol++)
    if (table.grains[mol].rigid())
      largest =
          MAX(largest, 3.0 * RESOLVED * all[mol] / table.grains[mol].felt_mass(domain->dimension));
  return largest;
}
