/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The pieces of broken grains: nodes that intact bonds hold together, directly or through others.

#ifndef LMP_PERIDEM_PIECES_H
#define LMP_PERIDEM_PIECES_H

#include "pointers.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

class PeridemPieces : protected Pointers {
 public:
  explicit PeridemPieces(class LAMMPS *lmp) : Pointers(lmp) {}

  // local indices are new
  void start(const FixPeridemBonds *);

  // each of these nodes of one grain gets its piece's lowest atom-ID on this rank as its label; least:
  // there are not fewer pieces than that. Returns how many there are.
  int label(const int *begin, const int *end, int least);
  tagint label_of(int i) const { return labels[i]; }

  // bonds to nodes of other ranks
  struct Link {
    tagint piece, node, partner;
  };
  void add_links(const int *begin, const int *end, std::vector<Link> &) const;
  // pieces that go on on other ranks get the lowest atom-ID of all; links of grains that this rank
  // has a part of, its own and those of the others
  void join(const std::vector<Link> &);
  void relabel(const int *begin, const int *end);

  // do the two ends of a broken bond still hold together, through one node?  What other ranks know
  // may be missing: if not, label() decides
  bool still_tied(int i, int j) const;

  double memory_usage() const
  {
    return static_cast<double>(labels.capacity()) * sizeof(tagint) +
        static_cast<double>(above.capacity()) * sizeof(int) +
        static_cast<double>(joints.capacity()) * sizeof(Joint);
  }

 private:
  const FixPeridemBonds *bonds{nullptr};
  std::vector<tagint> labels;    // of owned nodes
  std::vector<int> above;        // a node of the same piece, nearer to its root
  struct Joint {
    tagint piece, into;
  };
  std::vector<Joint> joints;    // by piece, ascending

  template <class Visit> void for_partners(int i, Visit) const;    // by intact bonds
  int owned(int j) const;
  int root(int i);
  tagint root_of(tagint piece);
  Joint *joint_of(tagint piece);
};

}    // namespace LAMMPS_NS

#endif
