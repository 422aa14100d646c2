/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The general engine of pair_style peridem/lps, for grains of any kind, and the engine of the linear
// bonds of peridem/pmb, which need its first pass alone: they are what bonds of peridem/lps are without
// dilatation, if q is 1/R of what it is there (peridem_general_kernel.h).  It has a list of its own
// with each bond once: half the memory traffic and half the roots of the rows of fix peridem/bonds,
// in which both ends have the bond.  Those rows stay what holds: they decide what breaks, and whoever
// else reads them need not know of this list.

#ifndef LMP_PERIDEM_GENERAL_H
#define LMP_PERIDEM_GENERAL_H

#include "peridem_simd.h"
#include "pointers.h"

#include <functional>
#include <limits>
#include <vector>

namespace LAMMPS_NS {

class FixPeridemBonds;

class PeridemGeneral : protected Pointers {
 public:
  struct Law {    // of one atom type
    // critical stretch of bonds within the type, and the smallest of those to any type
    double s0{std::numeric_limits<double>::infinity()}, least{s0};
    bool both{false}, any_both{false};    // do they break in compression too?
    bool viscous{false};
    double horizon{0.0};
  };
  // looks at every bond of an owned node, and breaks what must break
  using CarefulRow = std::function<void(int)>;

  PeridemGeneral(class LAMMPS *, CarefulRow);

  enum Strength { WEIGHT, WEIGHT_OVER_LENGTH };    // q = w v V_i V_j, or that over R
  void init(FixPeridemBonds *, const std::vector<Law> &, Strength);
  // the list, for the present local indices, of the owned nodes that are to be computed here
  void build(const std::function<bool(int)> &here);

  // break what is stretched too far, find the dilatations and what of the forces does not need
  // them; stiffness, dashpot: of owned and ghost nodes
  void first_pass(const double *stiffness, const double *dashpot);
  // of each node that is computed here: sum of w v V_i V_j R e over its bonds
  void each_sum(const std::function<void(int, double)> &) const;
  // pressure: of owned and ghost nodes
  void second_pass(const double *pressure);
  // all that was found, to three numbers of each owned node
  void add_forces(double *f) const;

  // the first pass of the linear response to displacements u, three of each owned and ghost node
  void first_response(const std::vector<double> &u, const double *stiffness);

  double memory_usage() const;

 private:
  CarefulRow careful_row;
  FixPeridemBonds *bonds{nullptr};
  std::vector<Law> laws;
  Strength kind{WEIGHT};
  bool breaks{false}, both{false}, viscous{false};
  double horizon{0.0};           // the longest
  std::size_t broken_seen{0};    // entries of bonds->broken that the list knows
  bigint layout{-1};             // of the bonds, that the list was made for
  std::size_t held{0};           // bonds that its nodes had since, seen from each of them
  bool gaps{false};              // did one of them break?

  // nodes of the list: those that are computed here, then others at the end of their bonds.  The
  // first WIDTH are none (see the kernel)
  int rows{0};
  std::vector<int> members;    // local index of a node
  std::vector<int> slot;       // the node of a local index, -1 if there is none

  // each bond once: in the row of the lower node if both are computed here
  std::vector<std::size_t> first;
  std::vector<int> partner;
  std::vector<double> length, strength;

  // per node; v: and displacements; known: no stretch up to this one is news (see look)
  std::vector<PeridemSimd::Node> x, v, sums;
  std::vector<double> known;
  std::vector<int> news;         // nodes that are stretched more than ever, in the present pass
  std::vector<char> has_news;    // per node: is it one of them?

  bool still_holds(const std::function<bool(int)> &here) const;
  void close_gaps();
  std::vector<int> in_order(const std::function<bool(int)> &here) const;
  void enter(int i);
  void enter_rows(const std::function<bool(int)> &here);
  void reserve_list();
  void fill_rows();
  void fill_strengths();
  double strength_of(int i, int j, double R) const;
  void set_known(int n);
  void gather(const double *stiffness, const double *dashpot);
  template <bool VISCOUS> void extend();
  void look(int n, std::size_t k);
  void tell(int n, double stretch);
  void judge(const double *stiffness, const double *dashpot);
  PeridemSimd::Node first_sums(int i, const double *stiffness, const double *dashpot) const;
  void drop_broken();
  bool drop_bond(int n, int m);
};

}    // namespace LAMMPS_NS

#endif
