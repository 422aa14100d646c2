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
#include "pair_peridem.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "force.h"
#include "group.h"
#include "math_const.h"
#include "math_extra.h"
#include "memory.h"
#include "modify.h"
#include "neighbor.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

using namespace LAMMPS_NS;
using namespace FixConst;

static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// forces on a grain that sum to more than this part of their sizes do not balance
static constexpr double UNBALANCED = 0.2;

// more than rounding
static constexpr double CHANGED = 1.0e-9;

// Stable is not exact: the bonds keep the steps of deformable grains short, the collisions of rigid
// ones are resolved by taking them for lighter than they are, so with twice the steps
static constexpr double RESOLVED = 4.0;

static constexpr int MAXPATIENCE = 64;
static constexpr int NTOTALS = 5;    // numbers in a restart file before the grains

/* ---------------------------------------------------------------------- */

FixPeridemAdapt::FixPeridemAdapt(LAMMPS *lmp, int narg, char **arg) : FixNVE(lmp, narg, arg)
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
  parse(narg, arg);

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
  memory->destroy(offset);
  memory->destroy(state);
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::parse(int narg, char **arg)
{
  const std::map<std::string, double *> positive = {
      {"eta", &eta}, {"back", &back}, {"stretch", &stretch}, {"relax", &relax}, {"sleep", &sleep}};
  const std::map<std::string, int *> counts = {{"every", &every}, {"hold", &hold}};
  std::map<std::string, bool> seen;
  for (int iarg = 3; iarg < narg; iarg += 2) {
    const std::string key = arg[iarg];
    const bool known = positive.count(key) || counts.count(key) || key == "start";
    if (!known)
      error->all(
          FLERR, iarg,
          "Unknown fix {} keyword {}: known are eta, back, every, hold, relax, sleep, start, "
          "stretch",
          style, key);
    if (seen[key]) error->all(FLERR, iarg, "Repeated fix {} keyword {}", style, key);
    seen[key] = true;
    if (iarg + 1 >= narg) error->all(FLERR, iarg, "Fix {} {} needs a value", style, key);
    const char *const word = arg[iarg + 1];
    if (key == "start") {
      start_rigid = std::string(word) == "rigid";
      if (!start_rigid && std::string(word) != "deformable")
        error->all(FLERR, iarg + 1, "Fix {} start {}: must be rigid or deformable", style, word);
    } else if (counts.count(key)) {
      int &value = *counts.at(key);
      value = utils::inumeric(FLERR, word, false, lmp);
      if (value < 1) error->all(FLERR, iarg + 1, "Fix {} {} {}: must be >= 1", style, key, word);
    } else {
      double &value = *positive.at(key);
      value = utils::numeric(FLERR, word, false, lmp);
      if (!(value >= 0.0))
        error->all(FLERR, iarg + 1, "Fix {} {} {}: must be >= 0", style, key, word);
      if (key == "back" && value >= 1.0)
        error->all(FLERR, iarg + 1, "Fix {} back {}: must be >= 0 and < 1", style, word);
    }
  }
  if (seen["eta"] && seen["stretch"])
    error->all(FLERR, 3, "Fix {} eta and stretch: give one of them", style);
  if (seen["stretch"] && stretch == 0.0) error->all(FLERR, 3, "Fix {} stretch: must be > 0", style);
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::setmask()
{
  return INITIAL_INTEGRATE | PRE_FORCE | FINAL_INTEGRATE | END_OF_STEP;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::init()
{
  if (modify->get_fix_by_style("^peridem/adapt$").size() > 1)
    error->all(FLERR, Error::NOLASTLINE, "More than one fix {}", style);
  if (!utils::strmatch(update->integrate_style, "^verlet"))
    error->all(FLERR, Error::NOLASTLINE, "Fix {} needs run_style verlet, not {}", style,
               update->integrate_style);
  if (domain->triclinic)
    error->all(FLERR, Error::NOLASTLINE, "Fix {} does not work in triclinic boxes", style);
  for (const auto *fix : modify->get_fix_list())
    if (fix->rigid_flag && (fix->groupbit & groupbit) && fix != this)
      error->all(FLERR, Error::NOLASTLINE,
                 "Fix {} and fix {} {} both move rigid grains: give them different groups", style,
                 fix->id, fix->style);
  const auto fixes = modify->get_fix_by_style("^peridem/bonds$");
  bonds = fixes.empty() ? nullptr : dynamic_cast<FixPeridemBonds *>(fixes[0]);
  solids = PairPeridem::find_all(lmp);
  FixNVE::init();
}

/* ----------------------------------------------------------------------
   families exist, forces have not been computed yet
------------------------------------------------------------------------- */

void FixPeridemAdapt::setup_pre_force(int)
{
  if (!started || natoms_seen != atom->natoms) {
    check_whole();
    if (started)
      for (auto &grain : grains) grain.state = Grain::NONE;    // nodes came or went
    measure();
    if (start_rigid && !started) {
      std::vector<tagint> whole;
      for (const tagint mol : listed(Grain::DEFORMABLE))
        if (!grains[mol].broken && grains[mol].limit > 0.0) whole.push_back(mol);
      freeze(whole);
      taken = 0.0;    // that the grains start rigid is no loss
      freezes = 0;
    }
    started = true;
  } else {
    for (auto &grain : grains)
      if (grain.state != Grain::NONE) set_limits(grain);
    follow_user();
  }
  comm->forward_comm();    // ghosts move as their grains do now
  tell_others();
  pre_force(0);
}

/* ----------------------------------------------------------------------
   a rigid grain is moved by the forces on all of its nodes
------------------------------------------------------------------------- */

void FixPeridemAdapt::check_whole()
{
  tagint highest = 0;
  for (int i = 0; i < atom->nlocal; i++) highest = MAX(highest, atom->molecule[i]);
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  std::vector<int> outside(highest + 1, 0), inside(highest + 1, 0);
  for (int i = 0; i < atom->nlocal; i++)
    ((atom->mask[i] & groupbit) ? inside : outside)[atom->molecule[i]]++;
  MPI_Allreduce(MPI_IN_PLACE, inside.data(), highest + 1, MPI_INT, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, outside.data(), highest + 1, MPI_INT, MPI_SUM, world);
  for (tagint mol = 1; mol <= highest; mol++)
    if (inside[mol] && outside[mol])
      error->all(FLERR, Error::NOLASTLINE,
                 "Fix {}: grain {} has {} nodes in group {} and {} that are not: whole grains only",
                 style, mol, inside[mol], group->names[igroup], outside[mol]);
}

/* ----------------------------------------------------------------------
   volume, centre, moduli, strength of grains that are not in the table yet
------------------------------------------------------------------------- */

void FixPeridemAdapt::measure()
{
  natoms_seen = atom->natoms;
  tagint highest = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (atom->mask[i] & groupbit) highest = MAX(highest, atom->molecule[i]);
  MPI_Allreduce(MPI_IN_PLACE, &highest, 1, MPI_LMP_TAGINT, MPI_MAX, world);
  grains.resize(highest + 1, Grain());

  int outside = 0;
  for (int i = 0; i < atom->nlocal; i++)
    if (!(atom->mask[i] & groupbit) && bonds && bonds->num[i] > 0) outside = 1;
  MPI_Allreduce(MPI_IN_PLACE, &outside, 1, MPI_INT, MPI_MAX, world);
  others_deform = outside;

  constexpr int N = 6;    // volume, mass, three of place, broken bonds
  std::vector<double> sum(N * (highest + 1), 0.0), weakest(3 * (highest + 1), INFINITE);
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    double x[3], *const s = &sum[N * atom->molecule[i]];
    double *const w = &weakest[3 * atom->molecule[i]];
    locate(atom->x[i], i, x);
    s[0] += atom->vfrac[i];
    s[1] += atom->rmass[i];
    for (int k = 0; k < 3; k++) s[2 + k] += atom->rmass[i] * x[k];
    if (bonds) s[5] += bonds->nref[i] - MAX(bonds->num[i], 0);
    const int itype = atom->type[i];
    for (const auto *solid : solids) {
      if (!solid->covers(itype)) continue;
      const auto &mat = solid->material(itype, itype);
      w[0] = MIN(w[0], 9.0 * mat.bulk * mat.shear / (3.0 * mat.bulk + mat.shear));
      w[1] = MIN(w[1], mat.s0);
      w[2] = MIN(w[2], mat.break_both ? -1.0 : 1.0);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), sum.size(), MPI_DOUBLE, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, weakest.data(), weakest.size(), MPI_DOUBLE, MPI_MIN, world);

  for (tagint mol = 1; mol <= highest; mol++) {
    auto &grain = grains[mol];
    const double *const s = &sum[N * mol], *const w = &weakest[3 * mol];
    if (s[1] == 0.0 || grain.state != Grain::NONE) continue;
    grain = Grain();
    grain.state = Grain::DEFORMABLE;
    grain.patience = 1;
    grain.broken = s[5] > 0.0;
    grain.volume = s[0];
    for (int k = 0; k < 3; k++) grain.body.x[k] = s[2 + k] / s[1];
    grain.young = w[0];
    grain.factor = w[2] < 0.0 ? PeridemLoad::FACTOR_BOTH : PeridemLoad::FACTOR_TENSION;
    grain.s0 = w[1];
    const int d = domain->dimension;
    grain.size = d == 2 ? 2.0 * std::sqrt(s[0] / MathConst::MY_PI)
                        : std::cbrt(6.0 * s[0] / MathConst::MY_PI);
    grain.speed = std::sqrt(force->ftm2v * w[0] * s[0] / s[1]);
    set_limits(grain);
  }
  states_stale = true;
}

/* ----------------------------------------------------------------------
   the stretch that wakes a grain; a grain without bonds has nothing that could be stretched
------------------------------------------------------------------------- */

void FixPeridemAdapt::set_limits(Grain &grain) const
{
  grain.limit = stretch > 0.0 ? stretch : eta * grain.s0;
  if (!std::isfinite(grain.young)) {
    grain.limit = INFINITE;
    grain.speed = grain.size = 1.0;
  } else if (!std::isfinite(grain.s0) && stretch == 0.0)
    error->all(FLERR, Error::NOLASTLINE,
               "Fix {}: there are unbreakable grains, so eta says nothing: give stretch", style);
}

/* ----------------------------------------------------------------------
   position of owned node i without periodic images
------------------------------------------------------------------------- */

void FixPeridemAdapt::locate(const double *x, int i, double *where) const
{
  domain->unmap(x, atom->image[i], where);
}

/* ---------------------------------------------------------------------- */

PeridemAdaptGrain *FixPeridemAdapt::grain_of(int i)
{
  return (atom->mask[i] & groupbit) && atom->molecule[i] ? &grains[atom->molecule[i]] : nullptr;
}

/* ---------------------------------------------------------------------- */

bool FixPeridemAdapt::rigid(int i) const
{
  const tagint mol = atom->molecule[i];
  return (atom->mask[i] & groupbit) && mol && mol < static_cast<tagint>(grains.size()) &&
      grains[mol].rigid();
}

/* ---------------------------------------------------------------------- */

std::vector<tagint> FixPeridemAdapt::listed(int which) const
{
  std::vector<tagint> list;
  for (tagint mol = 1; mol < static_cast<tagint>(grains.size()); mol++)
    if (grains[mol].state == which) list.push_back(mol);
  return list;
}

/* ----------------------------------------------------------------------
   sums over the nodes of some grains, about the centres that the table has; collective
------------------------------------------------------------------------- */

std::vector<PeridemMoments> FixPeridemAdapt::moments(const std::vector<tagint> &which)
{
  std::vector<int> slot(grains.size(), -1);
  for (std::size_t k = 0; k < which.size(); k++) slot[which[k]] = static_cast<int>(k);
  std::vector<PeridemMoments> all(which.size(), PeridemMoments());
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || slot[atom->molecule[i]] < 0) continue;
    double r[3];
    locate(atom->x[i], i, r);
    for (int k = 0; k < 3; k++) r[k] -= grain->body.x[k];
    all[slot[atom->molecule[i]]].add(atom->rmass[i], r, atom->v[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()) * PeridemMoments::SIZE,
                MPI_DOUBLE, MPI_SUM, world);
  return all;
}

