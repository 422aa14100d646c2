/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The bodies that collide: a whole grain moves as one rigid body, a piece of a broken grain is felt
// as the patch of nodes around the one that touches.  What makes a collision of deformable grains
// lose energy acts between bodies, because the two nodes that touch hardly move against each other:
// a stiff contact follows the bulk behind it.

#ifndef LMP_PERIDEM_BODIES_H
#define LMP_PERIDEM_BODIES_H

#include "atom.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

// mass, place and rigid motion of a set of nodes

struct PeridemMotion {
  double mass{0.0}, place[3]{0.0, 0.0, 0.0}, velocity[3]{0.0, 0.0, 0.0};
  double spin[3]{0.0, 0.0, 0.0};
  double inverse[6]{};    // of the tensor of inertia: xx, yy, zz, xy, xz, yz; 0 where nothing turns

  // of a point at this distance from the centre of mass
  void velocity_at(const double *arm, double *v) const;
  // of the nodes at this distance by a force and a torque about the centre of mass
  void acceleration_at(const double *arm, const double *force, const double *torque,
                       double *a) const;
  // velocity over impulse at that point, as a tensor
  void mobility_at(const double *arm, double *tensor) const;
  // spin and inverse from the angular momentum and the tensor of inertia
  void turn(const double *momentum, const double *inertia);
};

// a body as its node that touches feels it

struct PeridemBody {
  double offset[3];      // of the centre of mass from the node
  double velocity[3];    // of the node, if the body were rigid
  double mobility[6];    // velocity of the node over impulse at it: xx, yy, zz, xy, xz, yz
  double whole;          // 1 for a grain, 0 for a patch of a broken one

  static constexpr int SIZE = 13;    // as doubles, for communication

  // speed over impulse along a unit vector
  double mobility_along(const double *n) const;
};

class PeridemBodies : protected Pointers {
 public:
  PeridemBodies(class LAMMPS *);

  // sum up mass, place and motion of every grain; bonds may be null; collective
  void find(const FixPeridemBonds *);

  // the body that the owned node i belongs to
  PeridemBody body(int i) const;

  // a force on that body at the node: spread over its nodes as one that moves a rigid body.  Patches
  // of broken grains are served at once, in spread (three numbers for each owned and ghost node),
  // whole grains by apply()
  void push(int i, const double *force, double *spread);

  // adds the forces on whole grains to those of their owned nodes, f (three numbers each);
  // collective
  void apply(double *f);

  double memory_usage() const;

 private:
  struct Push {
    double force[3]{0.0, 0.0, 0.0}, torque[3]{0.0, 0.0, 0.0};
  };
  std::vector<PeridemMotion> grains;    // by molecule-ID
  std::vector<char> broken;             // by molecule-ID
  std::vector<Push> pushes;             // on whole grains, by molecule-ID
  std::vector<double> sums;
  std::vector<double> arms;    // of owned nodes, from the centres of their grains
  const FixPeridemBonds *bonds{nullptr};
  bigint natoms_seen{-1};
  tagint highest{0};

  void find_highest();
  void find_places();
  void find_spins();
  bool whole(int i) const;
  void unwrap();
  const double *arm_of(int i) const { return &arms[3 * i]; }
  template <class Visit> void for_patch(int i, Visit) const;
  PeridemMotion patch(int i) const;
  void push_patch(int i, const double *force, double *spread) const;
};

}    // namespace LAMMPS_NS

#endif
