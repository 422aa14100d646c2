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

#include "peridem_wall_list.h"

#include "peridem_surface.h"
#include "peridem_wall_motion.h"

#include "atom.h"
#include "neighbor.h"

#include <cmath>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   Between two neighbor lists a node moves by half the skin, so by no more than the skin since any
   time in between; the wall may move by the skin too.
------------------------------------------------------------------------- */

void PeridemWallList::build(PeridemSurface &surface, const PeridemWallMotion &motion, int groupbit,
                            double radius)
{
  const double reach = radius + 2.0 * neighbor->skin;
  surface.mark();
  near.clear();
  for (int m = 0; m < 3; m++) {
    shift[m] = motion.shift[m];
    low[m] = HUGE_VAL;
    high[m] = -HUGE_VAL;
  }
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    double x[3];    // as if the wall had not moved
    for (int m = 0; m < 3; m++) {
      x[m] = atom->x[i][m] - shift[m];
      low[m] = MIN(low[m], x[m] - reach);
      high[m] = MAX(high[m], x[m] + reach);
    }
    if (surface.near(x, reach)) near.push_back(i);
  }
}

/* ---------------------------------------------------------------------- */

bool PeridemWallList::stale(const PeridemSurface &surface, const PeridemWallMotion &motion) const
{
  if (low[0] > high[0]) return false;    // no nodes here
  double way = 0.0;
  for (int m = 0; m < 3; m++) way += (motion.shift[m] - shift[m]) * (motion.shift[m] - shift[m]);
  return std::sqrt(way) + surface.drift(low, high) > neighbor->skin;
}
