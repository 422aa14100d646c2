/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// The spring, dashpot and slider between two nodes, or a node and a wall.

#ifndef LMP_PERIDEM_CONTACT_LAW_H
#define LMP_PERIDEM_CONTACT_LAW_H

#include "pointers.h"

#include <cmath>
#include <string>

namespace LAMMPS_NS {

// What pair_coeff or a wall said: NAN or UNSET where it said nothing.

struct PeridemContactGiven {
  enum { UNSET = -1, BULK, JHA2021 };    // forms of the stiffness
  enum { HISTORY, REGULARISED };         // forms of the tangential force

  static constexpr double AUTO_FACTOR = 0.95;

  double radius{NAN};         // contact distance R_c
  double auto_factor{NAN};    // R_c as a fraction of the smallest node spacing
  double modulus{NAN};        // bulk modulus that the stiffness follows from
  int form{UNSET};
  double alpha{NAN};        // of form bulk
  double horizon{NAN};      // of form jha2021
  double stiffness{NAN};    // k_N itself
  double onset{NAN};        // of the contact distance: see PeridemContactLaw::elastic
  double restitution{NAN};
  double damping{NAN};    // beta_N itself
  double friction{NAN};
  int tangential{UNSET};
  double gamma{NAN};    // of the regularised tangential force, if given
  double ratio{NAN};    // of tangential to normal spring, if given
  int fragments{UNSET};

  // what is said here, and where nothing is said, what the other says
  PeridemContactGiven over(const PeridemContactGiven &other) const;
};

// What is known of the two types when pair_coeff leaves it out.

struct PeridemContactKnown {
  double bulk;       // harmonic mean of the solids' bulk moduli, 0 = unknown
  double horizon;    // mean of the solids' horizons, 0 = unknown
  double spacing;    // smallest node spacing of the two types, 0 = unknown
};

// The law between two types, ready for use.

class PeridemContactLaw {
 public:
  double radius{0.0};
  double friction{0.0};
  bool fragments{true};

  bool uses_velocity() const { return damping > 0.0 || friction > 0.0; }
  bool uses_restitution() const { return impact > 0.0; }
  bool uses_history() const { return friction > 0.0 && !regularised; }

  // spring constant of two nodes with volumes Vi, Vj
  double spring(double Vi, double Vj) const
  {
    if (per_volume) return modulus * Vi * Vj;
    return dim == 2 ? modulus : modulus * 0.5 * (std::cbrt(Vi) + std::cbrt(Vj));
  }

  // tangential over normal spring
  double tangential_ratio() const { return uses_history() ? ratio : 0.0; }

  double dashpot() const { return damping; }

  // contacts begin without stiffness
  bool begins_softly() const { return depth > 0.0; }

  // repulsion of a spring k at an overlap >= 0. Over the depth of the onset its stiffness grows from
  // nothing to k, so that time steps meet no kink where a contact opens or closes
  double elastic(double k, double overlap) const
  {
    if (overlap >= depth) return k * (overlap - 0.5 * depth);
    return 0.5 * k * overlap * overlap / depth;
  }

  // what it has stored
  double energy(double k, double overlap) const
  {
    if (overlap < depth) return k * overlap * overlap * overlap / (6.0 * depth);
    const double beyond = overlap - 0.5 * depth;
    return 0.5 * k * (beyond * beyond + depth * depth / 12.0);
  }

  // repulsion with the elastic force of an overlap that grows at the rate -rate: damping never pulls
  double normal(double elastic_force, double rate) const
  {
    const double force = elastic_force - damping * rate;
    return force > 0.0 ? force : 0.0;
  }

  // what the loss of a collision adds to the elastic force of one contact: bodies approach each other
  // at this speed, at most at the speed peak so far; stored is twice the energy of all springs between
  // the bodies, mobility their speed over impulse at the contact
  double impact_force(double elastic, double stored, double approach, double peak, double mobility,
                      double dt) const;

  // A collision is over when nodes that touched part by more than this gap: before that, contacts
  // open and close with the vibration of the bodies.  deepest = largest overlap of this contact;
  // lists do not hold gaps wider than the skin.
  double lingering_gap(double deepest, double skin) const
  {
    if (!uses_restitution()) return 0.0;
    const double widest = LINGER_WIDEST * radius < skin ? LINGER_WIDEST * radius : skin;
    return LINGER * deepest < widest ? LINGER * deepest : widest;
  }

  // A touching pair as friction sees it.
  struct Touch {
    double spring, dashpot;    // of the normal direction
    double normal_force;
    double node_mass;    // effective mass of the two nodes
    double dt;
    bool advance;               // false: forces are evaluated again at the same time
    const double *direction;    // unit vector from one to the other
  };

  // friction force that the other exerts, which moves at the tangential velocity slide; slip is the
  // stretch of the tangential spring, kept by the caller (null where there is no history)
  void tangential(const Touch &, const double *slide, double *slip, double *force) const;

  // energy of the tangential spring beside a normal spring k
  double spring_energy(double k, const double *slip) const
  {
    if (!uses_history()) return 0.0;
    return 0.5 * ratio * k * (slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2]);
  }

  static PeridemContactLaw resolve(const PeridemContactGiven &, const PeridemContactKnown &,
                                   const std::string &where, class LAMMPS *);
  // between two types, each of which has a law with itself and said what is given
  static PeridemContactLaw mix(const PeridemContactLaw &, const PeridemContactLaw &,
                               const std::string &where, class LAMMPS *);
  std::string describe() const;

 private:
  void check_units(const std::string &where, class LAMMPS *) const;
  static constexpr double LINGER = 10.0;
  static constexpr double LINGER_WIDEST = 0.8;    // of the contact distance
  int dim{3};
  bool per_volume{false};    // k = modulus Vi Vj, else k = modulus h^(d-2)
  double modulus{0.0};
  double depth{0.0};    // of the onset
  double restitution{1.0};
  double impact{0.0};     // number that gives this restitution
  double damping{0.0};    // beta_N when given by hand
  bool regularised{false};
  double gamma{-1.0};    // of the regularised force; < 0: as large as the time step allows
  double ratio{0.0};     // of tangential to normal spring

  static double impact_number(double restitution);
  void take_losses(const PeridemContactGiven &);
  void mix_loss(const PeridemContactLaw &, const PeridemContactLaw &, const std::string &where,
                class LAMMPS *);
  void mix_friction(const PeridemContactLaw &, const PeridemContactLaw &, const std::string &where,
                    class LAMMPS *);
  void tangential_spring(const Touch &, const double *slide, double *slip, double *force) const;
  void tangential_viscous(const Touch &, const double *slide, double *force) const;
};

}    // namespace LAMMPS_NS

#endif
