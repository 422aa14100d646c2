/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The two passes of the linear peridynamic solid over a batch: grains of like families side by side,
// one in each lane.  Each bond is visited once.  With s = e/R and q = w v V_i V_j R^2
//   sum_i = sum q s,   F_ij = q (a_i + a_j + (b_i + b_j) s) / (R r) d
// so a bond needs 1/R and q alone.

#ifndef LMP_PERIDEM_BATCH_KERNEL_H
#define LMP_PERIDEM_BATCH_KERNEL_H

#include "peridem_simd.h"

namespace LAMMPS_NS {
namespace PeridemBatchKernel {

  using PeridemSimd::Lanes;
  using PeridemSimd::Pack;

  // square of a distance below which two nodes have no direction: no force, no division by 0
  static constexpr double TINY = 1.0e-300;

  // bonds that are read that much later are asked for from memory
  static constexpr int AHEAD = 32;

  // bonds first[n] <= k < first[n + 1] lead from node n to nodes partner[k] > n
  struct Bonds {
    int nodes;
    const int *first;
    const unsigned short *partner;
  };

  // What a bond is in each of the grains, told in full.  Where a grain lacks the bond, 1/R and q are 0.
  struct FullBonds : Bonds {
    const Pack *inverses, *strengths;    // 1/R and q

    // tells which grains have the bond; read once, as numbers that are written might be it
    using Has = Lanes;
    Has has(int k) const { return inverses[k].v; }
    Lanes inverse(int k) const { return inverses[k].v; }
    Lanes strength(int k) const { return strengths[k].v; }
    // top, which is not below 0, or how far the bond is stretched, if that is more
    template <bool BOTH> static Lanes raise(Lanes top, Has has, Lanes s)
    {
      const Lanes zero = {};    // without the bond s = -1
      if (BOTH) s = has > zero ? PeridemSimd::larger(s, -s) : zero;
      return PeridemSimd::larger(s, top);
    }
    void ask_for(int k) const
    {
      PeridemSimd::expect(inverses + k + AHEAD);
      PeridemSimd::expect(strengths + k + AHEAD);
    }
  };

  // The same of grains that are equal but for rounding: two fifths of the memory, which decides the
  // time of the first pass.  here: a bit for each grain that has the bond.
  struct LeanBonds : Bonds {
    const double *common, *strengths;    // 1/R of the first grain, q
    const float *rests;                  // what 1/R of each grain has more
    const unsigned char *here;

    using Has = unsigned char;
    Has has(int k) const { return here[k]; }
    Lanes inverse(int k) const
    {
      return PeridemSimd::widen(rests + k * PeridemSimd::WIDTH) + common[k];
    }
    Lanes strength(int k) const
    {
      return PeridemSimd::only(here[k], PeridemSimd::all(strengths[k]));
    }
    template <bool BOTH> static Lanes raise(Lanes top, Has has, Lanes s)
    {
      return PeridemSimd::larger_where(has, top, BOTH ? PeridemSimd::larger(s, -s) : s);
    }
    void ask_for(int k) const { PeridemSimd::expect(rests + (k + AHEAD) * PeridemSimd::WIDTH); }
  };

  template <int DIM>
  inline Lanes separation(const Pack *x, std::size_t j, const Lanes *xn, Lanes *d)
  {
    Lanes square = PeridemSimd::all(TINY);
    for (int m = 0; m < DIM; m++) {
      d[m] = x[DIM * j + m].v - xn[m];
      square += d[m] * d[m];
    }
    return square;
  }

  // What the first pass finds of a bond and the second one needs: q / (R r) and s.  To keep it takes
  // less time than to find it again while the second-level cache holds it.
  struct Found {
    Pack pull, stretch;
  };
  static constexpr std::size_t FOUND_BONDS = 4096;

  // sum, top: zero on entry; top = largest stretch, with BOTH largest size of the stretch; found: with
  // KEEP
  template <int DIM, bool BREAKS, bool BOTH, bool KEEP, class AnyBonds>
  void stretch_pass(const AnyBonds &bonds, const Pack *x, Pack *sum, Pack *top, Found *found)
  {
    for (int n = 0; n < bonds.nodes; n++) {
      Lanes xn[DIM], d[DIM];
      for (int m = 0; m < DIM; m++) xn[m] = x[DIM * n + m].v;
      Lanes mysum = sum[n].v, mytop = top[n].v;
      for (int k = bonds.first[n]; k < bonds.first[n + 1]; k++) {
        bonds.ask_for(k);
        const std::size_t j = bonds.partner[k];
        const Lanes square = separation<DIM>(x, j, xn, d);
        const Lanes inverse = bonds.inverse(k), q = bonds.strength(k);
        const auto has = bonds.has(k);
        const Lanes both = KEEP ? inverse * PeridemSimd::inverse_root(square) : Lanes{};
        const Lanes s = (KEEP ? square * both : PeridemSimd::root(square) * inverse) - 1.0;
        const Lanes part = q * s;
        mysum += part;
        sum[j].v += part;
        if (KEEP) {
          found[k].pull.v = q * both;
          found[k].stretch.v = s;
        }
        if (BREAKS) {
          mytop = AnyBonds::template raise<BOTH>(mytop, has, s);
          top[j].v = AnyBonds::template raise<BOTH>(top[j].v, has, s);
        }
      }
      sum[n].v = mysum;
      top[n].v = mytop;
    }
  }

