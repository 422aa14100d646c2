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

#include "peridem_material.h"

#include "peridem_families.h"

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "math_const.h"
#include "utils.h"

#include <cmath>
#include <limits>
#include <map>
#include <type_traits>
#include <vector>

using namespace LAMMPS_NS;
using MathConst::MY_PI;

const char *const PeridemMaterialParser::modulus_names[NMODULI] = {"young", "bulk", "shear",
                                                                   "poisson"};

/* ---------------------------------------------------------------------- */

double PeridemMaterial::lambda() const
{
  const double lame = bulk - 2.0 * shear / 3.0;
  return plane == STRESS ? 2.0 * lame * shear / (lame + 2.0 * shear) : lame;
}

/* ----------------------------------------------------------------------
   Under an isotropic extension s the bonds hold c s^2/4 int w R dV per volume, the classical solid
   d^2 kappa s^2/2 with kappa = lambda' + 2 G/d. Pair forces make lambda' = G, so that
   c int w R dV = 2 d (d + 2) G, for any influence function.
------------------------------------------------------------------------- */

static double length_integral(const PeridemMaterial &mat)
{
  const double h = mat.horizon;
  return mat.dim() == 3 ? 4.0 * MY_PI * h * h * h * h * mat.influence.moment(3)
                        : 2.0 * MY_PI * h * h * h * mat.influence.moment(2);
}

/* ---------------------------------------------------------------------- */

double PeridemMaterial::micromodulus() const
{
  return 2.0 * dim() * (dim() + 2) * shear / length_integral(*this);
}

/* ---------------------------------------------------------------------- */

static double bond_based_poisson(int plane)
{
  return plane == PeridemMaterial::STRESS ? 1.0 / 3.0 : 0.25;
}

/* ---------------------------------------------------------------------- */

void PeridemMaterial::moduli_from_micromodulus(double c)
{
  const double nu = bond_based_poisson(plane);
  shear = c * length_integral(*this) / (2.0 * dim() * (dim() + 2));
  bulk = 2.0 * shear * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
}

/* ----------------------------------------------------------------------
   sum of w v R^n V over the bonds of one node of a square or cubic lattice
------------------------------------------------------------------------- */

static double lattice_sum(const PeridemMaterial &mat, int n)
{
  const double h = mat.spacing;
  const double taper = mat.cell > 0.0 ? mat.cell : h;
  const double reach = mat.horizon * (1.0 + PeridemFamilies::SLACK);
  const int most = static_cast<int>(reach / h);
  const int deep = mat.dim() == 3 ? most : 0;
  double sum = 0.0;
  for (int k = -deep; k <= deep; k++)
    for (int j = -most; j <= most; j++)
      for (int i = -most; i <= most; i++) {
        const double R = h * std::sqrt(static_cast<double>(i * i + j * j + k * k));
        if (R == 0.0 || R > reach) continue;
        sum += mat.influence(R / mat.horizon) * mat.volume_factor(R, taper) * std::pow(R, n);
      }
  return sum * std::pow(h, mat.dim());
}

/* ----------------------------------------------------------------------
   int w R^n dV over the horizon, or what a lattice of the spacing makes of it
------------------------------------------------------------------------- */

static double family_sum(const PeridemMaterial &mat, int n)
{
  if (mat.spacing > 0.0) return lattice_sum(mat, n);
  const int d = mat.dim();
  const double sphere = d == 3 ? 4.0 * MY_PI : 2.0 * MY_PI;
  return sphere * mat.influence.moment(n + d - 1) * std::pow(mat.horizon, n + d);
}

/* ----------------------------------------------------------------------
   Energy for s0 = 1 of all bonds that cross a unit of plane, which gets Gc when the stretch is s0:
   on average over the directions of planes, the part CROSSING R of the bonds of a unit of volume.
   Bonds of the bond-based solid hold c w R s0^2/2 each; with the regularised potential a bond
   pulled apart has taken C w = c w h s0^2; bonds of the linear solid under isotropic extension
   d^2 kappa' w R^2 s0^2 / m.
------------------------------------------------------------------------- */

