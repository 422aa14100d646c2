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

#include "peridem_simd.h"
#include "pointers.h"

#include <array>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

struct PeridemBatchGroup {
  int type{0};
  int nodes{0};
  int lanes{0};              // grains; the other lanes repeat the first, without bonds
  std::vector<int> index;    // local index of node n of the grain in a lane: [n * WIDTH + lane]

  // bonds first[n] <= k < first[n + 1] lead from node n to nodes partner[k] > n
  std::vector<int> first;
  std::vector<unsigned short> partner;
  std::vector<PeridemSimd::Pack> inverse;     // 1/R, 0 where the grain lacks the bond
  std::vector<PeridemSimd::Pack> strength;    // w v V_i V_j R^2

  // per node
  std::vector<PeridemSimd::Pack> soft, stiff, dashpot;    // a_i / sum, b_i, viscous b_i
  std::vector<PeridemSimd::Pack> sum;                     // of strength * stretch
  std::vector<PeridemSimd::Pack> most;    // what bonds->maxstretch is known to have reached

  // no bond from n to m any more in this lane
  void drop_bond(int lane, int n, int m);
  double memory_usage() const;
};

class PeridemBatchPlan : protected Pointers {
 public:
  // why a grain is left to the general engine
  enum Reason { SPANS, MIXED, RIGID, LARGE, FEW, NREASONS };

  // nodes of a grain above which the arrays of a batch leave the second-level cache
  static constexpr int MAXNODES = 4000;

  struct Law {          // of one atom type
    bool here;          // does the pair style cover it?
    double softness;    // a_i = softness sum / (m_i^2 V_i)
  };

  explicit PeridemBatchPlan(class LAMMPS *lmp) : Pointers(lmp) {}

  // forced: batch whatever can be, even without gain; stiffness, dashpot: of owned nodes
  void build(const FixPeridemBonds *, const std::vector<Law> &, const double *stiffness,
             const double *dashpot, bool forced);

  std::vector<PeridemBatchGroup> groups;
  std::vector<char> covered;    // by local index: is the node in a group?
  struct Place {
    int group, lane;
  };
  std::vector<Place> places;    // of covered nodes, by local index
  std::vector<int> number;      // of the node within its grain, by local index

  // of this rank
  int shapes{0};
  std::array<bigint, NREASONS> left{};    // grains left to the general engine
  bigint grains_batched() const;
  double memory_usage() const;

 private:
  struct Grain {
    int begin, end;    // in nodes
    int shape;
    double size;    // root mean square distance from the centroid of the reference
  };

  const FixPeridemBonds *bonds{nullptr};
  std::vector<int> nodes;    // local indices sorted by grain and ID

  void sort_nodes(const std::vector<Law> &);
  std::vector<Grain> find_grains() const;
  int unfit(const Grain &) const;
  bool flat(const Grain &) const;
  std::vector<double> profile(Grain &) const;
  void find_shapes(std::vector<Grain> &);
  bool build_group(const std::vector<Grain> &, std::size_t begin, std::size_t end, bool forced);
  void unite(const std::vector<Grain> &, std::size_t begin, PeridemBatchGroup &) const;
  void fill(const std::vector<Grain> &, std::size_t begin, PeridemBatchGroup &) const;
  void fill_nodes(PeridemBatchGroup &, const std::vector<Law> &, const double *,
                  const double *) const;
};

}    // namespace LAMMPS_NS

#endif
