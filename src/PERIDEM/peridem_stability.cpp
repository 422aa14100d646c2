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

#include "peridem_stability.h"

#include "fix_peridem_adapt.h"
#include "fix_peridem_wall.h"
#include "pair_peridem.h"
#include "pair_peridem_contact.h"
#include "peridem_impulse.h"
#include "peridem_level.h"

#include "atom.h"
#include "error.h"
#include "force.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

static constexpr double INFINITE = std::numeric_limits<double>::infinity();

// a dashpot ratio above this shortens the step by more than a third: then dashpots are named
static constexpr double MATTERS = 0.43;

// two limits at one level are together at least this part of the shorter: 1/sqrt(2)
static constexpr double RESONANT = 0.7;

// who looks no sooner than after so many steps may meet contacts that no list has yet
static constexpr int LATE = 100;

/* ---------------------------------------------------------------------- */

PeridemStability::PeridemStability(LAMMPS *lmp) : Pointers(lmp) {}

/* ---------------------------------------------------------------------- */

const char *PeridemStability::Limits::ruling() const
{
  if (stable < springs * (std::sqrt(1.0 + MATTERS * MATTERS) - MATTERS)) return "dashpots";
  const double of_bonds = bond_count * bonds, of_contacts = contact_count * contacts;
  if (springs < RESONANT * MIN(of_bonds, of_contacts)) return "resonances of both";
  return of_bonds <= of_contacts ? "bonds" : "contacts";
}

/* ---------------------------------------------------------------------- */

PeridemStability::Styles PeridemStability::find_styles() const
{
  Styles found;
  found.solids = PairPeridem::find_all(lmp);
  found.contact = dynamic_cast<PairPeridemContact *>(force->pair_match("peridem/contact", 1));
  for (auto *fix : modify->get_fix_by_style("^peridem/wall$"))
    found.walls.push_back(dynamic_cast<FixPeridemWall *>(fix));
  const auto adapts = modify->get_fix_by_style("^peridem/adapt$");
  found.adapt = adapts.empty() ? nullptr : dynamic_cast<const FixPeridemAdapt *>(adapts[0]);
  return found;
}

/* ---------------------------------------------------------------------- */

void PeridemStability::keep_styles()
{
  styles = find_styles();
  kept = true;
}

/* ----------------------------------------------------------------------
   levels of respa: forces of several pair styles of solids count as those of the outermost
------------------------------------------------------------------------- */

void PeridemStability::find_counts(Limits &limits) const
{
  PeridemLevel level(lmp);
  level.find(styles.contact, "Pair style peridem/contact");
  limits.contact_count = limits.bond_count = level.count();
  for (std::size_t k = 0; k < styles.solids.size(); k++) {
    level.find(styles.solids[k], "Pair style of a solid");
    limits.bond_count = k == 0 ? level.count() : MIN(limits.bond_count, level.count());
  }
}

/* ----------------------------------------------------------------------
   Velocity Verlet is stable up to 2/omega, and its levels up to what PeridemImpulse says. With a
   dashpot of ratio z that acts on velocities half a step old the limit is shorter by the factor
   sqrt(1 + z^2) - z.
------------------------------------------------------------------------- */

PeridemStability::Limits PeridemStability::find(int again)
{
  if (!kept) styles = find_styles();
  const auto &solids = styles.solids;
  bigint state = atom->natoms;
  for (const auto *solid : solids) state = 31 * state + solid->coeff_version();
  if (state != bonds_known) {
    bond_frequency_sq = 0.0;
    for (auto *solid : solids)
      bond_frequency_sq = std::max(bond_frequency_sq, solid->largest_frequency_sq());
    bonds_known = state;
  }

  const bool rigid = styles.adapt && !styles.adapt->any_deformable();
  const double bonds_sq = rigid ? 0.0 : bond_frequency_sq * force->ftm2v;
  const double z = largest_dashpot_ratio(bonds_sq);
  const double shorter = std::sqrt(1.0 + z * z) - z;

  Limits limits;
  find_counts(limits);
  const int steps = again == NEVER ? NEVER : again * limits.contact_count;
  const double contacts_sq = contact_frequency_sq(steps) * force->ftm2v;
  limits.bonds = bonds_sq > 0.0 ? 2.0 / std::sqrt(bonds_sq) : INFINITE;
  limits.contacts = contacts_sq > 0.0 ? 2.0 / std::sqrt(contacts_sq) : INFINITE;
  limits.springs =
      PeridemImpulse::largest_step(bonds_sq, limits.bond_count, contacts_sq, limits.contact_count);
  limits.stable = shorter * limits.springs;
  limits.dashpots = z > 0.0 ? limits.stable : INFINITE;
  limits.speeds = speed_limit();
  return limits;
}

