#include "rhs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>

void Free::operator()(double* numbers) const { std::free(numbers); }

namespace {

Numbers aligned(std::size_t count) {
    const std::size_t bytes = (count * sizeof(double) + 63) / 64 * 64;
    return Numbers(static_cast<double*>(std::aligned_alloc(64, bytes)));
}

// Eq. (5) as a function of the slip speed: mu(V) / V.
inline double ratio(const Model& m, double speed) {
    const double creep = 1 - std::exp(-m.creep * speed);
    const double sliding = m.mu_d + (m.mu_s - m.mu_d) * std::exp(-m.stribeck * speed);
    return creep * sliding / speed;
}

// Keeps the division by the speed finite.
constexpr double SPEED_FLOOR = 1e-280;

// Node by node, with all modes of a node in the inner loop.
void one_pass(const Model& m, const double* q, const double* v, double* __restrict out) {
    const int n = m.nodes;
    const double *s = m.along.get(), *t = m.across.get(), *r = m.outward.get();
    const double *speed = m.speed.get(), *pre_stress = m.pre_stress.get();
    const double *stiffness = m.stiffness.get(), *area = m.area.get();
    double sum[MODES] = {};
    for (int k = 0; k < n; ++k) {
        double u_r = 0, v_s = speed[k], v_t = 0, v_r = 0;
        for (int i = 0; i < MODES; ++i) {
            u_r += r[i * n + k] * q[i];
            v_s += s[i * n + k] * v[i];
            v_t += t[i * n + k] * v[i];
            v_r += r[i * n + k] * v[i];
        }
        const double normal = std::fmax(0.0, pre_stress[k] + stiffness[k] * u_r) * area[k];
        const double slip = std::sqrt(v_s * v_s + v_t * v_t + v_r * v_r + SPEED_FLOOR);
        const double drag = normal * ratio(m, slip);
        const double f_s = drag * v_s, f_t = drag * v_t, f_r = drag * v_r + normal;
        for (int i = 0; i < MODES; ++i) {
            sum[i] += s[i * n + k] * f_s + t[i * n + k] * f_t + r[i * n + k] * f_r;
        }
    }
    for (int i = 0; i < MODES; ++i) out[i] = -sum[i] - m.steady[i];
}

// Mode by mode, with all nodes in the inner loop. Intermediate values of the nodes are stored.
void passes(const Model& m, const double* q, const double* v, double* __restrict out) {
    constexpr int CHUNK = 64;
    const int n = m.nodes;
    double sum[MODES] = {};
    for (int first = 0; first < n; first += CHUNK) {
        const int count = std::min(CHUNK, n - first);
        alignas(64) double u_r[CHUNK] = {}, v_s[CHUNK], v_t[CHUNK] = {}, v_r[CHUNK] = {};
        std::memcpy(v_s, &m.speed[first], count * sizeof(double));
        for (int i = 0; i < MODES; ++i) {
            const double *s = &m.along[i * n + first], *t = &m.across[i * n + first];
            const double* r = &m.outward[i * n + first];
            for (int k = 0; k < count; ++k) {
                u_r[k] += r[k] * q[i];
                v_s[k] += s[k] * v[i];
                v_t[k] += t[k] * v[i];
                v_r[k] += r[k] * v[i];
            }
        }
        const double *pre_stress = &m.pre_stress[first], *stiffness = &m.stiffness[first];
        const double* area = &m.area[first];
        for (int k = 0; k < count; ++k) {
            const double normal = std::fmax(0.0, pre_stress[k] + stiffness[k] * u_r[k]) * area[k];
            const double slip =
                std::sqrt(v_s[k] * v_s[k] + v_t[k] * v_t[k] + v_r[k] * v_r[k] + SPEED_FLOOR);
            const double drag = normal * ratio(m, slip);
            v_s[k] *= drag;
            v_t[k] *= drag;
            v_r[k] = v_r[k] * drag + normal;
        }
        for (int i = 0; i < MODES; ++i) {
            const double *s = &m.along[i * n + first], *t = &m.across[i * n + first];
            const double* r = &m.outward[i * n + first];
            double part = 0;
            for (int k = 0; k < count; ++k) {
                part += s[k] * v_s[k] + t[k] * v_t[k] + r[k] * v_r[k];
            }
            sum[i] += part;
        }
    }
    for (int i = 0; i < MODES; ++i) out[i] = -sum[i] - m.steady[i];
}

std::array<double, MODES> coordinates(const Model& m, const double* y) {
    std::array<double, MODES> q;
    for (int i = 0; i < MODES; ++i) q[i] = y[i] / m.omega[i];
    return q;
}

}  // namespace

