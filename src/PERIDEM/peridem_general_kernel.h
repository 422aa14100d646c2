/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The two passes of the linear peridynamic solid over a list that has each bond once.  The first
// knows no dilatation yet, so it finds what makes the dilatations and the part of the forces without
// them; the second adds the rest.  With e = r - R, q = w v V_i V_j
//   sum_i = sum q R e
//   F_ij = q [(b_i + b_j) e + (g_i + g_j) dr/dt] d / r  +  q R (a_i + a_j) d / r
// Positions with b, and then with a, are four numbers that move as one, and so do force and sum.

#ifndef LMP_PERIDEM_GENERAL_KERNEL_H
#define LMP_PERIDEM_GENERAL_KERNEL_H

#include "peridem_simd.h"

#include <cstddef>

namespace LAMMPS_NS {
namespace PeridemGeneralKernel {

  using PeridemSimd::Lanes;
  using PeridemSimd::Node;
  using PeridemSimd::WIDTH;

  // square of a distance below which two nodes have no direction: no force, no division by 0
  static constexpr double TINY = 1.0e-300;

  // bonds that are read that much later are asked for from memory: with bonds that do not fit the
  // caches the loops wait for little else
  static constexpr int AHEAD = 128;

  // Row n holds the bonds first[n] <= k < first[n + 1], filled up to whole Lanes, of node WIDTH + n.
  // Nodes below WIDTH are none: bonds that fill up lead to them, with q = 0 and R = GONE, like bonds
  // that are broken.
  static constexpr double GONE = 1.0e200;

  struct Bonds {
    int rows;
    const std::size_t *first;
    const int *partner;
    const double *length, *strength;    // R and q

    void ask_for(std::size_t k) const
    {
      PeridemSimd::expect(partner + k + AHEAD);
      PeridemSimd::expect(length + k + AHEAD);
      PeridemSimd::expect(strength + k + AHEAD);
    }
  };

  // bonds from a node to WIDTH others
  struct Fan {
    Lanes d[4];    // separations; what the partners have in the fourth place
    Lanes square;

    Fan(const Node *x, const int *partner, const Lanes *me)
    {
      PeridemSimd::load_nodes(x, partner, d);
      square = PeridemSimd::all(TINY);
      for (int m = 0; m < 3; m++) {
        d[m] -= me[m];
        square += d[m] * d[m];
      }
    }
  };

  inline void spread(const Node &node, Lanes *to)
  {
    for (int m = 0; m < 4; m++) to[m] = PeridemSimd::all(node.v[m]);
  }

  // forces of the two ends cancel
  inline void add_total(const Lanes *mine, Node &to)
  {
    double total[4];
    PeridemSimd::sum_lanes(mine, total);
    for (int m = 0; m < 3; m++) to.v[m] += total[m];
    to.v[3] -= total[3];
  }

  // does any of the bonds reach the stretch from which on one of its ends wants to know?
  template <bool BOTH>
  inline bool worth_a_look(Lanes e, Lanes R, Lanes mine, const double *known, const int *partner)
  {
    // what has no bond is as if compressed
    const Lanes gone = PeridemSimd::all(GONE), zero = {};
    const Lanes reached = BOTH ? (R < gone ? PeridemSimd::larger(e, -e) : zero) : e;
    const Lanes theirs = PeridemSimd::gather(known, partner);
    return PeridemSimd::any_above(reached, PeridemSimd::smaller(mine, theirs) * R);
  }

  // x: positions and b; v: velocities and g, with VISCOUS; with LINEAR, displacements that bonds are
  // stretched by instead of by what positions say; known: with BREAKS, above which stretch
  // look(n, k) is to be called for node n and its WIDTH bonds from k on; sums: zero on entry
  template <bool BREAKS, bool BOTH, bool VISCOUS, bool LINEAR, class Look>
  void first_pass(const Bonds &bonds, const Node *x, const Node *v, const double *known, Node *sums,
                  Look look)
  {
    for (int n = WIDTH; n < WIDTH + bonds.rows; n++) {
      Lanes me[4], my_v[4], mine[4] = {}, part[4];
      spread(x[n], me);
      if (VISCOUS || LINEAR) spread(v[n], my_v);
      Lanes my_known = PeridemSimd::all(BREAKS ? known[n] : 0.0);
      for (auto k = bonds.first[n - WIDTH]; k < bonds.first[n - WIDTH + 1]; k += WIDTH) {
        bonds.ask_for(k);
        const int *const partner = bonds.partner + k;
        const Fan to(x, partner, me);
        Lanes inverse, u[4], rate = {};
        const Lanes r = PeridemSimd::root(to.square, inverse);
        const Lanes R = PeridemSimd::load(bonds.length + k);
        const Lanes q = PeridemSimd::load(bonds.strength + k);
        if (VISCOUS || LINEAR) {
          PeridemSimd::load_nodes(v, partner, u);
          for (int m = 0; m < 3; m++) rate += (u[m] - my_v[m]) * to.d[m];
        }
        const Lanes e = LINEAR ? rate * inverse : r - R;
        if (BREAKS && worth_a_look<BOTH>(e, R, my_known, known, partner)) {
          look(n, k);
          my_known = PeridemSimd::all(known[n]);
        }
        Lanes pull = (me[3] + to.d[3]) * e;
        if (VISCOUS) pull += (my_v[3] + u[3]) * rate * inverse;
        pull *= q * inverse;
        for (int m = 0; m < 3; m++) part[m] = pull * to.d[m];
        part[3] = -q * R * e;
        for (int m = 0; m < 4; m++) mine[m] += part[m];
        PeridemSimd::subtract_nodes(sums, partner, part);
      }
      add_total(mine, sums[n]);
    }
  }

  // x: positions and a; sums: forces are added to, the fourth numbers stay
  inline void second_pass(const Bonds &bonds, const Node *x, Node *sums)
  {
    for (int n = WIDTH; n < WIDTH + bonds.rows; n++) {
      Lanes me[4], mine[4] = {}, part[4] = {};
      spread(x[n], me);
      for (auto k = bonds.first[n - WIDTH]; k < bonds.first[n - WIDTH + 1]; k += WIDTH) {
        bonds.ask_for(k);
        const int *const partner = bonds.partner + k;
        const Fan to(x, partner, me);
        const Lanes R = PeridemSimd::load(bonds.length + k);
        const Lanes q = PeridemSimd::load(bonds.strength + k);
        const Lanes pull = q * R * (me[3] + to.d[3]) * PeridemSimd::inverse_root(to.square);
        for (int m = 0; m < 3; m++) {
          part[m] = pull * to.d[m];
          mine[m] += part[m];
        }
        PeridemSimd::subtract_nodes(sums, partner, part);
      }
      add_total(mine, sums[n]);
    }
  }

}    // namespace PeridemGeneralKernel
}    // namespace LAMMPS_NS

#endif