/* ----------------------------------------------------------------------
   From here on these grains keep their shape, also what they are deformed by at present. Momentum
   and angular momentum stay, the energy of vibration goes.
------------------------------------------------------------------------- */

void FixPeridemAdapt::freeze(const std::vector<tagint> &which)
{
  if (which.empty()) return;
  const auto all = moments(which);
  std::vector<double> strain(which.size());
  strain_energies(which, strain);
  for (std::size_t k = 0; k < which.size(); k++) {
    auto &grain = grains[which[k]];
    all[k].to_body(grain.body);
    taken += force->mvv2e * (all[k].kinetic - grain.body.kinetic());
    grain.strain = strain[k];
    grain.state = Grain::RIGID;
    grain.loaded = grain.relax = grain.since = 0.0;
    grain.quiet = 0;
    freezes++;
  }
  std::vector<char> fresh(grains.size(), 0);
  for (const tagint mol : which) fresh[mol] = 1;
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || !fresh[atom->molecule[i]]) continue;
    double r[3];
    locate(atom->x[i], i, r);
    for (int k = 0; k < 3; k++) r[k] -= grain->body.x[k];
    grain->body.to_body(r, offset[i]);
    set_velocity(i, grain->body, r);
  }
  find_reach(which);
}

/* ----------------------------------------------------------------------
   between runs the nodes of a rigid grain may have been moved or got other velocities (velocity,
   displace_atoms): their motion is the grain's
------------------------------------------------------------------------- */

