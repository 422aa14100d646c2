/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// What a style writes to restart files begins with a stamp: files that hold something else there, as
// another version of the package wrote it, are refused and not misread.

#ifndef LMP_PERIDEM_STAMP_H
#define LMP_PERIDEM_STAMP_H

#include <cstddef>
#include <cstdio>
#include <string>

namespace LAMMPS_NS {

class PeridemStamp {
 public:
  // layout: another number for each change of what follows; size: of a struct whose bytes follow
  constexpr explicit PeridemStamp(int layout, std::size_t size = 0) :
      number(LAYOUT * layout + static_cast<double>(size))
  {
  }

  // as the first of numbers
  const double number;
  // an error if the file has another one; style as at the beginning of a message
  void check(double found, const std::string &style, class Error *) const;

  // in files of pair styles: by the first rank, for all
  void write(FILE *) const;
  void read(FILE *, const std::string &style, class LAMMPS *) const;

 private:
  static constexpr double LAYOUT = 1.0e6;    // larger than any struct
};

}    // namespace LAMMPS_NS

#endif
