/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// A grain that moves as a rigid body: its centre, its turning, and how one step changes them.

#ifndef LMP_PERIDEM_RIGID_BODY_H
#define LMP_PERIDEM_RIGID_BODY_H

namespace LAMMPS_NS {

struct PeridemRigidBody {
  double mass;
  double x[3], v[3];             // of the centre of mass, x without periodic images
  double l[3];                   // angular momentum about the centre of mass
  double q[4];                   // from the body's axes to space
  double inertia[3];             // principal moments
  double omega[3];               // angular velocity
  double ex[3], ey[3], ez[3];    // principal axes in space
  double force[3], torque[3];

  // principal axes and moments from the moment of inertia about the centre of mass (xx, yy, zz, xy,
  // xz, yz), spin from the angular momentum
  void orient(const double *tensor);

  void kick(double dtf);                 // half a step of velocities
  void drift(double dtv, double dtq);    // a step of positions

  // a point of the body in its own axes, and back in space, from the centre of mass
  void to_body(const double *r, double *d) const;
  void to_space(const double *d, double *r) const;
  // velocity of a point at r from the centre of mass
  void velocity(const double *r, double *u) const;

  double kinetic() const;    // energy, without unit conversion

  // adds what the spinning itself does to sum f (x) r
  void add_spinning(double *moment) const;
};

}    // namespace LAMMPS_NS

#endif