void FixPeridemAdapt::follow_user()
{
  auto which = listed(Grain::RIGID);
  const auto sleeping = listed(Grain::ASLEEP);
  which.insert(which.end(), sleeping.begin(), sleeping.end());
  if (which.empty()) return;
  const auto all = moments(which);
  std::vector<tagint> changed;
  for (std::size_t k = 0; k < which.size(); k++) {
    const auto &grain = grains[which[k]];
    PeridemRigidBody now = grain.body;
    all[k].to_body(now);
    const double arm = 0.5 * grain.size;
    const double speed = std::sqrt(2.0 * all[k].kinetic / now.mass);
    double moved = 0.0, pushed = 0.0;
    for (int m = 0; m < 3; m++) {
      moved = MAX(moved, std::fabs(now.x[m] - grain.body.x[m]));
      pushed = MAX(pushed, std::fabs(now.v[m] - grain.body.v[m]));
      pushed = MAX(pushed, std::fabs(now.l[m] - grain.body.l[m]) / (now.mass * arm));
    }
    if (moved > CHANGED * arm || pushed > CHANGED * speed) changed.push_back(which[k]);
  }
  const auto before = std::make_pair(taken, freezes);
  freeze(changed);
  std::tie(taken, freezes) = before;
}

/* ----------------------------------------------------------------------
   Its nodes have the places and velocities of the rigid body already. Under a load that came slowly
   it would swing about its equilibrium: that is damped away. A load that came within a period is an
   impact: what it makes is a wave, and stays.
------------------------------------------------------------------------- */

