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

using namespace LAMMPS_NS;
using MathConst::MY_PI;

// tangential over normal spring: about 2 (1 - nu) / (2 - nu), the ratio of the elastic stiffnesses
// of two touching bodies (Mindlin 1949), at nu = 1/4
static constexpr double DEFAULT_RATIO = 0.85;

// the regularised force stops a sliding node pair in this many steps at the soonest
static constexpr double STOPPING_STEPS = 2.0;

// the loss of a collision slows bodies down in no fewer steps than this
static constexpr double IMPACT_STEPS = 10.0;

// times the longest edge of the box: no contact distance is larger than that
static constexpr double DWARFS = 1000.0;

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
  merged.onset = either(onset, other.onset);
  if (fragments == UNSET) merged.fragments = other.fragments;
  return merged;
}

/* ----------------------------------------------------------------------
   numbers that no scene has: more ghosts than LAMMPS can count, springs of zero
------------------------------------------------------------------------- */

void PeridemContactLaw::check_units(const std::string &where, LAMMPS *lmp) const
{
  const auto *domain = lmp->domain;
  const double box = MAX(MAX(domain->xprd, domain->yprd), domain->zprd);
  if (radius > DWARFS * box)
    lmp->error->all(FLERR, Error::NOLASTLINE,
                    "{}: radius {:.6g}, and the box is only {:.6g} long: is that the right unit of "
                    "length?",
                    where, radius, box);
  if (!std::isnormal(modulus) || !std::isnormal(radius))
    lmp->error->all(FLERR, Error::NOLASTLINE,
                    "{}: a radius of {:.6g} with a spring of {:.6g} cannot be computed with: are "
                    "these the right units?",
                    where, radius, modulus);
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
    law.radius = either(given.auto_factor, PeridemContactGiven::AUTO_FACTOR) * known.spacing;
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
      const double power = std::pow(delta, 5);
      if (!std::isnormal(power))
        error->all(FLERR, Error::NOLASTLINE,
                   "{}: horizon {:.6g}: is that the right unit of length?", where, delta);
      law.modulus = 18.0 * bulk / (MY_PI * power);
    } else {
      law.modulus = either(given.alpha, 10.0) * bulk;
    }
  }

  law.check_units(where, lmp);
  law.depth = either(given.onset, 0.0) * law.radius;

  law.take_losses(given);
  law.fragments = given.fragments != 0;
  return law;
}

/* ---------------------------------------------------------------------- */

void PeridemContactLaw::take_losses(const PeridemContactGiven &given)
{
  if (!std::isnan(given.restitution) && given.restitution < 1.0) {
    restitution = given.restitution;
    impact = impact_number(restitution);
  }
  damping = either(given.damping, 0.0);
  friction = either(given.friction, 0.0);
  regularised = given.tangential == PeridemContactGiven::REGULARISED;
  gamma = either(given.gamma, -1.0);
  ratio = either(given.ratio, DEFAULT_RATIO);
}

/* ----------------------------------------------------------------------
   Each type is half of the contact with itself, and a contact of two types is made of two such
   halves one behind the other: springs add as compliances, losses count with the share of the
   overlap that each half has.
------------------------------------------------------------------------- */

PeridemContactLaw PeridemContactLaw::mix(const PeridemContactLaw &a, const PeridemContactLaw &b,
                                         const std::string &where, LAMMPS *lmp)
{
  if (a.per_volume != b.per_volume)
    lmp->error->all(FLERR, Error::NOLASTLINE,
                    "{}: the spring of one is for each volume squared (stiffness or form jha2021), "
                    "of the other not: give pair_coeff for the two",
                    where);
  PeridemContactLaw law = a;
  law.radius = a.radius > b.radius ? a.radius : b.radius;
  law.modulus = 2.0 * a.modulus * b.modulus / (a.modulus + b.modulus);
  law.depth = (b.modulus * a.depth + a.modulus * b.depth) / (a.modulus + b.modulus);
  law.fragments = a.fragments && b.fragments;
  law.mix_loss(a, b, where, lmp);
  law.mix_friction(a, b, where, lmp);
  return law;
}

/* ---------------------------------------------------------------------- */

void PeridemContactLaw::mix_loss(const PeridemContactLaw &a, const PeridemContactLaw &b,
                                 const std::string &where, LAMMPS *lmp)
{
  if ((a.uses_restitution() && b.damping > 0.0) || (b.uses_restitution() && a.damping > 0.0))
    lmp->error->all(
        FLERR, Error::NOLASTLINE,
        "{}: one loses energy by restitution, the other by damping: give pair_coeff for the two",
        where);
  // of the overlap, and of the energy, the softer half has more
  const double share_a = b.modulus / (a.modulus + b.modulus), share_b = 1.0 - share_a;
  damping = 2.0 * (share_a * share_a * a.damping + share_b * share_b * b.damping);
  restitution = 1.0;
  impact = 0.0;
  if (!a.uses_restitution() && !b.uses_restitution()) return;
  // e^2 is the part of the energy that comes back
  restitution =
      std::sqrt(share_a * a.restitution * a.restitution + share_b * b.restitution * b.restitution);
  impact = impact_number(restitution);
}

/* ----------------------------------------------------------------------
   the geometric mean, as pair style granular has it: what is smooth is smooth on anything
------------------------------------------------------------------------- */

void PeridemContactLaw::mix_friction(const PeridemContactLaw &a, const PeridemContactLaw &b,
                                     const std::string &where, LAMMPS *lmp)
{
  friction = std::sqrt(a.friction * b.friction);
  if (friction == 0.0) return;
  const bool alike = a.regularised == b.regularised && (a.gamma < 0.0) == (b.gamma < 0.0);
  if (!alike)
    lmp->error->all(FLERR, Error::NOLASTLINE,
                    "{}: their tangential forces are of different kinds (history, regularised, "
                    "regularised gamma): give pair_coeff for the two",
                    where);
  gamma = a.gamma < 0.0 ? -1.0 : std::sqrt(a.gamma * b.gamma);
  const double ta = a.ratio * a.modulus, tb = b.ratio * b.modulus;
  ratio = 2.0 * ta * tb / (ta + tb) / modulus;
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

double PeridemContactLaw::impact_force(double elastic, double stored, double approach, double peak,
                                       double mobility, double dt) const
{
  if (!(peak > 0.0)) return 0.0;
  // Springs that hold more energy than the bodies came with are pressed by something else, and
  // slowly: what counts is the speed that their energy would give them. In a collision it is less.
  const double pressed = std::sqrt(stored * mobility);
  // bodies part no faster than a collision lets them: what parts faster has other reasons
  const double speed = approach / (peak > pressed ? peak : pressed);
  double force = elastic * impact * (speed > -restitution ? speed : -restitution);
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
  if (depth > 0.0) text += fmt::format(", onset over {:.4g}", depth);
  if (impact > 0.0)
    text += fmt::format(", restitution {:.4g} (impact number {:.4g})", restitution, impact);
  if (damping > 0.0) text += fmt::format(", damping {:.6g}", damping);
  text += fmt::format(", friction {:.4g}", friction);
  if (friction > 0.0) text += regularised ? " (regularised)" : " (history)";
  return text;
}
