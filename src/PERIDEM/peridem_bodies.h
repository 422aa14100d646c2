/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The bodies that collide: a whole grain moves as one, a piece of a broken grain is felt as the
// patch of nodes around the one that touches.  What makes a collision of deformable grains lose
// energy acts between bodies, because the two nodes that touch hardly move against each other: a
// stiff contact follows the bulk behind it.

#ifndef LMP_PERIDEM_BODIES_H
#define LMP_PERIDEM_BODIES_H

#include "atom.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

struct PeridemBody {
  double offset[3];      // of the centre of mass from the node that touches
  double velocity[3];    // of the centre of mass
  double mass;

  static constexpr int SIZE = 7;    // as doubles, for communication
};

class PeridemBodies : protected Pointers {
 public:
  PeridemBodies(class LAMMPS *);

  // sum up mass, place and velocity of every grain; bonds may be null; collective
  void find(const FixPeridemBonds *);

  // the body that the owned node i belongs to
  PeridemBody body(int i) const;

  // a force on that body, at its centre of mass: spread over its nodes by mass. Patches of broken
  // grains are served at once, in spread (three numbers for each owned and ghost node), whole
  // grains by apply()
  void push(int i, const double *force, double *spread);

  // adds the forces on whole grains to those of their owned nodes, f (three numbers each);
  // collective
  void apply(double *f);

  // The fastest approach that the contacts of a grain remember: a new contact of two grains that
  // touch already starts from it, not from the slow approach of its own first step.
  // forget, note for owned nodes, share (collective), then ask.
  void forget_peaks();
  void note_peak(int i, double peak);
  void share_peaks();
  double peak(int i) const { return peaks[atom->molecule[i]]; }

  double memory_usage() const;

 private:
  struct Sums {
    double mass, place[3], velocity[3], broken;
  };
  std::vector<Sums> grains;      // by molecule-ID
  std::vector<double> pushes;    // on whole grains, by molecule-ID
  std::vector<double> peaks;     // by molecule-ID
  const FixPeridemBonds *bonds{nullptr};
  bigint natoms_seen{-1};
  tagint highest{0};

  bool whole(int i) const;
  void unwrapped(int i, double *x) const;
  PeridemBody patch(int i) const;
  void push_patch(int i, const double *force, double *spread) const;
};

}    // namespace LAMMPS_NS

#endif
