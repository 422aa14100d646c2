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

#include "peridem_collisions.h"

#include "peridem_messages.h"

#include "comm.h"

#include <algorithm>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

void PeridemCollisions::clear()
{
  list.clear();
  places.clear();
}

/* ---------------------------------------------------------------------- */

void PeridemCollisions::begin()
{
  for (auto &one : list) one.force = one.power = one.stored = one.peak = 0.0;
}

/* ---------------------------------------------------------------------- */

int PeridemCollisions::find(bigint a, bigint b, int guess)
{
  const Bodies bodies{MIN(a, b), MAX(a, b)};
  if (guess >= 0 && guess < static_cast<int>(list.size()) && list[guess].low == bodies.low &&
      list[guess].high == bodies.high)
    return guess;
  const auto found = places.emplace(bodies, static_cast<int>(list.size()));
  if (found.second) {
    list.emplace_back();
    list.back().low = bodies.low;
    list.back().high = bodies.high;
  }
  return found.first->second;
}

/* ---------------------------------------------------------------------- */

void PeridemCollisions::add(int place, double force, double stored, double approach, double share)
{
  auto &one = list[place];
  one.force += share * force;
  one.power += share * force * approach;
  one.stored += share * stored;
}

/* ---------------------------------------------------------------------- */

bool PeridemCollisions::abroad() const
{
  return std::any_of(list.begin(), list.end(), [](const PeridemCollision &one) {
    return one.abroad && (one.force > 0.0 || one.peak > 0.0);
  });
}

/* ----------------------------------------------------------------------
   in the order of the ranks, so that all sum up to the same
------------------------------------------------------------------------- */

void PeridemCollisions::merge()
{
  if (comm->nprocs == 1) return;
  std::vector<PeridemCollision> seen;
  for (auto &one : list) {
    if (!one.abroad) continue;
    if (one.force > 0.0 || one.peak > 0.0) seen.push_back(one);
    one.force = one.power = one.stored = one.peak = 0.0;
  }
  for (const auto &one : PeridemMessages::gather(world, std::move(seen))) {
    const auto found = places.find({one.low, one.high});
    if (found == places.end()) continue;
    auto &same = list[found->second];
    same.force += one.force;
    same.power += one.power;
    same.stored += one.stored;
    same.peak = MAX(same.peak, one.peak);
  }
}
