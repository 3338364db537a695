// Resident memory per particle of a running `eos` simulation. It is the slope of the peak between two sizes, so that
// the memory of the program itself does not count. Each size runs in a process of its own.
#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/bench/sim_fixture.h"

namespace {

using namespace thixo;

struct Measured {
    double bytes = 0, particles = 0, neighbours = 0;
};

Measured run(double particles, double support) {
    Simulation s = fixture::standing_dam(particles, support);
    fixture::free_steps(s, 20);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return {1024.0 * static_cast<double>(usage.ru_maxrss), static_cast<double>(s.particles.size()),
            static_cast<double>(s.neighbours.total()) / static_cast<double>(s.particles.size())};
}

bool run_apart(double particles, double support, Measured& measured) {
    int ends[2];
    if (pipe(ends) != 0) return false;
    const pid_t child = fork();
    if (child < 0) return false;
    if (child == 0) {
        const Measured m = run(particles, support);
        _exit(write(ends[1], &m, sizeof m) == sizeof m ? 0 : 1);
    }
    close(ends[1]);
    const bool read_all = read(ends[0], &measured, sizeof measured) == sizeof measured;
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    return read_all && status == 0;
}

}  // namespace

int main() {
    for (const double support : {2.0, 2.17}) {
        Measured small, large;
        if (!run_apart(94'000, support, small) || !run_apart(287'000, support, large)) {
            fmt::print(stderr, "memory_bench: a run failed\n");
            return 1;
        }
        for (const Measured& m : {small, large})
            fmt::print("{:.0f} particles, {:.1f} neighbours: {:.1f} MiB\n", m.particles, m.neighbours,
                       m.bytes / 1048576);
        fmt::print("slope: {:.0f} bytes a particle\n",
                   (large.bytes - small.bytes) / (large.particles - small.particles));
    }
}
