/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Sums and searches over whole grains, wherever their nodes are.

#ifndef LMP_PERIDEM_GRAINS_H
#define LMP_PERIDEM_GRAINS_H

#include <vector>

namespace LAMMPS_NS {

class PeridemGrains {
 public:
  // by type: the lightest node, smallest and largest cell; infinite or 0 where a
  // type has no nodes
  struct Extremes {
    std::vector<double> lightest, smallest, largest;
  };
  static Extremes extremes(class LAMMPS *);

  // by type: the smallest reference distance of a node of that type to another node of its grain;
  // a type whose nodes are alone in their grains gets the size of its smallest cell, V^(1/d);
  // 0 where a type has no nodes.  widest: the largest distance of a node of that type to the nearest
  // one of its grain, 0 where nodes are alone
  static std::vector<double> spacings(class LAMMPS *, std::vector<double> *widest = nullptr);
};

}    // namespace LAMMPS_NS

#endif
