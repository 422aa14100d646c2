/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The nodes that may come to touch a wall soon.  Regions are slow to ask, and most nodes are far
// away: the list is made when LAMMPS makes its own, and when the wall has moved too far.

#ifndef LMP_PERIDEM_WALL_LIST_H
#define LMP_PERIDEM_WALL_LIST_H

#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemSurface;
class PeridemWallMotion;

class PeridemWallList : protected Pointers {
 public:
  explicit PeridemWallList(class LAMMPS *lmp) : Pointers(lmp) {}

  // owned nodes of the group that may touch within the radius until the list is stale
  void build(PeridemSurface &, const PeridemWallMotion &, int groupbit, double radius);
  bool stale(const PeridemSurface &, const PeridemWallMotion &) const;

  const std::vector<int> &nodes() const { return near; }

 private:
  std::vector<int> near;
  double shift[3]{0.0, 0.0, 0.0};    // of the wall when the list was made
  double low[3]{}, high[3]{};        // box around everything that counts
};

}    // namespace LAMMPS_NS

#endif
