/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What a wall needs to know of its surface: where a node touches it, and how it moves there.

#ifndef LMP_PERIDEM_SURFACE_H
#define LMP_PERIDEM_SURFACE_H

#include "peridem_level.h"
#include "pointers.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class PeridemSurface : protected Pointers {
 public:
  // where a node touches the surface
  struct Foot {
    int key;               // of the face: the same for as long as the node stays at it
    int part;              // which of the parts below the face belongs to
    double distance;       // of the node from the surface
    double normal[3];      // unit vector from the surface to the node
    double at[3];          // nearest point of the surface
    double velocity[3];    // of the surface at that point
  };

  // a part that moves as a rigid body: its velocity at a point, and how fast it turns about it
  struct Part {
    double point[3]{0.0, 0.0, 0.0};
    double velocity[3]{0.0, 0.0, 0.0};
    double spin[3]{0.0, 0.0, 0.0};
  };

  explicit PeridemSurface(class LAMMPS *lmp) : Pointers(lmp) {}
  virtual ~PeridemSurface() = default;

  // before each run
  virtual void init() {}
  // the surface of this moment
  virtual void advance(const PeridemMoment &) {}
  // faces nearer to x than the cutoff
  virtual void feet(const double *x, double cutoff, std::vector<Foot> &) = 0;
  // a face, seen from either side, may be nearer to x than the reach
  virtual bool near(const double *x, double reach) = 0;
  // how far, at most, any point of the surface within a box has moved since the last mark
  virtual void mark() {}
  virtual double drift(const double * /*low*/, const double * /*high*/) const { return 0.0; }
  // false: x is behind the surface
  virtual bool permits(const double *x) = 0;
  // most faces a node can touch at a time
  virtual int most_feet() const = 0;

  virtual bool moves() const { return false; }
  virtual bool changes_shape() const { return false; }
  // a node that has gone through is pushed back by a plane, and missed by a region
  virtual bool pushes_back() const = 0;
  virtual const std::vector<Part> &parts() const = 0;
  // the point that torques are about
  virtual void centre(double *) const = 0;

  // what to say of nodes that are not permitted: where they are, and where they should be
  virtual std::string wrong_side() const = 0;
  virtual std::string right_side() const = 0;

  // motion so far, for restarts
  virtual std::vector<double> state() const { return {}; }
  virtual void restore(const double *, int) {}
};

}    // namespace LAMMPS_NS

#endif
