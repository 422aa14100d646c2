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

#include "peridem_adapt_switch.h"

#include "peridem_load.h"

#include "atom.h"
#include "domain.h"
#include "force.h"
#include "math_const.h"
#include "math_extra.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

// forces on a grain that sum to more than this part of their sizes do not balance
static constexpr double UNBALANCED = 0.2;

// more than rounding
static constexpr double CHANGED = 1.0e-9;

static constexpr int MAXPATIENCE = 64;

/* ---------------------------------------------------------------------- */

PeridemAdaptSwitch::PeridemAdaptSwitch(LAMMPS *lmp, PeridemAdaptTable &grains,
                                       PeridemRigidNodes &nodes, const PeridemAdaptOptions &words) :
    Pointers(lmp), table(grains), rigid(nodes), options(words)
{
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptSwitch::start()
{
  std::vector<tagint> whole;
  for (const tagint mol : table.listed(Grain::DEFORMABLE))
    if (!table.grains[mol].broken && table.grains[mol].limit > 0.0) whole.push_back(mol);
  freeze(whole, false);
  taken = 0.0;    // that grains start rigid is no loss
  freezes = 0;
}

/* ----------------------------------------------------------------------
   From here on these grains keep their shape, also what they are deformed by at present. Momentum
   and angular momentum stay, the energy of vibration goes.
------------------------------------------------------------------------- */

void PeridemAdaptSwitch::freeze(const std::vector<tagint> &which, bool forces_known)
{
  if (which.empty()) return;
  const auto all = table.moments(which);
  const auto strain = forces_known ? table.strain_energies(which)
                                   : std::vector<double>(which.size(), 0.0);
  for (std::size_t k = 0; k < which.size(); k++) {
    auto &grain = table.grains[which[k]];
    all[k].to_body(grain.body);
    taken += force->mvv2e * (all[k].kinetic - grain.body.kinetic());
    grain.strain = strain[k];
    grain.state = Grain::RIGID;
    grain.loaded = grain.relax = grain.since = 0.0;
    grain.quiet = 0;
    freezes++;
    for (const int i : table.nodes(which[k])) {
      double r[3];
      table.place_from(i, grain.body.x, r);
      grain.body.to_body(r, table.offset[i]);
    }
  }
  find_reach(which);
  rigid.collect();
  rigid.set_velocities(false);
}

/* ----------------------------------------------------------------------
   how far the nodes of these rigid grains are from the centre
------------------------------------------------------------------------- */

void PeridemAdaptSwitch::find_reach(const std::vector<tagint> &which)
{
  std::vector<double> far(which.size(), 0.0);
  for (std::size_t k = 0; k < which.size(); k++)
    for (const int i : table.nodes(which[k]))
      far[k] = MAX(far[k], MathExtra::lensq3(table.offset[i]));
  MPI_Allreduce(MPI_IN_PLACE, far.data(), static_cast<int>(far.size()), MPI_DOUBLE, MPI_MAX, world);
  for (std::size_t k = 0; k < which.size(); k++) table.grains[which[k]].reach = std::sqrt(far[k]);
}

/* ----------------------------------------------------------------------
   between runs the nodes of a rigid grain may have been moved or got other velocities (velocity,
   displace_atoms): their motion is the grain's
------------------------------------------------------------------------- */

void PeridemAdaptSwitch::follow_user()
{
  auto which = table.listed(Grain::RIGID);
  const auto sleeping = table.listed(Grain::ASLEEP);
  which.insert(which.end(), sleeping.begin(), sleeping.end());
  if (which.empty()) return;
  const auto all = table.moments(which);
  std::vector<tagint> changed;
  for (std::size_t k = 0; k < which.size(); k++) {
    const auto &grain = table.grains[which[k]];
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
  const double taken_before = taken;
  const bigint freezes_before = freezes;
  freeze(changed);
  taken = taken_before;
  freezes = freezes_before;
}

/* ----------------------------------------------------------------------
   Its nodes have the places and velocities of the rigid body already. Under a load that came slowly
   it would swing about its equilibrium: that is damped away. A load that came within a period is an
   impact: what it makes is a wave, and stays.
------------------------------------------------------------------------- */

void PeridemAdaptSwitch::wake(Grain &grain, double dt)
{
  const bool sudden = grain.loaded < grain.period();
  const bool soon = grain.since < 10.0 * options.hold * options.every * dt;
  grain.relax = sudden ? 0.0 : options.relax * grain.period();
  grain.patience = soon ? MIN(MAXPATIENCE, 2 * grain.patience) : 1;
  grain.state = Grain::DEFORMABLE;
  grain.strain = grain.since = 0.0;
  grain.quiet = 0;
  wakes++;
}

/* ---------------------------------------------------------------------- */

void PeridemAdaptSwitch::fall_asleep(Grain &grain)
{
  auto &body = grain.body;
  taken += force->mvv2e * body.kinetic();
  for (int k = 0; k < 3; k++) body.v[k] = body.l[k] = body.omega[k] = 0.0;
  grain.state = Grain::ASLEEP;
}

/* ----------------------------------------------------------------------
   wake what is loaded; put to sleep what rests, and back what is pushed
------------------------------------------------------------------------- */

bool PeridemAdaptSwitch::consider_loads(double dt)
{
  bool changed = false, asleep = false;
  for (std::size_t k = 0; k < rigid.grains.size(); k++) {
    auto &grain = table.grains[rigid.grains[k]];
    if (overloaded(k, dt)) {
      wake(grain, dt);
      changed = true;
    } else if (options.sleep > 0.0 && rest(k, dt)) {
      changed = true;
      if (grain.state == Grain::ASLEEP) asleep = true;
    }
  }
  if (asleep) rigid.set_velocities(true);    // whose nodes do not move any more
  return changed;
}

/* ---------------------------------------------------------------------- */

bool PeridemAdaptSwitch::overloaded(std::size_t k, double dt)
{
  auto &grain = table.grains[rigid.grains[k]];
  PeridemLoad load;
  rigid.moment(k, load.moment);
  grain.body.add_spinning(load.moment);
  load.node = std::sqrt(rigid.highest[k]);
  const double limit = grain.trial ? options.back * grain.limit : grain.limit;
  grain.trial = 0;
  if (load.stretch_at_most(grain.volume, grain.young, grain.factor) <=
      MIN(limit, 0.5 * grain.limit)) {
    grain.loaded = 0.0;
    return false;
  }
  const double bound =
      std::isfinite(grain.limit) ? load.stretch(grain.volume, grain.young, grain.factor) : 0.0;
  grain.loaded = bound > 0.5 * grain.limit ? grain.loaded + dt : 0.0;
  return bound > limit;
}

/* ----------------------------------------------------------------------
   a grain sleeps while the forces on it balance, and what is left of them would not bring it to the
   speed in one interval of checks
------------------------------------------------------------------------- */

bool PeridemAdaptSwitch::rest(std::size_t k, double dt)
{
  auto &grain = table.grains[rigid.grains[k]];
  const auto &body = grain.body;
  const double arm = 0.5 * grain.size, interval = options.every * dt * force->ftm2v;
  const double push = MathExtra::len3(body.force) / body.mass;
  const double turn = MathExtra::len3(body.torque) / (body.mass * arm);
  const bool pushed = interval * (push + turn) > options.sleep ||
      MathExtra::len3(body.force) > UNBALANCED * rigid.sums[k].sizes;
  if (grain.state == Grain::ASLEEP) {
    if (pushed) grain.state = Grain::RIGID;
    return pushed;
  }
  if (update->ntimestep % options.every) return false;
  const bool slow = MathExtra::len3(body.v) + arm * MathExtra::len3(body.omega) < options.sleep;
  grain.quiet = slow && !pushed ? grain.quiet + 1 : 0;
  if (grain.quiet < options.hold) return false;
  fall_asleep(grain);
  return true;
}

/* ----------------------------------------------------------------------
   damp what moves other than rigidly: keeps momentum and angular momentum
------------------------------------------------------------------------- */

void PeridemAdaptSwitch::relax_vibration(double dt)
{
  std::vector<tagint> which;
  for (tagint mol = 1; mol <= table.highest(); mol++)
    if (table.grains[mol].state == Grain::DEFORMABLE && table.grains[mol].relax > 0.0)
      which.push_back(mol);
  if (which.empty()) return;

  double **v = atom->v;
  const auto all = table.moments(which);
  for (std::size_t k = 0; k < which.size(); k++) {
    auto &grain = table.grains[which[k]];
    all[k].to_body(grain.body);
    // critical damping of the slowest vibration
    const double keep = std::exp(-4.0 * MathConst::MY_PI / grain.period() * dt);
    taken += force->mvv2e * (1.0 - keep * keep) * (all[k].kinetic - grain.body.kinetic());
    grain.relax -= dt;
    for (const int i : table.nodes(which[k])) {
      double r[3], u[3];
      table.place_from(i, grain.body.x, r);
      grain.body.velocity(r, u);
      for (int m = 0; m < domain->dimension; m++) v[i][m] += (1.0 - keep) * (u[m] - v[i][m]);
    }
  }
}

/* ----------------------------------------------------------------------
   deformable grains that are whole, little stretched and do not ring become rigid
------------------------------------------------------------------------- */

bool PeridemAdaptSwitch::look_for_quiet()
{
  if (options.back == 0.0) return false;
  std::vector<tagint> which;
  for (const tagint mol : table.listed(Grain::DEFORMABLE))
    if (!table.grains[mol].broken && table.grains[mol].relax <= 0.0) which.push_back(mol);
  if (which.empty()) return false;

  const auto all = table.moments(which);
  std::vector<double> most(which.size());
  for (std::size_t k = 0; k < which.size(); k++) most[k] = table.largest_stretch(which[k]);
  MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX,
                world);

  std::vector<tagint> quiet;
  for (std::size_t k = 0; k < which.size(); k++) {
    auto &grain = table.grains[which[k]];
    all[k].to_body(grain.body);
    if (!std::isfinite(most[k])) {
      grain.broken = 1;
      continue;
    }
    const bool still = stretch_and_ringing(grain, all[k], most[k]) < options.back * grain.limit;
    grain.quiet = still ? grain.quiet + 1 : 0;
    if (grain.quiet >= options.hold * grain.patience) quiet.push_back(which[k]);
  }
  freeze(quiet);
  for (const tagint mol : quiet) table.grains[mol].trial = 1;
  return !quiet.empty();
}

/* ----------------------------------------------------------------------
   a wave of this speed stretches by so much of the speed of sound
------------------------------------------------------------------------- */

double PeridemAdaptSwitch::stretch_and_ringing(const Grain &grain, const PeridemMoments &all,
                                               double stretched) const
{
  const double ringing = MAX(0.0, all.kinetic - grain.body.kinetic());
  return stretched + std::sqrt(2.0 * ringing / grain.body.mass) / grain.speed;
}

/* ---------------------------------------------------------------------- */

double PeridemAdaptSwitch::energy_held() const
{
  double sum = 0.0;
  for (const auto &grain : table.grains)
    if (grain.rigid()) sum += grain.strain;
  return sum;
}
