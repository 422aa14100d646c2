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

#include "peridem_contact_law.h"

#include "domain.h"
#include "error.h"
#include "math_const.h"
#include "utils.h"

using namespace LAMMPS_NS;
using MathConst::MY_PI;

// tangential over normal spring: about 2 (1 - nu) / (2 - nu), the ratio of the elastic stiffnesses
// of two touching bodies (Mindlin 1949), at nu = 1/4
static constexpr double DEFAULT_RATIO = 0.85;

// the regularised force stops a sliding node pair in this many steps at the soonest
static constexpr double STOPPING_STEPS = 2.0;

// the loss of a collision slows bodies down in no fewer steps than this
static constexpr double IMPACT_STEPS = 10.0;

/* ---------------------------------------------------------------------- */

static double either(double mine, double other)
{
  return std::isnan(mine) ? other : mine;
}

/* ---------------------------------------------------------------------- */

PeridemContactGiven PeridemContactGiven::over(const PeridemContactGiven &other) const
{
  PeridemContactGiven merged = *this;
  // groups of keywords that exclude each other are taken as a whole
  if (std::isnan(radius) && std::isnan(auto_factor)) {
    merged.radius = other.radius;
    merged.auto_factor = other.auto_factor;
  }
  if (std::isnan(stiffness) && std::isnan(modulus)) {
    merged.modulus = other.modulus;
    if (form == UNSET) {
      merged.stiffness = other.stiffness;
      merged.form = other.form;
      merged.alpha = other.alpha;
      merged.horizon = other.horizon;
    }
  }
  if (std::isnan(restitution) && std::isnan(damping)) {
    merged.restitution = other.restitution;
    merged.damping = other.damping;
  }
  merged.friction = either(friction, other.friction);
  if (tangential == UNSET) {
    merged.tangential = other.tangential;
    merged.gamma = other.gamma;
    merged.ratio = other.ratio;
  }
  if (fragments == UNSET) merged.fragments = other.fragments;
  return merged;
}

/* ----------------------------------------------------------------------
   fill in what was left out; where = "Pair style peridem/contact, types 1 2" and the like
------------------------------------------------------------------------- */

PeridemContactLaw PeridemContactLaw::resolve(const PeridemContactGiven &given,
                                             const PeridemContactKnown &known,
                                             const std::string &where, LAMMPS *lmp)
{
  PeridemContactLaw law;
  auto *error = lmp->error;
  law.dim = lmp->domain->dimension;

  law.radius = given.radius;
  if (std::isnan(given.radius)) {
    if (known.spacing <= 0.0)
      error->all(FLERR, Error::NOLASTLINE,
                 "{}: radius auto finds no nodes to measure: give a radius", where);
    law.radius = either(given.auto_factor, 0.95) * known.spacing;
  }

  if (!std::isnan(given.stiffness)) {
    law.per_volume = true;
    law.modulus = given.stiffness;
  } else {
    const double bulk = either(given.modulus, known.bulk);
    if (!(bulk > 0.0))
      error->all(FLERR, Error::NOLASTLINE,
                 "{}: no solid says how stiff the contact is: give modulus or stiffness", where);
    if (given.form == PeridemContactGiven::JHA2021) {
      const double delta = either(given.horizon, known.horizon);
      if (!(delta > 0.0))
        error->all(FLERR, Error::NOLASTLINE, "{}: form jha2021 needs a horizon", where);
      law.per_volume = true;
      law.modulus = 18.0 * bulk / (MY_PI * std::pow(delta, 5));
    } else {
      law.modulus = either(given.alpha, 10.0) * bulk;
    }
  }

  if (!std::isnan(given.restitution) && given.restitution < 1.0) {
    law.restitution = given.restitution;
    law.impact = impact_number(law.restitution);
  }
  law.damping = either(given.damping, 0.0);
  law.friction = either(given.friction, 0.0);
  law.regularised = given.tangential == PeridemContactGiven::REGULARISED;
  law.gamma = either(given.gamma, -1.0);
  law.ratio = either(given.ratio, DEFAULT_RATIO);
  law.fragments = given.fragments != 0;
  return law;
}

/* ----------------------------------------------------------------------
   With the force F (1 + u V / V0) at an approach speed V that began with V0 (the form of Hunt and
   Crossley 1975), the energy that the elastic force F stores and gives back fixes the speed of
   rebound whatever F looks like:  u - ln(1 + u) = -e u - ln(1 - e u).
   Since e u < 1 the total force never pulls.
------------------------------------------------------------------------- */

double PeridemContactLaw::impact_number(double restitution)
{
  auto excess = [restitution](double u) {
    return u - std::log1p(u) + restitution * u + std::log1p(-restitution * u);
  };
  double lo = 0.0, hi = 1.0 / restitution;
  for (int bisection = 0; bisection < 200; bisection++) {
    const double u = 0.5 * (lo + hi);
    (excess(u) > 0.0 ? lo : hi) = u;
  }
  return 0.5 * (lo + hi);
}

/* ---------------------------------------------------------------------- */

