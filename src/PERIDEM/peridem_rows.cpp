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

#include "peridem_rows.h"

#include "memory.h"

#include <algorithm>

using namespace LAMMPS_NS;

// parts of the pool that may be gaps, and of the nodes whose rows may be out of order
static constexpr double MOST_GAPS = 0.05, MOST_STRAYS = 0.05;

/* ---------------------------------------------------------------------- */

PeridemRows::~PeridemRows()
{
  storage->destroy(start);
  storage->destroy(num);
  storage->destroy(nref);
  storage->destroy(wvolume);
  storage->destroy(famvolume);
  storage->destroy(maxstretch);
  storage->destroy(known_id);
}

/* ---------------------------------------------------------------------- */

void PeridemRows::grow_rows(int nmax)
{
  storage->grow(start, nmax, "peridem/bonds:start");
  storage->grow(num, nmax, "peridem/bonds:num");
  storage->grow(nref, nmax, "peridem/bonds:nref");
  storage->grow(wvolume, nmax, "peridem/bonds:wvolume");
  storage->grow(famvolume, nmax, "peridem/bonds:famvolume");
  storage->grow(maxstretch, nmax, "peridem/bonds:maxstretch");
  storage->grow(known_id, nmax, "peridem/bonds:known_id");
}

/* ---------------------------------------------------------------------- */

void PeridemRows::empty_row(int i)
{
  start[i] = 0;
  num[i] = -1;
  nref[i] = 0;
  wvolume[i] = famvolume[i] = maxstretch[i] = 0.0;
  known_id[i] = 0;
}

/* ---------------------------------------------------------------------- */

void PeridemRows::copy_row(int i, int j)
{
  start[j] = start[i];
  num[j] = num[i];
  nref[j] = nref[i];
  wvolume[j] = wvolume[i];
  famvolume[j] = famvolume[i];
  maxstretch[j] = maxstretch[i];
  known_id[j] = known_id[i];
}

/* ---------------------------------------------------------------------- */

int PeridemRows::pack_row(int i, double *buf) const
{
  int m = 0;
  buf[m++] = ubuf(num[i]).d;
  buf[m++] = ubuf(nref[i]).d;
  buf[m++] = wvolume[i];
  buf[m++] = famvolume[i];
  buf[m++] = maxstretch[i];
  buf[m++] = ubuf(known_id[i]).d;
  for (bigint k = start[i]; k < start[i] + num[i]; k++) {
    buf[m++] = ubuf(ptag[k]).d;
    buf[m++] = length[k];
  }
  return m;
}

/* ---------------------------------------------------------------------- */

int PeridemRows::unpack_row(int i, const double *buf)
{
  int m = 0;
  num[i] = (int) ubuf(buf[m++]).i;
  nref[i] = (int) ubuf(buf[m++]).i;
  wvolume[i] = buf[m++];
  famvolume[i] = buf[m++];
  maxstretch[i] = buf[m++];
  known_id[i] = (tagint) ubuf(buf[m++]).i;
  drop_stored();
  start[i] = static_cast<bigint>(ptag.size());
  for (int k = 0; k < num[i]; k++) {
    const auto tag = (tagint) ubuf(buf[m++]).i;
    append(tag, buf[m++]);
  }
  return m;
}

/* ---------------------------------------------------------------------- */

void PeridemRows::append(tagint tag, double R)
{
  ptag.push_back(tag);
  length.push_back(R);
}

/* ---------------------------------------------------------------------- */

void PeridemRows::erase_bond(int i, bigint k)
{
  const bigint end = start[i] + num[i];
  auto shift = [k, end](auto &list) {
    std::copy(list.begin() + k + 1, list.begin() + end, list.begin() + k);
  };
  shift(ptag);
  shift(length);
  if (!partners.empty()) {
    shift(partners);
    shift(weights);
  }
  num[i]--;
}

/* ---------------------------------------------------------------------- */

bool PeridemRows::bonded(int i, tagint jtag) const
{
  if (num[i] <= 0) return false;
  const auto row = ptag.begin() + start[i];
  return std::binary_search(row, row + num[i], jtag);
}

/* ----------------------------------------------------------------------
   the pool grows by doubling unless it is told how much there will be
------------------------------------------------------------------------- */

void PeridemRows::reserve_pool(std::size_t more)
{
  ptag.reserve(ptag.size() + more);
  length.reserve(length.size() + more);
}

/* ---------------------------------------------------------------------- */

void PeridemRows::make_room_for_stored()
{
  partners.resize(ptag.size(), -1);
  weights.resize(ptag.size(), 0.0);
}

/* ---------------------------------------------------------------------- */

void PeridemRows::drop_stored()
{
  partners.clear();
  weights.clear();
}

/* ---------------------------------------------------------------------- */

int PeridemRows::longest_row(int nlocal) const
{
  return nlocal ? std::max(0, *std::max_element(num, num + nlocal)) : 0;
}

/* ----------------------------------------------------------------------
   Nodes that came, left or were sorted, and broken bonds, leave the pool in disorder and with gaps.
   Both cost whoever passes over all rows, and moving them costs as much as some passes.
------------------------------------------------------------------------- */

void PeridemRows::order_pool(int nlocal)
{
  bigint total = 0, end = 0, strays = 0;
  for (int i = 0; i < nlocal; i++) {
    if (num[i] <= 0) continue;    // without a solid nodes have no families: num is -1
    if (start[i] < end) strays++;
    end = start[i] + num[i];
    total += num[i];
  }
  const auto size = static_cast<bigint>(ptag.size());
  if (static_cast<double>(size - total) <= MOST_GAPS * static_cast<double>(total) &&
      static_cast<double>(strays) <= MOST_STRAYS * nlocal)
    return;

  // one after the other: a second copy of one of them, not of both
  copy_rows(ptag, nlocal, total);
  copy_rows(length, nlocal, total);
  drop_stored();
  bigint at = 0;
  for (int i = 0; i < nlocal; i++) {
    start[i] = at;
    at += std::max(num[i], 0);
  }
}

/* ---------------------------------------------------------------------- */

template <class T> void PeridemRows::copy_rows(std::vector<T> &from, int nlocal, bigint total) const
{
  std::vector<T> to;
  to.reserve(total);
  for (int i = 0; i < nlocal; i++)
    if (num[i] > 0) to.insert(to.end(), &from[start[i]], &from[start[i]] + num[i]);
  from.swap(to);
}

/* ---------------------------------------------------------------------- */

double PeridemRows::pool_bytes(int nmax) const
{
  double bytes = static_cast<double>(nmax) *
      (sizeof(bigint) + 2 * sizeof(int) + 3 * sizeof(double) + sizeof(tagint));
  bytes += static_cast<double>(ptag.capacity()) * sizeof(tagint);
  bytes += static_cast<double>(partners.capacity()) * sizeof(int);
  bytes += static_cast<double>(length.capacity() + weights.capacity()) * sizeof(double);
  return bytes;
}
