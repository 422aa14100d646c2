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

#include "peridem_surface_region.h"

#include "comm.h"
#include "domain.h"
#include "error.h"
#include "modify.h"
#include "peridem_region_faces.h"
#include "peridem_schedule.h"
#include "region.h"
#include "update.h"

#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

// A region shows its axis of rotation only to its kin.

struct Kin : public Region {
  static const double *point_of(const Region *region) { return region->*(&Kin::point); }
  static const double *axis_of(const Region *region) { return region->*(&Kin::runit); }
};

// composites hold other regions

bool is_union(const Region *region)
{
  return strcmp(region->style, "union") == 0;
}

bool is_composite(const Region *region)
{
  return is_union(region) || strcmp(region->style, "intersect") == 0;
}

// side in of a union and side out of an intersection: grains are in one or another of the parts

bool grains_in_any(const Region *region)
{
  return is_union(region) == (region->interior != 0);
}

// while this lives, the parts of a composite of side out are turned inside out

class Inverted {
 public:
  explicit Inverted(Region *_region) : region(_region) { turn(); }
  ~Inverted() { turn(); }
  Inverted(const Inverted &) = delete;
  Inverted &operator=(const Inverted &) = delete;

 private:
  Region *region;
  void turn()
  {
    if (region->interior) return;
    for (int k = 0; k < region->nregion; k++) region->reglist[k]->interior ^= 1;
  }
};

}    // namespace

/* ---------------------------------------------------------------------- */

PeridemSurfaceRegion::PeridemSurfaceRegion(LAMMPS *lmp, const char *_style, int iarg, int narg,
                                           char **arg) : PeridemSurface(lmp), style(_style)
{
  if (iarg + 1 >= narg) error->all(FLERR, iarg, "Fix {} region needs the ID of a region", style);
  id = arg[iarg + 1];
  if (!domain->get_region_by_id(id))
    error->all(FLERR, iarg + 1, "Fix {}: region {} does not exist; define it before the fix", style,
               id);
  find();
}

/* ---------------------------------------------------------------------- */

void PeridemSurfaceRegion::find()
{
  whole = domain->get_region_by_id(id);
  if (!whole)
    error->all(FLERR, Error::NOLASTLINE, "Fix {}: region {} does not exist any more", style, id);
  primitives.clear();
  most = 0;
  collect(whole);
}

/* ---------------------------------------------------------------------- */

void PeridemSurfaceRegion::collect(Region *region)
{
  if (is_composite(region)) {
    for (int k = 0; k < region->nregion; k++) collect(region->reglist[k]);
    return;
  }
  if (index_of(region) < 0) {
    Primitive one;
    one.region = region;
    one.first_key = most;
    primitives.push_back(one);
    rigid.resize(primitives.size());
  }
  most += region->cmax;
}

/* ---------------------------------------------------------------------- */

int PeridemSurfaceRegion::index_of(const Region *region) const
{
  for (std::size_t k = 0; k < primitives.size(); k++)
    if (primitives[k].region == region) return static_cast<int>(k);
  return -1;
}

/* ----------------------------------------------------------------------
   regions may have been deleted and made again between runs
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::init()
{
  const auto before = primitives;
  const int most_before = most;
  find();
  check(whole);
  if (most > most_before)
    error->all(
        FLERR, Error::NOLASTLINE,
        "Fix {}: region {} has more faces now than when the fix was made: make the fix again",
        style, id);
  if (before.size() != primitives.size()) {
    rigid.assign(primitives.size(), Part());
    return;
  }
  for (std::size_t k = 0; k < before.size(); k++) {
    Region *const region = primitives[k].region;
    const int first_key = primitives[k].first_key;
    primitives[k] = before[k];
    primitives[k].region = region;
    primitives[k].first_key = first_key;
  }
}

/* ----------------------------------------------------------------------
   shapes whose speed no one knows, and edges that no one sees
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::check(Region *region)
{
  if (is_composite(region)) {
    if (grains_in_any(region) && !warned && comm->me == 0)
      error->warning(
          FLERR,
          "Fix {}: region {} lets grains be in any of its parts: where faces of two parts "
          "meet in an edge that points at the grains, nodes near that edge feel neither "
          "face; keep such edges apart from grains, or give the obstacle as regions of "
          "side out",
          style, region->id);
    warned = warned || grains_in_any(region);
    Inverted inverted(region);
    for (int k = 0; k < region->nregion; k++) check(region->reglist[k]);
    return;
  }
  const bool round = strcmp(region->style, "sphere") == 0 || strcmp(region->style, "cylinder") == 0;
  if (region->varshape && !round)
    error->all(
        FLERR, Error::NOLASTLINE,
        "Fix {}: region {} of style {} has a variable shape, whose surface velocity is known "
        "only for sphere and cylinder: use the region's move and rotate",
        style, region->id, region->style);
}

/* ---------------------------------------------------------------------- */

bool PeridemSurfaceRegion::moves() const
{
  return whole->dynamic_check() != 0;
}

