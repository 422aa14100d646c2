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
FixStyle(PERIDEM_HISTORY,FixPeridemHistory);
// clang-format on
#else

#ifndef LMP_FIX_PERIDEM_HISTORY_H
#define LMP_FIX_PERIDEM_HISTORY_H

#include "fix.h"

#include <vector>

namespace LAMMPS_NS {

class PairPeridemContact;

// What the contacts of each owned node remember (tangential spring, fastest approach, deepest overlap)
// while nodes migrate and in restart files. In between, pair style peridem/contact keeps them beside
// its list of candidates.
// Made by that pair style; not for input scripts.

class FixPeridemHistory : public Fix {
 public:
  struct Spring {
    tagint tag;        // of the other node
    double slip[3];    // how far the other has slipped, seen from this node
    double peak;       // fastest approach of the two
    double deepest;    // largest overlap
  };
  std::vector<std::vector<Spring>> rows;    // by local index

  FixPeridemHistory(class LAMMPS *, int, char **);
  ~FixPeridemHistory() override;
  int setmask() override;
  void pre_exchange() override;
  void post_run() override;
  void write_restart(FILE *) override;
  void restart(char *) override;
  double memory_usage() override;
  void grow_arrays(int) override;
  void copy_arrays(int, int, int) override;
  void set_arrays(int) override;
  int pack_exchange(int, double *) override;
  int unpack_exchange(int, double *) override;
  int pack_restart(int, double *) override;
  void unpack_restart(int, int) override;
  int size_restart(int) override;
  int maxsize_restart() override;

  void set_source(PairPeridemContact *pair) { source = pair; }

 private:
  PairPeridemContact *source{nullptr};
  void collect();
};

}    // namespace LAMMPS_NS

#endif
#endif
