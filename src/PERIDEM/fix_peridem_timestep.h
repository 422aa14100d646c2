/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(peridem/timestep,FixPeridemTimestep);
// clang-format on
#else

#ifndef LMP_FIX_PERIDEM_TIMESTEP_H
#define LMP_FIX_PERIDEM_TIMESTEP_H

#include "fix.h"
#include "peridem_stability.h"

#include <set>
#include <string>

namespace LAMMPS_NS {

// Sets the time step to a fraction of the largest stable one.

class FixPeridemTimestep : public Fix {
 public:
  FixPeridemTimestep(class LAMMPS *, int, char **);
  int setmask() override;
  void init() override;
  void setup(int) override;
  void end_of_step() override;
  double compute_scalar() override;
  double compute_vector(int) override;

  // look now; collective
  void set_timestep();

 private:
  double safety{0.8};
  PeridemStability stability;
  PeridemStability::Limits limits;
  std::string ruling;            // what limits the step
  std::set<std::string> said;    // that it did
};

}    // namespace LAMMPS_NS

#endif
#endif
