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

#include "compute_peridem_energy.h"

#include "fix_peridem_ledger.h"

#include "atom.h"
#include "error.h"
#include "modify.h"
#include "update.h"

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

ComputePeridemEnergy::ComputePeridemEnergy(LAMMPS *lmp, int narg, char **arg) :
    Compute(lmp, narg, arg)
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, 2, "Compute {} requires atom style peridem; the atom style is {}", style,
               atom->get_style());
  if (narg > 3) error->all(FLERR, 3, "Unknown compute {} keyword {}", style, arg[3]);
  if (igroup) error->all(FLERR, 1, "Compute {} must use group all", style);
  if (modify->get_compute_by_style("^peridem/energy$").size() > 0)
    error->all(FLERR, 2, "There is a compute {} already: one ledger is enough", style);

  scalar_flag = vector_flag = 1;
  size_vector = 9;
  extscalar = extvector = 1;
  vector = new double[size_vector];
  ledger = dynamic_cast<FixPeridemLedger *>(FixPeridemLedger::make(lmp));
}

/* ---------------------------------------------------------------------- */

ComputePeridemEnergy::~ComputePeridemEnergy()
{
  if (modify && modify->get_fix_by_id("PERIDEM_LEDGER")) modify->delete_fix("PERIDEM_LEDGER");
  delete[] vector;
}

/* ---------------------------------------------------------------------- */

void ComputePeridemEnergy::init()
{
  if (!modify->get_fix_by_id("PERIDEM_LEDGER"))
    error->all(FLERR, Error::NOLASTLINE, "The fix that compute {} {} made is gone", id, style);
}

/* ----------------------------------------------------------------------
   1 strain, 2 contact, 3 broken bonds, 4 friction loss, 5 damping loss, 6 wall work, 7 kinetic,
   8 drift of the balance, 9 work of other forces and of prescribed motion
------------------------------------------------------------------------- */

void ComputePeridemEnergy::compute_vector()
{
  invoked_vector = update->ntimestep;
  ledger->balance(vector);
}

/* ----------------------------------------------------------------------
   drift of the balance
------------------------------------------------------------------------- */

double ComputePeridemEnergy::compute_scalar()
{
  invoked_scalar = update->ntimestep;
  if (invoked_vector != update->ntimestep) compute_vector();
  scalar = vector[7];
  return scalar;
}
