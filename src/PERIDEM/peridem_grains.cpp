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

#include "peridem_grains.h"

#include "peridem_cells.h"
#include "peridem_messages.h"

#include "atom.h"
#include "atom_vec_peridem.h"
#include "comm.h"
#include "domain.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

static constexpr double BIG = 1.0e300;

/* ---------------------------------------------------------------------- */

PeridemGrains::Extremes PeridemGrains::extremes(LAMMPS *lmp)
{
  dynamic_cast<AtomVecPeridem *>(lmp->atom->style_match("peridem"))->sync_mass();
  const auto *atom = lmp->atom;
  const int n = atom->ntypes + 1;
  Extremes ex;
  ex.lightest.assign(n, BIG);
  ex.smallest.assign(n, BIG);
  ex.largest.assign(n, 0.0);
  for (int i = 0; i < atom->nlocal; i++) {
    const int t = atom->type[i];
    ex.lightest[t] = std::min(ex.lightest[t], atom->rmass[i]);
    ex.smallest[t] = std::min(ex.smallest[t], atom->vfrac[i]);
    ex.largest[t] = std::max(ex.largest[t], atom->vfrac[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, ex.lightest.data(), n, MPI_DOUBLE, MPI_MIN, lmp->world);
  MPI_Allreduce(MPI_IN_PLACE, ex.smallest.data(), n, MPI_DOUBLE, MPI_MIN, lmp->world);
  MPI_Allreduce(MPI_IN_PLACE, ex.largest.data(), n, MPI_DOUBLE, MPI_MAX, lmp->world);
  return ex;
}

/* ----------------------------------------------------------------------
   every grain is brought together on one rank, so that the answer does not depend on how nodes
   are spread over processors
------------------------------------------------------------------------- */

namespace {

struct Node {
  double mol, type, x[3];
};

std::vector<Node> gather_grains(LAMMPS *lmp)
{
  const auto *atom = lmp->atom;
  const int nprocs = lmp->comm->nprocs;
  std::vector<std::vector<Node>> outgoing(nprocs);
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *X = atom->x0[i];
    outgoing[atom->molecule[i] % nprocs].push_back({static_cast<double>(atom->molecule[i]),
                                                    static_cast<double>(atom->type[i]),
                                                    {X[0], X[1], X[2]}});
  }
  return PeridemMessages::exchange(lmp->world, outgoing);
}

}    // namespace

/* ---------------------------------------------------------------------- */

std::vector<double> PeridemGrains::spacings(LAMMPS *lmp, std::vector<double> *widest)
{
  const auto *atom = lmp->atom;
  const int ntypes = atom->ntypes;
  std::vector<double> smallest_cell(ntypes + 1, BIG), spacing(ntypes + 1, BIG);
  double reach = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    const double h = std::pow(atom->vfrac[i], 1.0 / lmp->domain->dimension);
    auto &smallest = smallest_cell[atom->type[i]];
    smallest = std::min(smallest, h);
    reach = std::max(reach, 2.0 * h);    // the closest pair is nearer than the largest two cells
  }
  MPI_Allreduce(MPI_IN_PLACE, smallest_cell.data(), ntypes + 1, MPI_DOUBLE, MPI_MIN, lmp->world);
  MPI_Allreduce(MPI_IN_PLACE, &reach, 1, MPI_DOUBLE, MPI_MAX, lmp->world);

  const auto nodes = gather_grains(lmp);
  std::vector<PeridemCells::Point> points;
  for (std::size_t i = 0; i < nodes.size(); i++)
    if (nodes[i].mol > 0.0)
      points.push_back({{nodes[i].x[0], nodes[i].x[1], nodes[i].x[2]}, static_cast<int>(i)});
  const PeridemCells cells(std::vector<PeridemCells::Point>(points), reach);
  std::vector<double> gap(ntypes + 1, 0.0);
  for (const auto &p : points) {
    const auto &mine = nodes[p.id];
    double nearest = BIG;
    cells.near(p.x, [&](const PeridemCells::Point &q) {
      const auto &other = nodes[q.id];
      if (q.id == p.id || other.mol != mine.mol) return;
      const double dx = q.x[0] - p.x[0], dy = q.x[1] - p.x[1], dz = q.x[2] - p.x[2];
      nearest = std::min(nearest, std::sqrt(dx * dx + dy * dy + dz * dz));
    });
    if (nearest == BIG) continue;
    const int type = static_cast<int>(mine.type);
    spacing[type] = std::min(spacing[type], nearest);
    gap[type] = std::max(gap[type], nearest);
  }
  if (widest) {
    MPI_Allreduce(MPI_IN_PLACE, gap.data(), ntypes + 1, MPI_DOUBLE, MPI_MAX, lmp->world);
    *widest = gap;
  }
  MPI_Allreduce(MPI_IN_PLACE, spacing.data(), ntypes + 1, MPI_DOUBLE, MPI_MIN, lmp->world);

  for (int t = 1; t <= ntypes; t++) {
    if (spacing[t] == BIG) spacing[t] = smallest_cell[t];
    if (spacing[t] == BIG) spacing[t] = 0.0;
  }
  return spacing;
}
