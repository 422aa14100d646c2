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

#include "peridem_rigid_nodes.h"

#include "atom.h"
#include "domain.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

static constexpr int NSUMS = sizeof(PeridemRigidNodes::Sums) / sizeof(double);

/* ---------------------------------------------------------------------- */

PeridemRigidNodes::PeridemRigidNodes(LAMMPS *lmp, PeridemAdaptTable &grains_of_all) :
    Pointers(lmp), table(grains_of_all), dimension(lmp->domain->dimension)
{
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::collect()
{
  grains.clear();
  pieces.clear();
  index.clear();
  offset.clear();
  mass.clear();
  per_area.clear();
  for (tagint mol = 1; mol <= table.highest(); mol++) {
    if (!table.grains[mol].rigid()) continue;
    grains.push_back(mol);
    auto piece = new_piece(static_cast<int>(grains.size()) - 1, static_cast<int>(index.size()));
    for (const int i : table.nodes(mol)) {
      index.push_back(i);
      for (int m = 0; m < dimension; m++) offset.push_back(table.offset[i][piece.axes[m]]);
      mass.push_back(static_cast<float>(atom->rmass[i]));
      const double V = atom->vfrac[i], area = 1.0 / (dimension == 2 ? V : V * std::cbrt(V));
      if (i == *table.nodes(mol).first) piece.unit = area;
      per_area.push_back(static_cast<float>(area / piece.unit));
      if (dimension == 2) atom->v[i][2] = 0.0;
    }
    piece.last = static_cast<int>(index.size());
    piece.whole = piece.last - piece.first == table.grains[mol].count;
    if (piece.last > piece.first) pieces.push_back(piece);
  }
  find_shifts();
}

/* ----------------------------------------------------------------------
   in 2d rounding must not lift nodes off their plane, a grain under load would buckle out of it: the
   axis along z takes no part
------------------------------------------------------------------------- */

PeridemRigidNodes::Piece PeridemRigidNodes::new_piece(int slot, int first) const
{
  Piece piece{slot, first, first, {0, 1, 2}, 1.0, false, false};
  if (dimension == 3) return piece;
  const auto &body = table.grains[grains[slot]].body;
  const double *const axes[3] = {body.ex, body.ey, body.ez};
  int normal = 0;
  for (int k = 1; k < 3; k++)
    if (std::fabs(axes[k][2]) > std::fabs(axes[normal][2])) normal = k;
  std::swap(piece.axes[normal], piece.axes[2]);
  return piece;
}

/* ----------------------------------------------------------------------
   nodes cross periodic boundaries when neighbour lists are built, and only then
------------------------------------------------------------------------- */

void PeridemRigidNodes::find_shifts()
{
  const imageint none = (static_cast<imageint>(IMGMAX) << IMG2BITS) |
      (static_cast<imageint>(IMGMAX) << IMGBITS) | IMGMAX;
  shifts.resize(3 * index.size());
  for (auto &piece : pieces) {
    piece.shifted = false;
    for (int k = piece.first; k < piece.last; k++)
      if (atom->image[index[k]] != none) piece.shifted = true;
    if (!piece.shifted) continue;
    const double home[3] = {0.0, 0.0, 0.0};
    for (int k = piece.first; k < piece.last; k++)
      domain->unmap(home, atom->image[index[k]], &shifts[3 * k]);
  }
}

/* ---------------------------------------------------------------------- */

bool PeridemRigidNodes::moves(const Piece &piece) const
{
  return table.grains[grains[piece.slot]].state == PeridemAdaptGrain::RIGID;
}

/* ---------------------------------------------------------------------- */

template <int D>
void PeridemRigidNodes::set_nodes(const Piece &piece, const PeridemRigidBody &body, bool move)
{
  // copies: nothing that is stored below can change them
  const PeridemRigidBody b = body;
  const double *const axes[3] = {b.ex, b.ey, b.ez};
  double e[D][D], *const x = atom->x[0], *const v = atom->v[0];
  for (int a = 0; a < D; a++)
    for (int c = 0; c < D; c++) e[a][c] = axes[piece.axes[c]][a];
  const int *const node = index.data();
  const double *const all = offset.data();

  for (int k = piece.first; k < piece.last; k++) {
    const double *const d = all + D * k;
    double *const vi = v + 3 * node[k], r[D] = {};
    for (int a = 0; a < D; a++)
      for (int c = 0; c < D; c++) r[a] += e[a][c] * d[c];
    vi[0] = b.v[0] - b.omega[2] * r[1] + (D == 3 ? b.omega[1] * r[D - 1] : 0.0);
    vi[1] = b.v[1] + b.omega[2] * r[0] - (D == 3 ? b.omega[0] * r[D - 1] : 0.0);
    if (D == 3) vi[2] = b.v[2] + b.omega[0] * r[1] - b.omega[1] * r[0];
    if (move)
      for (int a = 0; a < D; a++) x[3 * node[k] + a] = b.x[a] + r[a];
  }
  if (!move || !piece.shifted) return;
  for (int k = piece.first; k < piece.last; k++)
    for (int a = 0; a < D; a++) x[3 * node[k] + a] -= shifts[3 * k + a];
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::place()
{
  if (domain->box_change) find_shifts();
  for (const auto &piece : pieces) {
    if (!moves(piece)) continue;
    const auto &body = table.grains[grains[piece.slot]].body;
    if (dimension == 2)
      set_nodes<2>(piece, body, true);
    else
      set_nodes<3>(piece, body, true);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::set_velocities(const Piece &piece, const PeridemRigidBody &body)
{
  if (dimension == 2)
    set_nodes<2>(piece, body, false);
  else
    set_nodes<3>(piece, body, false);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::set_velocities(bool asleep)
{
  for (const auto &piece : pieces)
    if (asleep || moves(piece)) set_velocities(piece, table.grains[grains[piece.slot]].body);
}

/* ---------------------------------------------------------------------- */

template <int D> void PeridemRigidNodes::sum_nodes(const Piece &piece, bool with_sizes)
{
  const auto &body = table.grains[grains[piece.slot]].body;
  // the acceleration of the last step will do: a node is light
  double acceleration[D], total[D] = {}, moment[D][D] = {}, most = 0.0;
  for (int a = 0; a < D; a++) acceleration[a] = body.force[a] / body.mass;
  const double *const all = offset.data(), *const f = atom->f[0];
  for (int k = piece.first; k < piece.last; k++) {
    const double *const fi = f + 3 * index[k], *const d = all + D * k;
    double bending = 0.0;
    for (int a = 0; a < D; a++) {
      total[a] += fi[a];
      for (int c = 0; c < D; c++) moment[a][c] += fi[a] * d[c];
      const double part = fi[a] - mass[k] * acceleration[a];
      bending += part * part;
    }
    most = std::max(most, bending * per_area[k]);
  }

  Sums s = Sums();
  for (int a = 0; a < D; a++) {
    s.force[a] = total[a];
    for (int c = 0; c < D; c++) s.moment[3 * a + piece.axes[c]] = moment[a][c];
  }
  if (with_sizes)
    for (int k = piece.first; k < piece.last; k++) {
      const double *const fi = f + 3 * index[k];
      double square = 0.0;
      for (int a = 0; a < D; a++) square += fi[a] * fi[a];
      s.sizes += std::sqrt(square);
    }
  sums[piece.slot] = s;
  highest[piece.slot] = most * piece.unit;
}

/* ----------------------------------------------------------------------
   the nodes of a grain that is whole on this rank get their velocities while they are in the cache
------------------------------------------------------------------------- */

void PeridemRigidNodes::sum_up(bool with_sizes, double dtf)
{
  sums.assign(grains.size(), Sums());
  highest.assign(grains.size(), 0.0);
  for (const auto &piece : pieces) {
    if (dimension == 2)
      sum_nodes<2>(piece, with_sizes);
    else
      sum_nodes<3>(piece, with_sizes);
    if (dtf == 0.0 || !piece.whole || !moves(piece)) continue;
    auto after = table.grains[grains[piece.slot]].body;
    set_forces(after, sums[piece.slot]);
    after.kick(dtf);
    set_velocities(piece, after);
  }
  const int n = static_cast<int>(grains.size());
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), NSUMS * n, MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, highest.data(), n, MPI_DOUBLE, MPI_MAX, world);
  for (int k = 0; k < n; k++) set_forces(table.grains[grains[k]].body, sums[k]);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::sum_forces(bool with_sizes)
{
  if (!grains.empty()) sum_up(with_sizes, 0.0);
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::finish_step(bool with_sizes, double dtf)
{
  sum_up(with_sizes, dtf);
  for (const tagint mol : grains)
    if (table.grains[mol].state == PeridemAdaptGrain::RIGID) table.grains[mol].body.kick(dtf);
  for (const auto &piece : pieces)
    if (!piece.whole && moves(piece)) set_velocities(piece, table.grains[grains[piece.slot]].body);
}

/* ---------------------------------------------------------------------- */

static void to_space(const PeridemRigidBody &body, const double *sum, double *moment)
{
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      moment[3 * a + b] =
          sum[3 * a] * body.ex[b] + sum[3 * a + 1] * body.ey[b] + sum[3 * a + 2] * body.ez[b];
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::set_forces(PeridemRigidBody &body, const Sums &all) const
{
  double m[9];
  to_space(body, all.moment, m);
  const bool flat = dimension == 2;
  std::copy_n(all.force, 3, body.force);
  body.torque[0] = flat ? 0.0 : m[7] - m[5];
  body.torque[1] = flat ? 0.0 : m[2] - m[6];
  body.torque[2] = m[3] - m[1];
}

/* ---------------------------------------------------------------------- */

void PeridemRigidNodes::moment(std::size_t k, double *moment) const
{
  to_space(table.grains[grains[k]].body, sums[k].moment, moment);
}

/* ---------------------------------------------------------------------- */

double PeridemRigidNodes::memory_usage() const
{
  return static_cast<double>(index.capacity()) * sizeof(int) +
      static_cast<double>(offset.capacity() + shifts.capacity()) * sizeof(double) +
      static_cast<double>(mass.capacity() + per_area.capacity()) * sizeof(float);
}