/* ----------------------------------------------------------------------
   every rank comes here: variables may need all of them
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::advance(const PeridemMoment &now)
{
  if (!moves()) return;
  if (now.begins) modify->clearstep_compute();
  for (std::size_t k = 0; k < primitives.size(); k++) {
    if (!primitives[k].region->dynamic_check()) continue;
    if (now.begins) look_ahead(static_cast<int>(k), now);
    place(static_cast<int>(k), now);
  }
  if (now.begins) PeridemSchedule::invoked(modify, update->ntimestep + 1);
}

/* ----------------------------------------------------------------------
   The region tells where it is at the end of a step of the run; in between it moves at one speed,
   which is what nodes have when forces are evaluated; nothing is known of it at the very first
   evaluation.  Speeds are found here and not by the region, because several fixes may follow it,
   runs may come in pieces, its union does not ask its parts (before 2026), and its axis may be given
   with any length.
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::look_ahead(int k, const PeridemMoment &now)
{
  auto &one = primitives[k];
  auto &part = rigid[k];
  Region *const region = one.region;
  region->prematch();

  const double place[4] = {region->moveflag ? region->dx : 0.0, region->moveflag ? region->dy : 0.0,
                           region->moveflag ? region->dz : 0.0,
                           region->rotateflag ? region->theta : one.angle};
  for (int m = 0; m < 4; m++) {
    const double last = m < 3 ? one.shift[m] : one.angle;
    one.goal[m] = place[m];
    one.start[m] = one.known ? last : place[m];
  }
  const bool compare = now.stepping && one.known;
  for (int m = 0; m < 3 && compare; m++) {
    part.velocity[m] = (one.goal[m] - one.start[m]) / now.whole;
    if (region->rotateflag)
      part.spin[m] = (one.goal[3] - one.start[3]) / now.whole * Kin::axis_of(region)[m];
  }
  if (region->varshape) follow_shape(one, compare);
  one.known = true;
}

/* ----------------------------------------------------------------------
   the region compares its size with prev[4], and leaves its size there
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::follow_shape(Primitive &one, bool compare)
{
  Region *const region = one.region;
  if (compare) one.size_before = one.size;
  region->prev[4] = one.size_before;
  region->set_velocity_shape();
  one.size = region->prev[4];
  if (!one.known) {
    one.size_before = one.size;
    region->set_velocity_shape();
  }
}

/* ----------------------------------------------------------------------
   where the region is now, also for those who ask it themselves
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::place(int k, const PeridemMoment &now)
{
  auto &one = primitives[k];
  Region *const region = one.region;
  for (int m = 0; m < 3; m++) one.shift[m] = now.between(one.start[m], one.goal[m]);
  one.angle = now.between(one.start[3], one.goal[3]);
  if (region->moveflag) {
    region->dx = one.shift[0];
    region->dy = one.shift[1];
    region->dz = one.shift[2];
  }
  if (!region->rotateflag) return;
  region->theta = one.angle;
  for (int m = 0; m < 3; m++) rigid[k].point[m] = Kin::point_of(region)[m] + one.shift[m];
}

/* ---------------------------------------------------------------------- */

bool PeridemSurfaceRegion::changes_shape() const
{
  for (const auto &one : primitives)
    if (one.region->varshape) return true;
  return false;
}

/* ---------------------------------------------------------------------- */

void PeridemSurfaceRegion::feet(const double *x, double cutoff, std::vector<Foot> &list)
{
  feet_of(whole, x, cutoff, list);
}

/* ----------------------------------------------------------------------
   Grains that must be in all parts feel each part by itself, as if each were a wall: the force
   never jumps.  Grains that may be in any part feel those faces that are not inside another part.
   The same is meant in Region::surface of unions and intersections, which turn faces of
   rotating parts twice (2026), or find no face at all (unions of side out).
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::feet_of(Region *region, const double *x, double cutoff,
                                   std::vector<Foot> &list)
{
  if (!is_composite(region)) {
    feet_of_primitive(index_of(region), x, cutoff, list);
    return;
  }
  const bool any = grains_in_any(region);
  Inverted inverted(region);
  auto hidden = [&](const double *at, int mine) {
    for (int k = 0; k < region->nregion; k++) {
      Region *const other = region->reglist[k];
      if (k != mine && !other->openflag && other->match(at[0], at[1], at[2])) return true;
    }
    return false;
  };
  for (int k = 0; k < region->nregion; k++) {
    std::size_t kept = list.size();
    feet_of(region->reglist[k], x, cutoff, list);
    if (!any) continue;
    for (std::size_t n = kept; n < list.size(); n++)
      if (!hidden(list[n].at, k)) list[kept++] = list[n];
    list.resize(kept);
  }
}

/* ---------------------------------------------------------------------- */

