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

#include "fix_peridem_ledger.h"

#include "fix_peridem_adapt.h"
#include "fix_peridem_wall.h"
#include "pair_peridem.h"
#include "pair_peridem_contact.h"
#include "peridem_stamp.h"

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "update.h"

#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

static constexpr char ID[] = "PERIDEM_LEDGER";
static constexpr char PLACE[] = "PERIDEM_LEDGER_PLACE";

/* ---------------------------------------------------------------------- */

FixPeridemLedger::FixPeridemLedger(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg)
{
  nevery = 1;
  restart_global = 1;
}

/* ---------------------------------------------------------------------- */

FixPeridemLedger::~FixPeridemLedger()
{
  if (!force || !force->pair || !modify) return;
  find_styles();
  for (auto *solid : solids) solid->books.open = false;
  if (contact) contact->books.open = false;
  for (auto *wall : walls) wall->books.open = false;
}

/* ---------------------------------------------------------------------- */

void FixPeridemLedger::keep_place(LAMMPS *lmp)
{
  if (lmp->modify->get_fix_by_id(ID) || lmp->modify->get_fix_by_id(PLACE)) return;
  lmp->modify->add_fix(std::string(PLACE) + " all DUMMY");
}

/* ---------------------------------------------------------------------- */

Fix *FixPeridemLedger::make(LAMMPS *lmp)
{
  const std::string command = std::string(ID) + " all " + ID;
  return lmp->modify->get_fix_by_id(PLACE) ? lmp->modify->replace_fix(PLACE, command, 1)
                                           : lmp->modify->add_fix(command);
}

/* ---------------------------------------------------------------------- */

int FixPeridemLedger::setmask()
{
  return INITIAL_INTEGRATE | POST_FORCE | END_OF_STEP;
}

/* ---------------------------------------------------------------------- */

void FixPeridemLedger::find_styles()
{
  solids = PairPeridem::find_all(lmp);
  contact = dynamic_cast<PairPeridemContact *>(force->pair_match("peridem/contact", 1));
  const auto adapts = modify->get_fix_by_style("^peridem/adapt$");
  adapt = adapts.empty() ? nullptr : dynamic_cast<const FixPeridemAdapt *>(adapts[0]);
  walls.clear();
  for (auto *fix : modify->get_fix_by_style("^peridem/wall$"))
    walls.push_back(dynamic_cast<FixPeridemWall *>(fix));
}

/* ---------------------------------------------------------------------- */

void FixPeridemLedger::init()
{
  for (int i = 0; i < modify->nfix && modify->fix[i] != this; i++)
    if (modify->fmask[i] & POST_FORCE)
      error->all(FLERR, Error::NOLASTLINE,
                 "Compute peridem/energy: fix {} {} must be defined after the pair style",
                 modify->fix[i]->id, modify->fix[i]->style);
  if (utils::strmatch(update->integrate_style, "^respa"))
    error->all(FLERR, Error::NOLASTLINE,
               "Compute peridem/energy cannot be used with run_style respa");

  find_styles();
  for (auto *solid : solids) solid->books.open = true;
  if (contact) contact->books.open = true;
  for (auto *wall : walls) wall->books.open = true;
  prescribed_bits = 0;
  for (const auto *fix : modify->get_fix_by_style("^move$")) prescribed_bits |= fix->groupbit;
}

/* ----------------------------------------------------------------------
   the books are opened at the start of the first run
------------------------------------------------------------------------- */

void FixPeridemLedger::setup(int)
{
  if (resumed) resume();
  if (started) return;
  started = true;
  kinetic_prescribed_at_start = kinetic(prescribed_bits);
  broken_at_start = broken();
  walls_at_start = wall_work();
  opening = true;
}

/* ----------------------------------------------------------------------
   this fix is the first that is set up: walls know their nodes after it only
------------------------------------------------------------------------- */

void FixPeridemLedger::open()
{
  if (!opening) return;
  opening = false;
  double totals[NITEMS];
  balance(totals);
  stored_at_start = totals[STRAIN] + totals[CONTACT] + totals[KINETIC];
}

/* ----------------------------------------------------------------------
   this fix comes first: so far there are only the forces of bonds and contacts
------------------------------------------------------------------------- */

void FixPeridemLedger::post_force(int)
{
  const double *const f = atom->f[0];
  internal.assign(f, f + 3 * static_cast<std::size_t>(atom->nlocal));
}

/* ----------------------------------------------------------------------
   Work is force times velocity at the same time, each step from half a step before to half a step
   after it: at a given time half of the last step is still to come (the trapezoidal rule).
   On nodes whose motion is prescribed, what prescribes it makes up for all forces.
------------------------------------------------------------------------- */

