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

#include "peridem_families.h"

#include "peridem_cells.h"
#include "peridem_compat.h"
#include "peridem_cut.h"
#include "peridem_material.h"
#include "peridem_messages.h"

#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

using namespace LAMMPS_NS;

// edge of a block, in reaches: larger means fewer copies of nodes near block faces, smaller means
// more ranks share a large grain
static constexpr double BLOCK = 8.0;

// blocks are numbered by whole numbers in doubles: there are no neighbours beyond this one
static constexpr double COUNTABLE = 1.0e15;

// Influence times partial volume below which a pair is no bond: it would carry no force, and yet
// keep its nodes from touching. On lattices the linear influence function is 0, to the last digit,
// for nodes exactly on the horizon.
static constexpr double WEIGHTLESS = 1.0e-6;

// of a family as it travels: local index, weighted volume, volume, bonds without and with cuts
static constexpr std::size_t HEADER = 5;

// Numbers in a piece of what was found: so many that malloc has the memory from the system, gives it
// back when the piece goes, and does not touch what a piece does not need. A family has room behind.
static constexpr std::size_t PIECE = 5000000, ROOM = 20000;

// a node as it travels to the ranks that need it; all numbers are exact in a double
struct PeridemFamilies::Node {
  double tag, mol, type, volume;
  double X[3], shift[3];    // reference position, and the periodic image that this copy is
  double x[3];              // present position
  double block[3];
  double home;    // 1 if the family of this copy is wanted in this block
  double owner, local;
};

// those that the horizon of a node reaches, and the one that it is in
struct PeridemFamilies::Blocks {
  double first[3]{}, last[3]{}, home[3]{};
  bool near_box{true};    // could a node in the box be its partner?
};

/* ---------------------------------------------------------------------- */

PeridemFamilies::PeridemFamilies(LAMMPS *lmp, MaterialOf _material, const PeridemCuts &_cuts,
                                 double _reach) :
    Pointers(lmp), material(std::move(_material)), cuts(_cuts), reach(_reach)
{
}

/* ---------------------------------------------------------------------- */

void PeridemFamilies::build(const std::vector<int> &nodes)
{
  check_ids();
  auto mine = nodes_of_blocks(nodes);
  auto key = [](const Node &n) {
    return std::tie(n.mol, n.block[0], n.block[1], n.block[2]);
  };
  std::sort(mine.begin(), mine.end(), [&](const Node &a, const Node &b) {
    return key(a) < key(b);
  });

  longest_now = 0.0;
  nbonds = 0;
  std::vector<Numbers> answers(comm->nprocs);
  for (std::size_t begin = 0, end = 0; begin < mine.size(); begin = end) {
    while (end < mine.size() && key(mine[end]) == key(mine[begin])) end++;
    families_of_block(&mine[begin], &mine[begin] + (end - begin), answers);
  }
  MPI_Allreduce(MPI_IN_PLACE, &longest_now, 1, MPI_DOUBLE, MPI_MAX, world);
  if (comm->nprocs > 1) found.push_back(PeridemMessages::exchange(world, answers));
  for (const auto &piece : found)
    for (std::size_t m = 0; m < piece.size();) {
      const auto count = read(&piece[m]).count;
      nbonds += count;
      m += HEADER + 2 * count;
    }
}

/* ---------------------------------------------------------------------- */

std::vector<PeridemFamilies::Node>
PeridemFamilies::nodes_of_blocks(const std::vector<int> &nodes) const
{
  const auto received = PeridemMessages::exchange(world, send_nodes(nodes));
  const std::size_t width = sizeof(Node) / sizeof(double);
  const auto *const first = reinterpret_cast<const Node *>(received.data());
  return {first, first + received.size() / width};
}

/* ---------------------------------------------------------------------- */

PeridemFamilies::Family PeridemFamilies::read(const double *numbers)
{
  return {static_cast<int>(numbers[0]),
          numbers[1],
          numbers[2],
          static_cast<int>(numbers[3]),
          static_cast<std::size_t>(numbers[4]),
          numbers + HEADER};
}

/* ---------------------------------------------------------------------- */

void PeridemFamilies::hand_over(const std::function<void(const Family &)> &take)
{
  for (auto &piece : found) {
    for (std::size_t m = 0; m < piece.size();) {
      const auto family = read(&piece[m]);
      take(family);
      m += HEADER + 2 * family.count;
    }
    Numbers().swap(piece);
  }
  found.clear();
}

/* ----------------------------------------------------------------------
   Bonds know their partners by ID, and LAMMPS does not look whether a data file has one twice.
   Each ID goes to one rank, where equal ones meet.
------------------------------------------------------------------------- */

void PeridemFamilies::check_ids() const
{
  std::vector<std::vector<double>> outgoing(comm->nprocs);
  for (int i = 0; i < atom->nlocal; i++)
    outgoing[atom->tag[i] % comm->nprocs].push_back(static_cast<double>(atom->tag[i]));
  auto ids = PeridemMessages::exchange(world, outgoing);
  std::sort(ids.begin(), ids.end());
  const auto twice = std::adjacent_find(ids.begin(), ids.end());
  tagint first = twice == ids.end() ? MAXTAGINT : static_cast<tagint>(*twice);
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_LMP_TAGINT, MPI_MIN, world);
  if (first < MAXTAGINT)
    error->all(FLERR, Error::NOLASTLINE,
               "Atom-ID {} is given to more than one node: number the nodes anew, each with an ID "
               "of its own",
               first);
}

