// Eq. (8) as a plain loop: the right-hand side shared by all peers.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

// The number of modes is a compile-time constant, as in squeakscope for the paper's eleven.
constexpr int MODES = 11;
constexpr int DIM = 2 * MODES;
// Nodes are padded to whole vectors of the widest kind. Padding nodes have no area and no effect.
constexpr int LANES = 8;

using State = std::array<double, DIM>;

struct Free {
    void operator()(double* numbers) const;
};
using Numbers = std::unique_ptr<double[], Free>;

// The contact model, a structure of arrays. The state is y = [omega q | dq/dt], in units of a modal
// velocity (sqrt(kg) m/s), which makes one tolerance suitable for all components.
struct Model {
    int nodes = 0;
    double mu_s, mu_d, creep, stribeck;
    std::array<double, MODES> omega, steady;
    // Per node: speed of steady sliding, pre-stress, stiffness, area.
    Numbers speed, pre_stress, stiffness, area;
    // Per mode and node: the shape along the sliding direction, across it, and outwards.
    Numbers along, across, outward;
    // Start states.
    std::vector<State> starts;

    // Reads the file written by `scene.py`.
    explicit Model(const std::string& path);
};

// Forms of the loop; both give the same result.
enum class Form {
    // Node by node, with all modes in the inner loop: the straightforward form.
    OnePass,
    // Mode by mode, with all nodes in the inner loop: the faster form, used for the integrations.
    Passes
};

// Generalised forces of contact and friction at modal coordinates q and velocities v, minus those of
// steady sliding.
void force(const Model& model, Form form, const double* q, const double* v, double* out);

// dy/dt, with the faster form.
void slope(const Model& model, const double* y, double* dy);

// Derivative of dy/dt, DIM x DIM, element (i, j) at jacobian[i + DIM * j].
void slope_derivative(const Model& model, const double* y, double* jacobian);
