/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Any LAMMPS region as the surface of a wall: also one that moves and rotates, and unions and
// intersections of such.

#ifndef LMP_PERIDEM_SURFACE_REGION_H
#define LMP_PERIDEM_SURFACE_REGION_H

#include "peridem_surface.h"

namespace LAMMPS_NS {

class Region;

class PeridemSurfaceRegion : public PeridemSurface {
 public:
  // arg[iarg] is the word region, behind it comes its ID
  PeridemSurfaceRegion(class LAMMPS *, const char *style, int iarg, int narg, char **arg);
  static constexpr int WORDS = 2;

  void init() override;
  void advance(const PeridemMoment &) override;
  void feet(const double *x, double cutoff, std::vector<Foot> &) override;
  bool near(const double *x, double reach) override;
  void mark() override;
  double drift(const double *low, const double *high) const override;
  bool permits(const double *x) override;
  int most_feet() const override { return most; }
  bool moves() const override;
  bool changes_shape() const override;
  bool pushes_back() const override { return false; }
  const std::vector<Part> &parts() const override { return rigid; }
  void centre(double *) const override;
  std::string wrong_side() const override { return "on the wrong side of region " + id; }
  std::string right_side() const override
  {
    return "grains must be inside a region of side in, outside one of side out";
  }
  std::vector<double> state() const override;
  void restore(const double *, int) override;

 private:
  // a region that is not made of others, and where it was
  struct Primitive {
    Region *region{nullptr};
    int first_key{0};
    bool known{false};    // the numbers below are of some step
    double shift[3]{0.0, 0.0, 0.0};
    double angle{0.0};
    double start[4]{0.0, 0.0, 0.0, 0.0}, goal[4]{0.0, 0.0, 0.0, 0.0};    // of this step of the run
    double size{0.0};           // radius, where a variable sets it
    double size_before{0.0};    // a step earlier
    double marked_shift[3]{0.0, 0.0, 0.0}, marked_angle{0.0}, marked_size{0.0};
  };
  static constexpr int STATE = 13;    // numbers of a primitive in a restart

  std::string style, id;
  Region *whole{nullptr};
  int most{0};
  bool warned{false};
  std::vector<Primitive> primitives;
  std::vector<Part> rigid;    // how each primitive moves

  void find();
  void collect(Region *);
  void check(Region *);
  int index_of(const Region *) const;
  void feet_of(Region *, const double *x, double cutoff, std::vector<Foot> &);
  void feet_of_primitive(int, const double *x, double cutoff, std::vector<Foot> &);
  void look_ahead(int, const PeridemMoment &);
  void follow_shape(Primitive &, bool compare);
  void place(int, const PeridemMoment &);
  bool is_end_in_2d(const Region *, int c) const;
};

}    // namespace LAMMPS_NS

#endif
