// How the programs here are asked: a request a line, the answer as a line of JSON.
#pragma once

#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "rhs.hpp"

// Processor time of this thread, s: what others do on the machine does not count.
inline double cpu_seconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

// What an integration gave: calls of the right-hand side (and of its derivative), and the end.
struct Run {
    long calls = 0, derivatives = 0;
    State end;
};

// Integrates from a start by the method named; `knob` is its tolerance, or its step in s.
using Integrate = std::function<Run(const std::string& method, double knob, const State& start)>;

// Answers `METHOD KNOB` by the time (s) for all starts, the calls, and the ends.
inline void serve(const Model& model, const Integrate& integrate) {
    std::string method;
    double knob;
    while (std::cin >> method >> knob) {
        try {
            std::vector<Run> runs;
            const double began = cpu_seconds();
            for (const State& start : model.starts) {
                runs.push_back(integrate(method, knob, start));
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
