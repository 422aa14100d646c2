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

#include "fix_peridem_timestep.h"

#include "comm.h"
#include "error.h"
#include "force.h"
#include "integrate.h"
#include "modify.h"
#include "output.h"
#include "pair.h"
#include "update.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

// where speeds rule, the step leaves this much room for them to grow
static constexpr double ROOM = 0.8;

/* ---------------------------------------------------------------------- */

FixPeridemTimestep::FixPeridemTimestep(LAMMPS *lmp, int narg, char **arg) :
    Fix(lmp, narg, arg), stability(lmp)
{
  nevery = 10;
  scalar_flag = vector_flag = 1;
  size_vector = 5;
  global_freq = 1;
  extscalar = extvector = 0;
  dynamic_group_allow = 1;

  bool seen_safety = false, seen_every = false;
  for (int iarg = 3; iarg < narg; iarg += 2) {
    const std::string key = arg[iarg];
    bool &seen = key == "safety" ? seen_safety : seen_every;
    if (key != "safety" && key != "every")
      error->all(FLERR, iarg, "Unknown fix {} keyword {}: known are safety, every", style, key);
    if (seen) error->all(FLERR, iarg, "Repeated fix {} keyword {}", style, key);
    seen = true;
    if (iarg + 1 >= narg) error->all(FLERR, iarg, "Fix {} {} needs a value", style, key);
    if (key == "safety") {
      safety = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      if (!(safety > 0.0 && safety <= 1.0))
        error->all(FLERR, iarg + 1, "Fix {} safety {}: must be > 0 and <= 1", style, arg[iarg + 1]);
    } else {
      nevery = utils::inumeric(FLERR, arg[iarg + 1], false, lmp);
      if (nevery < 1)
        error->all(FLERR, iarg + 1, "Fix {} every {}: must be >= 1", style, arg[iarg + 1]);
    }
  }
}

/* ---------------------------------------------------------------------- */

int FixPeridemTimestep::setmask()
{
  return END_OF_STEP;
}

/* ---------------------------------------------------------------------- */

void FixPeridemTimestep::init()
{
  if (modify->get_fix_by_style("^peridem/timestep$").size() > 1)
    error->all(FLERR, Error::NOLASTLINE, "More than one fix {}", style);
  stability.keep_styles();
}

/* ---------------------------------------------------------------------- */

void FixPeridemTimestep::setup(int)
{
  set_timestep();
}

/* ---------------------------------------------------------------------- */

void FixPeridemTimestep::end_of_step()
{
  set_timestep();
}

/* ---------------------------------------------------------------------- */

void FixPeridemTimestep::set_timestep()
{
  limits = stability.find(nevery);
  if (!std::isfinite(limits.stable))
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {}: there are neither bonds nor contacts that limit the time step", style);
  const double still = safety * limits.stable, dt = MIN(still, ROOM * limits.speeds);
  const std::string rules = dt == still ? limits.ruling() : "speeds";
  // speeds change at every step: keep a step that is short enough and not much too short
  if (rules == "speeds" && rules == ruling && update->dt <= MIN(still, limits.speeds) &&
      update->dt > 0.5 * dt)
    return;

  if (ruling != rules) {
    ruling = rules;
    // limits that are nearly alike take turns: each is named once
    if (said.insert(rules).second && comm->me == 0)
      utils::logmesg(
          lmp,
          "PERIDEM: time step set to {:.4g}, {:.2g} of the largest stable one; {} limit it "
          "(bonds alone {:.4g}, contacts alone {:.4g}, with dashpots {:.4g}{}{})\n",
          dt, dt / limits.stable, ruling, limits.bonds, limits.contacts, limits.stable,
          ruling == "speeds" ? fmt::format(", speeds {:.4g}", limits.speeds) : "",
          limits.bond_count * limits.contact_count > 1
              ? fmt::format("; in each step {} of bonds, {} of contacts", limits.bond_count,
                            limits.contact_count)
              : "");
  }
  if (dt == update->dt) return;

  update->update_time();
  update->dt = dt;
  update->dt_default = 0;
  update->integrate->reset_dt();    // of its levels
  if (force->pair) force->pair->reset_dt();
  for (const auto &ifix : modify->get_fix_list()) ifix->reset_dt();
  output->reset_dt();
}

/* ---------------------------------------------------------------------- */

double FixPeridemTimestep::compute_scalar()
{
  return update->dt;
}

/* ----------------------------------------------------------------------
   largest stable step of bonds, contacts, dashpots, all together; step of speeds (0 = no limit)
------------------------------------------------------------------------- */

double FixPeridemTimestep::compute_vector(int n)
{
  const double values[5] = {limits.bonds, limits.contacts, limits.dashpots, limits.stable,
                            limits.speeds};
  return std::isfinite(values[n]) ? values[n] : 0.0;
}
