/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Forces that restitution spreads over owned nodes, and on request their sum at each node.

#ifndef LMP_PERIDEM_SPREAD_H
#define LMP_PERIDEM_SPREAD_H

#include "peridem_books.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemSpread {
 public:
  // f: forces on owned nodes, three numbers each; book: null, or the same of what is spread alone
  void begin(double *_f, std::vector<double> *_book)
  {
    f = _f;
    book = _book;
  }

  // in 2d, forces have two components
  template <int DIM> void add(int i, const double *force)
  {
    double *const at = f + 3 * static_cast<std::size_t>(i);
    for (int k = 0; k < DIM; k++) at[k] += force[k];
    if (book) PeridemBooks::add(*book, i, force);
  }

 private:
  double *f{nullptr};
  std::vector<double> *book{nullptr};
};

}    // namespace LAMMPS_NS

#endif
