/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Grains of which several ranks own parts: the rank that owns most of a grain computes it whole.  The
// others lend it their nodes: families once per reneighbouring, positions at each step, and get
// forces back.  No ghosts are needed for this, whatever the size of the grain.

#ifndef LMP_PERIDEM_BATCH_SHARE_H
#define LMP_PERIDEM_BATCH_SHARE_H

#include "pointers.h"

#include <functional>
#include <unordered_map>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

class PeridemBatchShare : protected Pointers {
 public:
  struct Node {    // as it travels; all numbers are exact in a double
    double tag, mol, type;
    double X[3], x[3], vz;
    double volume, wvolume, stiffness, dashpot;
    double mixed, rigid, unbroken;
    double bonds;    // so many follow
  };
  struct Bond {
    double tag, length, weight;
  };
  // what a node gets back: force, sum of w v V_i V_j R e, largest stretch of its bonds
  static constexpr int RESULTS = 5;

  explicit PeridemBatchShare(class LAMMPS *lmp) : Pointers(lmp) {}

  // who computes which grain? nodes: local indices sorted by grain; collective
  void assemble(const FixPeridemBonds *, const std::vector<int> &nodes, const double *stiffness,
                const double *dashpot);
  // taken[k]: is borrowed node k in a batch after all? collective
  void settle(const std::vector<char> &taken);

  bool any() const { return any_shared; }                        // on any rank
  bool lends(tagint mol) const { return hosts.count(mol); }      // is the grain computed elsewhere?
  const std::vector<int> &lent() const { return lent_nodes; }    // after settle(): local indices

  // borrowed nodes and their rows
  std::vector<Node> nodes;
  std::vector<std::size_t> first;    // row k: rows[first[k]] to rows[first[k + 1]]
  std::vector<Bond> rows;
  int slot(tagint tag) const;    // -1 if not borrowed

  // every step, in this order
  void send_places(double **x, double **v);    // v: null if nothing depends on velocities
  void receive_places();
  const double *place(int k) const { return &places[width * k]; }
  const double *velocity(int k) const { return &places[width * k + 3]; }
  double *result(int k) { return &results[RESULTS * static_cast<std::size_t>(k)]; }
  void send_results();
  void receive_results(const std::function<void(int, const double *)> &);

  double memory_usage() const;

 private:
  struct Peer {
    int rank;
    std::vector<int> nodes;         // local indices lent to it, or slots borrowed from it
    std::vector<double> buffer;     // places on their way
    std::vector<double> answers;    // results on their way
  };

  bool any_shared{false};
  int width{3};                             // numbers per place: 6 with velocities
  std::unordered_map<tagint, int> hosts;    // of grains that are computed elsewhere
  std::unordered_map<tagint, int> slots;    // by tag
  std::vector<Peer> lenders, borrowers;     // other ranks: nodes from them, nodes for them
  std::vector<int> lent_nodes;
  std::vector<double> places, results;
  std::vector<MPI_Request> requests;

  using Lists = std::vector<std::vector<double>>;    // by rank
  Lists exchange(const Lists &) const;
  Lists choose_hosts(const Lists &) const;
  void pack_node(const FixPeridemBonds *, int i, const double *stiffness, const double *dashpot,
                 std::vector<double> &) const;
  void unpack_nodes(int rank, const std::vector<double> &);
};

}    // namespace LAMMPS_NS

#endif
