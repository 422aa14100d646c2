/* ----------------------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

/* ----------------------------------------------------------------------
   Contributing author: the PERIDEM developers
------------------------------------------------------------------------- */

#include "peridem_contact_parser.h"

#include "error.h"
#include "utils.h"

#include <cctype>

using namespace LAMMPS_NS;

/* ---------------------------------------------------------------------- */

PeridemContactParser::PeridemContactParser(LAMMPS *lmp, const std::string &_style, int _iarg0) :
    Pointers(lmp), style(_style), Style(_style), iarg0(_iarg0)
{
  Style[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(Style[0])));
}

/* ---------------------------------------------------------------------- */

const char *PeridemContactParser::keywords()
{
  return "radius, modulus, form, horizon, stiffness, onset, restitution, damping, friction, "
         "tangential";
}

/* ---------------------------------------------------------------------- */

int PeridemContactParser::parse(int iarg, int _narg, char **_arg, PeridemContactGiven &given)
{
  narg = _narg;
  arg = _arg;
  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "radius")
      parse_radius(iarg, given);
    else if (key == "tangential")
      parse_tangential(iarg, given);
    else if (key == "fragments")
      parse_fragments(iarg, given);
    else if (!parse_stiffness(key, iarg, given) && !parse_loss(key, iarg, given))
      break;
  }
  return iarg;
}

/* ---------------------------------------------------------------------- */

bool PeridemContactParser::parse_stiffness(const std::string &key, int &iarg,
                                           PeridemContactGiven &given)
{
  if (key == "modulus") {
    fresh(iarg, std::isnan(given.modulus));
    exclusive(iarg, std::isnan(given.stiffness), "stiffness");
    given.modulus = value(iarg, POSITIVE);
  } else if (key == "form") {
    fresh(iarg, given.form == PeridemContactGiven::UNSET);
    exclusive(iarg, std::isnan(given.stiffness), "stiffness");
    parse_form(iarg, given);
  } else if (key == "horizon") {
    fresh(iarg, std::isnan(given.horizon));
    given.horizon = value(iarg, POSITIVE);
  } else if (key == "stiffness") {
    fresh(iarg, std::isnan(given.stiffness));
    exclusive(iarg, std::isnan(given.modulus), "modulus");
    exclusive(iarg, given.form == PeridemContactGiven::UNSET, "form");
    given.stiffness = value(iarg, POSITIVE);
  } else if (key == "onset") {
    fresh(iarg, std::isnan(given.onset));
    given.onset = value(iarg, FROM_0_BELOW_1);
  } else
    return false;
  return true;
}

/* ---------------------------------------------------------------------- */

bool PeridemContactParser::parse_loss(const std::string &key, int &iarg, PeridemContactGiven &given)
{
  if (key == "restitution") {
    fresh(iarg, std::isnan(given.restitution));
    exclusive(iarg, std::isnan(given.damping), "damping");
    given.restitution = value(iarg, POSITIVE_UP_TO_1);
  } else if (key == "damping") {
    fresh(iarg, std::isnan(given.damping));
    exclusive(iarg, std::isnan(given.restitution), "restitution");
    given.damping = value(iarg, NON_NEGATIVE);
  } else if (key == "friction") {
    fresh(iarg, std::isnan(given.friction));
    given.friction = value(iarg, NON_NEGATIVE);
  } else
    return false;
  return true;
}

/* ---------------------------------------------------------------------- */

void PeridemContactParser::parse_radius(int &iarg, PeridemContactGiven &given)
{
  fresh(iarg, std::isnan(given.radius) && std::isnan(given.auto_factor));
  if (word_at(iarg + 1) != "auto") {
    given.radius = value(iarg, POSITIVE);
    return;
  }
  given.auto_factor = PeridemContactGiven::AUTO_FACTOR;
  iarg += 2;
  if (number_at(iarg)) given.auto_factor = number(iarg++, POSITIVE, "radius auto");
}