static double crossing_energy(const PeridemMaterial &mat)
{
  const int d = mat.dim();
  const double CROSSING = d == 3 ? 0.25 : 1.0 / MY_PI;
  if (mat.model == PeridemMaterial::PMB) {
    const double c = mat.micromodulus();
    if (mat.potential == PeridemMaterial::RNP)
      return CROSSING * c * mat.horizon * family_sum(mat, 1);
    return CROSSING * 0.5 * c * family_sum(mat, 2);
  }
  const double kappa = mat.lambda() + 2.0 * mat.shear / d;
  const double m = family_sum(mat, 2);    // 0 where a horizon of 1e-320 has no fifth power
  return m > 0.0 ? CROSSING * d * d * kappa * family_sum(mat, 3) / m : 0.0;
}

/* ----------------------------------------------------------------------
   plane jha keeps eq. (4) of Jha et al. 2021
------------------------------------------------------------------------- */

double PeridemMaterial::stretch_from_gc() const
{
  if (plane == JHA) {
    const double factor = 81.0 / 256.0;    // (3/4)^4
    return std::sqrt(gc / ((3.0 * shear + factor * (bulk - 5.0 * shear / 3.0)) * horizon));
  }
  const double energy = crossing_energy(*this);
  return energy > 0.0 ? std::sqrt(gc / energy) : std::numeric_limits<double>::infinity();
}

/* ---------------------------------------------------------------------- */

std::string PeridemMaterial::spacing_text() const
{
  return spacing > 0.0 ? fmt::format(" on a lattice of spacing {:.6g}", spacing) : "";
}

/* ---------------------------------------------------------------------- */

static_assert(std::is_trivially_copyable<PeridemMaterial>::value,
              "restart files hold the bytes of a material");

void PeridemMaterial::write_restart(FILE *fp) const
{
  fwrite(this, sizeof(PeridemMaterial), 1, fp);
}

/* ---------------------------------------------------------------------- */

void PeridemMaterial::read_restart(FILE *fp, LAMMPS *lmp)
{
  if (lmp->comm->me == 0)
    utils::sfread(FLERR, this, sizeof(PeridemMaterial), 1, fp, nullptr, lmp->error);
  MPI_Bcast(this, sizeof(PeridemMaterial), MPI_BYTE, 0, lmp->world);
}

/* ---------------------------------------------------------------------- */

PeridemMaterialParser::PeridemMaterialParser(LAMMPS *lmp, const std::string &_style, int _iarg0,
                                             int _model) :
    Pointers(lmp), style(_style), iarg0(_iarg0), model(_model)
{
}

/* ----------------------------------------------------------------------
   narg,arg start at the first keyword
   one_type = true for I = J: moduli, horizon and strength are required
------------------------------------------------------------------------- */

PeridemMaterial PeridemMaterialParser::parse(int _narg, char **_arg, bool one_type)
{
  narg = _narg;
  arg = _arg;
  clear();
  if (domain->dimension == 2)
    mat.plane = one_type ? PeridemMaterial::STRAIN : PeridemMaterial::AS_TYPES;

  int iarg = 0;
  while (iarg < narg) {
    const std::string key = arg[iarg];
    if (seen.count(key)) error->all(FLERR, iarg0 + iarg, "Repeated {} keyword {}", style, key);
    check_strength(iarg);
    seen[key] = iarg;
    iarg += keyword(iarg);
  }

  if (model == PeridemMaterial::PMB)
    pmb_moduli(one_type);
  else
    moduli(one_type);
  if (one_type && mat.horizon == 0.0)
    error->all(FLERR, Error::ARGZERO, "{} needs the keyword horizon", style);
  check_spacing();
  if (model == PeridemMaterial::PMB) pmb_strength(one_type);
  if (one_type && mat.strength == PeridemMaterial::UNSET)
    error->all(FLERR, Error::ARGZERO, "{} needs one of the keywords gc, s0, unbreakable", style);
  return mat;
}

