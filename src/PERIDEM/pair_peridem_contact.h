/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

#ifdef PAIR_CLASS
// clang-format off
PairStyle(peridem/contact,PairPeridemContact);
// clang-format on
#else

#ifndef LMP_PAIR_PERIDEM_CONTACT_H
#define LMP_PAIR_PERIDEM_CONTACT_H

#include "atom.h"
#include "pair.h"
#include "peridem_bodies.h"
#include "peridem_books.h"
#include "peridem_collisions.h"
#include "peridem_contact_law.h"
#include "peridem_contact_stiffness.h"
#include "peridem_grains.h"
#include "peridem_level.h"
#include "update.h"

#include <vector>

namespace LAMMPS_NS {

class FixPeridemAdapt;
class FixPeridemBonds;
class FixPeridemHistory;

// Contact between nodes of different grains, and between nodes of one grain that share no intact
// bond.  Pairs that can touch are picked once per reneighbouring.

class PairPeridemContact : public Pair {
 public:
  PairPeridemContact(class LAMMPS *);
  ~PairPeridemContact() override;
  void compute(int, int) override;
  void settings(int, char **) override;
  void coeff(int, char **) override;
  void init_style() override;
  double init_one(int, int) override;
  void write_restart(FILE *) override;
  void read_restart(FILE *) override;
  void write_restart_settings(FILE *) override {}
  void read_restart_settings(FILE *) override { overlaps_checked = true; }
  double memory_usage() override;
  int pack_forward_comm(int, int *, double *, int, int *) override;
  void unpack_forward_comm(int, int, double *) override;

  // the bodies that collide, of this force evaluation; null without restitution
  PeridemBodies *moving_bodies() { return moved == update->ntimestep ? &bodies : nullptr; }

  // what pair_coeff said of a type with itself, and what is known of it: walls start from there
  bool covers(int itype) const { return !given.empty() && setflag[itype][itype]; }
  const PeridemContactGiven &own(int itype) const { return given[index(itype, itype)]; }

  // Bounds on frequencies; collective.  They are over the contacts that are and the stiffest that can
  // ever be; or, if all begin softly, over those that there may be within some time, and one of
  // the lightest nodes. What holds nodes is gathered first: walls add theirs to contacts of a time.
  bool begins_softly() const;
  PeridemContactStiffness &gather_stiffness();
  PeridemContactStiffness &gather_stiffness(double time);
  double single_frequency_sq() const { return frequency_sq_with(1.0); }
  double largest_frequency_sq();
  double largest_dashpot_ratio() const;

  // for the energy ledger: forces that take energy away; energy of overlaps and of tangential
  // springs, on this rank (half of what it shares with another)
  PeridemBooks books;
  double elastic_energy() const;
  double spring_energy() const;

  // tangential springs, for the fix that carries them along with the nodes
  bool springs_live() const { return live; }
  void rest_springs() { live = false; }
  void store_springs(FixPeridemHistory &) const;

  static PeridemContactKnown known(class LAMMPS *, int itype, int jtype,
                                   const std::vector<double> &spacings);

 private:
  int ntypes{0};
  std::vector<PeridemContactGiven> given;
  std::vector<PeridemContactLaw> laws;
  std::vector<double> widest_rcsq;    // by type: square of the largest contact distance
  std::vector<char> mixed;            // by type pair: no line of its own
  std::vector<int> bonded_types;      // by type: 1 if a solid holds it together
  FixPeridemBonds *bonds{nullptr};
  bool any_velocity{false}, any_restitution{false}, any_springs{false};
  bool overlaps_checked{false}, holes_checked{false};

  // Pairs that can touch before the next reneighbouring: candidates of row r are nodes of other
  // grains than that of node row_node[r]; fragments are pairs of one grain, each with its own
  // contact distance.  A pair that crosses to a ghost is known to both ranks, and each adds the
  // force on its own node.
  struct FragmentPair {
    int i, j;
    double distance;
    int memory;    // as of candidates
  };
  std::vector<int> row_node, row_first, candidates;
  std::vector<int>
      memories;    // of candidates: what they remember, a place in springs; -1 = nothing
  std::vector<FragmentPair> fragments;
  std::size_t broken_seen{0};
  int list_nlocal{-1};    // owned nodes when the candidates were picked

  // what a contact remembers from its first touch until the collision is over: slip of the other
  // node, how fast it came, how deep the two overlapped.  Few candidates touch.
  struct Spring {
    int i, j;    // -1: free
    double slip[3]{0.0, 0.0, 0.0};
    double peak{0.0};
    double deepest{0.0};
    int collision{UNKNOWN};                // its place in collisions
    enum { UNKNOWN = -2, WITHIN = -1 };    // WITHIN one body
  };
  std::vector<Spring> springs;
  std::vector<int> free_springs;
  FixPeridemHistory *history{nullptr};
  bool live{false};    // the springs here are newer than those of the fix
  bool advance{true};
  PeridemLevel level;
  double dt{0.0};    // of its level

  PeridemGrains::Extremes extremes;
  FixPeridemAdapt *adapt{nullptr};
  double lightest(int itype) const;

  // contacts of this step that lose energy by restitution
  struct Impact {
    int i, j;
    double elastic, stored;    // force, and twice the energy
    int spring;
    double n[3];    // from i to j
  };
  std::vector<Impact> impacts;
  PeridemBodies bodies;
  PeridemCollisions collisions;
  std::vector<PeridemBody> body_of;    // of owned and ghost nodes that touch
  std::vector<char> has_body;          // of owned nodes
  PeridemSpread spread;                // forces on bodies
  bigint moved{-1};                    // the step at which bodies was used last
  bigint bodies_known{-1};             // the version of bodies that springs know collisions of

  // for the bound on frequencies
  PeridemContactStiffness stiffness;
  bool timed{false};                     // it is of a time
  std::vector<double> held_by;           // stiffness at owned and ghost nodes over their masses
  std::vector<double> ghost_velocity;    // three numbers for each ghost
  double frequency_sq_with(double springs) const;
  double frequency_sq_now();
  void add_stiffness(int i, int j);
  const double *velocity(int i) const;

  enum Message { BODIES, HELD_BY, VELOCITIES };
  Message sending{BODIES};    // what ghosts hear of
  void send(Message);

  std::size_t index(int itype, int jtype) const { return itype * (ntypes + 1) + jtype; }
  bool indices_valid() const { return list_nlocal == atom->nlocal; }
  void allocate();
  void check_styles();
  void mix_pairs();
  PeridemContactLaw find_law(int itype, int jtype, const std::vector<double> &spacings) const;
  void find_laws();
  void check_holes(const std::vector<double> &widest) const;
  void shrink_skin() const;
  void find_history();
  void pick_candidates();
  void add_fragment(int i, int j);
  void add_broken_bonds();
  void check_overlaps();
  template <bool HISTORY> void touch_all();
  void touch(int i, int j, double distance, double rsq, const double *d, int memory);
  int remember(int i, int j);
  void part(const PeridemContactLaw &, double gap, int &memory);
  double lose(int i, int j, const PeridemContactLaw &, double k, double elastic, const double *n,
              int memory, double *total);
  void find_touching();
  bigint body_id(int i) const;
  void find_collisions();
  void find_collision(Spring &);
  void add_impact(const Impact &);
  void book(int i, int j, std::vector<double> &forces, const double *force);
  template <class Visit> void for_near(Visit) const;
  template <class Visit> void for_touching(Visit) const;
  void impact_pass();
  int find_spring(int i, int j);
  void find_springs();
};

}    // namespace LAMMPS_NS

#endif
#endif
