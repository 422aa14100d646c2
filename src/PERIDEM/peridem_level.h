/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The level of run_style respa that a force acts at.  Without respa there is one level, with the
// time step of the run.

#ifndef LMP_PERIDEM_LEVEL_H
#define LMP_PERIDEM_LEVEL_H

#include "pointers.h"

#include <string>

namespace LAMMPS_NS {

class Pair;
class Respa;

class PeridemLevel : protected Pointers {
 public:
  explicit PeridemLevel(class LAMMPS *lmp) : Pointers(lmp) {}

  // before each run: the level of a pair style, which is named in the error that it has none;
  // without a pair style the innermost level
  void find(const Pair *, const std::string &name);

  Respa *respa() const { return scheme; }      // nullptr: no respa
  int index() const { return level; }          // 0 = innermost
  int count() const { return evaluations; }    // force evaluations in one step of the run
  double dt() const;                           // time between them

  // true at the first force evaluation that sees new neighbor lists; ask once in each of them
  bool lists_are_new();

 private:
  Respa *scheme{nullptr};
  int level{0};
  int evaluations{1};
  bigint lists_seen{-1};
};

// The moment of a force evaluation within a step of the run.

struct PeridemMoment {
  bool stepping{false};    // time has gone by since the last one
  bool begins{true};       // the first one in this step of the run, or one outside of any
  double part{1.0};        // of the step of the run that has gone by
  double dt{0.0};          // since the last one
  double whole{0.0};       // the step of the run

  // between where something was and where it will be at the end of the step
  double between(double start, double goal) const
  {
    return part == 1.0 ? goal : start + part * (goal - start);
  }
};

// Tells the moments of force evaluations at a level: several of them may be at the same time.

class PeridemClock : protected Pointers {
 public:
  explicit PeridemClock(class LAMMPS *lmp) : Pointers(lmp) {}
  PeridemMoment next(const PeridemLevel &);

 private:
  bigint last_step{-1};
  int done{0};    // evaluations in this step of the run
};

}    // namespace LAMMPS_NS

#endif
