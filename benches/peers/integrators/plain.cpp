// Times the plain loop of rhs.hpp, and the core.
//
//     plain MODEL.bin                then one request per line:
//
// * `one-pass CALLS`, `passes CALLS`: seconds per call, and the forces at the first start;
// * `core 0`: the frequency in Hz, and the peak in floating-point operations per second, measured with
//   multiply-adds in registers only.

#include <cstdint>
#include <cstdio>
#include <iostream>

#include "peer.hpp"

namespace {

void time_form(const Model& model, Form form, long calls) {
    double q[MODES], out[MODES];
    const double* v = model.starts[0].data() + MODES;
    for (int i = 0; i < MODES; ++i) q[i] = model.starts[0][i] / model.omega[i];
    const double began = cpu_seconds();
    for (long call = 0; call < calls; ++call) {
        force(model, form, q, v, out);
        // Prevents the compiler from reusing the previous call or omitting this one.
        asm volatile("" : : "r"(q), "r"(v), "r"(out) : "memory");
    }
    std::printf("{\"seconds\": %.9g, \"force\": [", (cpu_seconds() - began) / calls);
    for (int i = 0; i < MODES; ++i) std::printf(i ? ", %.17g" : "%.17g", out[i]);
    std::printf("]}\n");
}

// A chain of multiplications, three cycles each on all x86 processors of the last decade.
double frequency() {
    constexpr long LINKS = 3'000'000;
    std::uint64_t x = 3;
    const double began = cpu_seconds();
    for (long link = 0; link < LINKS; ++link) asm volatile("imul %0, %0" : "+r"(x));
    return 3 * LINKS / (cpu_seconds() - began);
}

#ifdef __AVX512F__
constexpr int WIDTH = 8;
#else
constexpr int WIDTH = 4;
#endif

double peak() {
    typedef double Vector __attribute__((vector_size(WIDTH * sizeof(double))));
    constexpr int CHAINS = 12;
    constexpr long ROUNDS = 300'000;
    Vector x[CHAINS] = {};
    const Vector factor = Vector{} + 0.999, addend = Vector{} + 0.001;
    const double began = cpu_seconds();
    for (long round = 0; round < ROUNDS; ++round) {
#pragma GCC unroll 12
        for (int chain = 0; chain < CHAINS; ++chain) {
            x[chain] = x[chain] * factor + addend;
            asm volatile("" : "+v"(x[chain]));
        }
    }
    return 2.0 * WIDTH * CHAINS * ROUNDS / (cpu_seconds() - began);
}

}  // namespace

int main(int, char** arguments) {
    const Model model(arguments[1]);
    std::string what;
    long calls;
    while (std::cin >> what >> calls) {
        if (what == "core") {
            std::printf("{\"hertz\": %.6g, \"flops\": %.6g, \"width\": %d}\n", frequency(), peak(),
                        WIDTH);
        } else {
            time_form(model, what == "passes" ? Form::Passes : Form::OnePass, calls);
        }
        std::fflush(stdout);
    }
}
