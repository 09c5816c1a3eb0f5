// Eq. (8) as a plain loop: the right-hand side that all peers share.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

// The number of modes is known when compiling, as it is in the laboratory for the paper's eleven.
constexpr int MODES = 11;
constexpr int DIM = 2 * MODES;
// Nodes are padded to whole vectors of the widest kind; those added have no area and do nothing.
constexpr int LANES = 8;

using State = std::array<double, DIM>;

struct Free {
    void operator()(double* numbers) const;
};
using Numbers = std::unique_ptr<double[], Free>;

// The contact model, a structure of arrays. The state is y = [omega q | dq/dt], all in units of a
// modal velocity (sqrt(kg) m/s), so that one tolerance suits every component.
struct Model {
    int nodes = 0;
    double mu_s, mu_d, creep, stribeck;
    std::array<double, MODES> omega, steady;
    // Per node: speed of steady sliding, pre-stress, stiffness, area.
    Numbers speed, pre_stress, stiffness, area;
    // Per mode and node: the shape along the sliding direction, across it, and outwards.
    Numbers along, across, outward;
    // The states to start from.
    std::vector<State> starts;

    // Reads what `scene.py` wrote.
    explicit Model(const std::string& path);
};

// The forms of the loop; both give the same.
enum class Form {
    // A node after another, all modes of it in turn: the loop that anyone would write first.
    OnePass,
    // A mode after another, all nodes in turn: the faster one, by which the peers integrate.
    Passes
};

// Generalised forces of contact and friction at modal coordinates q and velocities v, less those
// of steady sliding.
void force(const Model& model, Form form, const double* q, const double* v, double* out);

// dy/dt, by the faster form.
void slope(const Model& model, const double* y, double* dy);

// The derivative of dy/dt, DIM x DIM, element (i, j) at jacobian[i + DIM * j].
void slope_derivative(const Model& model, const double* y, double* jacobian);
