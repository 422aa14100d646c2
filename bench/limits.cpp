// What one core of this machine can do, for comparison: bytes per second through a triad that does
// not fit a cache, and square roots with a division per second.  Prints two numbers: GB/s, and ns for
// one square root and one division of doubles.

#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

static double now()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

static double triad()
{
  const std::size_t n = 1 << 25;
  std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
  double best = 1e30;
  for (int round = 0; round < 5; round++) {
    const double start = now();
    for (std::size_t i = 0; i < n; i++) a[i] = b[i] + 0.5 * c[i];
    best = std::fmin(best, now() - start);
    b[round] = a[n - 1];
  }
  return 24.0 * n / best * 1e-9;    // two arrays read, one written
}

static double root_and_division()
{
  const int n = 1024, rounds = 20000;
  std::vector<double> a(n, 1.5), b(n, 0.0);
  double best = 1e30;
  for (int repeat = 0; repeat < 3; repeat++) {
    const double start = now();
    for (int round = 0; round < rounds; round++) {
#pragma omp simd
      for (int i = 0; i < n; i++) b[i] = b[i] * 1e-3 + a[i] / std::sqrt(a[i] + b[i]);
    }
    best = std::fmin(best, now() - start);
  }
  a[0] = b[1];
  return best / (static_cast<double>(n) * rounds) * 1e9 + (a[0] > 1e30 ? 1.0 : 0.0);
}

int main()
{
  std::printf("%.3f %.4f\n", triad(), root_and_division());
  return 0;
}
