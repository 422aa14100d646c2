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

/* ---------------------------------------------------------------------- */

PeridemBodies::PeridemBodies(LAMMPS *lmp) : Pointers(lmp) {}

/* ---------------------------------------------------------------------- */

void PeridemBodies::unwrapped(int i, double *x) const
{
  domain->unmap(atom->x[i], atom->image[i], x);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::find(const FixPeridemBonds *_bonds)
{
  bonds = _bonds;
  const int nlocal = atom->nlocal;
  const tagint *const mol = atom->molecule;
  if (natoms_seen != atom->natoms) {
    natoms_seen = atom->natoms;
    highest = 0;
    for (int i = 0; i < nlocal; i++) highest = MAX(highest, mol[i]);
    MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
    if (highest > MAXGRAIN)
      error->all(
          FLERR, Error::NOLASTLINE,
          "restitution keeps a table by molecule-ID: {} is larger than {}; number the grains "
          "anew (reset_atoms mol)",
          highest, MAXGRAIN);
  }

  grains.assign(highest + 1, Sums());
  pushes.assign(3 * (highest + 1), 0.0);
  for (int i = 0; i < nlocal; i++) {
    auto &grain = grains[mol[i]];
    const double m = atom->rmass[i];
    double x[3];
    unwrapped(i, x);
    grain.mass += m;
    for (int k = 0; k < 3; k++) {
      grain.place[k] += m * x[k];
      grain.velocity[k] += m * atom->v[i][k];
    }
    if (bonds) grain.broken += bonds->nref[i] - MAX(bonds->num[i], 0);
  }
  const int count = static_cast<int>(grains.size() * sizeof(Sums) / sizeof(double));
  MPI_Allreduce(MPI_IN_PLACE, grains.data(), count, MPI_DOUBLE, MPI_SUM, world);
  for (auto &grain : grains) {
    if (!(grain.mass > 0.0)) continue;
    for (int k = 0; k < 3; k++) {
      grain.place[k] /= grain.mass;
      grain.velocity[k] /= grain.mass;
    }
  }
}

/* ---------------------------------------------------------------------- */

bool PeridemBodies::whole(int i) const
{
  const tagint mol = atom->molecule[i];
  return mol != 0 && grains[mol].broken == 0.0;
}

/* ---------------------------------------------------------------------- */

PeridemBody PeridemBodies::body(int i) const
{
  if (!whole(i)) return patch(i);
  const auto &grain = grains[atom->molecule[i]];
  PeridemBody body{};
  double x[3];
  unwrapped(i, x);
  body.mass = grain.mass;
  for (int k = 0; k < 3; k++) {
    body.offset[k] = grain.place[k] - x[k];
    body.velocity[k] = grain.velocity[k];
  }
  return body;
}

/* ----------------------------------------------------------------------
   the node and those that intact bonds tie to it
------------------------------------------------------------------------- */

PeridemBody PeridemBodies::patch(int i) const
{
  PeridemBody patch{};
  auto add = [&](int j) {
    const double m = atom->rmass[j];
    patch.mass += m;
    for (int k = 0; k < 3; k++) {
      patch.offset[k] += m * (atom->x[j][k] - atom->x[i][k]);
      patch.velocity[k] += m * atom->v[j][k];
    }
  };
  add(i);
  if (bonds)
    for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
      add(bonds->partner[k]);
  for (int k = 0; k < 3; k++) {
    patch.offset[k] /= patch.mass;
    patch.velocity[k] /= patch.mass;
  }
  return patch;
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::push(int i, const double *force, double *spread)
{
  if (!whole(i)) {
    push_patch(i, force, spread);
    return;
  }
  double *const total = &pushes[3 * atom->molecule[i]];
  for (int k = 0; k < 3; k++) total[k] += force[k];
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::push_patch(int i, const double *force, double *spread) const
{
  const double mass = patch(i).mass;
  auto add = [&](int j) {
    const double share = atom->rmass[j] / mass;
    for (int k = 0; k < 3; k++) spread[3 * j + k] += share * force[k];
  };
  add(i);
  if (bonds)
    for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
      add(bonds->partner[k]);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::apply(double *f)
{
  MPI_Allreduce(MPI_IN_PLACE, pushes.data(), static_cast<int>(pushes.size()), MPI_DOUBLE, MPI_SUM,
                world);
  if (std::all_of(pushes.begin(), pushes.end(), [](double push) {
        return push == 0.0;
      }))
    return;
  for (int i = 0; i < atom->nlocal; i++) {
    const tagint mol = atom->molecule[i];
    const double *const total = &pushes[3 * mol];
    if (total[0] == 0.0 && total[1] == 0.0 && total[2] == 0.0) continue;
    const double share = atom->rmass[i] / grains[mol].mass;
    for (int k = 0; k < 3; k++) f[3 * i + k] += share * total[k];
  }
  pushes.assign(pushes.size(), 0.0);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::forget_peaks()
{
  peaks.assign(grains.size(), 0.0);
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::note_peak(int i, double peak)
{
  const tagint mol = atom->molecule[i];
  if (mol && peak > peaks[mol]) peaks[mol] = peak;
}

/* ---------------------------------------------------------------------- */

void PeridemBodies::share_peaks()
{
  MPI_Allreduce(MPI_IN_PLACE, peaks.data(), static_cast<int>(peaks.size()), MPI_DOUBLE, MPI_MAX,
                world);
}

/* ---------------------------------------------------------------------- */

double PeridemBodies::memory_usage() const
{
  return static_cast<double>(grains.capacity()) * sizeof(Sums) +
      static_cast<double>(pushes.capacity() + peaks.capacity()) * sizeof(double);
}
