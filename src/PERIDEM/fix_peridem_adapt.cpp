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

#include "fix_peridem_adapt.h"

#include "fix_peridem_bonds.h"
#include "fix_peridem_timestep.h"
#include "peridem_stamp.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include <cstring>

using namespace LAMMPS_NS;
using namespace FixConst;

static constexpr int NTOTALS = 6;    // numbers in a restart file before the grains

/* ---------------------------------------------------------------------- */

FixPeridemAdapt::FixPeridemAdapt(LAMMPS *lmp, int narg, char **arg) :
    FixNVE(lmp, narg, arg), options(lmp, narg, arg), table(lmp, igroup, options), nodes(lmp, table),
    switches(lmp, table, nodes, options), inertia(lmp, table)
{
  if (!atom->style_match("peridem"))
    error->all(FLERR, 2, "Fix {} requires atom style peridem; the atom style is {}", style,
               atom->get_style());
  time_integrate = 1;
  nevery = 1;
  vector_flag = peratom_flag = 1;
  size_vector = 7;
  extvector = 0;
  global_freq = peratom_freq = 1;
  size_peratom_cols = 0;
  restart_global = restart_peratom = 1;
  create_attribute = 1;

  FixPeridemAdapt::grow_arrays(atom->nmax);
  for (int i = 0; i < atom->nlocal; i++) FixPeridemAdapt::set_arrays(i);
  atom->add_callback(Atom::GROW);
  atom->add_callback(Atom::RESTART);
}

/* ---------------------------------------------------------------------- */

