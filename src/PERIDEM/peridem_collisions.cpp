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

#include "peridem_collisions.h"

#include "peridem_messages.h"

#include "comm.h"

#include <algorithm>
#include <utility>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

static bool before(const PeridemCollision &a, const PeridemCollision &b)
{
  return a.low != b.low ? a.low < b.low : a.high < b.high;
}

/* ---------------------------------------------------------------------- */

void PeridemCollisions::add(tagint a, tagint b, double force, double approach, double peak,
                            double share, bool seen_elsewhere)
{
  auto &where = seen_elsewhere ? abroad : list;
  where.push_back({MIN(a, b), MAX(a, b), share * force, share * force * approach, peak});
}

/* ---------------------------------------------------------------------- */

void PeridemCollisions::merge()
{
  if (comm->nprocs > 1) {
    compress(abroad);
    abroad = PeridemMessages::gather(world, std::move(abroad));    // in the order of the ranks
  }
  list.insert(list.end(), abroad.begin(), abroad.end());
  compress(list);
}

/* ----------------------------------------------------------------------
   one entry for each collision; stable, so that all ranks sum in the same order
------------------------------------------------------------------------- */

void PeridemCollisions::compress(std::vector<PeridemCollision> &list)
{
  std::stable_sort(list.begin(), list.end(), before);
  std::size_t kept = 0;
  for (std::size_t n = 0; n < list.size(); n++) {
    if (kept == 0 || before(list[kept - 1], list[n])) {
      list[kept++] = list[n];
      continue;
    }
    auto &same = list[kept - 1];
    same.force += list[n].force;
    same.power += list[n].power;
    same.peak = MAX(same.peak, list[n].peak);
  }
  list.resize(kept);
}

/* ---------------------------------------------------------------------- */

const PeridemCollision &PeridemCollisions::of(tagint a, tagint b) const
{
  const PeridemCollision wanted = {MIN(a, b), MAX(a, b), 0.0, 0.0, 0.0};
  return *std::lower_bound(list.begin(), list.end(), wanted, before);
}
