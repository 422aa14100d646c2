/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Largest eigenvalue of a symmetric operator by Lanczos' method: a few dozen products with it.

#ifndef LMP_PERIDEM_LANCZOS_H
#define LMP_PERIDEM_LANCZOS_H

#include <algorithm>
#include <cmath>
#include <vector>

namespace LAMMPS_NS {

class PeridemLanczos {
 public:
  // apply(in, out): out = A in;  dot(a, b): inner product over all ranks;
  // start: any vector with a part in the wanted direction (random)
  template <class Apply, class Dot>
  static double largest_eigenvalue(std::vector<double> start, Apply apply, Dot dot)
  {
    const std::size_t n = start.size();
    std::vector<double> previous(n, 0.0), current(std::move(start)), next(n);
    const double norm = std::sqrt(dot(current, current));
    if (!(norm > 0.0)) return 0.0;
    for (auto &value : current) value /= norm;

    std::vector<double> alpha, beta;    // diagonal and off-diagonal of the projection
    double eigenvalue = 0.0, before = 0.0;
    int settled = 0;
    while (settled < 2 && alpha.size() < MAXSTEPS) {
      apply(current, next);
      alpha.push_back(dot(current, next));
      for (std::size_t i = 0; i < n; i++) {
        next[i] -= alpha.back() * current[i];
        if (!beta.empty()) next[i] -= beta.back() * previous[i];
      }
      eigenvalue = largest_of_tridiagonal(alpha, beta);
      settled = std::fabs(eigenvalue - before) <= ACCURACY * std::fabs(eigenvalue) ? settled + 1
                                                                                   : 0;
      before = eigenvalue;

      const double length = std::sqrt(dot(next, next));
      if (!(length > 1.0e-14 * std::fabs(eigenvalue))) break;    // the space is exhausted
      beta.push_back(length);
      for (std::size_t i = 0; i < n; i++) next[i] /= length;
      previous.swap(current);
      current.swap(next);
    }
    return eigenvalue;
  }

 private:
  static constexpr std::size_t MAXSTEPS = 200;
  static constexpr double ACCURACY = 1.0e-4;    // relative change that counts as settled

  // bisection with Sturm's count of the eigenvalues below a number
  static double largest_of_tridiagonal(const std::vector<double> &alpha,
                                       const std::vector<double> &beta)
  {
    const std::size_t n = alpha.size();
    double lo = alpha[0], hi = alpha[0];
    for (std::size_t i = 0; i < n; i++) {
      const double radius = (i > 0 ? beta[i - 1] : 0.0) + (i + 1 < n ? beta[i] : 0.0);
      lo = std::max(lo, alpha[i]);
      hi = std::max(hi, alpha[i] + radius);
    }
    for (int bisection = 0; bisection < 60 && hi - lo > 1.0e-12 * std::fabs(hi); bisection++) {
      const double middle = 0.5 * (lo + hi);
      std::size_t below = 0;
      double pivot = 1.0;
      for (std::size_t i = 0; i < n; i++) {
        pivot = alpha[i] - middle - (i > 0 ? beta[i - 1] * beta[i - 1] / pivot : 0.0);
        if (pivot == 0.0) pivot = 1.0e-300;
        if (pivot < 0.0) below++;
      }
      if (below == n)
        hi = middle;
      else
        lo = middle;
    }
    return 0.5 * (lo + hi);
  }
};

}    // namespace LAMMPS_NS

#endif
