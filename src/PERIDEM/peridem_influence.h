/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The influence function w(R/horizon): how much a bond of length R counts.

#ifndef LMP_PERIDEM_INFLUENCE_H
#define LMP_PERIDEM_INFLUENCE_H

#include <cmath>

namespace LAMMPS_NS {

struct PeridemInfluence {
  enum Kind { LINEAR, CONSTANT, GAUSSIAN, INVERSE };
  int kind{LINEAR};
  double width{1.0};    // of the gaussian: w = exp(-(R/horizon)^2 / width)

  // q = R/horizon in (0,1]
  double operator()(double q) const
  {
    switch (kind) {
      case CONSTANT:
        return 1.0;
      case GAUSSIAN:
        return std::exp(-q * q / width);
      case INVERSE:
        return 1.0 / q;
      default:
        return q < 1.0 ? 1.0 - q : 0.0;
    }
  }

  bool operator==(const PeridemInfluence &other) const
  {
    return kind == other.kind && (kind != GAUSSIAN || width == other.width);
  }

  // moment of order n: integral of w(q) q^n over 0 < q < 1 (n >= 1 keeps it finite for all kinds)
  double moment(int n) const
  {
    // Simpson's rule; exact to rounding for the polynomials, 1e-13 for the gaussian
    const int intervals = 2000;
    double sum = 0.0;
    for (int k = 1; k <= intervals; k++) {
      const double q = static_cast<double>(k) / intervals;
      const double factor = (k == intervals) ? 1.0 : (k % 2 ? 4.0 : 2.0);
      sum += factor * (*this)(q) *std::pow(q, n);
    }
    return sum / (3.0 * intervals);    // the integrand vanishes at q = 0
  }
};

}    // namespace LAMMPS_NS

#endif