void FixPeridemLedger::end_of_step()
{
  double **f = atom->f, **v = atom->v;
  const int n = atom->nlocal;
  const double dt = update->dt;
  double total = 0.0, prescribed = 0.0;
  for (int i = 0; i < atom->nlocal; i++) {
    double power = 0.0;
    for (int k = 0; k < 3; k++) power += f[i][k] * v[i][k];
    total += power;
    if (atom->mask[i] & prescribed_bits) prescribed += power;
  }

  double inside = PeridemBooks::power(internal, v, n);
  last = {0.0, 0.0, 0.0, 0.0};
  for (auto *wall : walls) {
    const auto power = wall->power();
    inside += power.on_nodes;
    last.friction -= dt * power.friction;
    last.damping -= dt * power.damping;
  }
  if (contact) {
    last.friction -= dt * PeridemBooks::power(contact->books.friction, v, n);
    last.damping -= dt * PeridemBooks::power(contact->books.damping, v, n);
  }
  for (auto *solid : solids) last.damping -= dt * PeridemBooks::power(solid->books.damping, v, n);
  last.other = dt * (total - inside);
  last.on_prescribed = dt * prescribed;
  work.friction += last.friction;
  work.damping += last.damping;
  work.other += last.other;
  work.on_prescribed += last.on_prescribed;
}

/* ---------------------------------------------------------------------- */

double FixPeridemLedger::kinetic(int groupbits) const
{
  double **v = atom->v;
  double sum = 0.0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbits)
      sum += atom->rmass[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
  return 0.5 * force->mvv2e * sum;
}

/* ---------------------------------------------------------------------- */

double FixPeridemLedger::broken() const
{
  double sum = 0.0;
  for (const auto *solid : solids) sum += solid->broken_energy;
  return sum;
}

/* ----------------------------------------------------------------------
   over all ranks, and since the walls were made
------------------------------------------------------------------------- */

double FixPeridemLedger::wall_work() const
{
  double sum = 0.0;
  for (auto *wall : walls) sum += wall->compute_vector(7);
  return sum;
}

/* ---------------------------------------------------------------------- */

static constexpr PeridemStamp STAMP(1);

void FixPeridemLedger::write_restart(FILE *fp)
{
  Saved now{0.0, 0.0, 0.0, work, last, kinetic_prescribed_at_start, broken() - broken_at_start,
            0.0};
  MPI_Allreduce(MPI_IN_PLACE, &now, sizeof(Saved) / sizeof(double), MPI_DOUBLE, MPI_SUM, world);
  now.stamp = STAMP.number;
  now.started = started ? 1.0 : 0.0;
  now.stored_at_start = stored_at_start;
  now.walls = wall_work() - walls_at_start;
  if (comm->me) return;
  const int size = static_cast<int>(sizeof(Saved));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(&now, 1, size, fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemLedger::restart(char *buf)
{
  double stamp;
  memcpy(&stamp, buf, sizeof(double));
  STAMP.check(stamp, "Compute peridem/energy", error);
  memcpy(&saved, buf, sizeof(Saved));
  resumed = saved.started > 0.0;
}

/* ----------------------------------------------------------------------
   go on with the books of a restart file, on the first rank; styles made after the restart count
   broken bonds and work of walls from where they are now
------------------------------------------------------------------------- */

void FixPeridemLedger::resume()
{
  started = true;
  resumed = false;
  stored_at_start = saved.stored_at_start;
  walls_at_start = wall_work() - saved.walls;
  broken_at_start = broken();
  if (comm->me) return;
  work = saved.work;
  last = saved.last;
  broken_at_start -= saved.broken;
  kinetic_prescribed_at_start = saved.kinetic_prescribed_at_start;
}

/* ---------------------------------------------------------------------- */

void FixPeridemLedger::balance(double *totals)
{
  open();
  double mine[NITEMS] = {};
  for (auto *solid : solids)
    for (int i = 0; i < atom->nlocal; i++)
      if (solid->covers(atom->type[i]) && !(adapt && adapt->rigid(i)))
        mine[STRAIN] += solid->strain_energy(i);

  // a tangential spring holds part of what friction has taken so far
  double springs = contact ? contact->spring_energy() : 0.0;
  mine[CONTACT] = contact ? contact->elastic_energy() : 0.0;
  for (const auto *wall : walls) {
    springs += wall->spring_energy();
    mine[CONTACT] += wall->elastic_energy();
  }
  mine[CONTACT] += springs;
  mine[BROKEN] = broken() - broken_at_start;
  mine[FRICTION] = work.friction - 0.5 * last.friction - springs;
  mine[DAMPING] = work.damping - 0.5 * last.damping;
  mine[KINETIC] = kinetic(~0);
  // the motion of prescribed nodes is paid by what prescribes it
  mine[OTHER] = work.other - 0.5 * last.other + kinetic(prescribed_bits) -
      kinetic_prescribed_at_start - (work.on_prescribed - 0.5 * last.on_prescribed);
  if (adapt && comm->me == 0) {
    mine[STRAIN] += adapt->energy_held();
    mine[DAMPING] += adapt->energy_taken();
  }
  MPI_Allreduce(mine, totals, NITEMS, MPI_DOUBLE, MPI_SUM, world);
  totals[WALLS] = wall_work() - walls_at_start;

  const double stored = totals[STRAIN] + totals[CONTACT] + totals[KINETIC];
  const double lost = totals[BROKEN] + totals[FRICTION] + totals[DAMPING];
  totals[DRIFT] = stored - stored_at_start + lost - totals[WALLS] - totals[OTHER];
}

/* ---------------------------------------------------------------------- */

double FixPeridemLedger::memory_usage()
{
  return static_cast<double>(internal.capacity()) * sizeof(double);
}
