// Boost.odeint (Debian: libboost-dev) on Eq. (8).
//
//     odeint MODEL.bin HORIZON       then requests `METHOD SETTING`, see peer.hpp
//
// The setting is the tolerance, or the step (s) of methods with a fixed step (`...-fixed`).

#include <boost/numeric/odeint.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>

#include <cmath>
#include <functional>
#include <map>
#include <numeric>

#include "peer.hpp"

namespace {

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;

// Initial step of the methods with step control, s.
constexpr double FIRST_STEP = 1e-7;

struct Problem {
    const Model& model;
    double horizon, setting;
    const State& start;

    // Components pass through zero, so the absolute tolerance is relative to the typical size.
    double absolute() const {
        const double square = std::inner_product(start.begin(), start.end(), start.begin(), 0.0);
        return setting * std::sqrt(square / DIM);
    }
};

// Integrates with a stepper; `integrate` is one of odeint's functions.
template <class Stepper, class Integrate>
Run integrate_by(const Problem& problem, Stepper stepper, double step, Integrate integrate) {
    Run run;
    run.end = problem.start;
    const auto system = [&](const State& y, State& dy, double) {
        ++run.calls;
        slope(problem.model, y.data(), dy.data());
    };
    integrate(stepper, system, run.end, 0.0, problem.horizon, step);
    return run;
}

const auto adaptive = [](auto& stepper, auto system, State& y, double t, double end, double step) {
    odeint::integrate_adaptive(std::ref(stepper), system, y, t, end, step);
};

template <class Stepper>
Run controlled(const Problem& p) {
    return integrate_by(p, odeint::make_controlled(p.absolute(), p.setting, Stepper()), FIRST_STEP,
                        adaptive);
}

Run bulirsch_stoer(const Problem& p) {
    using Stepper = odeint::bulirsch_stoer<State, double, State, double, odeint::array_algebra>;
    return integrate_by(p, Stepper(p.absolute(), p.setting), FIRST_STEP, adaptive);
}

template <class Stepper>
Run fixed(const Problem& p) {
    const auto steps = std::max(1.0, std::round(p.horizon / p.setting));
    const auto go = [steps](auto& stepper, auto system, State& y, double t, double, double step) {
        odeint::integrate_n_steps(std::ref(stepper), system, y, t, step, std::size_t(steps));
    };
    return integrate_by(p, Stepper(), p.horizon / steps, go);
}

// Rosenbrock's method uses the vectors and matrices of uBLAS.
Run rosenbrock4(const Problem& p) {
    using Vector = ublas::vector<double>;
    Run run;
    const auto system = [&](const Vector& y, Vector& dy, double) {
        ++run.calls;
        slope(p.model, &y[0], &dy[0]);
    };
    const auto derivative = [&](const Vector& y, ublas::matrix<double>& matrix, double,
                                Vector& by_time) {
        ++run.derivatives;
        double columns[DIM * DIM];
        slope_derivative(p.model, &y[0], columns);
        for (int i = 0; i < DIM; ++i) {
            for (int j = 0; j < DIM; ++j) matrix(i, j) = columns[i + DIM * j];
            by_time[i] = 0;
        }
    };
    Vector y(DIM);
    std::copy(p.start.begin(), p.start.end(), y.begin());
    auto stepper = odeint::make_controlled(p.absolute(), p.setting, odeint::rosenbrock4<double>());
    odeint::integrate_adaptive(stepper, std::make_pair(system, derivative), y, 0.0, p.horizon,
                               FIRST_STEP);
    std::copy(y.begin(), y.end(), run.end.begin());
    return run;
}

template <template <class...> class Method>
using On = Method<State, double, State, double, odeint::array_algebra>;

template <std::size_t ORDER>
using Adams =
    odeint::adams_bashforth_moulton<ORDER, State, double, State, double, odeint::array_algebra>;

const std::map<std::string, Run (*)(const Problem&)> METHODS = {
    {"dopri5", controlled<On<odeint::runge_kutta_dopri5>>},
    {"cash-karp54", controlled<On<odeint::runge_kutta_cash_karp54>>},
    {"fehlberg78", controlled<On<odeint::runge_kutta_fehlberg78>>},
    {"bulirsch-stoer", bulirsch_stoer},
    {"rosenbrock4", rosenbrock4},
    {"rk4-fixed", fixed<On<odeint::runge_kutta4>>},
    {"dopri5-fixed", fixed<On<odeint::runge_kutta_dopri5>>},
    {"fehlberg78-fixed", fixed<On<odeint::runge_kutta_fehlberg78>>},
    {"adams4-fixed", fixed<Adams<4>>},
    {"adams6-fixed", fixed<Adams<6>>},
    {"adams8-fixed", fixed<Adams<8>>},
};

}  // namespace

int main(int, char** arguments) {
    const Model model(arguments[1]);
    const double horizon = std::stod(arguments[2]);
    serve(model, [&](const std::string& method, double setting, const State& start) {
        return METHODS.at(method)(Problem{model, horizon, setting, start});
    });
}
