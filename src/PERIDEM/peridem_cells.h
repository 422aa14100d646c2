/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Points sorted into the cells of a grid: all points near a place, in time that does not depend on
// how many there are elsewhere.  Used for reference configurations, where LAMMPS's neighbour lists
// (which look at current positions) do not help.

#ifndef LMP_PERIDEM_CELLS_H
#define LMP_PERIDEM_CELLS_H

#include <algorithm>
#include <cmath>
#include <vector>

namespace LAMMPS_NS {

class PeridemCells {
 public:
  struct Point {
    double x[3];
    int id;
  };

  // reach: distance within which points will be asked for
  PeridemCells(std::vector<Point> &&_points, double reach) : points(std::move(_points))
  {
    if (points.empty()) return;
    double hi[3];
    for (int k = 0; k < 3; k++) lo[k] = hi[k] = points[0].x[k];
    for (const auto &p : points)
      for (int k = 0; k < 3; k++) {
        lo[k] = std::min(lo[k], p.x[k]);
        hi[k] = std::max(hi[k], p.x[k]);
      }
    // cells no smaller than the reach, and not many more cells than points
    size = reach;
    while (count(hi) > 4.0 * points.size() + 64.0) size *= 1.5;
    for (int k = 0; k < 3; k++) n[k] = static_cast<int>((hi[k] - lo[k]) / size) + 1;

    first.assign(static_cast<std::size_t>(n[0]) * n[1] * n[2] + 1, 0);
    for (const auto &p : points) first[cell(p.x) + 1]++;
    for (std::size_t c = 1; c < first.size(); c++) first[c] += first[c - 1];
    order.resize(points.size());
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < points.size(); i++) order[next[cell(points[i].x)]++] = i;
  }

  // calls visit(point) for every point in the cells around x, which hold all within the reach
  template <class Visit> void near(const double *x, Visit visit) const
  {
    if (points.empty()) return;
    int c0[3], c1[3];
    for (int k = 0; k < 3; k++) {
      const double where = std::floor((x[k] - lo[k]) / size);
      if (where < -1.0 || where > n[k]) return;    // further than the reach from any point
      c0[k] = std::max(0, static_cast<int>(where) - 1);
      c1[k] = std::min(n[k] - 1, static_cast<int>(where) + 1);
    }
    for (int iz = c0[2]; iz <= c1[2]; iz++)
      for (int iy = c0[1]; iy <= c1[1]; iy++) {
        const std::size_t row = (static_cast<std::size_t>(iz) * n[1] + iy) * n[0];
        for (std::size_t m = first[row + c0[0]]; m < first[row + c1[0] + 1]; m++)
          visit(points[order[m]]);
      }
  }

 private:
  std::vector<Point> points;
  std::vector<std::size_t> first, order;
  double lo[3], size{1.0};
  int n[3]{1, 1, 1};

  double count(const double *hi) const
  {
    double product = 1.0;
    for (int k = 0; k < 3; k++) product *= std::floor((hi[k] - lo[k]) / size) + 1.0;
    return product;
  }

  std::size_t cell(const double *x) const
  {
    std::size_t c[3];
    for (int k = 0; k < 3; k++) c[k] = std::min(n[k] - 1, static_cast<int>((x[k] - lo[k]) / size));
    return (c[2] * n[1] + c[1]) * n[0] + c[0];
  }
};

}    // namespace LAMMPS_NS

#endif