/* ----------------------------------------------------------------------
   each node goes to every block that its horizon reaches, and so do its periodic images
------------------------------------------------------------------------- */

std::vector<std::vector<double>> PeridemFamilies::send_nodes(const std::vector<int> &nodes) const
{
  std::vector<std::vector<double>> outgoing(comm->nprocs);
  for (int i : nodes) send_images(i, outgoing);
  return outgoing;
}

/* ---------------------------------------------------------------------- */

void PeridemFamilies::send_images(int i, std::vector<std::vector<double>> &outgoing) const
{
  const int dim = domain->dimension;
  const int px = domain->xperiodic, py = domain->yperiodic, pz = dim == 3 ? domain->zperiodic : 0;
  const double *const X = atom->x0[i], *const x = atom->x[i];

  Node node{static_cast<double>(atom->tag[i]),
            static_cast<double>(atom->molecule[i]),
            static_cast<double>(atom->type[i]),
            atom->vfrac[i],
            {X[0], X[1], X[2]},
            {},
            {x[0], x[1], x[2]},
            {},
            0.0,
            static_cast<double>(comm->me),
            static_cast<double>(i)};
  for (int iz = -pz; iz <= pz; iz++)
    for (int iy = -py; iy <= py; iy++)
      for (int ix = -px; ix <= px; ix++) {
        node.shift[0] = ix * domain->xprd + iy * domain->xy + iz * domain->xz;
        node.shift[1] = iy * domain->yprd + iz * domain->yz;
        node.shift[2] = iz * domain->zprd;
        send_image(node, ix || iy || iz, outgoing);
      }
}

/* ---------------------------------------------------------------------- */

void PeridemFamilies::send_image(Node &node, bool image,
                                 std::vector<std::vector<double>> &outgoing) const
{
  const Blocks blocks = blocks_of(node);
  if (image && !blocks.near_box) return;
  const auto mol = static_cast<tagint>(node.mol);
  for (double bz = blocks.first[2]; bz <= blocks.last[2]; bz++)
    for (double by = blocks.first[1]; by <= blocks.last[1]; by++)
      for (double bx = blocks.first[0]; bx <= blocks.last[0]; bx++) {
        node.block[0] = bx;
        node.block[1] = by;
        node.block[2] = bz;
        node.home = !image && bx == blocks.home[0] && by == blocks.home[1] && bz == blocks.home[2];
        auto &out = outgoing[rank_of_block(mol, node.block)];
        const auto *const raw = reinterpret_cast<const double *>(&node);
        out.insert(out.end(), raw, raw + sizeof(Node) / sizeof(double));
      }
}

/* ---------------------------------------------------------------------- */

PeridemFamilies::Blocks PeridemFamilies::blocks_of(const Node &node) const
{
  const double *const lo = domain->triclinic ? domain->boxlo_bound : domain->boxlo;
  const double *const hi = domain->triclinic ? domain->boxhi_bound : domain->boxhi;
  const double edge = BLOCK * reach;
  Blocks blocks;
  for (int k = 0; k < domain->dimension; k++) {
    const double P = node.X[k] + node.shift[k];
    if (std::fabs(P) > COUNTABLE * edge)
      error->one(FLERR,
                 "Node {} of grain {} is at {:.6g}, too far away to be counted in horizons of "
                 "{:.6g}: is that the right unit of length?",
                 static_cast<tagint>(node.tag), static_cast<tagint>(node.mol), P, reach);
    if (P < lo[k] - reach || P > hi[k] + reach) blocks.near_box = false;
    blocks.first[k] = std::floor((P - reach) / edge);
    blocks.last[k] = std::floor((P + reach) / edge);
    blocks.home[k] = std::floor(P / edge);
  }
  return blocks;
}

/* ---------------------------------------------------------------------- */

int PeridemFamilies::rank_of_block(tagint mol, const double *block) const
{
  std::uint64_t hash = static_cast<std::uint64_t>(mol);
  for (int k = 0; k < 3; k++)
    hash = (hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(block[k]))) *
            UINT64_C(0x9E3779B97F4A7C15) +
        (hash >> 29);
  return static_cast<int>((hash >> 16) % static_cast<std::uint64_t>(comm->nprocs));
}

/* ----------------------------------------------------------------------
   all nodes of the grain within the horizon of one, by increasing tag
------------------------------------------------------------------------- */

