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

#include "peridem_sharing.h"

#include "comm.h"

#include <algorithm>
#include <map>
#include <utility>

using namespace LAMMPS_NS;

static constexpr int PARTS = 6031;    // tag of messages

/* ---------------------------------------------------------------------- */

int PeridemSharing::nprocs() const
{
  return comm->nprocs;
}

/* ----------------------------------------------------------------------
   parts that other ranks have of these things, by id and rank: each thing has a rank that all ask
   about it
------------------------------------------------------------------------- */

std::vector<PeridemSharing::Part> PeridemSharing::find_parts(const std::vector<bigint> &ids) const
{
  auto before = [](const Part &a, const Part &b) {
    return a.id != b.id ? a.id < b.id : a.rank < b.rank;
  };
  std::vector<std::vector<Part>> asked(comm->nprocs), answers(comm->nprocs);
  for (const bigint id : ids) asked[id % comm->nprocs].push_back({id, comm->me});
  auto parts = PeridemMessages::exchange(world, asked);
  std::sort(parts.begin(), parts.end(), before);
  for (std::size_t first = 0, last = 0; first < parts.size(); first = last) {
    while (last < parts.size() && parts[last].id == parts[first].id) last++;
    for (std::size_t a = first; a < last; a++)
      for (std::size_t b = first; b < last; b++)
        if (a != b) answers[parts[a].rank].push_back(parts[b]);
  }
  auto others = PeridemMessages::exchange(world, answers);
  std::sort(others.begin(), others.end(), before);
  return others;
}

/* ---------------------------------------------------------------------- */

void PeridemSharing::find(const std::vector<bigint> &ids)
{
  places.clear();
  peers.clear();
  if (comm->nprocs == 1) return;

  std::map<int, std::vector<int>> things;
  bigint last = -1;
  for (const auto &part : find_parts(ids)) {    // all ranks see the ids in the same order
    if (part.id != last)
      places.push_back(
          static_cast<int>(std::lower_bound(ids.begin(), ids.end(), part.id) - ids.begin()));
    last = part.id;
    things[part.rank].push_back(static_cast<int>(places.size()) - 1);
  }
  for (auto &entry : things) peers.push_back({entry.first, std::move(entry.second), {}, {}});
}

/* ---------------------------------------------------------------------- */

void PeridemSharing::swap_parts(const std::vector<double> &data, int width)
{
  requests.clear();
  for (auto &peer : peers) {
    peer.theirs.resize(width * peer.things.size());
    requests.emplace_back();
    MPI_Irecv(peer.theirs.data(), static_cast<int>(peer.theirs.size()), MPI_DOUBLE, peer.rank,
              PARTS, world, &requests.back());
  }
  for (auto &peer : peers) {
    peer.ours.clear();
    for (const int n : peer.things)
      peer.ours.insert(peer.ours.end(), &data[n * width], &data[n * width] + width);
    requests.emplace_back();
    MPI_Isend(peer.ours.data(), static_cast<int>(peer.ours.size()), MPI_DOUBLE, peer.rank, PARTS,
              world, &requests.back());
  }
  PeridemMessages::wait_for(requests);
}

/* ----------------------------------------------------------------------
   added up in the order of the ranks
------------------------------------------------------------------------- */

void PeridemSharing::sum(std::vector<double> &data, int width)
{
  if (peers.empty()) return;
  swap_parts(data, width);
  own.swap(data);
  data.assign(own.size(), 0.0);
  bool added = false;
  auto add_own = [&] {
    for (std::size_t n = 0; n < own.size(); n++) data[n] += own[n];
    added = true;
  };
  for (const auto &peer : peers) {
    if (!added && peer.rank > comm->me) add_own();
    const double *part = peer.theirs.data();
    for (const int n : peer.things)
      for (int k = 0; k < width; k++) data[n * width + k] += *part++;
  }
  if (!added) add_own();
}

/* ---------------------------------------------------------------------- */

double PeridemSharing::memory_usage() const
{
  double numbers = static_cast<double>(own.capacity());
  for (const auto &peer : peers) numbers += peer.ours.capacity() + peer.theirs.capacity();
  return numbers * sizeof(double);
}
