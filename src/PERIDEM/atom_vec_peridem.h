/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef ATOM_CLASS
// clang-format off
AtomStyle(peridem,AtomVecPeridem);
// clang-format on
#else

#ifndef LMP_ATOM_VEC_PERIDEM_H
#define LMP_ATOM_VEC_PERIDEM_H

#include "atom_vec.h"

#include <memory>

namespace LAMMPS_NS {

class PeridemCopies;

// A node: volume (Atom::vfrac), density, mass = density * volume (Atom::rmass), the grain it
// belongs to (Atom::molecule; 0 = none) and its reference position (Atom::x0).

class AtomVecPeridem : public AtomVec {
 public:
  AtomVecPeridem(class LAMMPS *);
  ~AtomVecPeridem() override;
  void process_args(int, char **) override;
  void init() override;

  // bring density, volume and mass together after "set"; collective. Pair styles need masses before
  // Atom::init() comes to it
  void sync_mass();

  void copy(int, int, int) override;
  void grow_pointers() override;
  void create_atom_post(int) override;
  void data_atom_post(int) override;
  void unpack_restart_init(int) override;
  void pack_data(double **) override;
  int property_atom(const std::string &) override;
  void pack_property_atom(int, double *, int, int) override;

 protected:
  double *rmass{nullptr}, *vfrac{nullptr}, **x0{nullptr};
  double *density{nullptr};      // density of each node
  double *mass_seen{nullptr};    // mass that density and volume gave; differs after "set density"
  bool with_reference{false};    // Atoms lines of data files carry reference positions

  // while "replicate" fills this instance from that of the originals
  std::unique_ptr<PeridemCopies> copies;

  void check_nodes();
};

}    // namespace LAMMPS_NS

#endif
#endif