void force(const Model& model, Form form, const double* q, const double* v, double* out) {
    switch (form) {
        case Form::OnePass: return one_pass(model, q, v, out);
        case Form::Passes: return passes(model, q, v, out);
    }
}

void slope(const Model& m, const double* y, double* dy) {
    const double* v = y + MODES;
    double* dv = dy + MODES;
    const auto q = coordinates(m, y);
    passes(m, q.data(), v, dv);
    for (int i = 0; i < MODES; ++i) {
        dy[i] = m.omega[i] * v[i];
        dv[i] -= m.omega[i] * y[i];
    }
}

void slope_derivative(const Model& m, const double* y, double* jacobian) {
    const int n = m.nodes;
    const double* v = y + MODES;
    const auto q = coordinates(m, y);
    const double *s = m.along.get(), *t = m.across.get(), *r = m.outward.get();
    std::memset(jacobian, 0, DIM * DIM * sizeof(double));
    const auto entry = [jacobian](int i, int j) -> double& { return jacobian[i + DIM * j]; };
    for (int k = 0; k < n; ++k) {
        double u_r = 0, slip[3] = {m.speed[k], 0, 0}, row[3][MODES];
        for (int i = 0; i < MODES; ++i) {
            row[0][i] = s[i * n + k], row[1][i] = t[i * n + k], row[2][i] = r[i * n + k];
            u_r += row[2][i] * q[i];
            for (int c = 0; c < 3; ++c) slip[c] += row[c][i] * v[i];
        }
        const double gap = m.pre_stress[k] + m.stiffness[k] * u_r;
        if (gap <= 0) continue;
        const double normal = gap * m.area[k], stiffness = m.stiffness[k] * m.area[k];
        const double speed = std::sqrt(slip[0] * slip[0] + slip[1] * slip[1] + slip[2] * slip[2] + SPEED_FLOOR);
        const double creep_left = std::exp(-m.creep * speed);
        const double fall = (m.mu_s - m.mu_d) * std::exp(-m.stribeck * speed);
        const double drag = ratio(m, speed);
        const double steepness = m.creep * creep_left * (m.mu_d + fall) - (1 - creep_left) * m.stribeck * fall;
        // (d(mu/V)/dV) / V, the factor of the slip squared.
        const double curvature = (steepness - drag) / (speed * speed);
        double by_gap[MODES], by_slip[MODES][3];
        for (int i = 0; i < MODES; ++i) {
            double projection = 0;
            for (int c = 0; c < 3; ++c) projection += row[c][i] * slip[c];
            by_gap[i] = -(drag * projection + row[2][i]) * stiffness;
            for (int c = 0; c < 3; ++c) {
                by_slip[i][c] = -normal * (drag * row[c][i] + curvature * projection * slip[c]);
            }
        }
        for (int j = 0; j < MODES; ++j) {
            const double outward = row[2][j] / m.omega[j];
            for (int i = 0; i < MODES; ++i) {
                entry(MODES + i, j) += by_gap[i] * outward;
                double sum = 0;
                for (int c = 0; c < 3; ++c) sum += by_slip[i][c] * row[c][j];
                entry(MODES + i, MODES + j) += sum;
            }
        }
    }
    for (int i = 0; i < MODES; ++i) {
        entry(i, MODES + i) = m.omega[i];
        entry(MODES + i, i) -= m.omega[i];
    }
}

Model::Model(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const auto read = [&file](double* numbers, std::size_t count) {
        file.read(reinterpret_cast<char*>(numbers), count * sizeof(double));
        if (!file) throw std::runtime_error("the model file is truncated");
    };
    double head[7];
    read(head, 7);
    nodes = static_cast<int>(head[0]);
    if (head[1] != MODES || nodes % LANES != 0) throw std::runtime_error("the model has another layout");
    mu_s = head[2], mu_d = head[3], creep = head[4], stribeck = head[5];
    starts.resize(static_cast<std::size_t>(head[6]));
    read(omega.data(), MODES);
    for (Numbers* numbers : {&speed, &pre_stress, &stiffness, &area}) {
        *numbers = aligned(nodes);
        read(numbers->get(), nodes);
    }
    for (Numbers* numbers : {&along, &across, &outward}) {
        *numbers = aligned(std::size_t(nodes) * MODES);
        read(numbers->get(), std::size_t(nodes) * MODES);
    }
    for (State& start : starts) read(start.data(), DIM);
    // Computed with the integrated loop itself, so the equilibrium stays exact.
    steady.fill(0);
    std::array<double, MODES> rest{}, at_rest;
    passes(*this, rest.data(), rest.data(), at_rest.data());
    steady = at_rest;
}
