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

#include "peridem_adapt_grain.h"

#include "math_extra.h"

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

double PeridemAdaptGrain::felt_mass(int dimension) const
{
  // in the plane it turns about its normal alone, whose moment is the largest
  double moment = 0.0;
  for (const double one : body.inertia)
    if (one > 0.0 && (moment == 0.0 || (dimension == 2) == (one > moment))) moment = one;
  return 1.0 / (1.0 / body.mass + (moment > 0.0 ? reach * reach / moment : 0.0));
}

/* ---------------------------------------------------------------------- */

void PeridemMoments::add(double m, const double *r, const double *v)
{
  double turning[3];
  MathExtra::cross3(r, v, turning);
  mass += m;
  for (int k = 0; k < 3; k++) {
    first[k] += m * r[k];
    momentum[k] += m * v[k];
    spin[k] += m * turning[k];
    second[k] += m * r[k] * r[k];
  }
  second[3] += m * r[0] * r[1];
  second[4] += m * r[0] * r[2];
  second[5] += m * r[1] * r[2];
  kinetic += 0.5 * m * MathExtra::lensq3(v);
}

/* ---------------------------------------------------------------------- */

void PeridemMoments::to_body(PeridemRigidBody &body) const
{
  double c[3], s[6], turning[3];
  body.mass = mass;
  for (int k = 0; k < 3; k++) {
    c[k] = first[k] / mass;
    body.x[k] += c[k];
    body.v[k] = momentum[k] / mass;
  }
  MathExtra::cross3(c, momentum, turning);
  for (int k = 0; k < 3; k++) {
    body.l[k] = spin[k] - turning[k];
    s[k] = second[k] - mass * c[k] * c[k];
  }
  s[3] = second[3] - mass * c[0] * c[1];
  s[4] = second[4] - mass * c[0] * c[2];
  s[5] = second[5] - mass * c[1] * c[2];
  const double tensor[6] = {s[1] + s[2], s[0] + s[2], s[0] + s[1], -s[3], -s[4], -s[5]};
  body.orient(tensor);
}
