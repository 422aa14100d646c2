/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Computes that were invoked since Modify::clearstep_compute() are to be ready again at the given step.
// Modify::addstep_compute() takes all of them in some releases, invoked or not, so that energy and
// pressure are summed up at every step of a scene whose walls move by variables.

#ifndef LMP_PERIDEM_SCHEDULE_H
#define LMP_PERIDEM_SCHEDULE_H

#include "compute.h"
#include "modify.h"

namespace LAMMPS_NS {
namespace PeridemSchedule {

  inline void invoked(Modify *modify, bigint step)
  {
    for (auto *compute : modify->get_compute_list())
      if (compute->timeflag && compute->invoked_flag > 0) compute->addstep(step);
  }

}    // namespace PeridemSchedule
}    // namespace LAMMPS_NS

#endif
