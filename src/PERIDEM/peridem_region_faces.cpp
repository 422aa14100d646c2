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

#include "peridem_region_faces.h"

#include "region.h"
#include "region_cone.h"
#include "region_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

using namespace LAMMPS_NS;

namespace {

// Regions keep their measures private; naming a member to instantiate a template is always allowed.

template <class Tag, typename Tag::type member> struct Opener {
  friend typename Tag::type open(Tag) { return member; }
};

#define PERIDEM_OPEN(tag, of, kind, member) \
  struct tag {                              \
    using type = kind of::*;                \
    friend type open(tag);                  \
  };                                        \
  template struct Opener<tag, &of::member>

PERIDEM_OPEN(ConeAxis, RegCone, char, axis);
PERIDEM_OPEN(ConeFirst, RegCone, double, c1);
PERIDEM_OPEN(ConeSecond, RegCone, double, c2);
PERIDEM_OPEN(ConeRadiusLow, RegCone, double, radiuslo);
PERIDEM_OPEN(ConeRadiusHigh, RegCone, double, radiushi);
PERIDEM_OPEN(ConeLow, RegCone, double, lo);
PERIDEM_OPEN(ConeHigh, RegCone, double, hi);
PERIDEM_OPEN(EllipsoidX, RegEllipsoid, double, xc);
PERIDEM_OPEN(EllipsoidY, RegEllipsoid, double, yc);
PERIDEM_OPEN(EllipsoidZ, RegEllipsoid, double, zc);
PERIDEM_OPEN(EllipsoidA, RegEllipsoid, double, a);
PERIDEM_OPEN(EllipsoidB, RegEllipsoid, double, b);
PERIDEM_OPEN(EllipsoidC, RegEllipsoid, double, c);

#undef PERIDEM_OPEN

// between where a region is now and where it was defined; its axis shows itself to its kin only

struct Place : public Region {
  static void turn(const Region *region, double *x, double angle)
  {
    const double *point = region->*(&Place::point), *axis = region->*(&Place::runit);
    const double c = std::cos(angle), s = std::sin(angle);
    double d[3], along = 0.0;
    for (int m = 0; m < 3; m++) d[m] = x[m] - point[m];
    for (int m = 0; m < 3; m++) along += axis[m] * d[m];
    for (int m = 0; m < 3; m++) {
      const int n = (m + 1) % 3, l = (m + 2) % 3;
      const double across = axis[n] * d[l] - axis[l] * d[n];
      x[m] = point[m] + c * d[m] + s * across + (1.0 - c) * along * axis[m];
    }
  }

  static void shift(const Region *region, double *x, double sign)
  {
    const double way[3] = {region->dx, region->dy, region->dz};
    for (int m = 0; m < 3; m++) x[m] += sign * way[m];
  }
};

// a face: where it is nearest, in the frame of the region

class Faces {
 public:
  Faces(Region *_region, const double *_x, double _cutoff) : region(_region), cutoff(_cutoff)
  {
    std::copy(_x, _x + 3, x);
    std::copy(_x, _x + 3, local);
    if (region->dynamic && region->moveflag) Place::shift(region, local, -1.0);
    if (region->dynamic && region->rotateflag) Place::turn(region, local, -region->theta);
  }

  const double *where() const { return local; }
  int found() const { return count; }

  void add(int face, double *nearest)
  {
    if (region->dynamic && region->rotateflag) Place::turn(region, nearest, region->theta);
    if (region->dynamic && region->moveflag) Place::shift(region, nearest, 1.0);
    auto &contact = region->contact[count];
    contact.delx = x[0] - nearest[0];
    contact.dely = x[1] - nearest[1];
    contact.delz = x[2] - nearest[2];
    contact.r = std::sqrt(contact.delx * contact.delx + contact.dely * contact.dely +
                          contact.delz * contact.delz);
    contact.iwall = face;
    if (contact.r < cutoff) count++;
  }

 private:
  Region *region;
  double cutoff, x[3], local[3];
  int count{0};
};

// --- cones: the half plane that holds the axis and the point ---------------------------------------

struct Flat {
  double r, h;    // distance from the axis, height along it
};

Flat nearest_on(const Flat &from, const Flat &to, const Flat &p)
{
  const double dr = to.r - from.r, dh = to.h - from.h;
  const double length2 = dr * dr + dh * dh;
  if (length2 == 0.0) return from;
  const double t = ((p.r - from.r) * dr + (p.h - from.h) * dh) / length2;
  const double share = std::min(std::max(t, 0.0), 1.0);
  return {from.r + share * dr, from.h + share * dh};
}

class Cone {
 public:
  Cone(const RegCone *cone, const double *x)
  {
    const char axis = cone->*open(ConeAxis());
    up = axis == 'x' ? 0 : axis == 'y' ? 1 : 2;
    first = up == 0 ? 1 : 0;
    second = up == 2 ? 1 : 2;
    centre[0] = cone->*open(ConeFirst());
    centre[1] = cone->*open(ConeSecond());
    low = {cone->*open(ConeRadiusLow()), cone->*open(ConeLow())};
    high = {cone->*open(ConeRadiusHigh()), cone->*open(ConeHigh())};
    way[0] = x[first] - centre[0];
    way[1] = x[second] - centre[1];
    p = {std::sqrt(way[0] * way[0] + way[1] * way[1]), x[up]};
    // on the axis all directions are as good
    way[0] = p.r > 0.0 ? way[0] / p.r : 1.0;
    way[1] = p.r > 0.0 ? way[1] / p.r : 0.0;
    const double radius = low.r + (p.h - low.h) * (high.r - low.r) / (high.h - low.h);
    inside = p.h >= low.h && p.h <= high.h && p.r <= radius;
  }

