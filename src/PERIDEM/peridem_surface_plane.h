/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// A plane as the surface of a wall.

#ifndef LMP_PERIDEM_SURFACE_PLANE_H
#define LMP_PERIDEM_SURFACE_PLANE_H

#include "peridem_surface.h"

namespace LAMMPS_NS {

class PeridemSurfacePlane : public PeridemSurface {
 public:
  // arg[iarg] is the word plane, behind it come x y z nx ny nz
  PeridemSurfacePlane(class LAMMPS *, const char *style, int iarg, int narg, char **arg);
  static constexpr int WORDS = 7;

  void feet(const double *x, double cutoff, std::vector<Foot> &) override;
  bool near(const double *x, double reach) override { return distance(x) < reach; }
  bool permits(const double *x) override { return distance(x) >= 0.0; }
  int most_feet() const override { return 1; }
  bool pushes_back() const override { return true; }
  const std::vector<Part> &parts() const override { return whole; }
  void centre(double *) const override;
  std::string wrong_side() const override { return "behind the plane"; }
  std::string right_side() const override
  {
    return "its normal must point to the side where the grains are";
  }

 private:
  double point[3]{0.0, 0.0, 0.0};
  double normal[3]{0.0, 0.0, 0.0};    // unit vector to the side where the grains are
  std::vector<Part> whole;

  double distance(const double *x) const
  {
    return (x[0] - point[0]) * normal[0] + (x[1] - point[1]) * normal[1] +
        (x[2] - point[2]) * normal[2];
  }
};

}    // namespace LAMMPS_NS

#endif