/* ---------------------------------------------------------------------- */

void PeridemMaterialParser::clear()
{
  mat = PeridemMaterial();
  mat.model = model;
  seen.clear();
  for (int k = 0; k < NMODULI; k++) where[k] = -1;
  micromodulus = rnp[0] = rnp[1] = 0.0;
}

/* ----------------------------------------------------------------------
   read the keyword at iarg; returns how many words it takes
------------------------------------------------------------------------- */

int PeridemMaterialParser::keyword(int iarg)
{
  const std::string key = arg[iarg];
  if (model == PeridemMaterial::PMB) {
    const int used = pmb_keyword(iarg);
    if (used) return used;
  }
  for (int k = 0; k < NMODULI; k++)
    if (key == modulus_names[k]) {
      need(iarg, 1);
      given[k] = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      where[k] = iarg;
      return 2;
    }

  if (key == "influence") return influence(iarg);
  if (key == "volume") return volume(iarg);
  if (key == "gc" || key == "s0" || key == "unbreakable") return strength(iarg);
  if (key == "horizon") {
    mat.horizon = positive(iarg, key);
    if (!std::isnormal(std::pow(mat.horizon, 6)))    // integrals over a family have such powers
      error->all(FLERR, iarg0 + iarg + 1, "{} horizon {}: is that the right unit of length?", style,
                 arg[iarg + 1]);
  } else if (key == "viscosity") {
    mat.viscosity = non_negative(iarg, key);
  } else if (key == "plane") {
    plane(iarg);
  } else if (key == "break") {
    breaking(iarg);
  } else {
    error->all(FLERR, iarg0 + iarg, "Unknown {} keyword {}: known are {}", style, key, known());
  }
  return 2;
}

/* ----------------------------------------------------------------------
   keywords of the bond-based solid alone; 0 = none of them
------------------------------------------------------------------------- */

int PeridemMaterialParser::pmb_keyword(int iarg)
{
  const std::string key = arg[iarg];
  if (key == "potential") return potential(iarg);
  if (key == "c") {
    micromodulus = positive(iarg, key);
    return 2;
  }
  if (key == "shear" || key == "poisson")
    error->all(FLERR, iarg0 + iarg,
               "{} keyword {}: Poisson's ratio of a bond-based solid is 1/4 (1/3 in plane stress), "
               "so one of young, bulk, c is enough",
               style, key);
  return 0;
}

/* ---------------------------------------------------------------------- */

std::string PeridemMaterialParser::known() const
{
  const std::string first = model == PeridemMaterial::PMB ? "young, bulk, c, potential"
                                                          : "young, bulk, shear, poisson";
  return first + ", horizon, gc, s0, unbreakable, viscosity, influence, plane, volume, break";
}

/* ----------------------------------------------------------------------
   the three strengths exclude each other
------------------------------------------------------------------------- */

void PeridemMaterialParser::check_strength(int iarg)
{
  const std::string key = arg[iarg];
  const bool strength = key == "gc" || key == "s0" || key == "unbreakable";
  if (strength && mat.strength != PeridemMaterial::UNSET)
    error->all(FLERR, iarg0 + iarg, "{} takes only one of gc, s0, unbreakable: {} is one too many",
               style, key);
}

/* ---------------------------------------------------------------------- */

int PeridemMaterialParser::strength(int iarg)
{
  const std::string key = arg[iarg];
  if (key == "unbreakable") {
    mat.s0 = std::numeric_limits<double>::infinity();
    mat.strength = PeridemMaterial::UNBREAKABLE;
    return 1;
  }
  if (key == "s0") {
    mat.s0 = positive(iarg, key);
    mat.strength = PeridemMaterial::S0;
    return 2;
  }
  mat.gc = positive(iarg, key);
  mat.strength = PeridemMaterial::GC;
  if (iarg + 2 >= narg || !utils::is_double(arg[iarg + 2])) return 2;
  mat.spacing = positive(iarg + 1, "gc spacing");
  return 3;
}

