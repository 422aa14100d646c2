/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The bodies that collide: a grain, or a piece of a broken one, moves as one rigid body.  What makes a
// collision of deformable grains lose energy acts between bodies, because the two nodes that touch
// hardly move against each other: a stiff contact follows the bulk behind it.

#ifndef LMP_PERIDEM_BODIES_H
#define LMP_PERIDEM_BODIES_H

#include "peridem_motion.h"
#include "peridem_pieces.h"
#include "peridem_sharing.h"
#include "peridem_spread.h"
#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

// Which nodes belong to which body is found out once per reneighbouring and where a grain falls
// apart; how a body moves only if somebody asks, and of bodies that several ranks have parts of at
// the start.

class PeridemBodies : protected Pointers {
 public:
  explicit PeridemBodies(class LAMMPS *);

  // a run starts: bonds may be others
  void init() { grains.clear(); }
  // local indices are new; bonds may be null; collective
  void sort_nodes(const FixPeridemBonds *);
  // nodes have moved
  void forget() { started = false; }
  // before start(): may a grain with nodes on other ranks have fallen apart, as far as this rank sees?
  bool torn();
  // before a body is asked for; any_torn: on any rank; collective, and nothing if nodes have not
  // moved since
  void start(bool any_torn);
  // since nodes have moved, has it been called?
  bool known() const { return started; }

  // of the body of the owned node i; the same on all ranks, and never that of another body
  bigint id(int i) const { return bodies[body_of[i]].id; }
  // do other ranks own nodes of the body of the owned node i?
  bool shared(int i) const { return bodies[body_of[i]].shared; }
  // grows when bodies of owned nodes become others
  bigint version() const { return changes; }

  // the body that the owned node i belongs to
  PeridemBody body(int i);

  // a force on that body at the node, which apply() spreads over its nodes as one that moves a rigid
  // body (collective, but without others: if no rank has pushed a body that others have parts of)
  void push(int i, const double *force);
  void apply(PeridemSpread &, bool with_others);

  double memory_usage() const;

 private:
  struct Body {
    bigint id{0};
    int first{0}, last{0};    // its owned nodes, in nodes
    bool shared{false};       // among ranks
    bool unwrap{false};       // lies across a periodic boundary
    bool pushed{false};       // by a force that apply() has to spread
    bigint known{-1};         // the evaluation that motion is from
    double origin[3]{};       // of sums: near its centre of mass
    PeridemMotion motion;     // place in the same frame as origin
    double force[3]{}, torque[3]{};
  };
  struct Grain {
    tagint id;
    int first{0}, last{0};    // its owned nodes, in nodes
    bool broken{false};       // has a broken bond
    bool shared{false};       // among ranks
    int pieces{1};            // that these nodes are at least
  };

  std::vector<Grain> grains;    // by molecule-ID
  std::vector<int> grain_of;    // of owned nodes; -1: of none
  std::vector<Body> bodies;
  std::vector<int> body_of;       // of owned nodes
  std::vector<int> nodes;         // owned nodes, grain by grain and within it body by body
  std::vector<int> pushed;        // bodies
  std::vector<double> numbers;    // of shared bodies, on their way
  PeridemSharing sharing_grains, sharing;
  PeridemPieces pieces;
  const FixPeridemBonds *bonds{nullptr};
  std::size_t broken_seen{0};
  std::vector<int> falling;        // grains of this rank alone, that may have fallen apart
  bool torn_among_ranks{false};    // so may one with nodes on other ranks
  bool started{false};
  bigint evaluation{0}, changes{0};

  void find_grains();
  void keep_pieces(const std::vector<Grain> &before);
  void label(Grain &);
  void find_broken();
  void find_pieces();
  void find_bodies();
  void add_whole(const Grain &);
  void add_pieces(const Grain &);
  void add_loose();
  void number_bodies();
  void find_origins();
  void find_unwrap(Body &) const;
  void split(int g);
  void start_shared();
  void place_of(int i, const Body &, double *x) const;
  void arm_of(int i, const Body &, double *arm) const;
  PeridemSums sum(const Body &) const;
  template <int DIM, bool UNWRAP> PeridemSums sum_nodes(const Body &) const;
  Body &moving(int i);
  void sum_pushes();
  void spread_over(const Body &, PeridemSpread &) const;
  template <int DIM, bool UNWRAP> void spread_nodes(const Body &, PeridemSpread &) const;
};

}    // namespace LAMMPS_NS

#endif
