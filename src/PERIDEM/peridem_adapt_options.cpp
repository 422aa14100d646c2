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

#include "peridem_adapt_options.h"

#include "error.h"
#include "pointers.h"
#include "utils.h"

#include <map>
#include <string>

using namespace LAMMPS_NS;

static constexpr char NAME[] = "Fix peridem/adapt";

/* ---------------------------------------------------------------------- */

static void read_start(LAMMPS *lmp, int iarg, char **arg, bool &rigid)
{
  const std::string word = arg[iarg];
  rigid = word == "rigid";
  if (!rigid && word != "deformable")
    lmp->error->all(FLERR, iarg, "{} start {}: must be rigid or deformable", NAME, word);
}

/* ---------------------------------------------------------------------- */

static void read_count(LAMMPS *lmp, int iarg, char **arg, int &value)
{
  value = utils::inumeric(FLERR, arg[iarg], false, lmp);
  if (value < 1)
    lmp->error->all(FLERR, iarg, "{} {} {}: must be >= 1", NAME, arg[iarg - 1], arg[iarg]);
}

/* ---------------------------------------------------------------------- */

static void read_number(LAMMPS *lmp, int iarg, char **arg, double &value)
{
  const std::string key = arg[iarg - 1];
  value = utils::numeric(FLERR, arg[iarg], false, lmp);
  if (!(value >= 0.0)) lmp->error->all(FLERR, iarg, "{} {} {}: must be >= 0", NAME, key, arg[iarg]);
  if (key == "back" && value >= 1.0)
    lmp->error->all(FLERR, iarg, "{} back {}: must be >= 0 and < 1", NAME, arg[iarg]);
  if (key == "stretch" && value == 0.0)
    lmp->error->all(FLERR, iarg, "{} stretch {}: must be > 0", NAME, arg[iarg]);
}

/* ---------------------------------------------------------------------- */

PeridemAdaptOptions::PeridemAdaptOptions(LAMMPS *lmp, int narg, char **arg)
{
  const std::map<std::string, double *> numbers = {
      {"eta", &eta}, {"back", &back}, {"stretch", &stretch}, {"relax", &relax}, {"sleep", &sleep}};
  const std::map<std::string, int *> counts = {{"every", &every}, {"hold", &hold}};
  std::map<std::string, bool> seen;
  auto *const error = lmp->error;
  for (int iarg = 3; iarg < narg; iarg += 2) {
    const std::string key = arg[iarg];
    const bool is_number = numbers.count(key), is_count = counts.count(key);
    if (!is_number && !is_count && key != "start")
      error->all(FLERR, iarg,
                 "Unknown fix peridem/adapt keyword {}: known are eta, back, every, hold, relax, "
                 "sleep, start, stretch",
                 key);
    if (seen[key]) error->all(FLERR, iarg, "Repeated fix peridem/adapt keyword {}", key);
    seen[key] = true;
    if (iarg + 1 >= narg) error->all(FLERR, iarg, "{} {} needs a value", NAME, key);
    if (is_number)
      read_number(lmp, iarg + 1, arg, *numbers.at(key));
    else if (is_count)
      read_count(lmp, iarg + 1, arg, *counts.at(key));
    else
      read_start(lmp, iarg + 1, arg, start_rigid);
  }
  if (seen["eta"] && seen["stretch"])
    error->all(FLERR, 3, "{} eta and stretch: give one of them", NAME);
}
