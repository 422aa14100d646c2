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

#include "peridem_surface_plane.h"

#include "domain.h"
#include "error.h"

#include <cmath>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

PeridemSurfacePlane::PeridemSurfacePlane(LAMMPS *lmp, const char *style, int iarg, int narg,
                                         char **arg) : PeridemSurface(lmp), whole(1)
{
  if (iarg + 6 >= narg)
    error->all(FLERR, iarg, "Fix {} plane needs six numbers: x y z nx ny nz", style);
  for (int k = 0; k < 6; k++) {
    const double value = utils::numeric(FLERR, arg[iarg + 1 + k], false, lmp);
    if (!std::isfinite(value))
      error->all(FLERR, iarg + 1 + k, "Fix {} plane {}: must be finite", style, arg[iarg + 1 + k]);
    (k < 3 ? point[k] : normal[k - 3]) = value;
  }

  const double length =
      std::sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  if (length == 0.0) error->all(FLERR, iarg + 4, "Fix {} plane: the normal is zero", style);
  for (int k = 0; k < 3; k++) {
    normal[k] /= length;
    whole[0].point[k] = point[k];
    if (normal[k] == 0.0) continue;
    if (domain->dimension == 2 && k == 2)
      error->all(FLERR, iarg + 6, "Fix {} plane: nz must be 0 in a 2d simulation", style);
    if (domain->periodicity[k])
      error->all(FLERR, iarg + 4 + k,
                 "Fix {} plane: the box is periodic in {}, which the plane cuts", style, "xyz"[k]);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemSurfacePlane::feet(const double *x, double cutoff, std::vector<Foot> &list)
{
  const double gap = distance(x);
  if (gap >= cutoff) return;
  Foot foot{};
  foot.distance = gap;
  for (int k = 0; k < 3; k++) {
    foot.normal[k] = normal[k];
    foot.at[k] = x[k] - gap * normal[k];
  }
  list.push_back(foot);
}

/* ---------------------------------------------------------------------- */

void PeridemSurfacePlane::centre(double *where) const
{
  for (int k = 0; k < 3; k++) where[k] = point[k];
}
