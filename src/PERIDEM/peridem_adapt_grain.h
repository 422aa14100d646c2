/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What fix peridem/adapt knows of one grain, and the sums over its nodes that it needs.

#ifndef LMP_PERIDEM_ADAPT_GRAIN_H
#define LMP_PERIDEM_ADAPT_GRAIN_H

#include "peridem_load.h"
#include "peridem_rigid_body.h"

namespace LAMMPS_NS {

// a plain struct: it travels in restart files
struct PeridemAdaptGrain {
  enum State { NONE, DEFORMABLE, RIGID, ASLEEP };

  int state;
  int broken;      // 1: some bond of it is broken
  int quiet;       // checks in a row that found it quiet
  int trial;       // 1: it has just become rigid, and how its contacts load it is not known yet
  int count;       // of its nodes
  int patience;    // it takes so many times longer before it is rigid again
  double volume, young, s0, factor;
  double limit;             // bound of the stretch that wakes it
  double size, speed;       // diameter of a ball of its volume; of waves in it
  double loaded;            // for how long its bound has been above half the limit
  double relax;             // time for which its vibration is still damped
  double since;             // time that it has been in its state
  double strain;            // energy of its bonds when it became rigid
  double reach;             // of its farthest node from the centre, since then
  PeridemRigidBody body;    // deformable: x is near its centre of mass

  bool rigid() const { return state == RIGID || state == ASLEEP; }
  double
  felt_mass(int dimension) const;    // what a force at its farthest node has to move, at least
  double period() const { return 2.0 * size / speed; }    // of its slowest vibration, about
};

// mass, momentum, angular momentum and inertia of some nodes
struct PeridemMoments {
  double mass, first[3], momentum[3], spin[3], second[6], kinetic;

  static constexpr int SIZE = 17;    // as doubles

  // a node at r from a point near the centre of mass; second: xx, yy, zz, xy, xz, yz
  void add(double m, const double *r, const double *v);

  // the rigid body with the same mass, momentum and angular momentum; in: body.x is that point
  void to_body(PeridemRigidBody &body) const;
};

static_assert(sizeof(PeridemMoments) == PeridemMoments::SIZE * sizeof(double),
              "moments travel as numbers");

}    // namespace LAMMPS_NS

#endif
