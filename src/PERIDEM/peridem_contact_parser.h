/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Reads contact keywords, for pair_coeff and walls alike.

#ifndef LMP_PERIDEM_CONTACT_PARSER_H
#define LMP_PERIDEM_CONTACT_PARSER_H

#include "peridem_contact_law.h"
#include "pointers.h"

#include <string>

namespace LAMMPS_NS {

class PeridemContactParser : protected Pointers {
 public:
  // style = as in the middle of a message: "pair style peridem/contact"; iarg0 = words of the command
  // before those given to parse()
  PeridemContactParser(class LAMMPS *, const std::string &style, int iarg0);

  // reads keywords from arg[iarg] until one it does not know; returns where it stopped
  int parse(int iarg, int narg, char **arg, PeridemContactGiven &);

  static const char *keywords();

 private:
  std::string style, Style;    // Style begins a message
  int iarg0;
  int narg{0};
  char **arg{nullptr};
  enum Range {
    POSITIVE,
    NON_NEGATIVE,
    POSITIVE_UP_TO_1,
    FROM_0_BELOW_1
  };    // as number() lists them

  bool parse_stiffness(const std::string &key, int &iarg, PeridemContactGiven &);
  bool parse_loss(const std::string &key, int &iarg, PeridemContactGiven &);
  void parse_radius(int &iarg, PeridemContactGiven &);
  void parse_form(int &iarg, PeridemContactGiven &);
  void parse_tangential(int &iarg, PeridemContactGiven &);
  void parse_fragments(int &iarg, PeridemContactGiven &);
  void fresh(int iarg, bool unset);
  void exclusive(int iarg, bool unset, const char *other);
  bool number_at(int iarg) const;
  std::string word_at(int iarg) const;
  double number(int iarg, Range, const std::string &keyword);
  double value(int &iarg, Range);
};

}    // namespace LAMMPS_NS

#endif
