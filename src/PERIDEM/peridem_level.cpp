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

#include "peridem_level.h"

#include "error.h"
#include "force.h"
#include "neighbor.h"
#include "pair_hybrid.h"
#include "respa.h"
#include "update.h"

using namespace LAMMPS_NS;

namespace {

// A hybrid style shows its sub-styles only to its kin.

struct Kin : public PairHybrid {
  static int count(const PairHybrid *hybrid) { return hybrid->*(&Kin::nstyles); }
  static Pair *style(const PairHybrid *hybrid, int k) { return (hybrid->*(&Kin::styles))[k]; }
};

// as the script counts them, from 1; 0 = at none

int level_of(const Respa *respa, Force *force, const Pair *pair)
{
  if (respa->nhybrid_styles == 0) return 1 + MAX(respa->level_pair, respa->level_outer);
  const auto *hybrid = dynamic_cast<const PairHybrid *>(force->pair);
  if (!hybrid) return 0;
  for (int k = 0; k < MIN(respa->nhybrid_styles, Kin::count(hybrid)); k++)
    if (Kin::style(hybrid, k) == pair) return 1 + respa->hybrid_level[k];
  return 0;
}

}    // namespace

/* ---------------------------------------------------------------------- */

void PeridemLevel::find(const Pair *pair, const std::string &name)
{
  scheme = nullptr;
  level = 0;
  evaluations = 1;
  // a minimizer knows no levels
  if (update->whichflag == 2 || !utils::strmatch(update->integrate_style, "^respa")) return;
  scheme = dynamic_cast<Respa *>(update->integrate);
  if (pair) {
    const int given = level_of(scheme, force, pair);
    if (given < 1 || given > scheme->nlevels)
      error->all(FLERR, Error::NOLASTLINE,
                 "{} is at level {} of run_style respa, which has levels 1 to {}: its forces would "
                 "never be computed; give the level of each pair style, in their order",
                 name, given, scheme->nlevels);
    level = given - 1;
  }
  for (int k = level; k < scheme->nlevels - 1; k++) evaluations *= scheme->loop[k];
}

/* ---------------------------------------------------------------------- */

double PeridemLevel::dt() const
{
  return scheme && update->whichflag == 1 ? scheme->step[level] : update->dt;
}

/* ----------------------------------------------------------------------
   lists stay as old as they are while the inner levels go on
------------------------------------------------------------------------- */

bool PeridemLevel::lists_are_new()
{
  if (neighbor->ago != 0) return false;
  const bool seen = scheme && !update->setupflag && lists_seen == update->ntimestep;
  lists_seen = update->ntimestep;
  return !seen;
}

/* ---------------------------------------------------------------------- */

PeridemMoment PeridemClock::next(const PeridemLevel &level)
{
  PeridemMoment now;
  now.dt = level.dt();
  now.whole = update->dt;
  if (update->whichflag != 1 || update->setupflag) {
    last_step = update->ntimestep;
    done = level.count();
    return now;
  }
  const bool first = update->ntimestep != last_step;
  if (first) done = 0;
  now.stepping = done < level.count();
  now.begins = first || !now.stepping;
  if (now.stepping) done++;
  now.part = static_cast<double>(done) / level.count();
  last_step = update->ntimestep;
  return now;
}
