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

#include "peridem_load.h"

#include "math_eigen.h"

#include <algorithm>
#include <array>
#include <cmath>

using namespace LAMMPS_NS;

/* ----------------------------------------------------------------------
   of the symmetric part of the moment: xx, yy, zz, xy, xz, yz
------------------------------------------------------------------------- */

static std::array<double, 6> symmetric(const double *m, double volume)
{
  return {m[0] / volume,
          m[4] / volume,
          m[8] / volume,
          0.5 * (m[1] + m[3]) / volume,
          0.5 * (m[2] + m[6]) / volume,
          0.5 * (m[5] + m[7]) / volume};
}

/* ---------------------------------------------------------------------- */

double PeridemLoad::average_stress(double volume) const
{
  const auto s = symmetric(moment, volume);
  if (s[2] == 0.0 && s[4] == 0.0 && s[5] == 0.0)    // in the plane
    return 0.5 * std::fabs(s[0] + s[1]) + std::hypot(0.5 * (s[0] - s[1]), s[3]);
  const double stress[3][3] = {{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}};
  double principal[3], axes[3][3];
  MathEigen::jacobi3(stress, principal, axes);
  return std::max({std::fabs(principal[0]), std::fabs(principal[1]), std::fabs(principal[2])});
}

/* ----------------------------------------------------------------------
   the root of all squares
------------------------------------------------------------------------- */

double PeridemLoad::stress_at_most(double volume) const
{
  const auto s = symmetric(moment, volume);
  return std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2] +
                   2.0 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}
