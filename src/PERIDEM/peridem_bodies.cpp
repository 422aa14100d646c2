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

#include "peridem_bodies.h"

#include "fix_peridem_bonds.h"

#include "atom.h"
#include "domain.h"
#include "error.h"

#include <algorithm>

using namespace LAMMPS_NS;

// a table by molecule-ID beyond this would not fit beside a simulation
static constexpr tagint MAXGRAIN = 20000000;

// nodes are on one line if their smallest moment of inertia is this small a part of the others
static constexpr double THIN = 1e-10;

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

/* ---------------------------------------------------------------------- */

void PeridemMotion::velocity_at(const double *arm, double *v) const
{
  for (int k = 0; k < 3; k++) v[k] = velocity[k];
  add_cross(spin, arm, 1.0, v);
}

/* ---------------------------------------------------------------------- */

void PeridemMotion::acceleration_at(const double *arm, const double *force, const double *torque,
                                    double *a) const
{
  double angular[3];
  multiply(inverse, torque, angular);
  for (int k = 0; k < 3; k++) a[k] = force[k] / mass;
  add_cross(angular, arm, 1.0, a);
}

/* ----------------------------------------------------------------------
   an impulse along each axis in turn
------------------------------------------------------------------------- */

void PeridemMotion::mobility_at(const double *arm, double *tensor) const
{
  double column[3][3];
  for (int k = 0; k < 3; k++) {
    double impulse[3] = {}, torque[3] = {};
    impulse[k] = 1.0;
    add_cross(arm, impulse, 1.0, torque);
    acceleration_at(arm, impulse, torque, column[k]);
  }
  for (int k = 0; k < 3; k++) tensor[k] = column[k][k];
  tensor[3] = column[0][1];
  tensor[4] = column[0][2];
  tensor[5] = column[1][2];
}

/* ---------------------------------------------------------------------- */

