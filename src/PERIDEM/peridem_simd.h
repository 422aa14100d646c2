/* -*- c++ -*- ----------------------------------------------------------
   LAMMPS - Large-scale Atomic/Molecular Massively Parallel Simulator
   https://www.lammps.org/, Sandia National Laboratories
   LAMMPS development team: developers@lammps.org

   This file is part of PERIDEM, a package for LAMMPS.  It is distributed
   under the GNU General Public License, version 2.

   See the README file in the top-level LAMMPS directory.
------------------------------------------------------------------------- */

// Several doubles side by side, computed at once: as many as one register of the processor holds.
// GNU's vector types give +, -, *, / and ?: on all lanes for any processor; a compiler without
// them gets one lane, an ordinary double.

#ifndef LMP_PERIDEM_SIMD_H
#define LMP_PERIDEM_SIMD_H

#include <cmath>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace LAMMPS_NS {
namespace PeridemSimd {

#if !defined(__GNUC__)
  static constexpr int WIDTH = 1;
  using Lanes = double;
#else
#if defined(__AVX512F__)
  static constexpr int WIDTH = 8;
#elif defined(__AVX__)
  static constexpr int WIDTH = 4;
#else
  static constexpr int WIDTH = 2;    // SSE2, NEON
#endif
  typedef double Lanes __attribute__((vector_size(WIDTH * sizeof(double))));
#endif

  // what containers hold: the alignment is the struct's, not an attribute of a template argument
  struct alignas(WIDTH * sizeof(double)) Pack {
    Lanes v;
  };

  inline Lanes all(double value)
  {
    return Lanes{} + value;
  }

  inline double get(const Pack &p, int lane)
  {
    return reinterpret_cast<const double *>(&p)[lane];
  }

  inline void set(Pack &p, int lane, double value)
  {
    reinterpret_cast<double *>(&p)[lane] = value;
  }

  inline Lanes larger(Lanes a, Lanes b)
  {
#if defined(__AVX512F__)
    return (Lanes) _mm512_max_pd((__m512d) a, (__m512d) b);
#elif defined(__AVX__)
    return (Lanes) _mm256_max_pd((__m256d) a, (__m256d) b);
#else
    return a > b ? a : b;
#endif
  }

  // is a > b in any lane?
  inline bool any_above(Lanes a, Lanes b)
  {
#if defined(__AVX512F__)
    return _mm512_cmp_pd_mask((__m512d) a, (__m512d) b, _CMP_GT_OQ) != 0;
#elif defined(__AVX__)
    return _mm256_movemask_pd(_mm256_cmp_pd((__m256d) a, (__m256d) b, _CMP_GT_OQ)) != 0;
#elif defined(__GNUC__)
    const auto above = a > b;
    return above[0] || above[1];
#else
    return a > b;
#endif
  }

#if defined(__AVX512F__)
  // From 14 bits, one step of Goldschmidt's iteration and a correction of the root: to the last place
  // in a third of the time of the processor's square root.  half: 1/(2 r) to 27 bits
  inline Lanes root_and_half(Lanes square, Lanes &half)
  {
    const Lanes start = (Lanes) _mm512_rsqrt14_pd((__m512d) square);
    Lanes r = square * start;
    half = 0.5 * start;
    const Lanes rest = 0.5 - r * half;
    r += r * rest;
    half += half * rest;
    return r + (square - r * r) * half;
  }

  inline Lanes root(Lanes square)
  {
    Lanes half;
    return root_and_half(square, half);
  }

  // inverse: 1/r, to the last place but one
  inline Lanes root(Lanes square, Lanes &inverse)
  {
    Lanes half;
    const Lanes r = root_and_half(square, half);
    inverse = half + half;
    inverse += inverse * (1.0 - r * inverse);
    return r;
  }
#else
  inline Lanes root(Lanes square)
  {
#if defined(__AVX__)
    return (Lanes) _mm256_sqrt_pd((__m256d) square);
#elif defined(__SSE2__)
    return (Lanes) _mm_sqrt_pd((__m128d) square);
#elif defined(__GNUC__)
    return Lanes{std::sqrt(square[0]), std::sqrt(square[1])};
#else
    return std::sqrt(square);
#endif
  }

  inline Lanes root(Lanes square, Lanes &inverse)
  {
    const Lanes r = root(square);
    inverse = 1.0 / r;
    return r;
  }
#endif

}    // namespace PeridemSimd
}    // namespace LAMMPS_NS

#endif
