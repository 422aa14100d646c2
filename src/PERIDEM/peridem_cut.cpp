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

#include "peridem_cut.h"

#include "domain.h"
#include "error.h"
#include "region.h"
#include "utils.h"

#include <cmath>
#include <limits>

using namespace LAMMPS_NS;

// a bond is looked at in this many places when a region cuts it: a region thinner than the bond's
// length over this number may be missed
static constexpr int SAMPLES = 32;

/* ---------------------------------------------------------------------- */

int PeridemCuts::add(int iarg, int narg, char **arg, const std::string &style)
{
  const std::string kind = iarg < narg ? arg[iarg] : "";
  if (kind == "plane") return add_plane(iarg, narg, arg, style);
  if (kind == "segment") return add_segment(iarg, narg, arg, style);
  if (kind != "region")
    error->all(FLERR, iarg - 1, "Fix {} cut {}: must be plane, segment or region", style, kind);

  if (iarg + 1 >= narg) error->all(FLERR, iarg, "Fix {} cut region needs a region-ID", style);
  Cut cut{REGION, {}, {}, 0.0, arg[iarg + 1], domain->get_region_by_id(arg[iarg + 1])};
  if (!cut.region)
    error->all(FLERR, iarg + 1, "Fix {} cut region {}: there is no such region", style,
               arg[iarg + 1]);
  cuts.push_back(cut);
  return iarg + 2;
}

/* ---------------------------------------------------------------------- */

double PeridemCuts::number(int iarg, int narg, char **arg, const std::string &what)
{
  if (iarg >= narg) error->all(FLERR, narg - 1, "Too few numbers for {}", what);
  const double value = utils::numeric(FLERR, arg[iarg], false, lmp);
  if (!std::isfinite(value)) error->all(FLERR, iarg, "{}: {} is not finite", what, arg[iarg]);
  return value;
}

/* ----------------------------------------------------------------------
   plane x y z nx ny nz [radius r]
------------------------------------------------------------------------- */

int PeridemCuts::add_plane(int iarg, int narg, char **arg, const std::string &style)
{
  const std::string what = "fix " + style + " cut plane";
  Cut cut{PLANE, {}, {}, std::numeric_limits<double>::infinity(), "", nullptr};
  double lengthsq = 0.0;
  for (int k = 0; k < 3; k++) {
    cut.point[k] = number(iarg + 1 + k, narg, arg, what);
    cut.normal[k] = number(iarg + 4 + k, narg, arg, what);
    lengthsq += cut.normal[k] * cut.normal[k];
  }
  if (lengthsq == 0.0) error->all(FLERR, iarg + 4, "{}: the normal is zero", what);
  iarg += 7;
  if (iarg < narg && std::string(arg[iarg]) == "radius") {
    cut.radius = number(iarg + 1, narg, arg, what + " radius");
    if (!(cut.radius > 0.0))
      error->all(FLERR, iarg + 1, "{} radius {}: must be > 0", what, arg[iarg + 1]);
    iarg += 2;
  }
  cuts.push_back(cut);
  return iarg;
}

/* ----------------------------------------------------------------------
   segment x1 y1 x2 y2
------------------------------------------------------------------------- */

int PeridemCuts::add_segment(int iarg, int narg, char **arg, const std::string &style)
{
  const std::string what = "fix " + style + " cut segment";
  if (domain->dimension != 2)
    error->all(FLERR, iarg, "{}: segments cut 2d simulations only, use plane or region", what);
  Cut cut{SEGMENT, {}, {}, 0.0, "", nullptr};
  for (int k = 0; k < 2; k++) {
    cut.point[k] = number(iarg + 1 + k, narg, arg, what);
    cut.normal[k] = number(iarg + 3 + k, narg, arg, what);
  }
  if (cut.point[0] == cut.normal[0] && cut.point[1] == cut.normal[1])
    error->all(FLERR, iarg, "{}: its two ends are the same point", what);
  cuts.push_back(cut);
  return iarg + 5;
}

/* ---------------------------------------------------------------------- */

void PeridemCuts::init()
{
  for (auto &cut : cuts) {
    if (cut.kind != REGION) continue;
    cut.region = domain->get_region_by_id(cut.region_id);
    if (!cut.region)
      error->all(FLERR, Error::NOLASTLINE, "The region {} of a cut does not exist any more",
                 cut.region_id);
    cut.region->init();
    cut.region->prematch();
  }
}

/* ---------------------------------------------------------------------- */

bool PeridemCuts::crosses(const double *X, const double *d) const
{
  for (const auto &cut : cuts) {
    if (cut.kind == PLANE && crosses_plane(cut, X, d)) return true;
    if (cut.kind == SEGMENT && crosses_segment(cut, X, d)) return true;
    if (cut.kind == REGION && crosses_region(cut, X, d)) return true;
  }
  return false;
}

/* ----------------------------------------------------------------------
   ends on both sides (a node in the plane belongs to the side of the normal), and the crossing
   within the radius
------------------------------------------------------------------------- */

bool PeridemCuts::crosses_plane(const Cut &cut, const double *X, const double *d)
{
  double begin = 0.0, along = 0.0;
  for (int k = 0; k < 3; k++) {
    begin += (X[k] - cut.point[k]) * cut.normal[k];
    along += d[k] * cut.normal[k];
  }
  const double end = begin + along;
  if ((begin >= 0.0) == (end >= 0.0)) return false;
  const double where = -begin / along;
  double distsq = 0.0;
  for (int k = 0; k < 3; k++) {
    const double offset = X[k] + where * d[k] - cut.point[k];
    distsq += offset * offset;
  }
  return distsq <= cut.radius * cut.radius;
}

/* ---------------------------------------------------------------------- */

bool PeridemCuts::crosses_segment(const Cut &cut, const double *X, const double *d)
{
  const double sx = cut.normal[0] - cut.point[0], sy = cut.normal[1] - cut.point[1];
  auto side_of_segment = [&](double x, double y) {
    return sx * (y - cut.point[1]) - sy * (x - cut.point[0]) >= 0.0;
  };
  auto side_of_bond = [&](double x, double y) {
    return d[0] * (y - X[1]) - d[1] * (x - X[0]) >= 0.0;
  };
  return side_of_segment(X[0], X[1]) != side_of_segment(X[0] + d[0], X[1] + d[1]) &&
      side_of_bond(cut.point[0], cut.point[1]) != side_of_bond(cut.normal[0], cut.normal[1]);
}

/* ---------------------------------------------------------------------- */

bool PeridemCuts::crosses_region(const Cut &cut, const double *X, const double *d)
{
  for (int m = 0; m <= SAMPLES; m++) {
    const double t = static_cast<double>(m) / SAMPLES;
    if (cut.region->match(X[0] + t * d[0], X[1] + t * d[1], X[2] + t * d[2])) return true;
  }
  return false;
}
