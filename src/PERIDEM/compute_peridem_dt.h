/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef COMPUTE_CLASS
// clang-format off
ComputeStyle(peridem/dt,ComputePeridemDt);
// clang-format on
#else

#ifndef LMP_COMPUTE_PERIDEM_DT_H
#define LMP_COMPUTE_PERIDEM_DT_H

#include "compute.h"
#include "peridem_stability.h"

namespace LAMMPS_NS {

// The largest stable time step, and what bonds, contacts and dashpots alone would allow.

class ComputePeridemDt : public Compute {
 public:
  ComputePeridemDt(class LAMMPS *, int, char **);
  ~ComputePeridemDt() override;
  void init() override {}
  double compute_scalar() override;
  void compute_vector() override;

 private:
  PeridemStability stability;
};

}    // namespace LAMMPS_NS

#endif
#endif
