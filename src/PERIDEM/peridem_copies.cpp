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

#include "peridem_copies.h"

#include "atom.h"
#include "domain.h"
#include "error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

using namespace LAMMPS_NS;

// where nodes of a grain are along a periodic box, in this many bins: bits of an integer
static constexpr int BINS = 64;

static constexpr double MAXGAP = 1.0e30;

/* ---------------------------------------------------------------------- */

PeridemCopies::PeridemCopies(LAMMPS *lmp) :
    Pointers(lmp), xy(domain->xy), xz(domain->xz), yz(domain->yz)
{
  for (int k = 0; k < 3; k++) {
    lo[k] = domain->boxlo[k];
    prd[k] = domain->prd[k];
    periodic[k] = domain->periodicity[k] && (k < 2 || domain->dimension == 3);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemCopies::note(int i)
{
  const double *const x = atom->x[i];
  originals.push_back({atom->tag[i], atom->molecule[i], {x[0], x[1], x[2]}});
}

/* ----------------------------------------------------------------------
   shortest of the periodic images, in the box of the originals
------------------------------------------------------------------------- */

void PeridemCopies::from_boundary(double *d) const
{
  const double tilt[3][3] = {{prd[0], 0.0, 0.0}, {xy, prd[1], 0.0}, {xz, yz, prd[2]}};
  for (int k = 2; k >= 0; k--) {
    if (!periodic[k]) continue;
    const double n = std::round(d[k] / prd[k]);
    for (int m = 0; m <= k; m++) d[m] -= n * tilt[k][m];
  }
}

/* ----------------------------------------------------------------------
   IDs of copies differ from those of the originals by multiples of the largest original ID
------------------------------------------------------------------------- */

void PeridemCopies::finish(const PeridemCopies *before)
{
  if (before) {
    split_grain = before->split_grain;
    split_along = before->split_along;
  }
  tagint largest[2] = {0, 0};
  for (const auto &node : originals) {
    largest[0] = MAX(largest[0], node.tag);
    largest[1] = MAX(largest[1], node.molecule);
  }
  MPI_Allreduce(MPI_IN_PLACE, largest, 2, MPI_LMP_TAGINT, MPI_MAX, world);
  if (largest[0] == 0) return;

  for (int i = 0; i < static_cast<int>(originals.size()); i++) {
    const auto &node = originals[i];
    const tagint copy = (atom->tag[i] - node.tag) / largest[0];
    if (node.molecule > 0) atom->molecule[i] += copy * largest[1];

    double d[3];
    for (int k = 0; k < 3; k++) d[k] = atom->x0[i][k] - node.x[k];
    from_boundary(d);
    for (int k = 0; k < 3; k++) atom->x0[i][k] = atom->x[i][k] + d[k];
  }
  find_split_grains(largest[1]);
  originals = std::vector<Original>();
}

/* ----------------------------------------------------------------------
   longest run of empty bins, around the boundary
------------------------------------------------------------------------- */

static int longest_gap(std::uint64_t occupied)
{
  int run = 0, longest = 0;
  for (int b = 0; b < 2 * BINS; b++) {
    run = (occupied >> (b % BINS)) & 1 ? 0 : run + 1;
    longest = MAX(longest, run);
  }
  return MIN(longest, BINS);
}

/* ----------------------------------------------------------------------
   the MPI that LAMMPS brings for serial builds knows neither these numbers nor MPI_BOR
------------------------------------------------------------------------- */

static void unite(void *from, void *into, int *n, MPI_Datatype *)
{
  const auto *const these = static_cast<const std::uint64_t *>(from);
  auto *const those = static_cast<std::uint64_t *>(into);
  for (int k = 0; k < *n; k++) those[k] |= these[k];
}

static void unite_over_ranks(std::vector<std::uint64_t> &bits, MPI_Comm world)
{
  static_assert(sizeof(long long) == sizeof(std::uint64_t), "they travel as the former");
  MPI_Op op;
  MPI_Op_create(unite, 1, &op);
  MPI_Allreduce(MPI_IN_PLACE, bits.data(), static_cast<int>(bits.size()), MPI_LONG_LONG, op, world);
  MPI_Op_free(&op);
}

/* ----------------------------------------------------------------------
   A grain in one piece is widest open where the boundary closes it. One in two halves is wider open
   somewhere between them.
------------------------------------------------------------------------- */

void PeridemCopies::find_split_grains(tagint maxmol)
{
  const auto n = static_cast<std::size_t>(maxmol) + 1;
  for (int k = 0; k < 3; k++) {
    if (!periodic[k]) continue;
    std::vector<std::uint64_t> occupied(n, 0);
    std::vector<double> ends(2 * n, -MAXGAP);    // -least and most, in periods
    for (const auto &node : originals) {
      double place = (node.x[k] - lo[k]) / prd[k];
      if (k == 1) place -= yz * (node.x[2] - lo[2]) / (prd[1] * prd[2]);
      if (k == 0) {
        const double height = (node.x[2] - lo[2]) / prd[2];
        const double depth = (node.x[1] - lo[1] - yz * height) / prd[1];
        place -= (xy * depth + xz * height) / prd[0];
      }
      const int bin = static_cast<int>(BINS * (place - std::floor(place)));
      occupied[node.molecule] |= UINT64_C(1) << MIN(bin, BINS - 1);
      ends[2 * node.molecule] = MAX(ends[2 * node.molecule], -place);
      ends[2 * node.molecule + 1] = MAX(ends[2 * node.molecule + 1], place);
    }
    unite_over_ranks(occupied, world);
    MPI_Allreduce(MPI_IN_PLACE, ends.data(), static_cast<int>(2 * n), MPI_DOUBLE, MPI_MAX, world);
    for (std::size_t mol = 1; mol < n && !split_grain; mol++) {
      if (!occupied[mol]) continue;
      const double open = BINS * (1.0 - ends[2 * mol] - ends[2 * mol + 1]);
      if (longest_gap(occupied[mol]) > open + 1.0) {
        split_grain = static_cast<tagint>(mol);
        split_along = k;
      }
    }
  }
}

/* ---------------------------------------------------------------------- */

void PeridemCopies::check() const
{
  if (split_grain)
    error->all(FLERR, Error::NOLASTLINE,
               "Grain {} crossed the periodic boundary in {} when the box was replicated, with "
               "image flags that leave its halves apart: give its nodes image flags that make it "
               "whole, or move it away from the boundary",
               split_grain, "xyz"[split_along]);
}