/* ----------------------------------------------------------------------
   the spacing of a lattice whose bonds spend gc
------------------------------------------------------------------------- */

void PeridemMaterialParser::check_spacing()
{
  if (mat.spacing == 0.0) return;
  const int where_spacing = iarg0 + seen["gc"] + 2;
  if (mat.plane == PeridemMaterial::JHA)
    error->all(FLERR, where_spacing,
               "{} plane jha has a formula of its own for gc: it takes no spacing", style);
  if (mat.horizon > 0.0 && mat.spacing > mat.horizon)
    error->all(FLERR, where_spacing, "{} gc spacing {}: must be <= the horizon {:.8g}", style,
               arg[seen["gc"] + 2], mat.horizon);
}

/* ---------------------------------------------------------------------- */

void PeridemMaterialParser::need(int iarg, int nvalues)
{
  if (iarg + nvalues >= narg)
    error->all(FLERR, iarg0 + iarg, "{} keyword {} needs {} value{}", style, arg[iarg], nvalues,
               nvalues > 1 ? "s" : "");
}

/* ---------------------------------------------------------------------- */

double PeridemMaterialParser::positive(int iarg, const std::string &keyword)
{
  need(iarg, 1);
  const double value = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
  if (!(value > 0.0) || !std::isfinite(value))
    error->all(FLERR, iarg0 + iarg + 1, "{} {} {}: must be > 0", style, keyword, arg[iarg + 1]);
  return value;
}

/* ---------------------------------------------------------------------- */

double PeridemMaterialParser::non_negative(int iarg, const std::string &keyword)
{
  need(iarg, 1);
  const double value = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
  if (!(value >= 0.0) || !std::isfinite(value))
    error->all(FLERR, iarg0 + iarg + 1, "{} {} {}: must be >= 0", style, keyword, arg[iarg + 1]);
  return value;
}

/* ---------------------------------------------------------------------- */

int PeridemMaterialParser::influence(int iarg)
{
  need(iarg, 1);
  const std::string value = arg[iarg + 1];
  if (value == "linear") {
    mat.influence.kind = PeridemInfluence::LINEAR;
  } else if (value == "constant") {
    mat.influence.kind = PeridemInfluence::CONSTANT;
  } else if (value == "inverse") {
    mat.influence.kind = PeridemInfluence::INVERSE;
  } else if (value == "gaussian") {
    need(iarg, 2);
    mat.influence.kind = PeridemInfluence::GAUSSIAN;
    mat.influence.width = positive(iarg + 1, "influence gaussian");
    return 3;
  } else {
    error->all(FLERR, iarg0 + iarg + 1,
               "{} influence {}: must be linear, constant, gaussian b or inverse", style, value);
  }
  return 2;
}

/* ---------------------------------------------------------------------- */

void PeridemMaterialParser::plane(int iarg)
{
  need(iarg, 1);
  const std::string value = arg[iarg + 1];
  if (domain->dimension == 3)
    error->all(FLERR, iarg0 + iarg, "{} plane {}: plane is for 2d simulations only", style, value);
  if (value == "strain") {
    mat.plane = PeridemMaterial::STRAIN;
  } else if (value == "stress") {
    mat.plane = PeridemMaterial::STRESS;
  } else if (value == "jha" && model == PeridemMaterial::LPS) {
    mat.plane = PeridemMaterial::JHA;
  } else {
    error->all(FLERR, iarg0 + iarg + 1, "{} plane {}: must be {}", style, value,
               model == PeridemMaterial::PMB ? "strain or stress" : "strain, stress or jha");
  }
}

/* ---------------------------------------------------------------------- */

void PeridemMaterialParser::breaking(int iarg)
{
  need(iarg, 1);
  const std::string value = arg[iarg + 1];
  if (value != "tension" && value != "both")
    error->all(FLERR, iarg0 + iarg + 1, "{} break {}: must be tension or both", style, value);
  mat.break_both = value == "both";
}