void FixPeridemAdapt::wake(tagint mol)
{
  auto &grain = grains[mol];
  const bool sudden = grain.loaded < grain.period();
  grain.relax = sudden ? 0.0 : relax * grain.period();
  grain.patience = grain.since < 10.0 * hold * every * dtv ? MIN(MAXPATIENCE, 2 * grain.patience)
                                                           : 1;
  grain.state = Grain::DEFORMABLE;
  grain.strain = grain.since = 0.0;
  grain.quiet = 0;
  wakes++;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::fall_asleep(tagint mol)
{
  auto &body = grains[mol].body;
  taken += force->mvv2e * body.kinetic();
  for (int k = 0; k < 3; k++) body.v[k] = body.l[k] = body.omega[k] = 0.0;
  grains[mol].state = Grain::ASLEEP;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::tell_others()
{
  states_stale = step_stale = true;
  if (bonds) bonds->flag_rigid();
  find_lightest();
}

/* ----------------------------------------------------------------------
   how far the nodes of these rigid grains are from the centre; collective
------------------------------------------------------------------------- */

void FixPeridemAdapt::find_reach(const std::vector<tagint> &which)
{
  std::vector<double> far(grains.size(), 0.0);
  for (int i = 0; i < atom->nlocal; i++)
    if (grain_of(i)) {
      double &most = far[atom->molecule[i]];
      most = MAX(most, MathExtra::lensq3(offset[i]));
    }
  MPI_Allreduce(MPI_IN_PLACE, far.data(), static_cast<int>(far.size()), MPI_DOUBLE, MPI_MAX, world);
  for (const tagint mol : which) grains[mol].reach = std::sqrt(far[mol]);
}

/* ---------------------------------------------------------------------- */

double FixPeridemAdapt::felt_mass(int i) const
{
  return rigid(i) ? grains[atom->molecule[i]].felt_mass(domain->dimension) / RESOLVED
                  : atom->rmass[i];
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::find_lightest()
{
  lightest_of.assign(atom->ntypes + 1, INFINITE);
  for (int i = 0; i < atom->nlocal; i++) {
    double &least = lightest_of[atom->type[i]];
    least = MIN(least, felt_mass(i));
  }
  MPI_Allreduce(MPI_IN_PLACE, lightest_of.data(), atom->ntypes + 1, MPI_DOUBLE, MPI_MIN, world);
}

/* ---------------------------------------------------------------------- */

tagint FixPeridemAdapt::atom_molecule(int i) const
{
  return atom->molecule[i];
}

/* ----------------------------------------------------------------------
   as Gershgorin's bound for nodes: twice all springs at a body over what it weighs where they push;
   half as much again for the contacts that come before the next look
------------------------------------------------------------------------- */

double FixPeridemAdapt::largest_frequency_sq() const
{
  std::vector<double> all(springs);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, world);
  double largest = 0.0;
  for (std::size_t mol = 0; mol < all.size(); mol++)
    if (grains[mol].rigid())
      largest = MAX(largest, 3.0 * RESOLVED * all[mol] / grains[mol].felt_mass(domain->dimension));
  return largest;
}

/* ---------------------------------------------------------------------- */

bool FixPeridemAdapt::any_deformable() const
{
  return others_deform || std::any_of(grains.begin(), grains.end(), [](const Grain &grain) {
           return grain.state == Grain::DEFORMABLE;
         });
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
  if (listed(Grain::RIGID).empty() && listed(Grain::ASLEEP).empty()) return;
  sum_forces();
  set_velocities();
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::initial_integrate(int vflag)
{
  if (rigid_grains.empty()) {
    FixNVE::initial_integrate(vflag);
    return;
  }
  move_deformable(true);
  for (auto &grain : grains)
    if (grain.state == Grain::RIGID) {
      grain.body.kick(dtf);
      grain.body.drift(dtv, 0.5 * dtv);
    }
  place();
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::move_deformable(bool drift)
{
  double **x = atom->x, **v = atom->v, **f = atom->f;
  const double *const rmass = atom->rmass;
  for (int i = 0; i < atom->nlocal; i++) {
    if (!(atom->mask[i] & groupbit)) continue;
    const tagint mol = atom->molecule[i];
    if (mol && grains[mol].state != Grain::DEFORMABLE) continue;
    const double dtfm = dtf / rmass[i];
    for (int k = 0; k < 3; k++) {
      v[i][k] += dtfm * f[i][k];
      if (drift) x[i][k] += dtv * v[i][k];
    }
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::place()
{
  double **x = atom->x;
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || grain->state != Grain::RIGID) continue;
    const auto &body = grain->body;
    double r[3], origin[3], home[3] = {0.0, 0.0, 0.0};
    body.to_space(offset[i], r);
    set_velocity(i, body, r);
    locate(home, i, origin);
    for (int k = 0; k < domain->dimension; k++) x[i][k] = body.x[k] + r[k] - origin[k];
  }
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::set_velocities()
{
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || !grain->rigid()) continue;
    double r[3];
    grain->body.to_space(offset[i], r);
    set_velocity(i, grain->body, r);
  }
}

/* ----------------------------------------------------------------------
   of a node at r from the centre; in a 2d simulation rounding must not lift nodes off their plane:
   a grain under load would buckle out of it
------------------------------------------------------------------------- */

void FixPeridemAdapt::set_velocity(int i, const PeridemRigidBody &body, const double *r)
{
  body.velocity(r, atom->v[i]);
  if (domain->dimension == 2) atom->v[i][2] = 0.0;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::final_integrate()
{
  if (rigid_grains.empty())
    FixNVE::final_integrate();
  else {
    move_deformable(false);
    sum_forces();
    for (auto &grain : grains)
      if (grain.state == Grain::RIGID) grain.body.kick(dtf);
    set_velocities();
  }
  relax_vibration();

  bool changed = consider_loads();
  if (update->ntimestep % every == 0) changed = look_for_quiet() || changed;
  for (auto &grain : grains) grain.since += dtv;
  if (!changed) return;
  tell_others();
  sum_forces();
}

/* ----------------------------------------------------------------------
   force, torque and load of every rigid grain; collective
------------------------------------------------------------------------- */

void FixPeridemAdapt::sum_forces()
{
  slot.assign(grains.size(), -1);
  rigid_grains.clear();
  for (tagint mol = 1; mol < static_cast<tagint>(grains.size()); mol++)
    if (grains[mol].rigid()) {
      slot[mol] = static_cast<int>(rigid_grains.size());
      rigid_grains.push_back(mol);
    }
  if (rigid_grains.empty()) return;

  sums.assign(NSUMS * rigid_grains.size(), 0.0);
  highest.assign(rigid_grains.size(), 0.0);
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || !grain->rigid()) continue;
    const int k = slot[atom->molecule[i]];
    add_force(i, grain->body, &sums[NSUMS * k], highest[k]);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                world);
  MPI_Allreduce(MPI_IN_PLACE, highest.data(), static_cast<int>(highest.size()), MPI_DOUBLE, MPI_MAX,
                world);

  const bool flat = domain->dimension == 2;
  for (std::size_t k = 0; k < rigid_grains.size(); k++) {
    auto &body = grains[rigid_grains[k]].body;
    const double *const s = &sums[NSUMS * k];
    std::copy_n(s, 3, body.force);
    std::copy_n(s + 3, 3, body.torque);
    if (flat) body.force[2] = body.torque[0] = body.torque[1] = 0.0;
  }
}

/* ----------------------------------------------------------------------
   what one node adds; node: largest squared force that bends the grain over h^(2 (d - 1))
------------------------------------------------------------------------- */

void FixPeridemAdapt::add_force(int i, const PeridemRigidBody &body, double *sum,
                                double &node) const
{
  const double *const f = atom->f[i];
  double r[3], bending = 0.0;
  body.to_space(offset[i], r);
  for (int a = 0; a < 3; a++) {
    sum[a] += f[a];
    for (int b = 0; b < 3; b++) sum[6 + 3 * a + b] += f[a] * r[b];
    // the acceleration of the last step will do: a node is light
    const double part = f[a] - atom->rmass[i] * body.force[a] / body.mass;
    bending += part * part;
  }
  sum[15] += MathExtra::len3(f);
  sum[3] += r[1] * f[2] - r[2] * f[1];
  sum[4] += r[2] * f[0] - r[0] * f[2];
  sum[5] += r[0] * f[1] - r[1] * f[0];
  const double V = atom->vfrac[i];
  const double area_sq = domain->dimension == 2 ? V : V * std::cbrt(V);
  if (bending > node * area_sq) node = bending / area_sq;
}

/* ----------------------------------------------------------------------
   wake what is loaded; put to sleep what rests, and back what is pushed
------------------------------------------------------------------------- */

bool FixPeridemAdapt::consider_loads()
{
  bool changed = false;
  for (std::size_t k = 0; k < rigid_grains.size(); k++) {
    auto &grain = grains[rigid_grains[k]];
    PeridemLoad load;
    std::copy_n(&sums[NSUMS * k + 6], 9, load.moment);
    grain.body.add_spinning(load.moment);
    load.node = std::sqrt(highest[k]);
    const double bound =
        std::isfinite(grain.limit) ? load.stretch(grain.volume, grain.young, grain.factor) : 0.0;
    grain.loaded = bound > 0.5 * grain.limit ? grain.loaded + dtv : 0.0;
    if (bound > grain.limit) {
      wake(rigid_grains[k]);
      changed = true;
    } else if (sleep > 0.0)
      changed = rest(k) || changed;
  }
  return changed;
}

/* ----------------------------------------------------------------------
   a grain sleeps while the forces on it balance, and what is left of them would not bring it to the
   speed in one interval of checks
------------------------------------------------------------------------- */

bool FixPeridemAdapt::rest(std::size_t k)
{
  auto &grain = grains[rigid_grains[k]];
  const auto &body = grain.body;
  const double arm = 0.5 * grain.size, interval = every * dtv * force->ftm2v;
  const double push = MathExtra::len3(body.force) / body.mass;
  const double turn = MathExtra::len3(body.torque) / (body.mass * arm);
  const bool pushed = interval * (push + turn) > sleep ||
      MathExtra::len3(body.force) > UNBALANCED * sums[NSUMS * k + 15];
  if (grain.state == Grain::ASLEEP) {
    if (pushed) grain.state = Grain::RIGID;
    return pushed;
  }
  if (update->ntimestep % every) return false;
  const bool slow = MathExtra::len3(body.v) + arm * MathExtra::len3(body.omega) < sleep;
  grain.quiet = slow && !pushed ? grain.quiet + 1 : 0;
  if (grain.quiet < hold) return false;
  fall_asleep(rigid_grains[k]);
  return true;
}

/* ----------------------------------------------------------------------
   damp what moves other than rigidly: keeps momentum and angular momentum; collective
------------------------------------------------------------------------- */

void FixPeridemAdapt::relax_vibration()
{
  std::vector<tagint> which;
  for (tagint mol = 1; mol < static_cast<tagint>(grains.size()); mol++)
    if (grains[mol].state == Grain::DEFORMABLE && grains[mol].relax > 0.0) which.push_back(mol);
  if (which.empty()) return;

  const auto all = moments(which);
  std::vector<double> part(grains.size(), 0.0);
  for (std::size_t k = 0; k < which.size(); k++) {
    auto &grain = grains[which[k]];
    all[k].to_body(grain.body);
    // critical damping of the slowest vibration
    const double keep = std::exp(-4.0 * MathConst::MY_PI / grain.period() * dtv);
    part[which[k]] = 1.0 - keep;
    taken += force->mvv2e * (1.0 - keep * keep) * (all[k].kinetic - grain.body.kinetic());
    grain.relax -= dtv;
  }
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || part[atom->molecule[i]] == 0.0) continue;
    double r[3], u[3];
    locate(atom->x[i], i, r);
    for (int k = 0; k < 3; k++) r[k] -= grain->body.x[k];
    grain->body.velocity(r, u);
    for (int k = 0; k < domain->dimension; k++)
      atom->v[i][k] += part[atom->molecule[i]] * (u[k] - atom->v[i][k]);
  }
}

