/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What the command replicate leaves to the atom style: copies of a grain are grains of their own,
// with reference positions that moved along.

#ifndef LMP_PERIDEM_COPIES_H
#define LMP_PERIDEM_COPIES_H

#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemCopies : protected Pointers {
 public:
  // while the box is still that of the originals
  explicit PeridemCopies(class LAMMPS *);

  // node i as it comes from the originals, before it is moved and gets an ID of its own
  void note(int i);

  // when all nodes are there; collective. The originals may have been copies as well
  void finish(const PeridemCopies *before);

  // a grain in two halves, each at its side of a periodic boundary, cannot be copied; the error
  // waits for the next init(), since finish() is called where none may be thrown
  void check() const;

 private:
  struct Original {
    tagint tag, molecule;
    double x[3];
  };
  std::vector<Original> originals;    // of the nodes of this rank, in their order
  double lo[3], prd[3], xy, xz, yz;
  int periodic[3];
  tagint split_grain{0};
  int split_along{0};

  void from_boundary(double *d) const;
  void find_split_grains(tagint maxmol);
};

}    // namespace LAMMPS_NS

#endif
