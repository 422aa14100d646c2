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
#include <cmath>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

void PeridemLoad::clear()
{
  std::fill_n(moment, 9, 0.0);
  node = 0.0;
}

/* ---------------------------------------------------------------------- */

void PeridemLoad::add(const double *force, const double *r)
{
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) moment[3 * a + b] += force[a] * r[b];
}

/* ---------------------------------------------------------------------- */

double PeridemLoad::average_stress(double volume) const
{
  double stress[3][3], principal[3], axes[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      stress[a][b] = 0.5 * (moment[3 * a + b] + moment[3 * b + a]) / volume;
  MathEigen::jacobi3(stress, principal, axes);
  return std::max({std::fabs(principal[0]), std::fabs(principal[1]), std::fabs(principal[2])});
}
