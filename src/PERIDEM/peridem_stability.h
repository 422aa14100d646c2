/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The largest stable time step: from the bonds, the contacts and the dashpots.

#ifndef LMP_PERIDEM_STABILITY_H
#define LMP_PERIDEM_STABILITY_H

#include "pointers.h"

#include <string>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class FixPeridemWall;
class PairPeridem;
class PairPeridemContact;

class PeridemStability : protected Pointers {
 public:
  // A node that goes further than this part of the contact distance in one step finds itself deep
  // in a contact that it never entered: the springs then give more than was put into them.
  static constexpr double TRAVEL = 0.1;

  // time steps at which velocity Verlet becomes unstable; infinite where there is nothing to limit
  struct Limits {
    double bonds{0.0};       // stiffness of the bonds alone, as a step of their level
    double contacts{0.0};    // stiffness of the contacts alone, as a step of their level
    double dashpots{0.0};    // what damping takes off both together
    double springs{0.0};     // both together without damping, as a step of the run
    double stable{0.0};      // all together, as a step of the run
    double speeds{0.0};      // not of stability: the fastest node travels TRAVEL
    int bond_count{1}, contact_count{1};    // steps of their levels in one of the run
    const char *ruling() const;             // which of them rules
  };

  PeridemStability(class LAMMPS *);

  // before a run, by who asks often: no style comes or goes before the next call
  void keep_styles();

  // collective: all ranks call it, after forces have been computed; if it is asked again within so
  // many steps, contacts that come later need no room
  static constexpr int NEVER = -1;
  Limits find(int again = NEVER);

 private:
  struct Styles {
    std::vector<PairPeridem *> solids;
    std::vector<FixPeridemWall *> walls;
    PairPeridemContact *contact{nullptr};
    const FixPeridemAdapt *adapt{nullptr};
  };
  Styles styles;
  bool kept{false};
  double bond_frequency_sq{-1.0};    // bonds only get softer as they break: found once
  bigint bonds_known{-1};

  Styles find_styles() const;
  void find_counts(Limits &) const;
  bool contacts_begin_softly() const;
  void gather_stiffness(int steps) const;
  double contact_frequency_sq(int steps) const;
  double largest_dashpot_ratio(double bonds_sq) const;
  double speed_limit() const;
};

}    // namespace LAMMPS_NS

#endif
