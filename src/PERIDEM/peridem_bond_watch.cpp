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

#include "peridem_bond_watch.h"

#include "fix_peridem_bonds.h"
#include "pair_peridem.h"
#include "peridem_material.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "modify.h"
#include "update.h"

#include <algorithm>
#include <cmath>

using namespace LAMMPS_NS;

// part of its length to which a bond may be compressed without a warning
static constexpr double CRUSHED = 0.25;

/* ---------------------------------------------------------------------- */

void PeridemBondWatch::init(const std::vector<PairPeridem *> &solids)
{
  said_compressed = false;
  look_at_rerun(solids);
}

/* ----------------------------------------------------------------------
   "rerun" initialises fixes for every snapshot, but pair styles once
------------------------------------------------------------------------- */

void PeridemBondWatch::look_at_rerun(const std::vector<PairPeridem *> &solids)
{
  int count = 0;
  bool breakable = false;
  for (const auto *solid : solids) {
    count += solid->init_count();
    for (int i = 1; i <= atom->ntypes; i++)
      if (solid->covers(i)) breakable = breakable || std::isfinite(solid->material(i, i).s0);
  }
  const bool again = count == solids_inits;
  if (again && !said_rerun && breakable && comm->me == 0)
    error->warning(FLERR,
                   "Rerun: bonds break where a snapshot shows them beyond their critical stretch; "
                   "those that broke between snapshots and closed again hold");
  said_rerun = again;
  solids_inits = count;
}

/* ----------------------------------------------------------------------
   a time step that somebody chose by hand may be too long
------------------------------------------------------------------------- */

void PeridemBondWatch::look_at_time_step()
{
  if (update->whichflag != 1 || modify->get_fix_by_style("^peridem/timestep$").size()) return;
  const auto limits = stability.find();
  const bool levels = limits.bond_count * limits.contact_count > 1;
  if (update->dt > limits.stable && comm->me == 0)
    error->warning(
        FLERR,
        "The time step {:.4g} is longer than the largest stable one, {:.4g} (bonds alone "
        "{:.4g}, contacts alone {:.4g}{}): use fix peridem/timestep or a smaller timestep",
        update->dt, limits.stable, limits.bonds, limits.contacts,
        levels ? fmt::format(", at levels with {} and {} steps in it", limits.bond_count,
                             limits.contact_count)
               : "");
  else if (update->dt > limits.speeds && comm->me == 0)
    error->warning(
        FLERR,
        "The fastest node moves {:.2g} of the contact distance in one step: contacts may "
        "gain energy or be jumped over; use fix peridem/timestep or a timestep of {:.4g}",
        PeridemStability::TRAVEL * update->dt / limits.speeds, limits.speeds);
}

/* ----------------------------------------------------------------------
   nodes beyond a fixed face are about to be lost, and bonds to them would be missed first
------------------------------------------------------------------------- */

void PeridemBondWatch::look_at_box(const PeridemRows &rows) const
{
  constexpr int FIXED = 1;
  bigint out = 0, out_all;
  tagint first = MAXTAGINT, first_all;
  for (int i = 0; i < atom->nlocal; i++) {
    if (rows.num[i] <= 0) continue;
    bool left = false;
    for (int k = 0; k < domain->dimension; k++) {
      const double x = atom->x[i][k];
      left = left || (domain->boundary[k][0] == FIXED && x < domain->boxlo[k]) ||
          (domain->boundary[k][1] == FIXED && x > domain->boxhi[k]);
    }
    if (!left) continue;
    out++;
    first = MIN(first, atom->tag[i]);
  }
  MPI_Allreduce(&out, &out_all, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (out_all == 0) return;
  MPI_Allreduce(&first, &first_all, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  error->all(
      FLERR, Error::NOLASTLINE,
      "{} bonded nodes have left the box through a fixed boundary (the first is atom-ID {}): "
      "make the box larger, or use boundary s or m",
      out_all, first_all);
}

/* ----------------------------------------------------------------------
   Each bond is looked at once, in the row of its lower ID. A fix that adds nodes may have taken the
   ghosts out of the map already: their bonds are looked for once there are ghosts again.
------------------------------------------------------------------------- */

double PeridemBondWatch::longest_bond(const FixPeridemBonds &bonds)
{
  const PeridemLookup find(atom);
  double **x = atom->x;
  double rsqmax = 0.0, least = 1.0;    // least: squared length over that in the reference
  int least_i = -1, least_j = -1;
  for (int i = 0; i < atom->nlocal; i++) {
    if (bonds.num[i] <= 0) continue;
    const auto row = bonds.ptag.begin() + bonds.start[i], end = row + bonds.num[i];
    const auto higher = std::upper_bound(row, end, atom->tag[i]);
    for (auto k = bonds.start[i] + (higher - row); k < bonds.start[i] + bonds.num[i]; k++) {
      const int j = bonds.nearest(i, find(bonds.ptag[k]));
      if (j < 0) continue;
      const double *const xj = x[j];
      const double dx = xj[0] - x[i][0], dy = xj[1] - x[i][1], dz = xj[2] - x[i][2];
      const double rsq = dx * dx + dy * dy + dz * dz, R = bonds.length[k];
      rsqmax = MAX(rsqmax, rsq);
      if (rsq < least * R * R) {
        least = rsq / (R * R);
        least_i = i;
        least_j = j;
      }
    }
  }
  double mine[2] = {std::sqrt(rsqmax), -std::sqrt(least)};
  double all[2];
  MPI_Allreduce(mine, all, 2, MPI_DOUBLE, MPI_MAX, world);
  if (-all[1] < CRUSHED && !said_compressed)
    say_compressed(-all[1], mine[1] == all[1] ? least_i : -1, least_j);
  return all[0];
}

/* ----------------------------------------------------------------------
   once per run; i < 0 on ranks that do not own the shortest bond
------------------------------------------------------------------------- */

void PeridemBondWatch::say_compressed(double shortest, int i, int j)
{
  said_compressed = true;
  const tagint *const tag = atom->tag;
  tagint who[3] = {0, 0, 0}, all[3];
  if (i >= 0) {
    who[0] = MIN(tag[i], tag[j]);
    who[1] = MAX(tag[i], tag[j]);
    who[2] = atom->molecule[i];
  }
  MPI_Allreduce(who, all, 3, MPI_LMP_TAGINT, MPI_MAX, world);
  if (comm->me == 0)
    error->warning(
        FLERR,
        "Bonds are compressed to {:.3g} of their length (nodes {} and {} of grain {}): "
        "bonded nodes do not touch, so they may pass through each other; use break both, "
        "a stiffer solid or a smaller load",
        shortest, all[0], all[1], all[2]);
}