void PeridemSurfaceRegion::feet_of_primitive(int k, const double *x, double cutoff,
                                             std::vector<Foot> &list)
{
  const auto &one = primitives[k];
  const auto &part = rigid[k];
  const int count = peridem_region_faces(one.region, domain->dimension, x, cutoff);
  for (int c = 0; c < count; c++) {
    const auto &contact = one.region->contact[c];
    if (!(contact.r > 0.0)) continue;    // there is no direction to push in
    if (is_end_in_2d(one.region, c)) continue;
    Foot foot;
    foot.key = one.first_key + contact.iwall;
    foot.part = k;
    foot.distance = contact.r;
    const double del[3] = {contact.delx, contact.dely, contact.delz};
    double arm[3];
    for (int m = 0; m < 3; m++) {
      foot.normal[m] = del[m] / contact.r;
      foot.at[m] = x[m] - del[m];
      arm[m] = foot.at[m] - part.point[m];
    }
    foot.velocity[0] = part.velocity[0] + part.spin[1] * arm[2] - part.spin[2] * arm[1];
    foot.velocity[1] = part.velocity[1] + part.spin[2] * arm[0] - part.spin[0] * arm[2];
    foot.velocity[2] = part.velocity[2] + part.spin[0] * arm[1] - part.spin[1] * arm[0];
    if (one.region->varshape && contact.varflag)
      one.region->velocity_contact_shape(foot.velocity, foot.at);
    list.push_back(foot);
  }
}

/* ----------------------------------------------------------------------
   the ends of a region that the plane of a 2d simulation cuts are no walls
------------------------------------------------------------------------- */

bool PeridemSurfaceRegion::is_end_in_2d(const Region *region, int c) const
{
  const auto &contact = region->contact[c];
  return domain->dimension == 2 && std::fabs(contact.delz) > 0.5 * contact.r;
}

/* ----------------------------------------------------------------------
   any face of any part counts, also those that another part hides now
------------------------------------------------------------------------- */

bool PeridemSurfaceRegion::near(const double *x, double reach)
{
  for (const auto &one : primitives) {
    Region *const region = one.region;
    bool found = false;
    for (int side = 0; side < 2; side++) {
      const int count = peridem_region_faces(region, domain->dimension, x, reach);
      for (int c = 0; c < count && !found; c++) found = !is_end_in_2d(region, c);
      region->interior ^= 1;    // twice
    }
    if (found) return true;
  }
  return false;
}

/* ---------------------------------------------------------------------- */

void PeridemSurfaceRegion::mark()
{
  for (auto &one : primitives) {
    for (int m = 0; m < 3; m++) one.marked_shift[m] = one.shift[m];
    one.marked_angle = one.angle;
    one.marked_size = one.size;
  }
}

/* ---------------------------------------------------------------------- */

double PeridemSurfaceRegion::drift(const double *low, const double *high) const
{
  double largest = 0.0;
  for (std::size_t k = 0; k < primitives.size(); k++) {
    const auto &one = primitives[k];
    double way = 0.0, arm = 0.0;    // arm: from the axis to the farthest corner of the box
    for (int m = 0; m < 3; m++) {
      const double step = one.shift[m] - one.marked_shift[m];
      const double p = rigid[k].point[m];
      const double far = MAX(std::fabs(low[m] - p), std::fabs(high[m] - p));
      way += step * step;
      arm += far * far;
    }
    way = std::sqrt(way) + std::sqrt(arm) * std::fabs(one.angle - one.marked_angle) +
        std::fabs(one.size - one.marked_size);
    largest = MAX(largest, way);
  }
  return largest;
}

/* ---------------------------------------------------------------------- */

bool PeridemSurfaceRegion::permits(const double *x)
{
  return whole->match(x[0], x[1], x[2]) != 0;
}

/* ----------------------------------------------------------------------
   torques are about the point on the axis of the first part that rotates, else about the origin
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::centre(double *where) const
{
  for (int m = 0; m < 3; m++) where[m] = 0.0;
  for (std::size_t k = 0; k < primitives.size(); k++) {
    if (!primitives[k].region->rotateflag) continue;
    for (int m = 0; m < 3; m++) where[m] = rigid[k].point[m];
    return;
  }
}

/* ---------------------------------------------------------------------- */

std::vector<double> PeridemSurfaceRegion::state() const
{
  std::vector<double> list;
  for (std::size_t k = 0; k < primitives.size(); k++) {
    const auto &one = primitives[k];
    list.push_back(one.known ? 1.0 : 0.0);
    for (const double s : one.shift) list.push_back(s);
    list.push_back(one.angle);
    list.push_back(one.size);
    list.push_back(one.size_before);
    for (const double v : rigid[k].velocity) list.push_back(v);
    for (const double w : rigid[k].spin) list.push_back(w);
  }
  return list;
}

/* ----------------------------------------------------------------------
   of another region: its motion is not known yet
------------------------------------------------------------------------- */

void PeridemSurfaceRegion::restore(const double *list, int count)
{
  if (count != STATE * static_cast<int>(primitives.size())) return;
  for (std::size_t k = 0; k < primitives.size(); k++) {
    auto &one = primitives[k];
    one.known = *list++ != 0.0;
    for (double &s : one.shift) s = *list++;
    one.angle = *list++;
    one.size = *list++;
    one.size_before = *list++;
    for (double &v : rigid[k].velocity) v = *list++;
    for (double &w : rigid[k].spin) w = *list++;
  }
}