FixPeridemAdapt::~FixPeridemAdapt()
{
  atom->delete_callback(id, Atom::GROW);
  atom->delete_callback(id, Atom::RESTART);
  memory->destroy(state);
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::setmask()
{
  return INITIAL_INTEGRATE | PRE_FORCE | FINAL_INTEGRATE | END_OF_STEP;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::init()
{
  check_others();
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
  table.find_styles();
  inertia.find_prescribed();
  FixNVE::init();
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::check_others() const
{
  if (modify->get_fix_by_style("^peridem/adapt$").size() > 1)
    error->all(FLERR, Error::NOLASTLINE, "More than one fix {}", style);
  if (!utils::strmatch(update->integrate_style, "^verlet"))
    error->all(FLERR, Error::NOLASTLINE, "Fix {} needs run_style verlet, not {}", style,
               update->integrate_style);
  if (update->whichflag == 2)
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {} has no minimization: grains that are rigid would lose their shape; unfix it "
               "before minimize and define it again after it",
               style);
  if (domain->triclinic)
    error->all(FLERR, Error::NOLASTLINE, "Fix {} does not work in triclinic boxes", style);
  for (const auto *fix : modify->get_fix_list())
    if (fix->rigid_flag && (fix->groupbit & groupbit) && fix != this)
      error->all(FLERR, Error::NOLASTLINE,
                 "Fix {} and fix {} {} both move rigid grains: give them different groups", style,
                 fix->id, fix->style);
}

/* ----------------------------------------------------------------------
   families exist, forces have not been computed yet
------------------------------------------------------------------------- */

void FixPeridemAdapt::setup_pre_force(int)
{
  const bool first_time = !started;
  if (first_time || natoms_seen != atom->natoms || table.highest_molecule() > table.highest()) {
    table.check_whole();
    for (auto &grain : table.grains) grain.state = Grain::NONE;    // nodes came or went
    take_stock();
    if (options.start_rigid && first_time) switches.start();
    started = true;
  } else {
    for (auto &grain : table.grains)
      if (grain.state != Grain::NONE) table.set_limits(grain);
    sort_nodes();
    switches.follow_user();
  }
  comm->forward_comm();    // ghosts move as their grains do now
  tell_others();
  pre_force(0);
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::take_stock()
{
  natoms_seen = atom->natoms;
  table.survey();
  int outside = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (!table.in_group(i) && table.bonded(i)) outside = 1;
  MPI_Allreduce(MPI_IN_PLACE, &outside, 1, MPI_INT, MPI_MAX, world);
  others_deform = outside;
  states_stale = true;
  sort_nodes();
}

/* ----------------------------------------------------------------------
   nodes have other places in the arrays
------------------------------------------------------------------------- */

void FixPeridemAdapt::sort_nodes()
{
  table.sort_nodes();
  regroup();
}

/* ----------------------------------------------------------------------
   grains have other states
------------------------------------------------------------------------- */

void FixPeridemAdapt::regroup()
{
  nodes.collect();
  const auto loose = table.loose();
  single.assign(loose.begin(), loose.end());
  for (tagint mol = 1; mol <= table.highest(); mol++) {
    if (table.grains[mol].rigid()) continue;
    const auto own = table.nodes(mol);
    single.insert(single.end(), own.begin(), own.end());
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::tell_others()
{
  states_stale = step_stale = true;
  regroup();
  if (bonds) bonds->flag_rigid();
  inertia.find_lightest();
}

/* ---------------------------------------------------------------------- */

bool FixPeridemAdapt::any_deformable() const
{
  return others_deform || table.any(Grain::DEFORMABLE);
}

/* ----------------------------------------------------------------------
   a grain that wakes needs a shorter step at once
------------------------------------------------------------------------- */

void FixPeridemAdapt::end_of_step()
{
  if (!step_stale) return;
  step_stale = false;
  for (auto *fix : modify->get_fix_by_style("^peridem/timestep$"))
    dynamic_cast<FixPeridemTimestep *>(fix)->set_timestep();
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::setup(int)
{
  nodes.sum_forces(options.sleep > 0.0);
  nodes.set_velocities(true);
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::initial_integrate(int vflag)
{
  if (nodes.grains.empty()) {
    FixNVE::initial_integrate(vflag);
    return;
  }
  move_single(true);
  for (const tagint mol : nodes.grains) {
    auto &grain = table.grains[mol];
    if (grain.state != Grain::RIGID) continue;
    grain.body.kick(dtf);
    grain.body.drift(dtv, 0.5 * dtv);
  }
  nodes.place();
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::move_single(bool drift)
{
  double **x = atom->x, **v = atom->v, **f = atom->f;
  const double *const rmass = atom->rmass;
  for (const int i : single) {
    const double dtfm = dtf / rmass[i];
    for (int k = 0; k < 3; k++) {
      v[i][k] += dtfm * f[i][k];
      if (drift) x[i][k] += dtv * v[i][k];
    }
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::final_integrate()
{
  const bool with_sizes = options.sleep > 0.0;
  if (nodes.grains.empty())
    FixNVE::final_integrate();
  else {
    move_single(false);
    nodes.finish_step(with_sizes, dtf);
  }
  switches.relax_vibration(dtv);

  bool changed = switches.consider_loads(dtv);
  if (update->ntimestep % options.every == 0) changed = switches.look_for_quiet() || changed;
  for (auto &grain : table.grains) grain.since += dtv;
  if (!changed) return;
  tell_others();
  nodes.sum_forces(with_sizes);
}

/* ----------------------------------------------------------------------
   forces are about to be computed; the state of each node, for output
------------------------------------------------------------------------- */

void FixPeridemAdapt::pre_force(int)
{
  inertia.clear_springs();
  if (neighbor->ago == 0) sort_nodes();
  if (!states_stale && neighbor->ago != 0) return;
  states_stale = false;
  for (int i = 0; i < atom->nlocal; i++) {
    const tagint mol = atom->molecule[i];
    state[i] = table.in_group(i) && mol ? table.grains[mol].state : Grain::DEFORMABLE;
  }
}

/* ----------------------------------------------------------------------
   grains deformable, rigid, asleep; wakings, freezings; energy taken; energy held
------------------------------------------------------------------------- */

double FixPeridemAdapt::compute_vector(int n)
{
  if (n < 3) return static_cast<double>(table.listed(Grain::DEFORMABLE + n).size());
  if (n == 3) return static_cast<double>(switches.wakes);
  if (n == 4) return static_cast<double>(switches.freezes);
  return n == 5 ? switches.taken : switches.energy_held();
}

/* ---------------------------------------------------------------------- */

double FixPeridemAdapt::memory_usage()
{
  return 4.0 * atom->nmax * sizeof(double) + nodes.memory_usage() +
      static_cast<double>(table.grains.size()) * sizeof(Grain);
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::grow_arrays(int nmax)
{
  memory->grow(table.offset, nmax, 3, "peridem/adapt:offset");
  memory->grow(state, nmax, "peridem/adapt:state");
  vector_atom = state;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::copy_arrays(int i, int j, int)
{
  for (int k = 0; k < 3; k++) table.offset[j][k] = table.offset[i][k];
  state[j] = state[i];
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::set_arrays(int i)
{
  for (int k = 0; k < 3; k++) table.offset[i][k] = 0.0;
  state[i] = Grain::DEFORMABLE;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::pack_exchange(int i, double *buf)
{
  for (int k = 0; k < 3; k++) buf[k] = table.offset[i][k];
  buf[3] = state[i];
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::unpack_exchange(int nlocal, double *buf)
{
  for (int k = 0; k < 3; k++) table.offset[nlocal][k] = buf[k];
  state[nlocal] = buf[3];
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::pack_restart(int i, double *buf)
{
  buf[0] = 4;
  for (int k = 0; k < 3; k++) buf[1 + k] = table.offset[i][k];
  return 4;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::unpack_restart(int nlocal, int nth)
{
  double **extra = atom->extra;
  int m = 0;
  for (int k = 0; k < nth; k++) m += static_cast<int>(extra[nlocal][m]);
  for (int k = 0; k < 3; k++) table.offset[nlocal][k] = extra[nlocal][m + 1 + k];
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::size_restart(int)
{
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::maxsize_restart()
{
  return 4;
}

/* ----------------------------------------------------------------------
   all ranks hold the table: the first writes it
------------------------------------------------------------------------- */

static constexpr PeridemStamp STAMP(3, sizeof(PeridemAdaptGrain));

void FixPeridemAdapt::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const auto &grains = table.grains;
  const double totals[NTOTALS] = {STAMP.number,
                                  static_cast<double>(grains.size()),
                                  switches.taken,
                                  static_cast<double>(switches.wakes),
                                  static_cast<double>(switches.freezes),
                                  static_cast<double>(atom->natoms)};
  const int size = static_cast<int>(sizeof(totals) + grains.size() * sizeof(Grain));
  fwrite(&size, sizeof(int), 1, fp);
  fwrite(totals, sizeof(double), NTOTALS, fp);
  fwrite(grains.data(), sizeof(Grain), grains.size(), fp);
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::restart(char *buf)
{
  double totals[NTOTALS];
  memcpy(totals, buf, sizeof(totals));
  STAMP.check(totals[0], fmt::format("Fix {}", style), error);
  auto &grains = table.grains;
  grains.resize(static_cast<std::size_t>(totals[1]));
  memcpy(static_cast<void *>(grains.data()), buf + sizeof(totals), grains.size() * sizeof(Grain));
  switches.taken = totals[2];
  switches.wakes = static_cast<bigint>(totals[3]);
  switches.freezes = static_cast<bigint>(totals[4]);
  natoms_seen = static_cast<bigint>(totals[5]);
  started = true;
}