double PeridemBody::mobility_along(const double *n) const
{
  double column[3];
  multiply(mobility, n, column);
  return n[0] * column[0] + n[1] * column[1] + n[2] * column[2];
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

PeridemBodies::PeridemBodies(LAMMPS *lmp) : Pointers(lmp) {}

/* ---------------------------------------------------------------------- */

void PeridemBodies::find(const FixPeridemBonds *_bonds)
{
  bonds = _bonds;
  if (natoms_seen != atom->natoms) find_highest();
  find_places();
  find_spins();
  pushes.assign(highest + 1, Push());
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::find_highest()
{
  natoms_seen = atom->natoms;
  highest = 0;
  for (int i = 0; i < atom->nlocal; i++) highest = MAX(highest, atom->molecule[i]);
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  if (highest > MAXGRAIN)
    error->all(FLERR, Error::NOLASTLINE,
               "restitution keeps a table by molecule-ID: {} is larger than {}; number the grains "
               "anew (reset_atoms mol)",
               highest, MAXGRAIN);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::find_places()
{
  unwrap();
  constexpr int N = 8;    // mass, place, velocity, broken bonds
  sums.assign(N * static_cast<std::size_t>(highest + 1), 0.0);
  for (int i = 0; i < atom->nlocal; i++) {
    double *const sum = &sums[N * atom->molecule[i]];
    const double m = atom->rmass[i], *const x = &arms[3 * i];
    sum[0] += m;
    for (int k = 0; k < 3; k++) {
      sum[1 + k] += m * x[k];
      sum[4 + k] += m * atom->v[i][k];
    }
    if (bonds) sum[7] += bonds->nref[i] - MAX(bonds->num[i], 0);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                world);
  grains.assign(highest + 1, PeridemMotion());
  broken.assign(highest + 1, 0);
  for (tagint mol = 0; mol <= highest; mol++) {
    const double *const sum = &sums[N * mol];
    auto &grain = grains[mol];
    broken[mol] = sum[7] != 0.0;
    if (!(sum[0] > 0.0)) continue;
    grain.mass = sum[0];
    for (int k = 0; k < 3; k++) {
      grain.place[k] = sum[1 + k] / sum[0];
      grain.velocity[k] = sum[4 + k] / sum[0];
    }
  }
  for (int i = 0; i < atom->nlocal; i++)
    for (int k = 0; k < 3; k++) arms[3 * i + k] -= grains[atom->molecule[i]].place[k];
}

/* ----------------------------------------------------------------------
   about the centres of mass: sums about the origin would lose digits far away from it
------------------------------------------------------------------------- */

void PeridemBodies::find_spins()
{
  constexpr int N = 9;    // angular momentum, tensor of inertia
  sums.assign(N * static_cast<std::size_t>(highest + 1), 0.0);
  for (int i = 0; i < atom->nlocal; i++) {
    if (!whole(i)) continue;
    double *const sum = &sums[N * atom->molecule[i]];
    const double *const arm = arm_of(i);
    add_cross(arm, atom->v[i], atom->rmass[i], sum);
    add_inertia(atom->rmass[i], arm, sum + 3);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                world);
  for (tagint mol = 1; mol <= highest; mol++) grains[mol].turn(&sums[N * mol], &sums[N * mol + 3]);
}

/* ---------------------------------------------------------------------- */

bool PeridemBodies::whole(int i) const
{
  const tagint mol = atom->molecule[i];
  return mol != 0 && !broken[mol];
}

/* ----------------------------------------------------------------------
   places of owned nodes in the open; find_places() makes arms of them
------------------------------------------------------------------------- */

void PeridemBodies::unwrap()
{
  arms.resize(3 * static_cast<std::size_t>(atom->nlocal));
  for (int i = 0; i < atom->nlocal; i++) domain->unmap(atom->x[i], atom->image[i], &arms[3 * i]);
}

/* ---------------------------------------------------------------------- */

PeridemBody PeridemBodies::body(int i) const
{
  PeridemBody body{};
  double arm[3];
  const PeridemMotion motion = whole(i) ? grains[atom->molecule[i]] : patch(i);
  for (int k = 0; k < 3; k++) arm[k] = whole(i) ? arm_of(i)[k] : atom->x[i][k] - motion.place[k];
  for (int k = 0; k < 3; k++) body.offset[k] = -arm[k];
  motion.velocity_at(arm, body.velocity);
  motion.mobility_at(arm, body.mobility);
  body.whole = whole(i);
  return body;
}

/* ----------------------------------------------------------------------
   the node and those that intact bonds tie to it
------------------------------------------------------------------------- */

template <class Visit> void PeridemBodies::for_patch(int i, Visit visit) const
{
  visit(i);
  if (!bonds) return;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
    visit(bonds->partner[k]);
}

/* ---------------------------------------------------------------------- */

PeridemMotion PeridemBodies::patch(int i) const
{
  double **x = atom->x, **v = atom->v;
  PeridemMotion patch;
  for_patch(i, [&](int j) {
    const double m = atom->rmass[j];
    patch.mass += m;
    for (int k = 0; k < 3; k++) {
      patch.place[k] += m * (x[j][k] - x[i][k]);
      patch.velocity[k] += m * v[j][k];
    }
  });
  for (int k = 0; k < 3; k++) {
    patch.place[k] = x[i][k] + patch.place[k] / patch.mass;
    patch.velocity[k] /= patch.mass;
  }

  double momentum[3] = {}, inertia[6] = {};
  for_patch(i, [&](int j) {
    double arm[3];
    for (int k = 0; k < 3; k++) arm[k] = x[j][k] - patch.place[k];
    add_cross(arm, v[j], atom->rmass[j], momentum);
    add_inertia(atom->rmass[j], arm, inertia);
  });
  patch.turn(momentum, inertia);
  return patch;
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::push(int i, const double *force, double *spread)
{
  if (!whole(i)) {
    push_patch(i, force, spread);
    return;
  }
  auto &push = pushes[atom->molecule[i]];
  for (int k = 0; k < 3; k++) push.force[k] += force[k];
  add_cross(arm_of(i), force, 1.0, push.torque);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::push_patch(int i, const double *force, double *spread) const
{
  const auto motion = patch(i);
  double arm[3], torque[3] = {};
  for (int k = 0; k < 3; k++) arm[k] = atom->x[i][k] - motion.place[k];
  add_cross(arm, force, 1.0, torque);
  for_patch(i, [&](int j) {
    double a[3], at[3];
    for (int k = 0; k < 3; k++) at[k] = atom->x[j][k] - motion.place[k];
    motion.acceleration_at(at, force, torque, a);
    for (int k = 0; k < 3; k++) spread[3 * j + k] += atom->rmass[j] * a[k];
  });
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::apply(double *f)
{
  const int count = static_cast<int>(pushes.size() * sizeof(Push) / sizeof(double));
  MPI_Allreduce(MPI_IN_PLACE, pushes.data(), count, MPI_DOUBLE, MPI_SUM, world);
  for (tagint mol = 1; mol <= highest; mol++) {    // from here on, accelerations
    auto &push = pushes[mol];
    if (!(grains[mol].mass > 0.0)) continue;
    double angular[3];
    multiply(grains[mol].inverse, push.torque, angular);
    for (int k = 0; k < 3; k++) {
      push.force[k] /= grains[mol].mass;
      push.torque[k] = angular[k];
    }
  }
  for (int i = 0; i < atom->nlocal; i++) {
    const auto &push = pushes[atom->molecule[i]];
    const double *const arm = arm_of(i), m = atom->rmass[i];
    for (int k = 0; k < 3; k++) f[3 * i + k] += m * push.force[k];
    add_cross(push.torque, arm, m, &f[3 * i]);
  }
  pushes.assign(pushes.size(), Push());
}

/* ---------------------------------------------------------------------- */

double PeridemBodies::memory_usage() const
{
  return static_cast<double>(grains.capacity()) * (sizeof(PeridemMotion) + 1) +
      static_cast<double>(pushes.capacity()) * sizeof(Push) +
      static_cast<double>(sums.capacity() + arms.capacity()) * sizeof(double);
}