/* ---------------------------------------------------------------------- */

void PeridemContactParser::parse_form(int &iarg, PeridemContactGiven &given)
{
  const std::string form = word_at(iarg + 1);
  if (form == "jha2021")
    given.form = PeridemContactGiven::JHA2021;
  else if (form == "bulk")
    given.form = PeridemContactGiven::BULK;
  else
    error->all(FLERR, iarg0 + iarg, "{} form {}: must be bulk [alpha] or jha2021", Style, form);
  iarg += 2;
  if (form == "bulk" && number_at(iarg)) given.alpha = number(iarg++, POSITIVE, "form bulk");
}

/* ---------------------------------------------------------------------- */

void PeridemContactParser::parse_tangential(int &iarg, PeridemContactGiven &given)
{
  fresh(iarg, given.tangential == PeridemContactGiven::UNSET);
  const std::string kind = word_at(iarg + 1);
  if (kind != "history" && kind != "regularised")
    error->all(FLERR, iarg0 + iarg,
               "{} tangential {}: must be history [k_t/k_n] or regularised [gamma]", Style, kind);
  const bool history = kind == "history";
  given.tangential = history ? PeridemContactGiven::HISTORY : PeridemContactGiven::REGULARISED;
  iarg += 2;
  if (number_at(iarg))
    (history ? given.ratio : given.gamma) = number(iarg++, POSITIVE, "tangential " + kind);
}

/* ---------------------------------------------------------------------- */

void PeridemContactParser::parse_fragments(int &iarg, PeridemContactGiven &given)
{
  fresh(iarg, given.fragments == PeridemContactGiven::UNSET);
  if (iarg + 1 >= narg) error->all(FLERR, iarg0 + iarg, "{} fragments needs yes or no", Style);
  given.fragments = utils::logical(FLERR, arg[iarg + 1], false, lmp);
  iarg += 2;
}

/* ---------------------------------------------------------------------- */

void PeridemContactParser::fresh(int iarg, bool unset)
{
  if (!unset) error->all(FLERR, iarg0 + iarg, "Repeated {} keyword {}", style, arg[iarg]);
}

/* ---------------------------------------------------------------------- */

void PeridemContactParser::exclusive(int iarg, bool unset, const char *other)
{
  if (!unset)
    error->all(FLERR, iarg0 + iarg, "{} takes either {} or {}, not both", Style, arg[iarg], other);
}

/* ---------------------------------------------------------------------- */

bool PeridemContactParser::number_at(int iarg) const
{
  return iarg < narg && utils::is_double(arg[iarg]);
}

/* ---------------------------------------------------------------------- */

std::string PeridemContactParser::word_at(int iarg) const
{
  return iarg < narg ? arg[iarg] : "";
}

/* ---------------------------------------------------------------------- */

double PeridemContactParser::number(int iarg, Range range, const std::string &keyword)
{
  if (iarg >= narg) error->all(FLERR, iarg0 + iarg - 1, "{} {} needs a value", Style, keyword);
  const double value = utils::numeric(FLERR, arg[iarg], false, lmp);
  struct Allowed {
    bool good;
    const char *words;
  };
  const Allowed ranges[] = {{value > 0.0, "> 0"},
                            {value >= 0.0, ">= 0"},
                            {value > 0.0 && value <= 1.0, "> 0 and <= 1"},
                            {value >= 0.0 && value < 1.0, ">= 0 and < 1"}};
  const auto &allowed = ranges[range];
  if (!allowed.good || !std::isfinite(value))
    error->all(FLERR, iarg0 + iarg, "{} {} {}: must be {}", Style, keyword, arg[iarg],
               allowed.words);
  return value;
}

/* ----------------------------------------------------------------------
   of the keyword at iarg; goes on to the next
------------------------------------------------------------------------- */

double PeridemContactParser::value(int &iarg, Range range)
{
  const double found = number(iarg + 1, range, arg[iarg]);
  iarg += 2;
  return found;
}
