/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Initial cracks: surfaces that no bond crosses from the start.

#ifndef LMP_PERIDEM_CUT_H
#define LMP_PERIDEM_CUT_H

#include "pointers.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class PeridemCuts : protected Pointers {
 public:
  PeridemCuts(class LAMMPS *lmp) : Pointers(lmp) {}

  // reads "plane ...", "segment ..." or "region ID" at arg[iarg]; returns where it stopped
  int add(int iarg, int narg, char **arg, const std::string &style);

  bool empty() const { return cuts.empty(); }

  // regions may have been deleted or redefined since; collective
  void init();

  // does the bond from X to X + d cross a cut?
  bool crosses(const double *X, const double *d) const;

 private:
  enum Kind { PLANE, SEGMENT, REGION };
  struct Cut {
    Kind kind;
    double point[3], normal[3];    // of a plane; end points of a segment
    double radius;                 // of the disc that a plane is limited to; infinite: not limited
    std::string region_id;
    class Region *region;
  };
  std::vector<Cut> cuts;

  double number(int iarg, int narg, char **arg, const std::string &what);
  int add_plane(int iarg, int narg, char **arg, const std::string &style);
  int add_segment(int iarg, int narg, char **arg, const std::string &style);
  static bool crosses_plane(const Cut &, const double *X, const double *d);
  static bool crosses_segment(const Cut &, const double *X, const double *d);
  static bool crosses_region(const Cut &, const double *X, const double *d);
};

}    // namespace LAMMPS_NS

#endif
