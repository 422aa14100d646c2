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
FixStyle(peridem/wall,FixPeridemWall);
// clang-format on
#else

#ifndef LMP_FIX_PERIDEM_WALL_H
#define LMP_FIX_PERIDEM_WALL_H

#include "fix.h"
#include "peridem_contact_law.h"
#include "peridem_grains.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

// A plane that nodes of grains touch with the same law as each other, still or moving.

class FixPeridemWall : public Fix {
 public:
  FixPeridemWall(class LAMMPS *, int, char **);
  ~FixPeridemWall() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void min_setup(int) override;
  void initial_integrate(int) override;
  void post_force(int) override;
  void min_post_force(int) override;
  void post_force_respa(int, int, int) override;
  double compute_scalar() override;
  double compute_vector(int) override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override { return 5; }
  int maxsize_restart() override { return 5; }
  int pack_reverse_comm(int, int, double *) override;
  void unpack_reverse_comm(int, int *, double *) override;
  double memory_usage() override;

  // bounds over all nodes that can touch the wall
  double largest_frequency_sq() const;
  double largest_dashpot_ratio() const;

 private:
  double point[3]{0.0, 0.0, 0.0};       // of the plane, when the fix was made
  double normal[3]{0.0, 0.0, 0.0};      // unit vector to the side where the grains are
  double velocity[3]{0.0, 0.0, 0.0};
  double shift[3]{0.0, 0.0, 0.0};       // how far the plane has moved
  PeridemContactGiven given;
  std::vector<PeridemContactLaw> laws;    // by node type
  PeridemGrains::Extremes extremes;
  double **memory_at_wall{nullptr};       // of each owned node: tangential spring, fastest approach
  FixPeridemBonds *bonds{nullptr};
  bool any_restitution{false};
  std::vector<double> pushes;             // forces on the patches, of owned and ghost nodes
  bool advance{true};
  bool moving{false}, started{false};
  int ilevel_respa{0};

  // on this rank, of the last force evaluation: force on the wall, torque about its point,
  // deepest overlap, elastic energy; work of the wall on the nodes so far
  double force[3], torque[3], deepest, energy, work{0.0};
  double total[9];    // over all ranks
  bool totals_known{false};

  int parse_plane(int, int, char **);
  int parse_vector(int, int, char **, const char *, double *);
  void describe(const std::vector<int> &) const;
  void check_start();
  void touch(int i, double distance, const double *at);
  void impact(int i, double elastic, double *total);
  void bring_pushes_home();
  void sum_totals();
};

}    // namespace LAMMPS_NS

#endif
#endif