double PeridemContactLaw::impact_force(double elastic, double approach, double peak,
                                       double mobility, double dt) const
{
  if (!(peak > 0.0)) return 0.0;
  // bodies part no faster than a collision lets them: what parts faster has other reasons
  const double ratio = approach / peak;
  double force = elastic * impact * (ratio > -restitution ? ratio : -restitution);
  // never more than slows the two bodies down within several steps
  const double most = std::fabs(approach) / (mobility * IMPACT_STEPS * dt);
  if (force > most) force = most;
  if (force < -most) force = -most;
  return force;
}

/* ---------------------------------------------------------------------- */

void PeridemContactLaw::tangential(const Touch &touch, const double *slide, double *slip,
                                   double *force) const
{
  if (regularised)
    tangential_viscous(touch, slide, force);
  else
    tangential_spring(touch, slide, slip, force);
}

/* ----------------------------------------------------------------------
   a spring with the dashpot of the normal direction, cut at the Coulomb limit: what the slider
   slips, the spring forgets
------------------------------------------------------------------------- */

void PeridemContactLaw::tangential_spring(const Touch &touch, const double *slide, double *slip,
                                          double *force) const
{
  if (touch.advance) {
    // the pair may have turned: keep the length of the spring, in the new tangential plane
    const double *const n = touch.direction;
    double along = 0.0, before = 0.0, after = 0.0;
    for (int m = 0; m < 3; m++) {
      along += slip[m] * n[m];
      before += slip[m] * slip[m];
    }
    for (int m = 0; m < 3; m++) {
      slip[m] -= along * n[m];
      after += slip[m] * slip[m];
    }
    const double scale = after > 0.0 ? std::sqrt(before / after) : 0.0;
    for (int m = 0; m < 3; m++) slip[m] = scale * slip[m] + slide[m] * touch.dt;
  }

  const double kt = ratio * touch.spring;
  const double limit = friction * touch.normal_force;
  double springsq = 0.0;
  for (int m = 0; m < 3; m++) {
    force[m] = kt * slip[m];
    springsq += force[m] * force[m];
  }
  if (springsq > limit * limit) {
    const double scale = limit / std::sqrt(springsq);
    for (int m = 0; m < 3; m++) {
      force[m] *= scale;
      if (touch.advance) slip[m] *= scale;
    }
    return;
  }

  // the dashpot gets what the spring leaves of the limit: |force + share dashpot slide| = limit
  if (touch.dashpot == 0.0) return;
  double dashsq = 0.0, cross = 0.0;
  for (int m = 0; m < 3; m++) {
    const double dash = touch.dashpot * slide[m];
    dashsq += dash * dash;
    cross += dash * force[m];
  }
  double share = 1.0;
  if (springsq + 2.0 * cross + dashsq > limit * limit)
    share = (-cross + std::sqrt(cross * cross + dashsq * (limit * limit - springsq))) / dashsq;
  for (int m = 0; m < 3; m++) force[m] += share * touch.dashpot * slide[m];
}

/* ----------------------------------------------------------------------
   min(mu f_N, gamma v): no jump at zero speed, no memory, and so grains at rest creep
------------------------------------------------------------------------- */

void PeridemContactLaw::tangential_viscous(const Touch &touch, const double *slide,
                                           double *force) const
{
  const double speed = std::sqrt(slide[0] * slide[0] + slide[1] * slide[1] + slide[2] * slide[2]);
  double drag = gamma >= 0.0 ? gamma : touch.node_mass / (STOPPING_STEPS * touch.dt);
  const double limit = friction * touch.normal_force;
  if (drag * speed > limit) drag = limit / speed;
  for (int m = 0; m < 3; m++) force[m] = drag * slide[m];
}

/* ---------------------------------------------------------------------- */

std::string PeridemContactLaw::describe() const
{
  const char *unit = per_volume ? " V_i V_j" : (dim == 2 ? "" : " h");
  std::string text = fmt::format("radius {:.6g}, spring {:.6g}{}", radius, modulus, unit);
  if (impact > 0.0) text += fmt::format(", restitution (impact number {:.4g})", impact);
  if (damping > 0.0) text += fmt::format(", damping {:.6g}", damping);
  text += fmt::format(", friction {:.4g}", friction);
  if (friction > 0.0) text += regularised ? " (regularised)" : " (history)";
  return text;
}

/* ---------------------------------------------------------------------- */

PeridemContactParser::PeridemContactParser(LAMMPS *lmp, const std::string &_style, int _iarg0) :
    Pointers(lmp), style(_style), iarg0(_iarg0)
{
}

/* ---------------------------------------------------------------------- */

const char *PeridemContactParser::keywords()
{
  return "radius, modulus, form, horizon, stiffness, restitution, damping, friction, tangential, "
         "fragments";
}

/* ---------------------------------------------------------------------- */

