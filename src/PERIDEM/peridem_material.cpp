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

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "math_const.h"
#include "utils.h"

#include <cmath>
#include <limits>
#include <map>
#include <type_traits>

using namespace LAMMPS_NS;
using MathConst::MY_PI;

enum { YOUNG, BULK, SHEAR, POISSON, NMODULI };
static const char *const modulus_names[NMODULI] = {"young", "bulk", "shear", "poisson"};

/* ---------------------------------------------------------------------- */

double PeridemMaterial::lambda() const
{
  const double lame = bulk - 2.0 * shear / 3.0;
  return plane == STRESS ? 2.0 * lame * shear / (lame + 2.0 * shear) : lame;
}

/* ----------------------------------------------------------------------
   The energy of all bonds that cross a unit of plane, each stretched to s0 by an isotropic
   extension, is Gc:  s0^2 = Gc m / (d^2 kappa I), with the weighted volume m = int w R^2 dV of
   the whole family ball and I the first moment of the crossing bonds.
   plane jha keeps eq. (4) of Jha et al. 2021.
------------------------------------------------------------------------- */

double PeridemMaterial::stretch_from_gc() const
{
  if (plane == JHA) {
    const double factor = 81.0 / 256.0;    // (3/4)^4
    return std::sqrt(gc / ((3.0 * shear + factor * (bulk - 5.0 * shear / 3.0)) * horizon));
  }
  const int d = dim();
  const double kappa = lambda() + 2.0 * shear / d;
  double m, crossing;    // both without their powers of the horizon: m ~ h^(d+2), I ~ h^(d+3)
  if (d == 3) {
    m = 4.0 * MY_PI * influence.moment(4);
    crossing = MY_PI * influence.moment(5);
  } else {
    m = 2.0 * MY_PI * influence.moment(3);
    crossing = 2.0 * influence.moment(4);
  }
  return std::sqrt(gc * m / (d * d * kappa * crossing * horizon));
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

PeridemMaterialParser::PeridemMaterialParser(LAMMPS *lmp, const std::string &_style, int _iarg0) :
    Pointers(lmp), style(_style), iarg0(_iarg0)
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

  PeridemMaterial mat;
  mat.plane = domain->dimension == 3 ? PeridemMaterial::THREE_D : PeridemMaterial::STRAIN;
  double given[NMODULI];
  int where[NMODULI] = {-1, -1, -1, -1};
  std::map<std::string, int> seen;
  const double infinite = std::numeric_limits<double>::infinity();

  int iarg = 0;
  while (iarg < narg) {
    const std::string key = arg[iarg];
    // the three strengths exclude each other
    const bool strength = key == "gc" || key == "s0" || key == "unbreakable";
    if (seen.count(key))
      error->all(FLERR, iarg0 + iarg, "Repeated {} keyword {}", style, key);
    if (strength && mat.strength != PeridemMaterial::UNSET)
      error->all(FLERR, iarg0 + iarg, "{} takes only one of gc, s0, unbreakable: {} is one too many",
                 style, key);
    seen[key] = iarg;

    int modulus = -1;
    for (int k = 0; k < NMODULI; k++)
      if (key == modulus_names[k]) modulus = k;

    int used = 2;
    if (modulus >= 0) {
      need(iarg, 1);
      given[modulus] = utils::numeric(FLERR, arg[iarg + 1], false, lmp);
      where[modulus] = iarg;
    } else if (key == "horizon") {
      mat.horizon = positive(iarg, key);
    } else if (key == "gc") {
      mat.gc = positive(iarg, key);
      mat.strength = PeridemMaterial::GC;
    } else if (key == "s0") {
      mat.s0 = positive(iarg, key);
      mat.strength = PeridemMaterial::S0;
    } else if (key == "unbreakable") {
      mat.s0 = infinite;
      mat.strength = PeridemMaterial::UNBREAKABLE;
      used = 1;
    } else if (key == "viscosity") {
      mat.viscosity = non_negative(iarg, key);
    } else if (key == "influence") {
      used = influence(iarg, mat);
    } else if (key == "plane") {
      plane(iarg, mat);
    } else if (key == "volume") {
      used = volume(iarg, mat);
    } else if (key == "break") {
      need(iarg, 1);
      const std::string value = arg[iarg + 1];
      if (value != "tension" && value != "both")
        error->all(FLERR, iarg0 + iarg + 1, "{} break {}: must be tension or both", style, value);
      mat.break_both = value == "both";
    } else {
      error->all(FLERR, iarg0 + iarg,
                 "Unknown {} keyword {}: known are young, bulk, shear, poisson, horizon, gc, s0, "
                 "unbreakable, viscosity, influence, plane, volume, break",
                 style, key);
    }
    iarg += used;
  }

  moduli(given, where, mat, one_type);
  if (one_type && mat.horizon == 0.0)
    error->all(FLERR, Error::ARGZERO, "{} needs the keyword horizon", style);
  if (one_type && mat.strength == PeridemMaterial::UNSET)
    error->all(FLERR, Error::ARGZERO, "{} needs one of the keywords gc, s0, unbreakable", style);
  return mat;
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

int PeridemMaterialParser::influence(int iarg, PeridemMaterial &mat)
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

void PeridemMaterialParser::plane(int iarg, PeridemMaterial &mat)
{
  need(iarg, 1);
  const std::string value = arg[iarg + 1];
  if (domain->dimension == 3)
    error->all(FLERR, iarg0 + iarg, "{} plane {}: plane is for 2d simulations only", style, value);
  if (value == "strain") {
    mat.plane = PeridemMaterial::STRAIN;
  } else if (value == "stress") {
    mat.plane = PeridemMaterial::STRESS;
  } else if (value == "jha") {
    mat.plane = PeridemMaterial::JHA;
  } else {
    error->all(FLERR, iarg0 + iarg + 1, "{} plane {}: must be strain, stress or jha", style, value);
  }
}

/* ---------------------------------------------------------------------- */

int PeridemMaterialParser::volume(int iarg, PeridemMaterial &mat)
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

void PeridemMaterialParser::moduli(const double *given, const int *where, PeridemMaterial &mat,
                                   bool required)
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