/* ----------------------------------------------------------------------
   deformable grains that are whole, little stretched and do not ring become rigid; collective
------------------------------------------------------------------------- */

bool FixPeridemAdapt::look_for_quiet()
{
  if (back == 0.0) return false;
  std::vector<tagint> which;
  for (const tagint mol : listed(Grain::DEFORMABLE))
    if (!grains[mol].broken && grains[mol].relax <= 0.0) which.push_back(mol);
  if (which.empty()) return false;

  const auto all = moments(which);
  std::vector<double> most(grains.size(), 0.0);
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    if (!grain || grain->state != Grain::DEFORMABLE || grain->broken) continue;
    double &largest = most[atom->molecule[i]];
    largest = MAX(largest, row_stretch(i));
  }
  MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX,
                world);

  std::vector<tagint> quiet;
  for (std::size_t k = 0; k < which.size(); k++) {
    auto &grain = grains[which[k]];
    all[k].to_body(grain.body);
    if (!std::isfinite(most[which[k]])) {
      grain.broken = 1;
      continue;
    }
    const double ringing = MAX(0.0, all[k].kinetic - grain.body.kinetic());
    const double speed = std::sqrt(2.0 * ringing / grain.body.mass);
    const double stretched = most[which[k]] + speed / grain.speed;
    grain.quiet = stretched < back * grain.limit ? grain.quiet + 1 : 0;
    if (grain.quiet >= hold * grain.patience) quiet.push_back(which[k]);
  }
  freeze(quiet);
  return !quiet.empty();
}

