/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Two grains touch at several nodes at a time, and open and close again at each of them while they
// vibrate.  All that is one collision: its speed of approach is that of the contacts, each weighted
// with its force, and it began with the fastest approach that any of them remembers.

#ifndef LMP_PERIDEM_COLLISIONS_H
#define LMP_PERIDEM_COLLISIONS_H

#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

struct PeridemCollision {
  tagint low, high;    // two grains, or a face of a wall (a number below 0) and a grain
  double force;        // sum of the elastic forces
  double power;        // sum of force times speed of approach
  double peak;         // fastest approach so far
  double approach() const { return force > 0.0 ? power / force : 0.0; }
};

class PeridemCollisions : protected Pointers {
 public:
  PeridemCollisions(class LAMMPS *lmp) : Pointers(lmp) {}

  void clear()
  {
    list.clear();
    abroad.clear();
  }
  // a contact that has touched in a collision that is not over; share = of this rank, seen_elsewhere:
  // another rank may have a contact of the same collision
  void add(tagint a, tagint b, double force, double approach, double peak, double share,
           bool seen_elsewhere);
  // sum up what all ranks have added; collective
  void merge();
  // of grains (or a face and a grain) that have been added
  const PeridemCollision &of(tagint a, tagint b) const;

 private:
  std::vector<PeridemCollision> list;      // of this rank alone, and after merge() of all
  std::vector<PeridemCollision> abroad;    // those that other ranks may see too

  static void compress(std::vector<PeridemCollision> &);
};

}    // namespace LAMMPS_NS

#endif
