/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Local indices by ID, as Atom::map() finds them, for loops over all bonds: without the virtual call
// for each, and where LAMMPS has a hash table, with one of our own, in which IDs that follow each other
// are found side by side.  Good until LAMMPS makes its map anew.

#ifndef LMP_PERIDEM_LOOKUP_H
#define LMP_PERIDEM_LOOKUP_H

#include "atom.h"

#include <cstdint>
#include <vector>

namespace LAMMPS_NS {

class PeridemLookup {
 public:
  explicit PeridemLookup(Atom *atom) :
      table(atom->map_style == Atom::MAP_ARRAY ? atom->get_map_array() : nullptr)
  {
    if (!table) fill(atom);
  }

  // an owned node if there is one, else a ghost; -1 if there is neither
  int operator()(tagint id) const { return table ? table[id] : entries[place(id)].i; }

 private:
  struct Entry {
    tagint id{0};
    int i{-1};
  };
  static constexpr int SIDE_BY_SIDE = 8;

  const int *table;
  std::vector<Entry> entries;    // at least twice as many as nodes, a power of 2
  int shift{0};

  void fill(Atom *);

  // of the entry that has this ID, or would have it
  std::size_t place(tagint id) const
  {
    const auto key = static_cast<std::uint64_t>(id);
    const auto mixed = key / SIDE_BY_SIDE * UINT64_C(0x9E3779B97F4A7C15);
    std::size_t at = (mixed >> shift) * SIDE_BY_SIDE + key % SIDE_BY_SIDE;
    while (entries[at].i >= 0 && entries[at].id != id) at = (at + 1) & (entries.size() - 1);
    return at;
  }
};

}    // namespace LAMMPS_NS

#endif
