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

#include "peridem_pieces.h"

#include "fix_peridem_bonds.h"

#include "atom.h"

#include <algorithm>

using namespace LAMMPS_NS;

// nodes whose bonds are looked at one after the other are that far apart
static constexpr int STRIDE = 8;

/* ---------------------------------------------------------------------- */

void PeridemPieces::start(const FixPeridemBonds *_bonds)
{
  bonds = _bonds;
  labels.assign(atom->nlocal, 0);
  above.resize(atom->nlocal);
}

/* ----------------------------------------------------------------------
   ghosts may be images of owned nodes
------------------------------------------------------------------------- */

int PeridemPieces::owned(int j) const
{
  if (j >= atom->nlocal) j = atom->map(atom->tag[j]);
  return j < atom->nlocal ? j : -1;
}

/* ---------------------------------------------------------------------- */

int PeridemPieces::root(int i)
{
  while (above[i] != i) {
    above[i] = above[above[i]];
    i = above[i];
  }
  return i;
}

/* ---------------------------------------------------------------------- */

template <class Visit> void PeridemPieces::for_partners(int i, Visit visit) const
{
  if (!bonds) return;
  for (bigint k = bonds->start[i]; k < bonds->start[i] + bonds->num[i]; k++)
    visit(atom->map(bonds->ptag[k]));
}

/* ----------------------------------------------------------------------
   bonds only break, so a grain never has fewer pieces than it had: with that many, all is known
------------------------------------------------------------------------- */

int PeridemPieces::label(const int *begin, const int *end, int least)
{
  const tagint *const tag = atom->tag;
  int count = static_cast<int>(end - begin);
  for (const int *n = begin; n < end; n++) above[*n] = *n;
  auto unite = [&](int n, int k) {
    const int j = owned(k);
    if (j < 0 || above[j] == above[n]) return;
    const int a = root(n), b = root(j);
    if (a == b) return;
    above[tag[a] < tag[b] ? b : a] = tag[a] < tag[b] ? a : b;
    count--;
  };
  // every eighth node first, whose partners are nearly all
  for (int pass = 0; pass < STRIDE; pass++)
    for (const int *n = begin + pass; n < end && count > least; n += STRIDE)
      for_partners(*n, [&](int k) {
        unite(*n, k);
      });
  for (const int *n = begin; n < end; n++) labels[*n] = tag[root(*n)];
  return count;
}

/* ---------------------------------------------------------------------- */

void PeridemPieces::add_links(const int *begin, const int *end, std::vector<Link> &links) const
{
  for (const int *n = begin; n < end; n++)
    for_partners(*n, [&](int k) {
      if (owned(k) < 0) links.push_back({labels[*n], atom->tag[*n], atom->tag[k]});
    });
}

/* ----------------------------------------------------------------------
   each bond between two ranks is listed by both: its two ends name their pieces
------------------------------------------------------------------------- */

void PeridemPieces::join(const std::vector<Link> &links)
{
  joints.clear();
  for (const auto &link : links) joints.push_back({link.piece, link.piece});
  std::sort(joints.begin(), joints.end(), [](const Joint &a, const Joint &b) {
    return a.piece < b.piece;
  });
  joints.erase(std::unique(joints.begin(), joints.end(),
                           [](const Joint &a, const Joint &b) {
                             return a.piece == b.piece;
                           }),
               joints.end());

  auto sorted = links;
  std::sort(sorted.begin(), sorted.end(), [](const Link &a, const Link &b) {
    return a.node < b.node;
  });
  for (const auto &link : links) {
    auto other = std::lower_bound(sorted.begin(), sorted.end(), link.partner,
                                  [](const Link &one, tagint node) {
                                    return one.node < node;
                                  });
    if (other == sorted.end() || other->node != link.partner) continue;
    const tagint a = root_of(link.piece), b = root_of(other->piece);
    if (a != b) joint_of(MAX(a, b))->into = MIN(a, b);
  }
}

/* ---------------------------------------------------------------------- */

PeridemPieces::Joint *PeridemPieces::joint_of(tagint piece)
{
  auto found =
      std::lower_bound(joints.begin(), joints.end(), piece, [](const Joint &one, tagint what) {
        return one.piece < what;
      });
  return found == joints.end() || found->piece != piece ? nullptr : &*found;
}

/* ---------------------------------------------------------------------- */

tagint PeridemPieces::root_of(tagint piece)
{
  for (const Joint *joint = joint_of(piece); joint && joint->into != piece; joint = joint_of(piece))
    piece = joint->into;
  return piece;
}

/* ---------------------------------------------------------------------- */

void PeridemPieces::relabel(const int *begin, const int *end)
{
  for (const int *n = begin; n < end; n++) labels[*n] = root_of(labels[*n]);
}

/* ---------------------------------------------------------------------- */

bool PeridemPieces::still_tied(int i, int j) const
{
  const tagint wanted = atom->tag[j];
  bool tied = false;
  for_partners(i, [&](int k) {
    const int m = owned(k);
    if (m >= 0 && bonds->bonded(m, wanted)) tied = true;
  });
  return tied;
}
