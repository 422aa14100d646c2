/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Lists of any length between ranks; every rank of the communicator calls each of these.  Nothing
// that MPI gets is const: in the MPI that LAMMPS brings along for serial builds nothing is.

#ifndef LMP_PERIDEM_MESSAGES_H
#define LMP_PERIDEM_MESSAGES_H

#include <mpi.h>
#include <numeric>
#include <type_traits>
#include <vector>

namespace LAMMPS_NS {
namespace PeridemMessages {

  // one T as it is in memory; counts of MPI are ints, and those of bytes would overflow first
  template <class T> class Type {
    static_assert(std::is_trivially_copyable<T>::value, "only what memcpy could send");

   public:
    Type()
    {
      MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type);
      MPI_Type_commit(&type);
    }
    ~Type() { MPI_Type_free(&type); }
    Type(const Type &) = delete;
    Type &operator=(const Type &) = delete;
    operator MPI_Datatype() const { return type; }

   private:
    MPI_Datatype type;
  };

  // where each of some lists starts, when they stand one after the other
  inline std::vector<int> starts(const std::vector<int> &counts)
  {
    std::vector<int> at(counts.size(), 0);
    std::partial_sum(counts.begin(), counts.end() - 1, at.begin() + 1);
    return at;
  }

  // until all have come and gone; the MPI of serial builds has no name for statuses to ignore
  inline void wait_for(std::vector<MPI_Request> &requests)
  {
    for (auto &request : requests) MPI_Wait(&request, MPI_STATUS_IGNORE);
    requests.clear();
  }

  // the lists of all ranks, one after the other
  template <class T> std::vector<T> gather(MPI_Comm world, std::vector<T> list)
  {
    int nprocs;
    MPI_Comm_size(world, &nprocs);
    if (nprocs == 1) return list;
    int mine = static_cast<int>(list.size());
    std::vector<int> counts(nprocs);
    MPI_Allgather(&mine, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
    auto at = starts(counts);
    std::vector<T> all(at.back() + counts.back());
    const Type<T> type;
    MPI_Allgatherv(list.data(), mine, type, all.data(), counts.data(), at.data(), type, world);
    return all;
  }

  // outgoing[p] goes to rank p; returns what the ranks have sent here, one after the other, and how
  // many by each
  template <class T>
  std::vector<T> exchange(MPI_Comm world, const std::vector<std::vector<T>> &outgoing,
                          std::vector<int> &nrecv)
  {
    const int nprocs = static_cast<int>(outgoing.size());
    nrecv.assign(nprocs, static_cast<int>(outgoing[0].size()));
    if (nprocs == 1) return outgoing[0];
    std::vector<int> nsend(nprocs);
    for (int p = 0; p < nprocs; p++) nsend[p] = static_cast<int>(outgoing[p].size());
    MPI_Alltoall(nsend.data(), 1, MPI_INT, nrecv.data(), 1, MPI_INT, world);
    auto sendat = starts(nsend), recvat = starts(nrecv);
    std::vector<T> send, recv(recvat.back() + nrecv.back());
    send.reserve(sendat.back() + nsend.back());
    for (const auto &part : outgoing) send.insert(send.end(), part.begin(), part.end());
    const Type<T> type;
    MPI_Alltoallv(send.data(), nsend.data(), sendat.data(), type, recv.data(), nrecv.data(),
                  recvat.data(), type, world);
    return recv;
  }

  template <class T>
  std::vector<T> exchange(MPI_Comm world, const std::vector<std::vector<T>> &outgoing)
  {
    std::vector<int> nrecv;
    return exchange(world, outgoing, nrecv);
  }

}    // namespace PeridemMessages
}    // namespace LAMMPS_NS

#endif
