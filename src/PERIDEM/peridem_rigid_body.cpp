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

#include "peridem_rigid_body.h"

#include "math_eigen.h"
#include "math_extra.h"

#include <algorithm>

using namespace LAMMPS_NS;

// a principal moment below this part of the largest one is 0: nodes in a line do not spin about it
static constexpr double NO_MOMENT = 1.0e-7;

/* ---------------------------------------------------------------------- */

void PeridemRigidBody::orient(const double *t)
{
  const double matrix[3][3] = {{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}};
  double axes[3][3];
  MathEigen::jacobi3(matrix, inertia, axes);
  const double largest = std::max({inertia[0], inertia[1], inertia[2]});
  for (double &moment : inertia)
    if (moment < NO_MOMENT * largest) moment = 0.0;
  for (int k = 0; k < 3; k++) {
    ex[k] = axes[k][0];
    ey[k] = axes[k][1];
    ez[k] = axes[k][2];
  }
  double right[3];    // the axes must be right-handed
  MathExtra::cross3(ex, ey, right);
  if (MathExtra::dot3(right, ez) < 0.0) MathExtra::negate3(ez);
  MathExtra::exyz_to_q(ex, ey, ez, q);
  MathExtra::angmom_to_omega(l, ex, ey, ez, inertia, omega);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidBody::kick(double dtf)
{
  for (int k = 0; k < 3; k++) {
    v[k] += dtf / mass * force[k];
    l[k] += dtf * torque[k];
  }
  MathExtra::angmom_to_omega(l, ex, ey, ez, inertia, omega);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidBody::drift(double dtv, double dtq)
{
  for (int k = 0; k < 3; k++) x[k] += dtv * v[k];
  MathExtra::richardson(q, l, omega, inertia, dtq);
  MathExtra::q_to_exyz(q, ex, ey, ez);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidBody::to_body(const double *r, double *d) const
{
  MathExtra::transpose_matvec(ex, ey, ez, r, d);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidBody::to_space(const double *d, double *r) const
{
  MathExtra::matvec(ex, ey, ez, d, r);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidBody::velocity(const double *r, double *u) const
{
  u[0] = v[0] + omega[1] * r[2] - omega[2] * r[1];
  u[1] = v[1] + omega[2] * r[0] - omega[0] * r[2];
  u[2] = v[2] + omega[0] * r[1] - omega[1] * r[0];
}

/* ---------------------------------------------------------------------- */

double PeridemRigidBody::kinetic() const
{
  return 0.5 * mass * MathExtra::lensq3(v) + 0.5 * MathExtra::dot3(omega, l);
}

/* ----------------------------------------------------------------------
   - sum m (w x (w x r)) (x) r = sum m (w^2 r - w (w r)) (x) r
------------------------------------------------------------------------- */

void PeridemRigidBody::add_spinning(double *moment) const
{
  const double trace = 0.5 * (inertia[0] + inertia[1] + inertia[2]);
  const double *const axes[3] = {ex, ey, ez};
  double second[3][3] = {};    // sum m r (x) r
  for (int n = 0; n < 3; n++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++) second[a][b] += (trace - inertia[n]) * axes[n][a] * axes[n][b];
  const double square = MathExtra::lensq3(omega);
  double along[3];
  MathExtra::matvec(second, omega, along);
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) moment[3 * a + b] += square * second[a][b] - omega[a] * along[b];
}
