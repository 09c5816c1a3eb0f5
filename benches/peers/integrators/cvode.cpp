// CVODE of SUNDIALS (Debian: libsundials-dev) on Eq. (8).
//
//     cvode MODEL.bin HORIZON        then requests `METHOD TOLERANCE`, see peer.hpp
//
// METHOD is FORMULA-SOLVER: `adams` or `bdf`, and the solver of the implicit equations: `fixed`
// (fixed-point iteration), `anderson` (accelerated fixed-point iteration), `diagonal` (Newton with a
// diagonal Jacobian by differences), `newton` (Newton with the analytic Jacobian), `differences` (Newton
// with a Jacobian by differences).

#include <cvode/cvode.h>
#include <cvode/cvode_diag.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>

#include "peer.hpp"

namespace {

void check(int flag) {
    if (flag < 0) throw std::runtime_error("CVODE error " + std::to_string(flag));
}

int right_hand_side(realtype, N_Vector y, N_Vector dy, void* model) {
    slope(*static_cast<Model*>(model), N_VGetArrayPointer(y), N_VGetArrayPointer(dy));
    return 0;
}

int jacobian(realtype, N_Vector y, N_Vector, SUNMatrix matrix, void* model, N_Vector, N_Vector,
             N_Vector) {
    slope_derivative(*static_cast<Model*>(model), N_VGetArrayPointer(y),
                     SUNDenseMatrix_Data(matrix));
    return 0;
}

// One method, created once and restarted for each run.
class Solver {
public:
    Solver(Model& model, const std::string& method, SUNContext context)
        : y_(N_VNew_Serial(DIM, context)) {
        const auto dash = method.find('-');
        const std::string formula = method.substr(0, dash), solver = method.substr(dash + 1);
        memory_ = CVodeCreate(formula == "adams" ? CV_ADAMS : CV_BDF, context);
        N_VConst(0, y_);
        check(CVodeInit(memory_, right_hand_side, 0, y_));
        check(CVodeSetUserData(memory_, &model));
        check(CVodeSetMaxNumSteps(memory_, 100'000'000));
        check(CVodeSStolerances(memory_, 1e-4, 1e-4));
        if (solver == "fixed" || solver == "anderson") {
            const int depth = solver == "fixed" ? 0 : 2;
            check(CVodeSetNonlinearSolver(memory_, SUNNonlinSol_FixedPoint(y_, depth, context)));
        } else if (solver == "diagonal") {
            check(CVDiag(memory_));
        } else if (solver == "newton" || solver == "differences") {
            SUNMatrix matrix = SUNDenseMatrix(DIM, DIM, context);
            check(CVodeSetLinearSolver(memory_, SUNLinSol_Dense(y_, matrix, context), matrix));
            if (solver == "newton") check(CVodeSetJacFn(memory_, jacobian));
            dense_ = true;
        } else {
            throw std::runtime_error("unknown method");
        }
    }

    Run run(double tolerance, const State& start, double horizon) {
        std::copy(start.begin(), start.end(), N_VGetArrayPointer(y_));
        // Components pass through zero, so the absolute tolerance is relative to the typical size.
        const double usual = std::sqrt(N_VDotProd(y_, y_) / DIM);
        check(CVodeReInit(memory_, 0, y_));
        check(CVodeSStolerances(memory_, tolerance, tolerance * usual));
        check(CVodeSetStopTime(memory_, horizon));
        realtype t;
        check(CVode(memory_, horizon, y_, &t, CV_NORMAL));
        Run run;
        long more = 0;
        check(CVodeGetNumRhsEvals(memory_, &run.calls));
        if (dense_) {
            check(CVodeGetNumLinRhsEvals(memory_, &more));
            check(CVodeGetNumJacEvals(memory_, &run.derivatives));
        }
        run.calls += more;
        std::copy_n(N_VGetArrayPointer(y_), DIM, run.end.begin());
        return run;
    }

private:
    void* memory_;
    N_Vector y_;
    bool dense_ = false;
};

}  // namespace

int main(int, char** arguments) {
    Model model(arguments[1]);
    const double horizon = std::stod(arguments[2]);
    sundials::Context context;
    std::map<std::string, std::unique_ptr<Solver>> solvers;
    serve(model, [&](const std::string& method, double tolerance, const State& start) {
        auto& solver = solvers[method];
        if (!solver) solver = std::make_unique<Solver>(model, method, context);
        return solver->run(tolerance, start, horizon);
    });
}
