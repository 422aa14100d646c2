/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// How a whole wall moves: at a constant velocity, or as variables say.

#ifndef LMP_PERIDEM_WALL_MOTION_H
#define LMP_PERIDEM_WALL_MOTION_H

#include "peridem_level.h"
#include "pointers.h"

#include <string>

namespace LAMMPS_NS {

class PeridemWallMotion : protected Pointers {
 public:
  PeridemWallMotion(class LAMMPS *lmp, const char *_style) : Pointers(lmp), style(_style) {}

  // reads velocity or move from arg[iarg]; returns where it stopped: iarg for any other word
  int parse(int iarg, int narg, char **arg);
  static const char *keywords() { return "velocity"; }

  void init();
  // where the wall is at this moment
  void advance(const PeridemMoment &);
  bool moves() const { return constant || variable; }

  double shift[3]{0.0, 0.0, 0.0};       // from where the wall was when the fix was made
  double velocity[3]{0.0, 0.0, 0.0};    // over the last step

  // as numbers, for restarts
  static constexpr int SIZE = 7;
  void pack(double *) const;
  void unpack(const double *);

 private:
  const char *style;
  bool given{false};
  bool constant{false}, variable{false};
  bool known{false};       // where the wall was before; for variables
  std::string names[3];    // of the variables; empty: does not move in this direction
  double start[3]{0.0, 0.0, 0.0},
      goal[3]{0.0, 0.0, 0.0};    // of this step of the run; for variables

  void parse_velocity(int iarg, int narg, char **arg);
  void parse_move(int iarg, int narg, char **arg);
  double evaluate(int k);
  void look_ahead(const PeridemMoment &);
};

}    // namespace LAMMPS_NS

#endif
