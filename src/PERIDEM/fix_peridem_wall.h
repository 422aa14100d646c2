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
#include "peridem_bodies.h"
#include "peridem_books.h"
#include "peridem_collisions.h"
#include "peridem_contact_law.h"
#include "peridem_grains.h"
#include "peridem_level.h"
#include "peridem_surface.h"
#include "peridem_wall_list.h"
#include "peridem_wall_memory.h"
#include "peridem_wall_motion.h"

#include <memory>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class FixPeridemBonds;
class PairPeridemContact;
class PeridemContactStiffness;

// A surface that nodes of grains touch with the same law as each other, still or moving.

class FixPeridemWall : public Fix {
 public:
  FixPeridemWall(class LAMMPS *, int, char **);
  ~FixPeridemWall() override;
  int setmask() override;
  void init() override;
  void setup(int) override;
  void min_setup(int) override;
  void post_force(int) override;
  void post_force_respa(int, int, int) override;
  void min_post_force(int) override;
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
  int size_restart(int) override;
  int maxsize_restart() override;
  double memory_usage() override;

  // for the energy ledger, on this rank: power of the wall's forces on nodes; power of friction and
  // of damping against the wall as it moves; energy of overlaps and of tangential springs
  struct Power {
    double on_nodes, friction, damping;
  };
  PeridemBooks books;
  Power power() const;
  double elastic_energy() const { return energy; }
  double spring_energy() const { return springs; }

  // what may hold nodes within some time
  bool begins_softly() const;
  void add_stiffness(PeridemContactStiffness &, double time);
  // bounds over all nodes that can touch the wall
  double largest_frequency_sq() const;
  double largest_dashpot_ratio() const;

 private:
  std::unique_ptr<PeridemSurface> surface;
  PeridemWallMotion motion;    // of the surface as a whole
  PeridemContactGiven given;
  std::vector<PeridemContactLaw> laws;    // by node type
  PeridemGrains::Extremes extremes;
  FixPeridemAdapt *adapt{nullptr};
  double lightest(int itype) const;
  PeridemWallList nearby;
  double largest_radius{0.0};
  PeridemWallMemory memories;
  FixPeridemBonds *bonds{nullptr};
  bool any_restitution{false};
  PeridemBodies own_bodies;    // that collide, unless the contact pair style has them
  PeridemBodies *bodies{nullptr};
  PeridemSpread spread;          // forces that collisions lose energy by
  std::vector<double> pushes;    // the same on owned nodes, while energies are booked
  struct Impact {                // a contact of this step that loses energy by restitution
    int node;
    PeridemSurface::Foot foot;
    double elastic, stored;    // force, and twice the energy
    PeridemBody body;
    int collision;    // its place in collisions
  };
  std::vector<Impact> impacts;
  PeridemCollisions collisions;
  bool pushing{false};       // some rank has one
  double push_power{0.0};    // of the wall against the pushes, on this rank
  std::vector<PeridemSurface::Foot> feet;
  bool advance{true};
  bool started{false};
  PeridemLevel level;
  double dt{0.0};    // of its level
  PeridemClock clock;
  PeridemMoment now;

  // on this rank, of the last force evaluation: force on each part of the wall and torque about
  // the point of the part, power of faces that change their shape, deepest overlap, elastic energy
  struct Load {
    double force[3], torque[3];
  };
  std::vector<Load> loads, loads_before;
  std::vector<Load> mean_loads;    // of the force evaluations in one step of the run
  double shape_power{0.0}, deepest{0.0}, energy{0.0};
  int most_touched{0};    // faces, by one node
  double springs{0.0};    // energy of the tangential springs
  struct Touch {          // what a node felt, while energies are booked
    int node;
    double friction[3], damping[3], wall_velocity[3];
    double direct[3];    // all but what restitution adds
  };
  std::vector<Touch> touches;
  double work{0.0};    // of the wall on the nodes so far
  double total[8];     // over all ranks: force, torque, work, elastic energy
  bool totals_known{false};

  int parse_surface(int, int, char **);
  int parse_keyword(int, int, char **);
  void describe(const std::vector<int> &) const;
  void find_level(const PairPeridemContact *);
  void follow_surface();
  bool misplaced(int i) const;
  bigint sum_misplaced(bigint count, tagint &lowest) const;
  void check_start();
  void check_overlaps();
  void check_lost();
  double springs_at_a_node() const;
  void renew_list();
  void clear_loads();
  void average_loads();
  void touch_all();
  double linger(int i) const;
  void touch(int i, const PeridemSurface::Foot &);
  void part(int i, const PeridemSurface::Foot &);
  void impact(const Impact &);
  void impact_pass();
  void react(int i, const PeridemSurface::Foot &, const double *on_node);
  void find_bodies(bool new_indices);
  void find_collisions();
  void book(int i, const PeridemSurface::Foot &, double lossy, const double *drag,
            const double *direct);
  void add_work();
  void sum_totals();
};

}    // namespace LAMMPS_NS

#endif
#endif
