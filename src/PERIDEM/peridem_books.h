/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Forces that take energy away, kept apart from the rest while somebody books energies
// (compute peridem/energy). Closed books cost nothing.

#ifndef LMP_PERIDEM_BOOKS_H
#define LMP_PERIDEM_BOOKS_H

#include <vector>

namespace LAMMPS_NS {

struct PeridemBooks {
  bool open{false};
  std::vector<double> friction, damping;    // forces on owned nodes, three numbers each

  void clear(int nlocal)
  {
    friction.assign(3 * static_cast<std::size_t>(nlocal), 0.0);
    damping.assign(3 * static_cast<std::size_t>(nlocal), 0.0);
  }

  static void add(std::vector<double> &forces, int i, const double *force, double factor = 1.0)
  {
    for (int k = 0; k < 3; k++) forces[3 * i + k] += factor * force[k];
  }

  // power of forces on the first n nodes, that move with v; a style that books none has none
  static double power(const std::vector<double> &forces, double **v, int n)
  {
    if (forces.empty()) return 0.0;
    double sum = 0.0;
    for (int i = 0; i < n; i++)
      for (int k = 0; k < 3; k++) sum += forces[3 * i + k] * v[i][k];
    return sum;
  }
};

}    // namespace LAMMPS_NS

#endif
