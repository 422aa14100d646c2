/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// How a set of nodes moves as if it were one rigid body, and what a node that touches feels of it.

#ifndef LMP_PERIDEM_MOTION_H
#define LMP_PERIDEM_MOTION_H

#include "lmptype.h"

#include <cstring>

namespace LAMMPS_NS {

// sums over nodes, from which their motion follows

struct PeridemSums {
  double mass{0.0}, place[3]{}, velocity[3]{}, momentum[3]{};    // times mass but the first
  double square[6]{};    // of places: xx, yy, zz, xy, xz, yz; in 2d the first two

  // a node; in 2d two numbers each
  template <int DIM> void add(double m, const double *x, const double *v)
  {
    double p[3];
    for (int k = 0; k < DIM; k++) {
      p[k] = m * x[k];
      place[k] += p[k];
      velocity[k] += m * v[k];
      square[k] += p[k] * x[k];
    }
    mass += m;
    momentum[2] += p[0] * v[1] - p[1] * v[0];
    if (DIM == 2) return;
    momentum[0] += p[1] * v[2] - p[2] * v[1];
    momentum[1] += p[2] * v[0] - p[0] * v[2];
    square[3] += p[0] * x[1];
    square[4] += p[0] * x[2];
    square[5] += p[1] * x[2];
  }

  PeridemSums operator+(const PeridemSums &other) const
  {
    PeridemSums sum(*this);
    sum.mass += other.mass;
    for (int k = 0; k < 3; k++) {
      sum.place[k] += other.place[k];
      sum.velocity[k] += other.velocity[k];
      sum.momentum[k] += other.momentum[k];
    }
    for (int k = 0; k < 6; k++) sum.square[k] += other.square[k];
    return sum;
  }
};

// mass, place and rigid motion of a set of nodes

struct PeridemMotion {
  double mass{0.0}, place[3]{0.0, 0.0, 0.0}, velocity[3]{0.0, 0.0, 0.0};
  double spin[3]{0.0, 0.0, 0.0};
  double inverse[6]{};    // of the tensor of inertia: xx, yy, zz, xy, xz, yz; 0 where nothing turns

  PeridemMotion() = default;
  // places in the sums are about that origin
  PeridemMotion(const PeridemSums &, const double *origin);

  // of a point at this distance from the centre of mass
  void velocity_at(const double *arm, double *v) const;
  // by a torque
  void angular_acceleration(const double *torque, double *a) const;

 private:
  // spin and inverse from the angular momentum and the tensor of inertia
  void turn(const double *momentum, const double *inertia);
};

// a body as its node that touches feels it; nothing but doubles, for communication

struct PeridemBody {
  double id;             // the bytes of name()
  double offset[3];      // of the centre of mass from the node
  double velocity[3];    // of the node, if the body were rigid
  double lightness;      // 1 / mass
  double inverse[6];     // as of the motion

  static constexpr int SIZE = 14;

  // of the body, the same on all ranks
  bigint number() const
  {
    bigint which;
    std::memcpy(&which, &id, sizeof(which));
    return which;
  }
  void name(bigint which) { std::memcpy(&id, &which, sizeof(which)); }

  // speed over impulse along a unit vector
  double mobility_along(const double *n) const;
};

static_assert(sizeof(bigint) == sizeof(double), "an id fits into a number");
static_assert(sizeof(PeridemBody) == PeridemBody::SIZE * sizeof(double),
              "bodies travel as numbers");

}    // namespace LAMMPS_NS

#endif
