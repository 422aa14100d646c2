/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Two bodies touch at several nodes at a time, and open and close again at each of them while they
// vibrate.  All that is one collision: its speed of approach is that of the contacts, each weighted
// with its force, and it began with the fastest approach that any of them remembers.

#ifndef LMP_PERIDEM_COLLISIONS_H
#define LMP_PERIDEM_COLLISIONS_H

#include "pointers.h"

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

struct PeridemCollision {
  bigint low, high;      // two bodies, or a face of a wall (a number below 0) and a body
  double force{0.0};     // sum of the elastic forces
  double power{0.0};     // sum of force times speed of approach
  double stored{0.0};    // twice the energy of the springs
  double peak{0.0};      // fastest approach so far
  bool abroad{false};    // another rank may have a contact of the same collision
  double approach() const { return force > 0.0 ? power / force : 0.0; }
};

class PeridemCollisions : protected Pointers {
 public:
  PeridemCollisions(class LAMMPS *lmp) : Pointers(lmp) {}

  // no contact of a collision is known; places are void
  void clear();
  // a new moment: collisions keep their places
  void begin();
  // where the collision of these two bodies is; guess: where it may have been found before, or -1
  int find(bigint a, bigint b, int guess = -1);
  // another rank may have a contact of the same collision
  void seen_elsewhere(int place) { list[place].abroad = true; }
  // a contact that has touched in a collision that is not over; stored = twice its energy; share = of
  // this rank
  void add(int place, double force, double stored, double approach, double share);
  // the same of one that is open, or not: how fast it has come
  void remember(int place, double peak)
  {
    if (list[place].peak < peak) list[place].peak = peak;
  }
  // may another rank have added to one of these, as far as this one knows?
  bool abroad() const;
  // sum up what all ranks have added; collective
  void merge();
  const PeridemCollision &at(int place) const { return list[place]; }

 private:
  struct Bodies {
    bigint low, high;
    bool operator==(const Bodies &other) const { return low == other.low && high == other.high; }
  };
  struct Hash {
    static constexpr std::uint64_t SPREAD = 0x9E3779B97F4A7C15ULL;    // 2^64 over the golden ratio
    std::size_t operator()(const Bodies &one) const
    {
      const auto a = static_cast<std::uint64_t>(one.low), b = static_cast<std::uint64_t>(one.high);
      return static_cast<std::size_t>((a * SPREAD + b) * SPREAD >> 16);
    }
  };
  std::vector<PeridemCollision> list;
  std::unordered_map<Bodies, int, Hash> places;
};

}    // namespace LAMMPS_NS

#endif