  // faces: 0 and 1 are the ends, 2 is the mantle; an end of radius 0 is none
  void from_inside(const int *is_open, Faces &faces) const
  {
    if (!is_open[2]) add(2, nearest_on(low, high, p), faces);
    if (!is_open[0] && low.r > 0.0) add(0, {p.r, low.h}, faces);
    if (!is_open[1] && high.r > 0.0) add(1, {p.r, high.h}, faces);
  }

  void from_outside(const int *is_open, Faces &faces) const
  {
    const Flat sides[3][2] = {{{0.0, low.h}, low}, {{0.0, high.h}, high}, {low, high}};
    double least = -1.0;
    Flat best{0.0, 0.0};
    for (int k = 0; k < 3; k++) {
      if (is_open[k]) continue;
      const Flat at = nearest_on(sides[k][0], sides[k][1], p);
      const double distance = std::hypot(p.r - at.r, p.h - at.h);
      if (least >= 0.0 && distance >= least) continue;
      least = distance;
      best = at;
    }
    if (least >= 0.0) add(0, best, faces);
  }

  bool inside;

 private:
  int up, first, second;
  double centre[2], way[2];
  Flat low, high, p;

  void add(int face, const Flat &at, Faces &faces) const
  {
    double nearest[3];
    nearest[up] = at.h;
    nearest[first] = centre[0] + at.r * way[0];
    nearest[second] = centre[1] + at.r * way[1];
    faces.add(face, nearest);
  }
};

int faces_of(const RegCone *region, Faces &faces)
{
  const Cone cone(region, faces.where());
  const bool both = region->openflag != 0;
  if (cone.inside && (both || region->interior)) cone.from_inside(region->open_faces, faces);
  if (!cone.inside && (both || !region->interior)) cone.from_outside(region->open_faces, faces);
  return faces.found();
}

// --- ellipsoids ----------------------------------------------------------------------------------

/* ----------------------------------------------------------------------
   The nearest point is e_i^2 x_i/(t + e_i^2) with the largest t at which it lies on the ellipsoid.
   sum (e_i x_i/(t + e_i^2))^2 falls and is convex there, so Newton's steps from below go to it
   without passing it.
------------------------------------------------------------------------- */

double multiplier(int d, const double *e, const double *x, double t)
{
  for (int step = 0; step < 200; step++) {
    double value = -1.0, slope = 0.0;
    for (int m = 0; m < d; m++) {
      if (x[m] == 0.0) continue;
      const double u = t + e[m] * e[m], q = e[m] * x[m] / u;
      value += q * q;
      slope += 2.0 * q * q / u;
    }
    const double next = t + value / slope;
    if (!(value > 0.0) || next == t) break;
    t = next;
  }
  return t;
}

// a point inside, in the plane of symmetry across the shortest axis, may be nearest to points beside it

bool beside(int d, const double *e, const double *x, int shortest, double *nearest)
{
  if (x[shortest] != 0.0) return false;
  double rest = 1.0;
  for (int m = 0; m < d; m++) {
    nearest[m] = 0.0;
    if (m == shortest || x[m] == 0.0) continue;
    if (!(e[m] > e[shortest])) return false;
    nearest[m] = e[m] * e[m] * x[m] / (e[m] * e[m] - e[shortest] * e[shortest]);
    rest -= nearest[m] * nearest[m] / (e[m] * e[m]);
  }
  if (rest < 0.0) return false;
  nearest[shortest] = e[shortest] * std::sqrt(rest);
  return true;
}

int faces_of(const RegEllipsoid *region, int d, Faces &faces)
{
  const double e[3] = {region->*open(EllipsoidA()), region->*open(EllipsoidB()),
                       region->*open(EllipsoidC())};
  const double centre[3] = {region->*open(EllipsoidX()), region->*open(EllipsoidY()),
                            region->*open(EllipsoidZ())};
  double x[3], nearest[3], size = 0.0, start = 0.0;
  for (int m = 0; m < d; m++) {
    x[m] = faces.where()[m] - centre[m];
    size += x[m] * x[m] / (e[m] * e[m]);
    const double low = std::fabs(e[m] * x[m]) - e[m] * e[m];
    start = m == 0 ? low : std::max(start, low);
  }
  if ((size <= 1.0) != (region->interior != 0)) return 0;
  const int shortest = static_cast<int>(std::min_element(e, e + d) - e);
  if (!beside(d, e, x, shortest, nearest)) {
    const double t = multiplier(d, e, x, start);
    for (int m = 0; m < d; m++)
      nearest[m] = x[m] == 0.0 ? 0.0 : e[m] * e[m] * x[m] / (t + e[m] * e[m]);
  }
  for (int m = 0; m < d; m++) nearest[m] += centre[m];
  if (d == 2) nearest[2] = faces.where()[2];
  faces.add(0, nearest);
  return faces.found();
}

}    // namespace

/* ---------------------------------------------------------------------- */

int LAMMPS_NS::peridem_region_faces(Region *region, int dimension, const double *x, double cutoff)
{
  const bool cone = strcmp(region->style, "cone") == 0;
  const bool ellipsoid = strcmp(region->style, "ellipsoid") == 0;
  if (!cone && !ellipsoid) return region->surface(x[0], x[1], x[2], cutoff);
  Faces faces(region, x, cutoff);
  if (cone) return faces_of(static_cast<const RegCone *>(region), faces);
  return faces_of(static_cast<const RegEllipsoid *>(region), dimension, faces);
}
