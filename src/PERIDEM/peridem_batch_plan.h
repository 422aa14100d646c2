/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Which grains are computed side by side: grains with the same number of nodes and one shape, whatever
// their scale and rotation, sorted by size, so that their families differ little.  The shape only
// sorts: bonds are those that fix peridem/bonds has, each grain has its own lengths and weights, and
// a bond that some grains of a batch lack has weight zero in them.

#ifndef LMP_PERIDEM_BATCH_PLAN_H
#define LMP_PERIDEM_BATCH_PLAN_H

#include "peridem_batch_share.h"
#include "peridem_simd.h"
#include "pointers.h"

#include <array>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

struct PeridemBatchGroup {
  int type{0};
  int nodes{0};
  int lanes{0};                // grains; the other lanes repeat the first, without bonds
  std::vector<int> index;      // of node n of the grain in a lane, [n * WIDTH + lane]; see below
  std::vector<tagint> ids;     // of the same
  std::vector<bigint> held;    // bonds that the grain in a lane has, counted from both ends

  // three for each of the indices: to the side of the periodic box where node 0 is; empty if there
  // is nothing to shift
  std::vector<double> shift;

  // bonds first[n] <= k < first[n + 1] lead from node n to nodes partner[k] > n
  std::vector<int> first;
  std::vector<unsigned short> partner;

  // in full, for each lane: 1/R, 0 where the grain lacks the bond, and w v V_i V_j R^2
  std::vector<PeridemSimd::Pack> inverse, strength;
  // or, if lean, one for all lanes; what 1/R of each lane has more; and a bit for each lane that has
  // the bond (peridem_batch_kernel.h)
  bool lean{false};
  std::vector<double> common, one_strength;
  std::vector<float> rest;
  std::vector<unsigned char> here;

  // per node
  std::vector<PeridemSimd::Pack> soft, stiff, dashpot;    // a_i / sum, b_i, viscous b_i
  std::vector<PeridemSimd::Pack> sum;                     // of strength * stretch
  std::vector<PeridemSimd::Pack> most;    // what bonds->maxstretch is known to have reached

  // no bond from n to m any more in this lane; was there one?
  bool drop_bond(int lane, int n, int m);
  // tell bonds leanly if the grains are alike enough
  void make_lean();
  double memory_usage() const;

 private:
  bool alike(std::size_t k, int first_lane, double tolerance) const;
};

// Indices of nodes here are local indices below nlocal, and above that the places among borrowed nodes
// (peridem_batch_share.h).

class PeridemBatchPlan : protected Pointers {
 public:
  // why a grain is left to the general engine
  enum Reason { WIDE, MIXED, RIGID, LARGE, FEW, NREASONS };

  // nodes of a grain above which the arrays of a batch leave the second-level cache
  static constexpr int MAXNODES = 4000;

  struct Law {          // of one atom type
    bool here;          // does the pair style cover it?
    double softness;    // a_i = softness sum / (m_i^2 V_i)
  };

  explicit PeridemBatchPlan(class LAMMPS *lmp) : Pointers(lmp), share(lmp) {}

  // forced: batch whatever can be, even without gain; stiffness, dashpot: of owned nodes; collective
  void build(const FixPeridemBonds *, const std::vector<Law> &, const double *stiffness,
             const double *dashpot, bool forced);

  // build everything anew next time
  void forget()
  {
    groups.clear();
    loners.clear();
  }

  PeridemBatchShare share;
  std::vector<PeridemBatchGroup> groups;
  std::size_t first_shared{0};    // groups from here on have borrowed nodes
  std::vector<char> covered;      // by index: is the node in a batch, here or on another rank?
  struct Place {
    int group, lane;
  };
  std::vector<Place> places;    // by index: where in the groups of this rank, -1 if nowhere
  std::vector<int> number;      // by index: of the node within its grain

  // number within its grain of a bonded node, given by a local or ghost index, or by its ID
  int number_of(int j) const;
  int number_of_tag(tagint) const;

  // does no bond between two such nodes ever break?
  bool unbroken(int) const;

  // of this rank
  std::array<bigint, NREASONS> left{};    // grains left to the general engine
  bigint grains_batched() const;
  double memory_usage() const;

 private:
  struct Grain {
    std::vector<int> nodes;    // indices, by tag
    bool shared{false};
    int type{0}, shape{0};
    double size{0.0};             // root mean square distance from the centroid of the reference
    std::vector<double> shift;    // three per node, if any is not zero
  };
  using Grains = std::vector<Grain>;
  struct Bond {
    double length, weight;
  };

  const FixPeridemBonds *bonds{nullptr};
  const double *stiffness{nullptr}, *dashpot{nullptr};
  int nlocal{0};
  bigint natoms{-1};
  std::vector<tagint> loners;    // grains of this rank that were too few of their kind, by ID

  void keep_groups(bool forced);
  bool keep(PeridemBatchGroup &, bool forced) const;
  bool find_lane(PeridemBatchGroup &, int lane, Grain &) const;
  bool news(const Grains &) const;
  void leave_loners(Grains &);
  void dissolve_small(Grains &);
  void leave(const Grain *first, const Grain *last);
  static void put_shift(PeridemBatchGroup &, int lane, const Grain &);
  void enter(const PeridemBatchGroup &, std::size_t place);

  tagint tag(int) const;
  int type(int) const;
  const double *place(int) const;
  const double *reference(int) const;
  // of a node, own or borrowed: how many bonds it has, and of one of them the number within the grain
  // of the node at its other end
  int bond_count(int i) const;
  int partner(int i, int k) const;
  Bond bond(int i, int k) const;

  std::vector<int> candidates(const std::vector<Law> &) const;
  Grains find_grains(const std::vector<int> &) const;
  void add_borrowed(Grains &) const;
  int unfit(Grain &) const;
  static bool gains(const PeridemBatchGroup &);
  bool flat(const Grain &) const;
  bool unwrap(Grain &) const;
  std::vector<double> profile(Grain &) const;
  void find_shapes(Grains &) const;
  void form_groups(Grains &, const std::vector<Law> &, bool forced);
  bool build_group(const Grain *first, const Grain *last, bool forced);
  void count_bonds(const Grain *first, PeridemBatchGroup &) const;
  void unite(const Grain *first, PeridemBatchGroup &) const;
  void fill(const Grain *first, PeridemBatchGroup &) const;
  void fill_nodes(PeridemBatchGroup &, const std::vector<Law> &) const;
  void settle();
};

}    // namespace LAMMPS_NS

#endif
