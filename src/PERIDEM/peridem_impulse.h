/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// How long the steps of two forces may be that act at two levels of run_style respa.
//
// The slow force, of stiffness A, kicks the nodes every step H; in between the fast one, of stiffness
// B, moves them by k steps of velocity Verlet.  (A and B with the masses taken in; their largest
// eigenvalues are the squared frequencies a and b.)  Positions after each H then obey
//
//   x(t + H) - 2 cos(T) x(t) + x(t - H) = -H S A x(t),
//
// with functions of the matrix B: T = 2 k asin(h sqrt(B)/2), h = H/k, the angle that k steps of Verlet
// turn, and S = sin(T)/sqrt(B (1 - h^2 B/4)).  While T < pi, S is positive, and with y = S^(-1/2) x the
// recurrence has a symmetric matrix: it is stable if 2 cos(T) - H S^(1/2) A S^(1/2) > -2.  That is so if
//
//   H a tan(t/2) < 2 w,  t = 2 k asin(h sqrt(b)/2) < pi,  w = sqrt(b (1 - h^2 b/4)),
//
// since w/tan(t/2) falls with b: a bound that needs no more than the two frequencies, exact where
// the fastest modes of both are one.  For k = 1 it is Verlet's own, H^2 (a + b) < 4.  Beyond t = pi
// kicks can come in step with the fast motion: H is to be less than half of its period.

#ifndef LMP_PERIDEM_IMPULSE_H
#define LMP_PERIDEM_IMPULSE_H

#include <cmath>
#include <limits>

namespace LAMMPS_NS {
namespace PeridemImpulse {

  // squared frequencies; k steps of the fast force in one of the slow
  inline bool stable(double H, double slow_sq, double fast_sq, int k)
  {
    const double h = H / k, half = 0.5 * h * std::sqrt(fast_sq);
    if (half >= 1.0) return false;
    const double turn = k * std::asin(half);    // t/2
    if (turn >= 2.0 * std::atan(1.0)) return false;
    const double w = std::sqrt(fast_sq * (1.0 - half * half));
    return H * slow_sq * std::tan(turn) < 2.0 * w;
  }

  // largest stable step of the slow force
  inline double largest_slow_step(double slow_sq, double fast_sq, int k)
  {
    if (slow_sq + fast_sq == 0.0) return std::numeric_limits<double>::infinity();
    if (fast_sq == 0.0) return 2.0 / std::sqrt(slow_sq);
    if (slow_sq == 0.0) return 2.0 * k / std::sqrt(fast_sq);    // there are no kicks
    if (k == 1) return 2.0 / std::sqrt(slow_sq + fast_sq);
    double low = 0.0, high = 2.0 * k / std::sqrt(fast_sq);
    while (high - low > 1.0e-12 * high) {
      const double middle = 0.5 * (low + high);
      (stable(middle, slow_sq, fast_sq, k) ? low : high) = middle;
    }
    return low;
  }

  // of two forces that are evaluated so many times in one step of the run: its largest step
  inline double largest_step(double one_sq, int one_count, double other_sq, int other_count)
  {
    if (one_count > other_count) return largest_step(other_sq, other_count, one_sq, one_count);
    return one_count * largest_slow_step(one_sq, other_sq, other_count / one_count);
  }

}    // namespace PeridemImpulse
}    // namespace LAMMPS_NS

#endif
