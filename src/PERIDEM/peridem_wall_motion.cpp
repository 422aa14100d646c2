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

#include "peridem_wall_motion.h"

#include "domain.h"
#include "error.h"
#include "input.h"
#include "modify.h"
#include "peridem_schedule.h"
#include "update.h"
#include "variable.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

int PeridemWallMotion::parse(int iarg, int narg, char **arg)
{
  const bool is_velocity = strcmp(arg[iarg], "velocity") == 0;
  const bool is_move = strcmp(arg[iarg], "move") == 0;
  if (!is_velocity && !is_move) return iarg;
  if (given)
    error->all(FLERR, iarg, "Repeated fix {} keyword {}: a wall has one velocity or one move",
               style, arg[iarg]);
  given = true;
  if (is_velocity)
    parse_velocity(iarg, narg, arg);
  else
    parse_move(iarg, narg, arg);
  return iarg + 4;
}

/* ---------------------------------------------------------------------- */

void PeridemWallMotion::parse_velocity(int iarg, int narg, char **arg)
{
  if (iarg + 3 >= narg) error->all(FLERR, iarg, "Fix {} velocity needs three numbers", style);
  for (int k = 0; k < 3; k++) {
    velocity[k] = utils::numeric(FLERR, arg[iarg + 1 + k], false, lmp);
    if (!std::isfinite(velocity[k]))
      error->all(FLERR, iarg + 1 + k, "Fix {} velocity {}: must be finite", style,
                 arg[iarg + 1 + k]);
    constant = constant || velocity[k] != 0.0;
  }
  if (domain->dimension == 2 && velocity[2] != 0.0)
    error->all(FLERR, iarg + 3, "Fix {} velocity in z must be 0 in a 2d simulation", style);
}

/* ---------------------------------------------------------------------- */

void PeridemWallMotion::parse_move(int iarg, int narg, char **arg)
{
  if (iarg + 3 >= narg)
    error->all(FLERR, iarg, "Fix {} move needs three displacements, each v_name or NULL", style);
  for (int k = 0; k < 3; k++) {
    const char *word = arg[iarg + 1 + k];
    if (strcmp(word, "NULL") == 0) continue;
    if (!utils::strmatch(word, "^v_."))
      error->all(FLERR, iarg + 1 + k, "Fix {} move {}: must be v_name or NULL", style, word);
    if (domain->dimension == 2 && k == 2)
      error->all(FLERR, iarg + 1 + k, "Fix {} move in z must be NULL in a 2d simulation", style);
    names[k] = word + 2;
    variable = true;
  }
}

/* ---------------------------------------------------------------------- */

void PeridemWallMotion::init()
{
  for (const auto &name : names) {
    if (name.empty()) continue;
    const int index = input->variable->find(name.c_str());
    if (index < 0)
      error->all(FLERR, Error::NOLASTLINE, "Fix {} move: variable {} does not exist", style, name);
    if (!input->variable->equalstyle(index))
      error->all(FLERR, Error::NOLASTLINE,
                 "Fix {} move: variable {} must be equal-style: one number for the whole wall",
                 style, name);
  }
}

/* ---------------------------------------------------------------------- */

double PeridemWallMotion::evaluate(int k)
{
  const double value = input->variable->compute_equal(input->variable->find(names[k].c_str()));
  if (!std::isfinite(value))
    error->all(FLERR, Error::NOLASTLINE, "Fix {} move: variable {} is {} at step {}", style,
               names[k], value, update->ntimestep);
  return value;
}

/* ---------------------------------------------------------------------- */

void PeridemWallMotion::advance(const PeridemMoment &now)
{
  if (constant && now.stepping)
    for (int k = 0; k < 3; k++) shift[k] += now.dt * velocity[k];
  if (!variable) return;
  if (now.begins) look_ahead(now);
  for (int k = 0; k < 3; k++)
    if (!names[k].empty()) shift[k] = now.between(start[k], goal[k]);
}

/* ----------------------------------------------------------------------
   Variables tell where the wall is at the end of a step of the run; in between it moves at one speed.
   That is what nodes have when forces are evaluated; nothing is known of it at the very first
   evaluation.
------------------------------------------------------------------------- */

void PeridemWallMotion::look_ahead(const PeridemMoment &now)
{
  modify->clearstep_compute();
  for (int k = 0; k < 3; k++) {
    if (names[k].empty()) continue;
    goal[k] = evaluate(k);
    if (now.stepping && known) velocity[k] = (goal[k] - shift[k]) / now.whole;
    start[k] = known ? shift[k] : goal[k];
  }
  known = true;
  PeridemSchedule::invoked(modify, update->ntimestep + 1);
}

/* ---------------------------------------------------------------------- */

void PeridemWallMotion::pack(double *list) const
{
  for (int k = 0; k < 3; k++) {
    list[k] = shift[k];
    list[3 + k] = velocity[k];
  }
  list[6] = known ? 1.0 : 0.0;
}

/* ----------------------------------------------------------------------
   a constant velocity is what the script says now
------------------------------------------------------------------------- */

void PeridemWallMotion::unpack(const double *list)
{
  for (int k = 0; k < 3; k++) {
    shift[k] = list[k];
    if (variable) velocity[k] = list[3 + k];
  }
  known = list[6] != 0.0;
}
