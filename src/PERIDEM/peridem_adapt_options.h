/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The keywords of fix peridem/adapt.

#ifndef LMP_PERIDEM_ADAPT_OPTIONS_H
#define LMP_PERIDEM_ADAPT_OPTIONS_H

namespace LAMMPS_NS {

struct PeridemAdaptOptions {
  double eta{0.3}, back{0.5}, stretch{0.0}, relax{2.0}, sleep{0.0};
  int every{50}, hold{4};
  bool start_rigid{true};

  PeridemAdaptOptions(class LAMMPS *, int narg, char **arg);
};

}    // namespace LAMMPS_NS

#endif
