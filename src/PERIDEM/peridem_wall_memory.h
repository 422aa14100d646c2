/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What the contacts of each node with a wall remember: tangential spring, fastest approach, deepest
// overlap.  Few nodes touch, so each has a list of its own, empty for most.

#ifndef LMP_PERIDEM_WALL_MEMORY_H
#define LMP_PERIDEM_WALL_MEMORY_H

#include <vector>

namespace LAMMPS_NS {

class PeridemWallMemory {
 public:
  struct Slot {
    int key;           // of the face
    double slip[3];    // stretch of the tangential spring
    double peak;       // fastest approach so far
    double deepest;    // largest overlap so far
    bool used;         // the collision with this face goes on
  };

  void grow(int nmax) { nodes.resize(nmax); }
  void copy(int i, int j) { nodes[j] = nodes[i]; }
  void clear(int i) { nodes[i].clear(); }
  bool empty(int i) const { return nodes[i].empty(); }

  // the memory of a face that node i touches, new if need be; valid until the next call
  Slot &at(int i, int key)
  {
    for (auto &slot : nodes[i])
      if (slot.key == key) {
        slot.used = true;
        return slot;
      }
    nodes[i].push_back({key, {0.0, 0.0, 0.0}, 0.0, 0.0, true});
    return nodes[i].back();
  }

  // the memory of a face that node i has touched, or null; valid until the next call of at()
  Slot *known(int i, int key)
  {
    for (auto &slot : nodes[i])
      if (slot.key == key) return &slot;
    return nullptr;
  }

  const std::vector<Slot> &of(int i) const { return nodes[i]; }

  // what was not asked for since the last call is forgotten
  void forget_unused(int i)
  {
    auto &list = nodes[i];
    std::size_t kept = 0;
    for (auto &slot : list)
      if (slot.used) {
        slot.used = false;
        list[kept++] = slot;
      }
    list.resize(kept);
  }

  // numbers that a node with so many slots packs into
  static constexpr int size(int slots) { return 1 + 6 * slots; }
  int size_of(int i) const { return size(static_cast<int>(nodes[i].size())); }

  int pack(int i, double *buf) const
  {
    int n = 0;
    buf[n++] = static_cast<double>(nodes[i].size());
    for (const auto &slot : nodes[i]) {
      buf[n++] = slot.key;
      for (const double s : slot.slip) buf[n++] = s;
      buf[n++] = slot.peak;
      buf[n++] = slot.deepest;
    }
    return n;
  }

  int unpack(int i, const double *buf)
  {
    int n = 0;
    nodes[i].resize(static_cast<std::size_t>(buf[n++]));
    for (auto &slot : nodes[i]) {
      slot.key = static_cast<int>(buf[n++]);
      for (double &s : slot.slip) s = buf[n++];
      slot.peak = buf[n++];
      slot.deepest = buf[n++];
      slot.used = false;
    }
    return n;
  }

  double bytes() const
  {
    double sum = static_cast<double>(nodes.capacity() * sizeof(std::vector<Slot>));
    for (const auto &list : nodes) sum += static_cast<double>(list.capacity() * sizeof(Slot));
    return sum;
  }

 private:
  std::vector<std::vector<Slot>> nodes;
};

}    // namespace LAMMPS_NS

#endif
