/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef FIX_CLASS
// clang-format off
FixStyle(peridem/adapt,FixPeridemAdapt);
// clang-format on
#else

#ifndef LMP_FIX_PERIDEM_ADAPT_H
#define LMP_FIX_PERIDEM_ADAPT_H

#include "fix_nve.h"
#include "peridem_adapt_inertia.h"
#include "peridem_adapt_options.h"
#include "peridem_adapt_switch.h"
#include "peridem_adapt_table.h"
#include "peridem_rigid_nodes.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

// Time integration of grains that are rigid until the forces on them could stretch their bonds, and
// deform from then on.

class FixPeridemAdapt : public FixNVE {
 public:
  FixPeridemAdapt(class LAMMPS *, int, char **);
  ~FixPeridemAdapt() override;
  int setmask() override;
  void init() override;
  void setup_pre_force(int) override;
  void setup(int) override;
  void initial_integrate(int) override;
  void pre_force(int) override;
  void final_integrate() override;
  void end_of_step() override;

  double compute_vector(int) override;
  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;
  void write_restart(FILE *) override;
  void restart(char *) override;

  // is the node part of a rigid grain? i may be a ghost
  bool rigid(int i) const { return table.rigid(i); }

  // for the time step; see PeridemAdaptInertia
  bool any_deformable() const;
  bool moves_alone(int i) const { return inertia.moves_alone(i); }
  void note_spring(int i, double k) { inertia.note_spring(i, k); }
  double largest_frequency_sq() const { return inertia.largest_frequency_sq(); }
  double lightest(int itype) const { return inertia.lightest(itype); }

  // for the energy ledger: what switches and relaxation have taken so far, and strain energy that
  // rigid grains hold; the same on all ranks
  double energy_taken() const { return switches.taken; }
  double energy_held() const { return switches.energy_held(); }

 private:
  using Grain = PeridemAdaptGrain;

  PeridemAdaptOptions options;
  PeridemAdaptTable table;
  PeridemRigidNodes nodes;
  PeridemAdaptSwitch switches;
  PeridemAdaptInertia inertia;

  bool started{false};
  bigint natoms_seen{-1};
  double *state{nullptr};    // of nodes, for output
  bool states_stale{true}, step_stale{false};
  bool others_deform{false};    // is there a bonded node outside the group?
  std::vector<int> single;      // nodes that move one by one
  FixPeridemBonds *bonds{nullptr};

  void check_others() const;
  void take_stock();
  void sort_nodes();
  void regroup();
  void tell_others();
  void move_single(bool drift);
};

}    // namespace LAMMPS_NS

#endif
#endif