/* ----------------------------------------------------------------------
   largest stretch of the bonds of owned node i; infinite if one is broken
------------------------------------------------------------------------- */

double FixPeridemAdapt::row_stretch(int i) const
{
  if (!bonds || bonds->num[i] < 0) return 0.0;
  if (bonds->num[i] < bonds->nref[i]) return INFINITE;
  double **x = atom->x;
  double largest = 0.0;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++) {
    const double *const xj = x[bonds->partner[k]];
    const double d[3] = {xj[0] - x[i][0], xj[1] - x[i][1], xj[2] - x[i][2]};
    const double R = bonds->length[k];
    largest = MAX(largest, std::fabs(MathExtra::len3(d) / R - 1.0));
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::strain_energies(const std::vector<tagint> &which,
                                      std::vector<double> &strain) const
{
  std::vector<double> sum(grains.size(), 0.0);
  if (started)    // before, no forces have been computed
    for (const auto *solid : solids)
      for (int i = 0; i < atom->nlocal; i++)
        if ((atom->mask[i] & groupbit) && solid->covers(atom->type[i]))
          sum[atom->molecule[i]] += solid->strain_energy(i);
  for (std::size_t k = 0; k < which.size(); k++) strain[k] = sum[which[k]];
  MPI_Allreduce(MPI_IN_PLACE, strain.data(), static_cast<int>(strain.size()), MPI_DOUBLE, MPI_SUM,
                world);
}

/* ---------------------------------------------------------------------- */

double FixPeridemAdapt::energy_held() const
{
  double sum = 0.0;
  for (const auto &grain : grains)
    if (grain.rigid()) sum += grain.strain;
  return sum;
}

/* ----------------------------------------------------------------------
   forces are about to be computed; the state of each node, for output
------------------------------------------------------------------------- */

void FixPeridemAdapt::pre_force(int)
{
  springs.assign(grains.size(), 0.0);
  if (!states_stale && neighbor->ago != 0) return;
  states_stale = false;
  for (int i = 0; i < atom->nlocal; i++) {
    const auto *const grain = grain_of(i);
    state[i] = grain ? grain->state : Grain::DEFORMABLE;
  }
}

/* ----------------------------------------------------------------------
   grains deformable, rigid, asleep; wakings, freezings; energy taken; energy held
------------------------------------------------------------------------- */

double FixPeridemAdapt::compute_vector(int n)
{
  if (n < 3) return static_cast<double>(listed(Grain::DEFORMABLE + n).size());
  if (n == 3) return static_cast<double>(wakes);
  if (n == 4) return static_cast<double>(freezes);
  return n == 5 ? taken : energy_held();
}

/* ---------------------------------------------------------------------- */

double FixPeridemAdapt::memory_usage()
{
  return 4.0 * atom->nmax * sizeof(double) + static_cast<double>(grains.size()) * sizeof(Grain);
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::grow_arrays(int nmax)
{
  memory->grow(offset, nmax, 3, "peridem/adapt:offset");
  memory->grow(state, nmax, "peridem/adapt:state");
  vector_atom = state;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::copy_arrays(int i, int j, int)
{
  for (int k = 0; k < 3; k++) offset[j][k] = offset[i][k];
  state[j] = state[i];
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::set_arrays(int i)
{
  for (int k = 0; k < 3; k++) offset[i][k] = 0.0;
  state[i] = Grain::DEFORMABLE;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::pack_exchange(int i, double *buf)
{
  for (int k = 0; k < 3; k++) buf[k] = offset[i][k];
  buf[3] = state[i];
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::unpack_exchange(int nlocal, double *buf)
{
  for (int k = 0; k < 3; k++) offset[nlocal][k] = buf[k];
  state[nlocal] = buf[3];
  return 4;
}

/* ---------------------------------------------------------------------- */

int FixPeridemAdapt::pack_restart(int i, double *buf)
{
  buf[0] = 4;
  for (int k = 0; k < 3; k++) buf[1 + k] = offset[i][k];
  return 4;
}

/* ---------------------------------------------------------------------- */

void FixPeridemAdapt::unpack_restart(int nlocal, int nth)
{
  double **extra = atom->extra;
  int m = 0;
  for (int k = 0; k < nth; k++) m += static_cast<int>(extra[nlocal][m]);
  for (int k = 0; k < 3; k++) offset[nlocal][k] = extra[nlocal][m + 1 + k];
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

void FixPeridemAdapt::write_restart(FILE *fp)
{
  if (comm->me != 0) return;
  const double totals[NTOTALS] = {static_cast<double>(grains.size()), taken,
                                  static_cast<double>(wakes), static_cast<double>(freezes),
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
  grains.resize(static_cast<std::size_t>(totals[0]));
  memcpy(static_cast<void *>(grains.data()), buf + sizeof(totals), grains.size() * sizeof(Grain));
  taken = totals[1];
  wakes = static_cast<bigint>(totals[2]);
  freezes = static_cast<bigint>(totals[3]);
  natoms_seen = static_cast<bigint>(totals[4]);
  started = true;
}
