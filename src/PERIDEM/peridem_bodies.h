/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The bodies that collide: a whole grain moves as one rigid body, a piece of a broken grain is felt
// as the patch of nodes around the one that touches.  What makes a collision of deformable grains
// lose energy acts between bodies, because the two nodes that touch hardly move against each other:
// a stiff contact follows the bulk behind it.

#ifndef LMP_PERIDEM_BODIES_H
#define LMP_PERIDEM_BODIES_H

#include "peridem_sharing.h"
#include "peridem_spread.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

// mass, place and rigid motion of a set of nodes

struct PeridemMotion {
  double mass{0.0}, place[3]{0.0, 0.0, 0.0}, velocity[3]{0.0, 0.0, 0.0};
  double spin[3]{0.0, 0.0, 0.0};
  double inverse[6]{};    // of the tensor of inertia: xx, yy, zz, xy, xz, yz; 0 where nothing turns

  // of a point at this distance from the centre of mass
  void velocity_at(const double *arm, double *v) const;
  // of the nodes at this distance by a force and a torque about the centre of mass
  void acceleration_at(const double *arm, const double *force, const double *torque,
                       double *a) const;
  // velocity over impulse at that point, as a tensor
  void mobility_at(const double *arm, double *tensor) const;
  // spin and inverse from the angular momentum and the tensor of inertia
  void turn(const double *momentum, const double *inertia);
};

// a body as its node that touches feels it

struct PeridemBody {
  double offset[3];      // of the centre of mass from the node
  double velocity[3];    // of the node, if the body were rigid
  double mobility[6];    // velocity of the node over impulse at it: xx, yy, zz, xy, xz, yz
  double whole;          // 1 for a grain, 0 for a patch of a broken one

  static constexpr int SIZE = 13;    // as doubles, for communication

  // speed over impulse along a unit vector
  double mobility_along(const double *n) const;
};

// Which nodes belong to which grain is found out once per reneighbouring; how a grain moves only if
// somebody asks, and of grains that several ranks have parts of at the start.

class PeridemBodies : protected Pointers {
 public:
  explicit PeridemBodies(class LAMMPS *);

  // local indices are new; bonds may be null; collective
  void sort_nodes(const FixPeridemBonds *);
  // nodes have moved
  void forget() { started = false; }
  // before a body is asked for; collective, and nothing if nodes have not moved since
  void start();

  // this rank owns a node that is felt with the patch around it
  bool any_patch();

  // do other ranks own nodes of the grain of the owned node i?
  bool shared(int i) const { return grain_of[i] >= 0 && grains[grain_of[i]].shared; }

  // the body that the owned node i belongs to
  PeridemBody body(int i);

  // a force on that body at the node, which the next two spread over its nodes as one that moves a
  // rigid body: over patches, whose nodes may be ghosts; over whole grains (collective)
  void push(int i, const double *force);
  void apply_patches(PeridemSpread &);
  void apply(PeridemSpread &);

  double memory_usage() const;

 private:
  struct Grain {
    int first, last;         // its owned nodes, in nodes
    bool broken{false};      // has a broken bond
    bool shared{false};      // among ranks
    bool unwrap{false};      // lies across a periodic boundary
    bool pushed{false};      // by a force that apply() has to spread
    bigint known{-1};        // the evaluation that motion is from
    double origin[3]{};      // of sums: near its centre of mass
    PeridemMotion motion;    // place in the same frame as origin
    double force[3]{}, torque[3]{};
  };
  struct Patch {    // an owned node of a broken grain, and those that intact bonds tie to it
    int node{-1};
    bool pushed{false};
    PeridemMotion motion;
    double force[3]{};
  };
  struct Sums {
    double mass{0.0}, place[3]{}, velocity[3]{}, momentum[3]{};    // times mass but the first
    double square[6]{};    // of places: xx, yy, zz, xy, xz, yz; in 2d the first two
    double broken{0.0};
  };

  std::vector<Grain> grains;
  std::vector<int> nodes;         // owned nodes, grain by grain
  std::vector<int> grain_of;      // of owned nodes; -1: of none
  std::vector<int> pushed;        // grains
  std::vector<Patch> patches;     // of nodes that touch, since nodes have moved
  std::vector<int> patch_of;      // of owned nodes; -1: not asked for
  std::vector<double> numbers;    // of shared grains, on their way
  PeridemSharing sharing;
  const FixPeridemBonds *bonds{nullptr};
  std::size_t broken_seen{0};
  bool loose{false}, any_broken{false};    // nodes of no grain, broken grains; on this rank
  bool started{false};
  bigint evaluation{0};

  std::vector<tagint> find_grains();
  void find_origins();
  void note_broken();
  void start_shared();
  bool whole(int i) const { return grain_of[i] >= 0 && !grains[grain_of[i]].broken; }
  void place_of(int i, const Grain &, double *x) const;
  void arm_of(int i, const Grain &, double *arm) const;
  Sums sum(const Grain &) const;
  template <int DIM, bool UNWRAP> Sums sum_nodes(const Grain &) const;
  static PeridemMotion motion_of(const Sums &, const double *origin);
  const Grain &moving(int g);
  void sum_pushes();
  void spread_over(const Grain &, PeridemSpread &) const;
  template <int DIM, bool UNWRAP> void spread_nodes(const Grain &, PeridemSpread &) const;
  template <class Visit> void for_patch(int i, Visit) const;
  PeridemMotion motion_of_patch(int i) const;
  Patch &patch(int i);
  void spread_patch(const Patch &, PeridemSpread &) const;
};

}    // namespace LAMMPS_NS

#endif
