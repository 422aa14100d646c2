/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Where a point touches a region that is not made of others.

#ifndef LMP_PERIDEM_REGION_FACES_H
#define LMP_PERIDEM_REGION_FACES_H

namespace LAMMPS_NS {

class Region;

// Region::surface(), but right for cones and ellipsoids.  LAMMPS (4Jul2026 and before) lets the ends
// of a cone along y push along z, finds no outside of a cone that ends in a point, no outside of an
// ellipsoid in 2d whose third axis is short, and misses ellipsoids a little below the cutoff.
int peridem_region_faces(Region *, int dimension, const double *x, double cutoff);

}    // namespace LAMMPS_NS

#endif