double PeridemContactParser::number(int iarg, int narg, char **arg, Range range,
                                    const std::string &keyword)
{
  if (iarg >= narg) error->all(FLERR, iarg0 + iarg - 1, "{} {} needs a value", style, keyword);
  const double value = utils::numeric(FLERR, arg[iarg], false, lmp);
  const bool good = std::isfinite(value) &&
      ((range == POSITIVE && value > 0.0) || (range == NON_NEGATIVE && value >= 0.0) ||
       (range == FRACTION && value > 0.0 && value <= 1.0));
  const char *allowed = range == POSITIVE ? "> 0" : range == NON_NEGATIVE ? ">= 0" : "> 0 and <= 1";
  if (!good)
    error->all(FLERR, iarg0 + iarg, "{} {} {}: must be {}", style, keyword, arg[iarg], allowed);
  return value;
}

/* ---------------------------------------------------------------------- */

int PeridemContactParser::parse(int iarg, int narg, char **arg, PeridemContactGiven &given)
{
  auto fresh = [&](bool unset) {
    if (!unset) error->all(FLERR, iarg0 + iarg, "Repeated {} keyword {}", style, arg[iarg]);
  };
  auto exclusive = [&](bool unset, const char *other) {
    if (!unset)
      error->all(FLERR, iarg0 + iarg, "{} takes either {} or {}, not both", style, arg[iarg],
                 other);
  };

  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (key == "radius") {
      fresh(std::isnan(given.radius) && std::isnan(given.auto_factor));
      if (iarg + 1 < narg && std::string(arg[iarg + 1]) == "auto") {
        given.auto_factor = 0.95;
        iarg += 2;
        if (iarg < narg && utils::is_double(arg[iarg]))
          given.auto_factor = number(iarg++, narg, arg, POSITIVE, "radius auto");
      } else {
        given.radius = number(iarg + 1, narg, arg, POSITIVE, key);
        iarg += 2;
      }
    } else if (key == "modulus") {
      fresh(std::isnan(given.modulus));
      exclusive(std::isnan(given.stiffness), "stiffness");
      given.modulus = number(iarg + 1, narg, arg, POSITIVE, key);
      iarg += 2;
    } else if (key == "form") {
      fresh(given.form == PeridemContactGiven::UNSET);
      exclusive(std::isnan(given.stiffness), "stiffness");
      const std::string value = iarg + 1 < narg ? arg[iarg + 1] : "";
      if (value == "bulk") {
        given.form = PeridemContactGiven::BULK;
      } else if (value == "jha2021") {
        given.form = PeridemContactGiven::JHA2021;
      } else {
        error->all(FLERR, iarg0 + iarg, "{} form {}: must be bulk [alpha] or jha2021", style,
                   value);
      }
      iarg += 2;
      if (value == "bulk" && iarg < narg && utils::is_double(arg[iarg]))
        given.alpha = number(iarg++, narg, arg, POSITIVE, "form bulk");
    } else if (key == "horizon") {
      fresh(std::isnan(given.horizon));
      given.horizon = number(iarg + 1, narg, arg, POSITIVE, key);
      iarg += 2;
    } else if (key == "stiffness") {
      fresh(std::isnan(given.stiffness));
      exclusive(std::isnan(given.modulus), "modulus");
      exclusive(given.form == PeridemContactGiven::UNSET, "form");
      given.stiffness = number(iarg + 1, narg, arg, POSITIVE, key);
      iarg += 2;
    } else if (key == "restitution") {
      fresh(std::isnan(given.restitution));
      exclusive(std::isnan(given.damping), "damping");
      given.restitution = number(iarg + 1, narg, arg, FRACTION, key);
      iarg += 2;
    } else if (key == "damping") {
      fresh(std::isnan(given.damping));
      exclusive(std::isnan(given.restitution), "restitution");
      given.damping = number(iarg + 1, narg, arg, NON_NEGATIVE, key);
      iarg += 2;
    } else if (key == "friction") {
      fresh(std::isnan(given.friction));
      given.friction = number(iarg + 1, narg, arg, NON_NEGATIVE, key);
      iarg += 2;
    } else if (key == "tangential") {
      fresh(given.tangential == PeridemContactGiven::UNSET);
      const std::string value = iarg + 1 < narg ? arg[iarg + 1] : "";
      const bool more = iarg + 2 < narg && utils::is_double(arg[iarg + 2]);
      if (value == "history") {
        given.tangential = PeridemContactGiven::HISTORY;
        if (more) given.ratio = number(iarg + 2, narg, arg, POSITIVE, "tangential history");
      } else if (value == "regularised") {
        given.tangential = PeridemContactGiven::REGULARISED;
        if (more) given.gamma = number(iarg + 2, narg, arg, POSITIVE, "tangential regularised");
      } else {
        error->all(FLERR, iarg0 + iarg,
                   "{} tangential {}: must be history [k_t/k_n] or regularised [gamma]", style,
                   value);
      }
      iarg += more ? 3 : 2;
    } else if (key == "fragments") {
      fresh(given.fragments == PeridemContactGiven::UNSET);
      if (iarg + 1 >= narg) error->all(FLERR, iarg0 + iarg, "{} {} needs yes or no", style, key);
      given.fragments = utils::logical(FLERR, arg[iarg + 1], false, lmp);
      iarg += 2;
    } else {
      return iarg;
    }
  }
  return iarg;
}
