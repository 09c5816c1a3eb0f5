// The right-hand side for callers from other languages.

#include "rhs.hpp"

extern "C" {

Model* load_model(const char* path) { return new Model(path); }

void model_slope(const Model* model, const double* y, double* dy) { slope(*model, y, dy); }

void model_slope_derivative(const Model* model, const double* y, double* jacobian) {
    slope_derivative(*model, y, jacobian);
}
}