/* ----------------------------------------------------------------------
   C and beta of rnp may be left out: then they follow from a modulus and the strength
------------------------------------------------------------------------- */

int PeridemMaterialParser::potential(int iarg)
{
  need(iarg, 1);
  const std::string value = arg[iarg + 1];
  if (value == "pmb") {
    mat.potential = PeridemMaterial::BRITTLE;
  } else if (value == "elastic") {
    mat.potential = PeridemMaterial::ELASTIC;
  } else if (value == "rnp") {
    mat.potential = PeridemMaterial::RNP;
    if (iarg + 2 < narg && utils::is_double(arg[iarg + 2])) {
      rnp[0] = positive(iarg + 1, "potential rnp C");
      if (iarg + 3 >= narg)
        error->all(FLERR, iarg0 + iarg, "{} potential rnp takes C and beta, or neither", style);
      rnp[1] = positive(iarg + 2, "potential rnp C beta");
      return 4;
    }
  } else {
    error->all(FLERR, iarg0 + iarg + 1, "{} potential {}: must be pmb, elastic or rnp [C beta]",
               style, value);
  }
  return 2;
}

/* ---------------------------------------------------------------------- */

int PeridemMaterialParser::volume(int iarg)
{
  need(iarg, 1);
  const std::string value = arg[iarg + 1];
  if (value == "full") {
    mat.volume = PeridemMaterial::FULL;
  } else if (value == "taper") {
    mat.volume = PeridemMaterial::TAPER;
    if (iarg + 2 < narg && utils::is_double(arg[iarg + 2])) {
      mat.cell = positive(iarg + 1, "volume taper");
      return 3;
    }
  } else {
    error->all(FLERR, iarg0 + iarg + 1, "{} volume {}: must be taper [cell size] or full", style,
               value);
  }
  return 2;
}

/* ----------------------------------------------------------------------
   bulk and shear modulus from any two of young, bulk, shear, poisson
------------------------------------------------------------------------- */

void PeridemMaterialParser::moduli(bool required)
{
  int count = 0;
  std::string names;
  for (int k = 0; k < NMODULI; k++) {
    if (where[k] < 0) continue;
    count++;
    names += std::string(names.empty() ? "" : ", ") + modulus_names[k];
    if (k != POISSON && !(given[k] > 0.0 && std::isfinite(given[k])))
      error->all(FLERR, iarg0 + where[k] + 1, "{} {} {}: must be > 0", style, modulus_names[k],
                 arg[where[k] + 1]);
    if (k == POISSON && !(given[k] > -1.0 && given[k] < 0.5))
      error->all(FLERR, iarg0 + where[k] + 1, "{} poisson {}: must be > -1 and < 0.5", style,
                 arg[where[k] + 1]);
  }
  if (count == 0 && !required) return;
  if (count != 2)
    error->all(FLERR, Error::ARGZERO,
               "{} needs two of the moduli young, bulk, shear, poisson; given: {}", style,
               names.empty() ? "none" : names);

  const double E = given[YOUNG], K = given[BULK], G = given[SHEAR], nu = given[POISSON];
  const bool hasE = where[YOUNG] >= 0, hasK = where[BULK] >= 0, hasG = where[SHEAR] >= 0;
  if (hasK && hasG) {
    mat.bulk = K;
    mat.shear = G;
  } else if (hasE && hasK) {
    mat.bulk = K;
    mat.shear = 3.0 * K * E / (9.0 * K - E);
  } else if (hasE && hasG) {
    mat.bulk = E * G / (3.0 * (3.0 * G - E));
    mat.shear = G;
  } else if (hasE) {
    mat.bulk = E / (3.0 * (1.0 - 2.0 * nu));
    mat.shear = E / (2.0 * (1.0 + nu));
  } else if (hasK) {
    mat.bulk = K;
    mat.shear = 1.5 * K * (1.0 - 2.0 * nu) / (1.0 + nu);
  } else {
    mat.bulk = 2.0 * G * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu));
    mat.shear = G;
  }
  // two positive moduli may still belong to no stable solid
  const double ratio = mat.poisson();
  if (!(mat.bulk > 0.0) || !(mat.shear > 0.0) || !(ratio > -1.0 && ratio < 0.5) ||
      !std::isfinite(mat.bulk) || !std::isfinite(mat.shear))
    error->all(FLERR, Error::ARGZERO,
               "{}: {} belong to no stable solid (Poisson's ratio would be {:.4g}: must be > -1 "
               "and < 0.5)",
               style, names, ratio);
}

