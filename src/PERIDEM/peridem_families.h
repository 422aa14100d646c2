/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Finds the families of nodes in the reference configuration, wherever the nodes are by now and
// whichever rank owns them: space is cut into blocks, and one rank finds all families of a block.

#ifndef LMP_PERIDEM_FAMILIES_H
#define LMP_PERIDEM_FAMILIES_H

#include "pointers.h"

#include <functional>
#include <utility>
#include <vector>

namespace LAMMPS_NS {

class PeridemCells;
struct PeridemMaterial;

class PeridemFamilies : protected Pointers {
 public:
  struct Family {
    int node;               // local index
    double wvolume;         // weighted volume
    double volume;          // sum of v_ij V_j
    int reference;          // bonds that the family has without the cuts
    std::size_t count;      // of those that no cut crosses, by increasing tag
    const double *bonds;    // of each of them the partner's tag and the length in the reference

    tagint tag(std::size_t k) const { return static_cast<tagint>(bonds[2 * k]); }
    double length(std::size_t k) const { return bonds[2 * k + 1]; }
  };
  // the material of bonds between two types, null where there are none
  using MaterialOf = std::function<const PeridemMaterial *(int, int)>;

  // reach: no bond is longer
  PeridemFamilies(class LAMMPS *, MaterialOf, const class PeridemCuts &, double reach);

  // families of owned nodes among each other's grains; collective
  void build(const std::vector<int> &nodes);
  std::size_t bonds() const { return nbonds; }
  // each of them, and gives back the memory that it had
  void hand_over(const std::function<void(const Family &)> &);

  // longest bond at the present positions, of all ranks
  double longest() const { return longest_now; }

  // a bond exists where R <= horizon * (1 + SLACK): lattices with nodes exactly on the horizon keep
  // symmetric families whatever the last digit of their coordinates
  static constexpr double SLACK = 1.0e-9;

 private:
  struct Node;
  struct Blocks;
  struct Bond {
    tagint tag;
    double length;
  };
  using Row = std::vector<std::pair<Bond, const Node *>>;
  using Numbers = std::vector<double>;

  // families as they travel; those that stay on this rank are in pieces, which do not move as they grow
  std::vector<Numbers> found;
  std::size_t nbonds{0};
  MaterialOf material;
  const PeridemCuts &cuts;
  double reach;
  double longest_now{0.0};

  void check_ids() const;
  std::vector<Node> nodes_of_blocks(const std::vector<int> &) const;
  std::vector<std::vector<double>> send_nodes(const std::vector<int> &) const;
  void send_images(int i, std::vector<std::vector<double>> &) const;
  void send_image(Node &, bool image, std::vector<std::vector<double>> &) const;
  Blocks blocks_of(const Node &) const;
  double cell_size(const PeridemMaterial &, const Node &, const Node &) const;
  double volume_and_influence(const PeridemMaterial &, const Node &, const Node &, double R) const;
  void find_partners(const Node &, const Node *first, const PeridemCells &, Row &) const;
  void weigh(const Node &, const Row &, double &wvolume, double &volume);
  bool is_cut(const Node &, const Node &) const;
  int rank_of_block(tagint mol, const double *block) const;
  Numbers &answer_for(int rank, std::vector<Numbers> &answers);
  void families_of_block(const Node *first, const Node *last, std::vector<Numbers> &answers);
  static Family read(const double *);
};

}    // namespace LAMMPS_NS

#endif