void PeridemFamilies::find_partners(const Node &node, const Node *first, const PeridemCells &cells,
                                    Row &row) const
{
  row.clear();
  cells.near(node.X, [&](const PeridemCells::Point &p) {
    const Node &other = first[p.id];
    if (&other == &node) return;
    const auto *mat = material(static_cast<int>(node.type), static_cast<int>(other.type));
    if (!mat) return;
    double rsq = 0.0;
    for (int k = 0; k < 3; k++) {
      // grouped so that the other end finds exactly the same length
      const double d = (other.X[k] - node.X[k]) + other.shift[k];
      rsq += d * d;
    }
    const double R = std::sqrt(rsq);
    if (R > mat->horizon * (1.0 + SLACK)) return;
    if (R == 0.0)
      error->one(FLERR, "Nodes {:.0f} and {:.0f} of grain {:.0f} have the same reference position",
                 node.tag, other.tag, node.mol);
    if (volume_and_influence(*mat, node, other, R) < WEIGHTLESS) return;
    row.push_back({{static_cast<tagint>(other.tag), R}, &other});
  });
  std::sort(row.begin(), row.end(), [](const auto &a, const auto &b) {
    return a.first.tag < b.first.tag;
  });
  for (std::size_t k = 0; k < row.size(); k++)
    if (row[k].second->tag == node.tag || (k && row[k].first.tag == row[k - 1].first.tag))
      error->one(FLERR,
                 "Node {:.0f} is bonded to node {:.0f} twice, or to itself, through the periodic "
                 "boundary: the box must be longer than two horizons",
                 node.tag, row[k].second->tag);
}

/* ----------------------------------------------------------------------
   sums over the whole reference family, cut bonds included
------------------------------------------------------------------------- */

void PeridemFamilies::weigh(const Node &node, const Row &row, double &wvolume, double &volume)
{
  wvolume = volume = 0.0;
  for (const auto &entry : row) {
    const Node &other = *entry.second;
    const auto *mat = material(static_cast<int>(node.type), static_cast<int>(other.type));
    const double R = entry.first.length;
    const double vV = mat->volume_factor(R, cell_size(*mat, node, other)) * other.volume;
    volume += vV;
    wvolume += mat->influence(R / mat->horizon) * R * R * vV;

    double d[3] = {other.x[0] - node.x[0], other.x[1] - node.x[1], other.x[2] - node.x[2]};
    PeridemCompat::minimum_image(domain, d);
    longest_now = std::max(longest_now, std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
  }
}

/* ---------------------------------------------------------------------- */

double PeridemFamilies::cell_size(const PeridemMaterial &mat, const Node &a, const Node &b) const
{
  if (mat.cell > 0.0) return mat.cell;
  const double power = 1.0 / domain->dimension;
  return 0.5 * (std::pow(a.volume, power) + std::pow(b.volume, power));
}

/* ---------------------------------------------------------------------- */

double PeridemFamilies::volume_and_influence(const PeridemMaterial &mat, const Node &a,
                                             const Node &b, double R) const
{
  return mat.influence(R / mat.horizon) * mat.volume_factor(R, cell_size(mat, a, b));
}

/* ----------------------------------------------------------------------
   where the next family that a rank wants has its place
------------------------------------------------------------------------- */

PeridemFamilies::Numbers &PeridemFamilies::answer_for(int rank, std::vector<Numbers> &answers)
{
  if (rank != comm->me) return answers[rank];
  if (found.empty() || found.back().size() > PIECE) {
    found.emplace_back();
    found.back().reserve(PIECE + ROOM);
  }
  return found.back();
}

/* ----------------------------------------------------------------------
   nodes first to last are those of one grain that reach one block
------------------------------------------------------------------------- */

void PeridemFamilies::families_of_block(const Node *first, const Node *last,
                                        std::vector<Numbers> &answers)
{
  std::vector<PeridemCells::Point> points(last - first);
  for (std::size_t m = 0; m < points.size(); m++) {
    for (int k = 0; k < 3; k++) points[m].x[k] = first[m].X[k] + first[m].shift[k];
    points[m].id = static_cast<int>(m);
  }
  const PeridemCells cells(std::move(points), reach);

  Row row;
  for (const auto *node = first; node < last; node++) {
    if (node->home == 0.0) continue;
    find_partners(*node, first, cells, row);
    double wvolume, volume;
    weigh(*node, row, wvolume, volume);

    const auto reference = static_cast<double>(row.size());
    if (!cuts.empty())
      row.erase(std::remove_if(row.begin(), row.end(),
                               [&](const auto &entry) {
                                 return is_cut(*node, *entry.second);
                               }),
                row.end());
    auto &answer = answer_for(static_cast<int>(node->owner), answers);
    answer.insert(answer.end(),
                  {node->local, wvolume, volume, reference, static_cast<double>(row.size())});
    for (const auto &entry : row)
      answer.insert(answer.end(), {static_cast<double>(entry.first.tag), entry.first.length});
  }
}

/* ----------------------------------------------------------------------
   seen from the lower ID, so that both ends of a bond find the same
------------------------------------------------------------------------- */

bool PeridemFamilies::is_cut(const Node &node, const Node &other) const
{
  double d[3];
  const bool lower = node.tag < other.tag;
  for (int k = 0; k < 3; k++) {
    d[k] = (other.X[k] - node.X[k]) + other.shift[k];
    if (!lower) d[k] = -d[k];
  }
  return cuts.crosses(lower ? node.X : other.X, d);
}
