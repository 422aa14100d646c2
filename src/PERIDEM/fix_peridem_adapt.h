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
#include "peridem_adapt_grain.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;
class PairPeridem;

// Time integration of grains that are rigid until the forces on them could stretch their bonds, and
// deform from then on.  All ranks hold the table of the grains and see the same sums, so they decide
// alike.

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
  bool rigid(int i) const;

  // for the time step: is there a grain whose bonds are computed? The lightest that a contact can
  // push of a type: a node, or a rigid grain as it is felt at its farthest node; and that of a node
  bool any_deformable() const;
  // contacts and walls: a spring that pushes node i at this step
  void note_spring(int i, double k)
  {
    if (rigid(i)) springs[atom_molecule(i)] += k;
  }
  // bound from the springs that push rigid grains; collective
  double largest_frequency_sq() const;
  double lightest(int itype) const { return lightest_of.at(itype); }

  // for the energy ledger: what switches and relaxation have taken so far, and strain energy that
  // rigid grains hold; the same on all ranks
  double energy_taken() const { return taken; }
  double energy_held() const;

 private:
  using Grain = PeridemAdaptGrain;

  double eta{0.3}, back{0.5}, stretch{0.0}, relax{2.0}, sleep{0.0};
  int every{50}, hold{4};
  bool start_rigid{true};

  std::vector<Grain> grains;    // by molecule-ID
  bool started{false};
  bigint natoms_seen{-1};
  double **offset{nullptr};    // of nodes of rigid grains, in the body's axes
  double *state{nullptr};      // of nodes, for output
  bool states_stale{true}, step_stale{false};
  std::vector<double> lightest_of;    // by type
  std::vector<double> springs;        // by molecule-ID, of this step on this rank
  bool others_deform{false};          // is there a bonded node outside the group?
  double taken{0.0};
  bigint wakes{0}, freezes{0};
  FixPeridemBonds *bonds{nullptr};
  std::vector<PairPeridem *> solids;

  // of this step: the rigid grains, where each of them is in that list, sums over its nodes
  static constexpr int NSUMS = 16;    // force, torque, moment, sizes of forces
  std::vector<tagint> rigid_grains;
  std::vector<int> slot;
  std::vector<double> sums, highest;

  void parse(int, char **);
  void check_whole();
  void measure();
  void set_limits(Grain &) const;
  void locate(const double *, int, double *) const;
  Grain *grain_of(int i);
  std::vector<tagint> listed(int state) const;
  std::vector<PeridemMoments> moments(const std::vector<tagint> &);
  void freeze(const std::vector<tagint> &);
  void follow_user();
  void wake(tagint);
  void fall_asleep(tagint);
  void tell_others();
  double felt_mass(int i) const;
  tagint atom_molecule(int i) const;
  void find_lightest();
  void find_reach(const std::vector<tagint> &);

  void move_deformable(bool drift);
  void place();
  void set_velocities();
  void set_velocity(int i, const PeridemRigidBody &, const double *r);
  void sum_forces();
  void add_force(int i, const PeridemRigidBody &, double *sum, double &node) const;
  bool consider_loads();
  bool rest(std::size_t);
  void relax_vibration();
  bool look_for_quiet();
  void strain_energies(const std::vector<tagint> &, std::vector<double> &) const;
  double row_stretch(int i) const;
};

}    // namespace LAMMPS_NS

#endif
#endif
