/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Contributing author: the PERIDEM developers
------------------------------------------------------------------------- */

#include "compute_peridem_dt.h"

#include "error.h"
#include "update.h"

#include <cmath>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

ComputePeridemDt::ComputePeridemDt(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg), stability(lmp)
{
  if (narg > 3) error->all(FLERR, 3, "Unknown compute {} keyword {}", style, arg[3]);
  scalar_flag = vector_flag = 1;
  size_vector = 4;
  extscalar = extvector = 0;
  vector = new double[size_vector];
}

/* ---------------------------------------------------------------------- */

ComputePeridemDt::~ComputePeridemDt()
{
  delete[] vector;
}

/* ----------------------------------------------------------------------
   1 = bonds, 2 = contacts, 3 = dashpots, 4 = speeds; 0 where there is no limit
------------------------------------------------------------------------- */

void ComputePeridemDt::compute_vector()
{
  invoked_vector = invoked_scalar = update->ntimestep;
  const auto limits = stability.find();
  const double values[4] = {limits.bonds, limits.contacts, limits.dashpots, limits.speeds};
  for (int k = 0; k < 4; k++) vector[k] = std::isfinite(values[k]) ? values[k] : 0.0;
  scalar = std::isfinite(limits.stable) ? limits.stable : 0.0;
}

/* ---------------------------------------------------------------------- */

double ComputePeridemDt::compute_scalar()
{
  if (invoked_vector != update->ntimestep) compute_vector();
  return scalar;
}
