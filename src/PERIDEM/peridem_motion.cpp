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

#include "peridem_motion.h"

using namespace LAMMPS_NS;

// nodes are on one line if their smallest moment of inertia is this small a part of the others
static constexpr double THIN = 1e-10;

// what is left of a moment of inertia about the centre of mass is rounding below this part of that
// about the origin of the sums
static constexpr double ROUNDING = 1e-12;

/* ---------------------------------------------------------------------- */

static void add_cross(const double *a, const double *b, double factor, double *sum)
{
  sum[0] += factor * (a[1] * b[2] - a[2] * b[1]);
  sum[1] += factor * (a[2] * b[0] - a[0] * b[2]);
  sum[2] += factor * (a[0] * b[1] - a[1] * b[0]);
}

static void add_inertia(double m, const double *r, double *tensor)
{
  tensor[0] += m * (r[1] * r[1] + r[2] * r[2]);
  tensor[1] += m * (r[0] * r[0] + r[2] * r[2]);
  tensor[2] += m * (r[0] * r[0] + r[1] * r[1]);
  tensor[3] -= m * r[0] * r[1];
  tensor[4] -= m * r[0] * r[2];
  tensor[5] -= m * r[1] * r[2];
}

static void multiply(const double *t, const double *v, double *result)
{
  result[0] = t[0] * v[0] + t[3] * v[1] + t[4] * v[2];
  result[1] = t[3] * v[0] + t[1] * v[1] + t[5] * v[2];
  result[2] = t[4] * v[0] + t[5] * v[1] + t[2] * v[2];
}

/* ----------------------------------------------------------------------
   from sums about the origin to those about the centre of mass
------------------------------------------------------------------------- */

PeridemMotion::PeridemMotion(const PeridemSums &sums, const double *origin) : mass(sums.mass)
{
  double c[3], momentum[3];
  for (int k = 0; k < 3; k++) {
    c[k] = sums.place[k] / sums.mass;
    place[k] = origin[k] + c[k];
    velocity[k] = sums.velocity[k] / sums.mass;
    momentum[k] = sums.momentum[k];
  }
  add_cross(c, velocity, -sums.mass, momentum);

  const double *const q = sums.square;
  double inertia[6] = {q[1] + q[2], q[0] + q[2], q[0] + q[1], -q[3], -q[4], -q[5]};
  const double before = q[0] + q[1] + q[2];
  add_inertia(-sums.mass, c, inertia);
  if (0.5 * (inertia[0] + inertia[1] + inertia[2]) > ROUNDING * before) turn(momentum, inertia);
}

/* ----------------------------------------------------------------------
   nodes on one line do not turn about it, and a single node does not turn at all
------------------------------------------------------------------------- */

void PeridemMotion::turn(const double *momentum, const double *I)
{
  const double half = 0.5 * (I[0] + I[1] + I[2]);
  if (!(half > 0.0)) return;
  const double minor[6] = {I[1] * I[2] - I[5] * I[5], I[0] * I[2] - I[4] * I[4],
                           I[0] * I[1] - I[3] * I[3], I[4] * I[5] - I[2] * I[3],
                           I[3] * I[5] - I[1] * I[4], I[3] * I[4] - I[0] * I[5]};
  const double determinant = I[0] * minor[0] + I[3] * minor[3] + I[4] * minor[4];
  const bool line = determinant < THIN * half * half * half;
  for (int k = 0; k < 6; k++) inverse[k] = line ? I[k] / (half * half) : minor[k] / determinant;
  multiply(inverse, momentum, spin);
}

/* ---------------------------------------------------------------------- */

void PeridemMotion::velocity_at(const double *arm, double *v) const
{
  for (int k = 0; k < 3; k++) v[k] = velocity[k];
  add_cross(spin, arm, 1.0, v);
}

/* ---------------------------------------------------------------------- */

void PeridemMotion::angular_acceleration(const double *torque, double *a) const
{
  multiply(inverse, torque, a);
}

/* ----------------------------------------------------------------------
   an impulse along n at the node pushes the whole body and turns it
------------------------------------------------------------------------- */

double PeridemBody::mobility_along(const double *n) const
{
  double torque[3] = {}, turned[3];
  add_cross(n, offset, 1.0, torque);           // arm x n, the arm being -offset
  if (torque[0] == 0.0 && torque[1] == 0.0)    // in 2d always
    return lightness + inverse[2] * torque[2] * torque[2];
  multiply(inverse, torque, turned);
  return lightness + torque[0] * turned[0] + torque[1] * turned[1] + torque[2] * turned[2];
}
