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

#include "peridem_stamp.h"

#include "comm.h"
#include "error.h"
#include "lammps.h"
#include "utils.h"

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

void PeridemStamp::check(double found, const std::string &style, Error *error) const
{
  if (found != number)
    error->all(FLERR, Error::NOLASTLINE,
               "{}: the restart file was written by another version of the package: go on with "
               "that one, or start from a data file (write_data)",
               style);
}

/* ---------------------------------------------------------------------- */

void PeridemStamp::write(FILE *fp) const
{
  fwrite(&number, sizeof(double), 1, fp);
}

/* ---------------------------------------------------------------------- */

void PeridemStamp::read(FILE *fp, const std::string &style, LAMMPS *lmp) const
{
  double found = 0.0;
  if (lmp->comm->me == 0) utils::sfread(FLERR, &found, sizeof(double), 1, fp, nullptr, lmp->error);
  MPI_Bcast(&found, 1, MPI_DOUBLE, 0, lmp->world);
  check(found, style, lmp->error);
}
