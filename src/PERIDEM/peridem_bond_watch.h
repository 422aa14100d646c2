/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What may happen to bonds, and is not what somebody wants, is said: a time step too long for them,
// bonds compressed to nothing, bonded nodes about to be lost, and what "rerun" cannot know.

#ifndef LMP_PERIDEM_BOND_WATCH_H
#define LMP_PERIDEM_BOND_WATCH_H

#include "peridem_stability.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;
class PairPeridem;
class PeridemRows;

class PeridemBondWatch : protected Pointers {
 public:
  explicit PeridemBondWatch(class LAMMPS *lmp) : Pointers(lmp), stability(lmp) {}

  // the following are collective

  void init(const std::vector<PairPeridem *> &);    // a run begins
  void look_at_time_step();                         // once there are forces
  void look_at_box(const PeridemRows &) const;
  double
  longest_bond(const FixPeridemBonds &);    // at the present positions; looks for crushed ones

 private:
  PeridemStability stability;
  bool said_compressed{false};    // in this run
  bool said_rerun{false};
  int solids_inits{-1};    // how often the solids had been initialised when this was

  void look_at_rerun(const std::vector<PairPeridem *> &);
  void say_compressed(double shortest, int i, int j);
};

}    // namespace LAMMPS_NS

#endif
