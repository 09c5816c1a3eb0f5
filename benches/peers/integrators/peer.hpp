// Protocol of these programs: one request per line, answered by one line of JSON.
#pragma once

#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "rhs.hpp"

// CPU time of this thread, s, unaffected by other processes.
inline double cpu_seconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

// Result of an integration: evaluations of the right-hand side (and of its derivative), and the final
// state.
struct Run {
    long calls = 0, derivatives = 0;
    State end;
};

// Integrates from a start state with the named method; `setting` is its tolerance, or its step in s.
using Integrate = std::function<Run(const std::string& method, double setting, const State& start)>;

// Answers `METHOD SETTING` with the time (s) for all starts, the evaluations and the final states.
inline void serve(const Model& model, const Integrate& integrate) {
    std::string method;
    double setting;
    while (std::cin >> method >> setting) {
        try {
            std::vector<Run> runs;
            const double began = cpu_seconds();
            for (const State& start : model.starts) {
                runs.push_back(integrate(method, setting, start));
            }
            const double seconds = cpu_seconds() - began;
            long calls = 0, derivatives = 0;
            for (const Run& run : runs) calls += run.calls, derivatives += run.derivatives;
            std::printf("{\"seconds\": %.9g, \"calls\": %ld, \"derivatives\": %ld, \"ends\": [",
                        seconds, calls, derivatives);
            for (const Run& run : runs) {
                std::printf(&run == &runs[0] ? "[" : ", [");
                for (int i = 0; i < DIM; ++i) std::printf(i ? ", %.17g" : "%.17g", run.end[i]);
                std::printf("]");
            }
            std::printf("]}\n");
        } catch (const std::exception& failure) {
            std::printf("{\"failed\": \"%s\"}\n", failure.what());
        }
        std::fflush(stdout);
    }
}
