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
ComputeStyle(peridem/energy,ComputePeridemEnergy);
// clang-format on
#else

#ifndef LMP_COMPUTE_PERIDEM_ENERGY_H
#define LMP_COMPUTE_PERIDEM_ENERGY_H

#include "compute.h"

namespace LAMMPS_NS {

class FixPeridemLedger;

// The energy ledger: what is stored, what was lost, what came in, and what is missing.

class ComputePeridemEnergy : public Compute {
 public:
  ComputePeridemEnergy(class LAMMPS *, int, char **);
  ~ComputePeridemEnergy() override;
  void init() override;
  double compute_scalar() override;
  void compute_vector() override;

 private:
  FixPeridemLedger *ledger{nullptr};
};

}    // namespace LAMMPS_NS

#endif
#endif
