/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Which state a grain of fix peridem/adapt is in: what wakes it, what lets it become rigid again or
// sleep, and what happens then.

#ifndef LMP_PERIDEM_ADAPT_SWITCH_H
#define LMP_PERIDEM_ADAPT_SWITCH_H

#include "peridem_adapt_options.h"
#include "peridem_adapt_table.h"
#include "peridem_rigid_nodes.h"

#include <vector>

namespace LAMMPS_NS {

class PeridemAdaptSwitch : protected Pointers {
 public:
  double taken{0.0};    // energy, by switches and relaxation so far
  bigint wakes{0}, freezes{0};

  PeridemAdaptSwitch(class LAMMPS *, PeridemAdaptTable &, PeridemRigidNodes &,
                     const PeridemAdaptOptions &);

  // all collective; true: some grain has another state now

  void start();    // all whole grains become rigid, before there are forces
  void follow_user();
  bool consider_loads(double dt);
  bool look_for_quiet();
  void relax_vibration(double dt);

  double energy_held() const;    // strain energy of rigid grains

 private:
  using Grain = PeridemAdaptGrain;

  PeridemAdaptTable &table;
  PeridemRigidNodes &rigid;
  const PeridemAdaptOptions &options;

  void freeze(const std::vector<tagint> &, bool forces_known = true);
  void find_reach(const std::vector<tagint> &);
  void wake(Grain &, double dt);
  bool overloaded(std::size_t, double dt);
  bool rest(std::size_t, double dt);
  void fall_asleep(Grain &);
  double stretch_and_ringing(const Grain &, const PeridemMoments &, double stretched) const;
};

}    // namespace LAMMPS_NS

#endif
