/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// How stiff the contacts of each node hold it: the tensor sum of k n n + kt (1 - n n) over them, with
// springs k along their directions n and kt across.  Springs in different directions hold a node
// less than their sum does.

#ifndef LMP_PERIDEM_CONTACT_STIFFNESS_H
#define LMP_PERIDEM_CONTACT_STIFFNESS_H

#include <cmath>
#include <cstddef>
#include <vector>

namespace LAMMPS_NS {

class PeridemContactStiffness {
 public:
  static constexpr int WALL = -1;

  // Nodes nearer than this may touch within the time: if they go on as they do, at this velocity of
  // one past the other, or have a little to go, which waves and collisions may do at any time.
  static double reach(double distance, const double *v, double time)
  {
    constexpr double LITTLE = 0.05;    // part of the contact distance
    return (1.0 + LITTLE) * distance + time * std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }

  // nodes: those whose stiffness is summed here, the first ones
  void start(int nodes, int dimension);
  // a contact of node i with node j or a WALL; direction: a unit vector
  void add(int i, int j, double along, double across, const double *direction);

  // those of the first ones that have contacts
  const std::vector<int> &nodes() const { return held; }
  // of node held[n]: in the direction where it is held most, the largest eigenvalue of its tensor;
  // and of its springs along contacts together, whatever their directions
  double largest(std::size_t n) const;
  double springs(std::size_t n) const { return sums[n].springs; }

  // The largest sum over a contact of what is given for its two nodes; a node of less than 0 counts
  // as the other one.
  double largest_pair(const std::vector<double> &of_nodes) const;

  // Shares each contact between its nodes in proportion to what is given for them: what holds a node
  // is from now on that over its share, which of a contact with a WALL is all of it.
  void share(const std::vector<double> &of_nodes);

  double memory_usage() const;

 private:
  struct Sum {
    double xx{0.0}, yy{0.0}, zz{0.0}, xy{0.0}, xz{0.0}, yz{0.0};
    double springs{0.0};
  };
  struct Contact {
    int i, j;
    double along, across, direction[3];
  };
  int dim{3};
  std::vector<int> held, place_of;    // of nodes: their place in held, -1 = none
  std::vector<Sum> sums;              // of nodes held
  std::vector<Contact> contacts;

  void hold(int i, double along, double across, const double *direction);
  static double largest_in_space(const Sum &);
};

}    // namespace LAMMPS_NS

#endif
