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

#include "peridem_contact_stiffness.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

void PeridemContactStiffness::start(int nodes, int dimension)
{
  dim = dimension;
  place_of.assign(nodes, -1);
  held.clear();
  sums.clear();
  contacts.clear();
}

/* ---------------------------------------------------------------------- */

void PeridemContactStiffness::add(int i, int j, double along, double across, const double *n)
{
  contacts.push_back({i, j, along, across, {n[0], n[1], n[2]}});
  hold(i, along, across, n);
  if (j != WALL && j < static_cast<int>(place_of.size())) hold(j, along, across, n);
}

/* ---------------------------------------------------------------------- */

void PeridemContactStiffness::hold(int i, double along, double across, const double *n)
{
  if (place_of[i] < 0) {
    place_of[i] = static_cast<int>(held.size());
    held.push_back(i);
    sums.emplace_back();
  }
  auto &sum = sums[place_of[i]];
  const double more = along - across;
  sum.springs += along;
  sum.xx += across + more * n[0] * n[0];
  sum.yy += across + more * n[1] * n[1];
  sum.xy += more * n[0] * n[1];
  if (dim == 2) return;
  sum.zz += across + more * n[2] * n[2];
  sum.xz += more * n[0] * n[2];
  sum.yz += more * n[1] * n[2];
}

/* ---------------------------------------------------------------------- */

double PeridemContactStiffness::largest(std::size_t n) const
{
  const auto &sum = sums[n];
  if (dim == 3) return largest_in_space(sum);
  const double half = 0.5 * (sum.xx - sum.yy);
  return 0.5 * (sum.xx + sum.yy) + std::sqrt(half * half + sum.xy * sum.xy);
}

/* ----------------------------------------------------------------------
   the trigonometric solution of the cubic (Smith 1961, Commun. ACM 4, 168)
------------------------------------------------------------------------- */

double PeridemContactStiffness::largest_in_space(const Sum &sum)
{
  const double mean = (sum.xx + sum.yy + sum.zz) / 3.0;
  const double a = sum.xx - mean, b = sum.yy - mean, c = sum.zz - mean;
  const double off = sum.xy * sum.xy + sum.xz * sum.xz + sum.yz * sum.yz;
  const double size = std::sqrt((a * a + b * b + c * c + 2.0 * off) / 6.0);
  if (!(size > 0.0)) return mean;
  const double determinant = a * (b * c - sum.yz * sum.yz) -
      sum.xy * (sum.xy * c - sum.yz * sum.xz) + sum.xz * (sum.xy * sum.yz - b * sum.xz);
  const double cosine = std::max(-1.0, std::min(1.0, 0.5 * determinant / (size * size * size)));
  return mean + 2.0 * size * std::cos(std::acos(cosine) / 3.0);
}

/* ---------------------------------------------------------------------- */

double PeridemContactStiffness::largest_pair(const std::vector<double> &of_nodes) const
{
  double largest = 0.0;
  for (const auto &contact : contacts) {
    const double a = of_nodes[contact.i], b = contact.j == WALL ? 0.0 : of_nodes[contact.j];
    largest = std::max(largest, (a < 0.0 ? b : a) + (b < 0.0 ? a : b));
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

void PeridemContactStiffness::share(const std::vector<double> &of_nodes)
{
  std::fill(sums.begin(), sums.end(), Sum());
  for (const auto &one : contacts) {
    if (!(one.along > 0.0)) continue;    // volumes so small that there is no spring
    const bool wall = one.j == WALL;
    const double a = of_nodes[one.i], b = wall ? 0.0 : of_nodes[one.j];
    const double both = a < 0.0 || b < 0.0 ? 2.0 * std::max(a, b) : a + b;
    if (a > 0.0) hold(one.i, both / a * one.along, both / a * one.across, one.direction);
    if (b > 0.0 && one.j < static_cast<int>(place_of.size()))
      hold(one.j, both / b * one.along, both / b * one.across, one.direction);
  }
}

/* ---------------------------------------------------------------------- */

double PeridemContactStiffness::memory_usage() const
{
  return static_cast<double>(sums.capacity() * sizeof(Sum)) +
      static_cast<double>((held.capacity() + place_of.capacity()) * sizeof(int)) +
      static_cast<double>(contacts.capacity() * sizeof(Contact));
}