/* ----------------------------------------------------------------------
   Contacts that begin softly are no danger while nobody has seen them; others have to be expected
   anywhere.
------------------------------------------------------------------------- */

bool PeridemStability::contacts_begin_softly() const
{
  for (const auto *wall : styles.walls)
    if (!wall->begins_softly()) return false;
  return styles.contact->begins_softly();
}

/* ---------------------------------------------------------------------- */

void PeridemStability::gather_stiffness(int steps) const
{
  if (steps == NEVER || steps > LATE || !contacts_begin_softly()) {
    styles.contact->gather_stiffness();
    return;
  }
  const double single_sq = styles.contact->single_frequency_sq() * force->ftm2v;
  const double time = single_sq > 0.0 ? 2.0 * steps / std::sqrt(single_sq) : 0.0;
  auto &stiffness = styles.contact->gather_stiffness(time);
  for (auto *wall : styles.walls) wall->add_stiffness(stiffness, time);
}

/* ---------------------------------------------------------------------- */

double PeridemStability::contact_frequency_sq(int steps) const
{
  double largest = 0.0;
  if (styles.contact) {
    gather_stiffness(steps);
    largest = styles.contact->largest_frequency_sq();
  }
  for (const auto *wall : styles.walls) largest = std::max(largest, wall->largest_frequency_sq());
  if (styles.adapt) largest = std::max(largest, styles.adapt->largest_frequency_sq());
  return largest;
}

/* ---------------------------------------------------------------------- */

double PeridemStability::largest_dashpot_ratio(double bonds_sq) const
{
  double largest = 0.0;
  for (auto *solid : styles.solids)
    largest = MAX(largest, 0.5 * std::sqrt(bonds_sq) * solid->largest_viscous_time());
  if (styles.contact) largest = std::max(largest, styles.contact->largest_dashpot_ratio());
  for (const auto *wall : styles.walls) largest = std::max(largest, wall->largest_dashpot_ratio());
  return largest;
}

/* ---------------------------------------------------------------------- */

double PeridemStability::speed_limit() const
{
  const auto *contact = styles.contact;
  if (!contact || !contact->cutsq) return INFINITE;
  double leastsq = INFINITE;
  for (int i = 1; i <= atom->ntypes; i++)
    for (int j = i; j <= atom->ntypes; j++)
      if (contact->cutsq[i][j] > 0.0) leastsq = MIN(leastsq, contact->cutsq[i][j]);

  double **v = atom->v;
  double most[2] = {0.0, 0.0};    // square of the largest speed; whether one has no square
  for (int i = 0; i < atom->nlocal; i++) {
    const double vsq = v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2];
    if (!std::isfinite(vsq))
      most[1] = 1.0;
    else
      most[0] = MAX(most[0], vsq);
  }
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, world);
  if (most[1] > 0.0)
    error->all(FLERR, Error::NOLASTLINE,
               "The speed of a node is no number any more, or beyond all bounds, at step {}: the "
               "time step is too long, or the input has such speeds",
               update->ntimestep);
  const double fastestsq = most[0];
  return fastestsq > 0.0 ? TRAVEL * std::sqrt(leastsq / fastestsq) : INFINITE;
}