  // the same for stretches from small displacements u
  template <int DIM, class AnyBonds>
  void linear_pass(const AnyBonds &bonds, const Pack *x, const Pack *u, Pack *sum, Found *found)
  {
    for (int n = 0; n < bonds.nodes; n++) {
      Lanes xn[DIM], d[DIM];
      for (int m = 0; m < DIM; m++) xn[m] = x[DIM * n + m].v;
      for (int k = bonds.first[n]; k < bonds.first[n + 1]; k++) {
        const std::size_t j = bonds.partner[k];
        Lanes inverse_r = PeridemSimd::inverse_root(separation<DIM>(x, j, xn, d)), along = {};
        for (int m = 0; m < DIM; m++) along += (u[DIM * j + m].v - u[DIM * n + m].v) * d[m];
        const Lanes q = bonds.strength(k), both = bonds.inverse(k) * inverse_r, s = along * both;
        sum[n].v += q * s;
        sum[j].v += q * s;
        found[k].pull.v = q * both;
        found[k].stretch.v = s;
      }
    }
  }

  // Sums over bonds, for each lane: energy of the extensions, and the virial xx, yy, zz, xy, xz, yz
  static constexpr int TALLIES = 7;

  template <int DIM> inline void tally_bond(Lanes energy, Lanes pull, const Lanes *d, Pack *tallies)
  {
    tallies[0].v += energy;
    for (int m = 0; m < DIM; m++) tallies[1 + m].v -= pull * d[m] * d[m];
    tallies[4].v -= pull * d[0] * d[1];
    if (DIM == 3) {
      tallies[5].v -= pull * d[0] * d[DIM - 1];
      tallies[6].v -= pull * d[1] * d[DIM - 1];
    }
  }

  // v, g: velocities and dashpots, with VISCOUS; force: zero on entry; tallies: with TALLY
  template <int DIM, bool VISCOUS, bool TALLY, class AnyBonds>
  void force_pass(const AnyBonds &bonds, const Pack *x, const Pack *v, const Pack *a, const Pack *b,
                  const Pack *g, Pack *force, Pack *tallies)
  {
    for (int n = 0; n < bonds.nodes; n++) {
      Lanes xn[DIM], vn[DIM], d[DIM], f[DIM], inverse_r, gn{};
      for (int m = 0; m < DIM; m++) {
        xn[m] = x[DIM * n + m].v;
        f[m] = force[DIM * n + m].v;
        if (VISCOUS) vn[m] = v[DIM * n + m].v;
      }
      const Lanes an = a[n].v, bn = b[n].v;
      if (VISCOUS) gn = g[n].v;
      for (int k = bonds.first[n]; k < bonds.first[n + 1]; k++) {
        const std::size_t j = bonds.partner[k];
        const Lanes r = PeridemSimd::root(separation<DIM>(x, j, xn, d), inverse_r);
        const Lanes inverse = bonds.inverse(k);
        const Lanes q = bonds.strength(k), s = r * inverse - 1.0, bb = bn + b[j].v;
        Lanes t = (an + a[j].v) + bb * s;
        if (VISCOUS) {
          Lanes rate = (v[DIM * j].v - vn[0]) * d[0];
          for (int m = 1; m < DIM; m++) rate += (v[DIM * j + m].v - vn[m]) * d[m];
          t += (gn + g[j].v) * rate * inverse_r * inverse;
        }
        t *= q * inverse * inverse_r;
        if (TALLY) tally_bond<DIM>(0.5 * bb * q * s * s, t, d, tallies);
        for (int m = 0; m < DIM; m++) {
          f[m] += t * d[m];
          force[DIM * j + m].v -= t * d[m];
        }
      }
      for (int m = 0; m < DIM; m++) force[DIM * n + m].v = f[m];
    }
  }

  // the same without dashpots, from what the first pass has found
  template <int DIM, bool TALLY, class AnyBonds>
  void short_force_pass(const AnyBonds &bonds, const Pack *x, const Pack *a, const Pack *b,
                        const Found *found, Pack *force, Pack *tallies)
  {
    for (int n = 0; n < bonds.nodes; n++) {
      Lanes xn[DIM], d[DIM], f[DIM];
      for (int m = 0; m < DIM; m++) {
        xn[m] = x[DIM * n + m].v;
        f[m] = force[DIM * n + m].v;
      }
      const Lanes an = a[n].v, bn = b[n].v;
      for (int k = bonds.first[n]; k < bonds.first[n + 1]; k++) {
        const std::size_t j = bonds.partner[k];
        for (int m = 0; m < DIM; m++) d[m] = x[DIM * j + m].v - xn[m];
        const Lanes s = found[k].stretch.v, bb = bn + b[j].v;
        const Lanes t = found[k].pull.v * ((an + a[j].v) + bb * s);
        if (TALLY) tally_bond<DIM>(0.5 * bb * bonds.strength(k) * s * s, t, d, tallies);
        for (int m = 0; m < DIM; m++) {
          f[m] += t * d[m];
          force[DIM * j + m].v -= t * d[m];
        }
      }
      for (int m = 0; m < DIM; m++) force[DIM * n + m].v = f[m];
    }
  }

}    // namespace PeridemBatchKernel
}    // namespace LAMMPS_NS

#endif
