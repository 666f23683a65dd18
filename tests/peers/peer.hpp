/*
 * What the programs of this folder that time another library share: the clock, medians, and the
 * counts of its mesh, in lines that bench_peers.sh reads: "NAME MEDIAN_MS TRIANGLES
 * BOUNDARY_EDGES", and at last "peak_rss_mb N".
 */
#ifndef PEER_HPP
#define PEER_HPP

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include <sys/resource.h>

static inline double now_ms()
{
    auto t = std::chrono::steady_clock::now().time_since_epoch();

    return std::chrono::duration<double, std::milli>(t).count();
}

/* `step` once to warm (pages, caches, its output's memory), then n times. */
template <class Step> static double median_ms(int n, Step step)
{
    std::vector<double> ms;

    step();
    for (int k = 0; k < n; k++) {
        double start = now_ms();

        step();
        ms.push_back(now_ms() - start);
    }
    std::sort(ms.begin(), ms.end());
    return ms[ms.size() / 2];
}

/* The edges of triangles that came so far. */
class Edges
{
  public:
    void add_triangle(uint32_t a, uint32_t b, uint32_t c)
    {
        add(a, b);
        add(b, c);
        add(c, a);
    }

    size_t triangles() const
    {
        return edge.size() / 3;
    }

    /* Those of one triangle only. */
    size_t boundary()
    {
        size_t n = 0;

        std::sort(edge.begin(), edge.end());
        for (size_t k = 0, end; k < edge.size(); k = end) {
            for (end = k + 1; end < edge.size() && edge[end] == edge[k];)
                end++;
            n += end == k + 1;
        }
        return n;
    }

  private:
    void add(uint32_t a, uint32_t b)
    {
        edge.push_back(uint64_t{std::min(a, b)} << 32 | std::max(a, b));
    }

    std::vector<uint64_t> edge;
};

static inline void print_way(const char *name, double ms, Edges &edges)
{
    std::printf("%s %.3f %zu %zu\n", name, ms, edges.triangles(), edges.boundary());
}

static inline long peak_rss_mb()
{
    struct rusage u;

    getrusage(RUSAGE_SELF, &u);
    return u.ru_maxrss / 1024;
}

#endif