/* ----------------------------------------------------------------------
   bulk and shear modulus of the bond-based solid from one of young, bulk, c, C and beta
------------------------------------------------------------------------- */

void PeridemMaterialParser::pmb_moduli(bool required)
{
  const bool hasE = where[YOUNG] >= 0, hasK = where[BULK] >= 0;
  std::vector<std::string> names;
  if (hasE) names.emplace_back("young");
  if (hasK) names.emplace_back("bulk");
  if (micromodulus > 0.0) names.emplace_back("c");
  if (rnp[0] > 0.0) names.emplace_back("C and beta");
  if (names.empty() && !required) return;
  if (names.size() != 1)
    error->all(FLERR, Error::ARGZERO, "{} needs one of young, bulk, c{}; given: {}", style,
               mat.potential == PeridemMaterial::RNP ? ", or C and beta of potential rnp" : "",
               names.empty() ? "none" : utils::join_words(names, ", "));

  if (hasE) given[YOUNG] = positive(where[YOUNG], modulus_names[YOUNG]);
  if (hasK) given[BULK] = positive(where[BULK], modulus_names[BULK]);
  // between two types: the plane of the two is known later, and with it the moduli
  if (mat.plane == PeridemMaterial::AS_TYPES)
    error->all(FLERR, Error::ARGZERO,
               "{} with a modulus of its own between two types needs the keyword plane", style);
  if (!hasE && !hasK) {
    if (mat.horizon == 0.0)
      error->all(FLERR, Error::ARGZERO, "{} needs the keyword horizon", style);
    mat.moduli_from_micromodulus(rnp[0] > 0.0 ? 2.0 * rnp[0] * rnp[1] : micromodulus);
    return;
  }
  const double nu = bond_based_poisson(mat.plane);
  mat.bulk = hasK ? given[BULK] : given[YOUNG] / (3.0 * (1.0 - 2.0 * nu));
  mat.shear = 1.5 * mat.bulk * (1.0 - 2.0 * nu) / (1.0 + nu);
}

/* ----------------------------------------------------------------------
   elastic bonds never break; C and beta of rnp say where bonds soften
------------------------------------------------------------------------- */

void PeridemMaterialParser::pmb_strength(bool required)
{
  const bool limited = mat.strength == PeridemMaterial::GC || mat.strength == PeridemMaterial::S0;
  if (mat.potential == PeridemMaterial::ELASTIC) {
    if (limited)
      error->all(FLERR, Error::ARGZERO,
                 "{} potential elastic never breaks: it takes neither gc nor s0", style);
    mat.s0 = std::numeric_limits<double>::infinity();
    mat.strength = PeridemMaterial::UNBREAKABLE;
  }
  if (mat.potential != PeridemMaterial::RNP) return;

  if (rnp[0] > 0.0) {
    if (limited)
      error->all(FLERR, Error::ARGZERO,
                 "{} potential rnp C beta has its strength from C and beta: it takes neither gc "
                 "nor s0",
                 style);
    mat.s0 = std::sqrt(0.5 / (rnp[1] * mat.horizon));
    if (mat.strength == PeridemMaterial::UNSET) mat.strength = PeridemMaterial::S0;
  } else if (!limited && (required || mat.strength == PeridemMaterial::UNBREAKABLE)) {
    error->all(FLERR, Error::ARGZERO,
               "{} potential rnp needs gc or s0, from which C and beta follow, or C and beta",
               style);
  }
}
