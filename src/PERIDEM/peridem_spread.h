/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Forces that restitution spreads over nodes: those of owned nodes act at once, those of ghosts
// (nodes of a patch of a broken grain) are kept until they go home.

#ifndef LMP_PERIDEM_SPREAD_H
#define LMP_PERIDEM_SPREAD_H

#include "peridem_books.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemSpread {
 public:
  // f: forces on owned nodes, three numbers each; book: null, or the same of what is spread alone
  void begin(double *_f, int _nlocal, int nghost, std::vector<double> *_book)
  {
    f = _f;
    nlocal = _nlocal;
    book = _book;
    of_ghosts.assign(3 * static_cast<std::size_t>(nghost), 0.0);
  }

  void add(int j, const double *force)
  {
    if (j >= nlocal) {
      for (int k = 0; k < 3; k++) of_ghosts[3 * (j - nlocal) + k] += force[k];
      return;
    }
    add_owned<3>(j, force);
  }

  // in 2d, forces have two components
  template <int DIM> void add_owned(int i, const double *force)
  {
    double *const at = f + 3 * static_cast<std::size_t>(i);
    for (int k = 0; k < DIM; k++) at[k] += force[k];
    if (book) PeridemBooks::add(*book, i, force);
  }

  // for reverse communication
  int pack(int n, int first, double *buf) const
  {
    for (int m = 0; m < 3 * n; m++) buf[m] = of_ghosts[3 * (first - nlocal) + m];
    return 3 * n;
  }
  void unpack(int n, const int *list, const double *buf)
  {
    for (int m = 0; m < n; m++) add(list[m], buf + 3 * m);
  }

 private:
  double *f{nullptr};
  int nlocal{0};
  std::vector<double> *book{nullptr};
  std::vector<double> of_ghosts;
};

}    // namespace LAMMPS_NS

#endif
